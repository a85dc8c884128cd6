"""Kinds of settings: recipes, scenarios and detectors in TOML, and recordings with their seqinfo.ini and archives."""

import zipfile
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

from tests.fuzz.kind import Kind
from tests.fuzz.mutations import BYTES, TEXT, TOML
from vbbench.generation.sources import Source
from vbbench.parsing.toml_text import read_toml
from vbbench_generators.crowds import read_scenario
from vbbench_generators.recordings.readers.crohd import find_recording, read_heads
from vbbench_generators.recordings.recipe import read_recipe
from vbbench_generators.tiers.tracking import TrackingSettings

NAME = "HT21-03"
SEQINFO = "[Sequence]\nname=HT21-03\nimDir=img1\nframeRate=25\nseqLength=90\nimWidth=1920\nimHeight=1080\nimExt=.jpg\n"
HEADS = "".join(f"{f},{t},{100 + 5 * f},{50 + 20 * t},15,18.5,1,1,{t / 5}\n" for f in range(1, 7) for t in range(1, 5))
ARCHIVE = Source(path="crohd/HT21Labels.zip", url="", sha256="")


def _toml(name: str, place: str, read: Callable[[Path], object], weight: int) -> Kind:
    """A bundled file of settings."""
    return Kind(
        name=name,
        make=lambda folder: (folder / "made.toml").write_bytes((files("vbbench_generators") / place).read_bytes()),
        target="made.toml",
        mutations=TOML,
        read=lambda folder: read(folder / "made.toml"),
        weight=weight,
    )


def _detector(path: Path) -> object:
    return read_toml(path, TrackingSettings, "top level")


def _recording(folder: Path) -> None:
    (folder / "gt").mkdir()
    (folder / "gt" / "gt.txt").write_text(HEADS)
    (folder / "seqinfo.ini").write_text(SEQINFO)


def _archive(folder: Path) -> None:
    with zipfile.ZipFile(folder / "labels.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(f"train/{NAME}/seqinfo.ini", SEQINFO)
        archive.writestr(f"train/{NAME}/gt/gt.txt", HEADS)
        archive.writestr("readme.txt", "labels")


def _heads(place: Path) -> object:
    return read_heads(find_recording(NAME, ARCHIVE, place, split="shibuya01"))


KINDS = (
    _toml("recipe", "recipes/students-resampled.toml", read_recipe, 4),
    _toml("scenario", "scenarios/plaza.toml", read_scenario, 4),
    _toml("detector", "detectors/model.toml", _detector, 2),
    Kind(name="seqinfo", make=_recording, target="seqinfo.ini", mutations=TEXT, read=_heads, weight=4),
    Kind(name="heads", make=_recording, target="gt/gt.txt", mutations=TEXT, read=_heads, weight=3),
    Kind(
        name="archive",
        make=_archive,
        target="labels.zip",
        mutations=BYTES,
        read=lambda folder: _heads(folder / "labels.zip"),
        weight=6,
    ),
)
"""Settings and recordings."""
