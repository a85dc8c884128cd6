"""Recordings of Head Tracking 21 for tests: folders and archives of a small crowd."""

import zipfile
from functools import cache
from pathlib import Path

import numpy as np

from tests.lib.lifting_crowd import Camera, photograph, walk
from vbbench_generators.lifting.heads import HeadBoxes

SEQINFO = "[Sequence]\nname={name}\nimDir=img1\nframeRate=25\nseqLength=90\nimWidth=1920\nimHeight=1080\nimExt=.jpg\n"
MEMBERS = ("seqinfo.ini", "gt/gt.txt")


@cache
def crowd() -> HeadBoxes:
    """Heads of 60 people crossing in all directions for 90 frames."""
    rng = np.random.default_rng(7)
    truth = walk(rng, 60, 90, 0.04, rng.uniform(0, 2 * np.pi, 60), area=(-6, 8, 6, 26))
    return photograph(Camera(), truth, 0.04, rng, size_noise=0.12, jitter=0.02, key=5)


def lines_of(heads: HeadBoxes) -> list[str]:
    """Lines of ``gt.txt``, frames and boxes from 1."""
    boxes = heads.boxes + np.array([1.0, 1.0, 0.0, 0.0])
    rows = zip(heads.frame.tolist(), heads.track.tolist(), boxes.tolist(), strict=True)
    return [f"{frame + 1},{track},{','.join(map(repr, box))},1,1,1" for frame, track, box in rows]


@cache
def crowd_text() -> str:
    """``gt.txt`` of the crowd."""
    return "\n".join(lines_of(crowd())) + "\n"


def write_recording(folder: Path, text: str | None = None, *, name: str = "HT21-03", info: str = SEQINFO) -> Path:
    """A folder as it is after unpacking."""
    (folder / "gt").mkdir(parents=True)
    (folder / "seqinfo.ini").write_text(info.format(name=name), encoding="utf-8")
    (folder / "gt" / "gt.txt").write_text(crowd_text() if text is None else text, encoding="utf-8")
    return folder


def pack(path: Path, folders: dict[str, Path]) -> Path:
    """An archive with recordings under the names given, and what else archives hold."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("readme.txt", "labels")
        archive.writestr("__MACOSX/train/HT21-03/._seqinfo.ini", b"\0\5\x16\7")
        for name, folder in folders.items():
            for member in MEMBERS:
                archive.writestr(f"{name}/{member}", (folder / member).read_bytes())
    return path
