"""Which settings of tier `field` rank solvers like which real camera: Spearman's ρ of every setting with every family.

``python -m benchmarks.family_ranks --out out/family-ranks`` solves every dataset with the variants `RANKED` and
writes ``family-ranks.png`` and ``.json`` there; what it holds is reused. ``--page docs/transfer.md`` writes the table.
The recordings are those of ``python -m benchmarks.families`` (``--data``, $VBBENCH_DATA), in runs of `LONGEST` frames.
"""

import argparse
import json
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from benchmarks.families.places import Places
from vbbench.camera import make_camera
from vbbench.files.dataset import Dataset
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import save_picture
from vbbench.registry import load
from vbbench.reproduction.agreement import Errors, Estimate, agreement, halves
from vbbench.reproduction.grid import Making
from vbbench.reproduction.transfer import errors_of
from vbbench.reproduction.variants import registered_variants

LONGEST = 20
SPLIT, STRIDE = "eth-15fps", 3
"""Whose people tier `field` shows, and every how many-th window of them is taken."""
RANKED = (
    *("cv", "sf", "ground-plane", "vb-cv", "vb-sf", "map-causal", "map-batch", "vb-former"),
    *("vb-cv-free", "vb-sf-free", "map-causal-window-6"),
)
"""Names of the variants that are ranked."""
SETTINGS: dict[str, dict[str, object]] = {
    "drawn, vehicle": {"observer": "vehicle", "detector": False},
    "found, vehicle": {"observer": "vehicle"},
    "drawn, vehicle, panorama": {"observer": "vehicle", "detector": False, "camera": "panorama"},
    "found, walker, panorama": {"camera": "panorama"},
}
"""Options of the generator by the name of a setting."""


class Real(NamedTuple):
    """A family of real recordings: how its dataset is made, the protocol, and the metric that its truth allows."""

    make: Callable[[Places], Dataset]
    protocol: str = "sequential"
    metric: str = "dx"


def _cars(places: Places, name: str, every: int) -> Dataset:
    footage = FootageOptions(every=every, longest=LONGEST)
    plan = load("generator", "own").plan(Options(source=places.folder(f"{name}/own"), footage=footage))
    return Making().planned(plan, places.cache / name)


def _filmed(places: Places) -> Dataset:
    return Making().dataset("street-film", places.cache / "street-film", Options())


FAMILIES = {
    "kitti, labels": Real(lambda places: places.kitti(4, found=False)),
    "kitti, detector": Real(lambda places: places.kitti(4, found=True)),
    "argoverse2": Real(lambda places: _cars(places, "argoverse2", 4)),
    "nuscenes": Real(lambda places: _cars(places, "nuscenes", 5)),
    "jrdb": Real(Places.jrdb, "cold-start", "dx_rel"),
    "street-film": Real(_filmed),
}
"""By name."""


def apart(places: Places, name: str) -> Places:
    """The places with a folder of its own for a dataset and the submissions to it."""
    return replace(places, cache=places.cache / re.sub(r"\W+", "-", name))


def field_dataset(places: Places, name: str) -> Dataset:
    """The dataset of a setting of tier `field`."""
    asked = dict(SETTINGS[name])
    if "camera" in asked:
        asked["camera"] = make_camera(str(asked["camera"]))
    options = Options(tier="field", stride=STRIDE, source=places.data, **asked)  # type: ignore[arg-type]
    return Making().dataset(SPLIT, apart(places, f"field {name}").cache / "dataset", options)


class Solved:
    """Errors of all variants on datasets, each solved once."""

    def __init__(self) -> None:
        self.variants = {name: registered_variants()[name] for name in RANKED}
        self._cells: dict[tuple[Path, str], list] = {}  # type: ignore[type-arg]

    def errors(self, dataset: Dataset, protocol: str, metric: str) -> Errors:
        """[V, N] capped errors."""
        key = dataset.folder, protocol
        if key not in self._cells:
            solvers = [variant.solver for variant in self.variants.values()]
            self._cells[key] = Making().cells(dataset, solvers, [protocol])
        return errors_of(self._cells[key], metric)


def compare(places: Places) -> tuple[dict[str, dict[str, Estimate]], dict[str, float]]:
    """Spearman's ρ by family and setting, and that of a family's halves."""
    solved, found, own = Solved(), {}, {}
    feet = np.array([variant.feet for variant in solved.variants.values()])
    for family, real in FAMILIES.items():
        theirs = solved.errors(real.make(apart(places, family)), real.protocol, real.metric)
        own[family] = halves(theirs)
        found[family] = {
            name: agreement(solved.errors(field_dataset(places, name), real.protocol, real.metric), theirs, feet)[
                "spearman"
            ]
            for name in SETTINGS
        }
    return found, own


def lines(found: Mapping[str, Mapping[str, Estimate]], own: Mapping[str, float]) -> list[str]:
    """The table as Markdown."""
    head = ["tier `field`, `eth-15fps`:", *SETTINGS, "the family's halves"]
    rows = [head, ["---"] * len(head)]
    for family, row in found.items():
        cells = [" to ".join(map(_short, one[1:])) for one in row.values()]
        cells = [f"{_short(one.value)} [{cell}]" for cell, one in zip(cells, row.values(), strict=True)]
        rows.append([family, *cells, _short(own[family])])
    return [f"| {' | '.join(row)} |" for row in rows]


def _short(value: float) -> str:
    """Two digits without a leading zero."""
    return f"{value:.2f}".removeprefix("0")


def draw(found: Mapping[str, Mapping[str, Estimate]]) -> Figure:
    """A cell for each family and setting: darker where they rank more alike."""
    values = np.array([[one.value for one in row.values()] for row in found.values()])
    figure = style.lay_out((7.2, 3.6), {"": (1.5, 0.7, 5.5, 2.2)})
    axes = figure.axes[0]
    axes.imshow(values, cmap="Blues", vmin=0.0, vmax=1.2, aspect="auto")
    for (row, column), value in np.ndenumerate(values):
        ink = "white" if value > 0.75 else style.INK
        axes.text(column, row, f"{value:.2f}", ha="center", va="center", color=ink, fontsize=style.TEXT_SIZE)
    axes.set_xticks(range(len(SETTINGS)), [name.replace(", ", ",\n") for name in SETTINGS])
    axes.set_yticks(range(len(found)), list(found))
    axes.set_title("")
    axes.tick_params(length=0)
    facts = f"Spearman's rank correlation of {len(RANKED)} solvers and variants"
    style.write_heading(figure, 0.2, "Which tier field ranks like which camera?", facts)
    return figure


def written(page: str, rows: Sequence[str]) -> str:
    """The page with these rows in place of its table of families."""
    return re.sub(r"(?m)^\| tier `field`, .*\n(?:\|.*\n)+", lambda _: "\n".join(rows) + "\n", page)


def main() -> None:
    """Parse, solve, write and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("VBBENCH_DATA"))
    parser.add_argument("--out", type=Path, default=Path("out/family-ranks"))
    parser.add_argument("--page", type=Path)
    asked = parser.parse_args()
    found, own = compare(Places(data=Path(asked.data), cache=asked.out))
    rows = lines(found, own)
    save_picture(draw(found), asked.out / "family-ranks.png")
    text = json.dumps({"spearman": found, "halves": own}, indent=1)
    (asked.out / "family-ranks.json").write_text(f"{text}\n", encoding="utf-8")
    if asked.page is not None:
        asked.page.write_text(written(asked.page.read_text("utf-8"), rows), encoding="utf-8")
    print("\n".join(rows))


if __name__ == "__main__":
    main()
