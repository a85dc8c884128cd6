"""The study of transfer: whether datasets of tier `field` rank solvers as a real camera does, here KITTI's.

Solvers and variants of them answer both: KITTI's recordings, every 4th frame and every frame, and trajectories seen by
a vehicle's camera in tier `field` at the same frame times. `vbbench.reproduction.agreement` compares the ranks.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from vbbench.errors import VbbenchError
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Generator, Options
from vbbench.geometry import FloatArray, runs_of_true
from vbbench.pictures.plotting import style
from vbbench.registry import load
from vbbench.reproduction.agreement import LEVEL, Errors, Estimate, agreement, halves, separated
from vbbench.reproduction.grid import Cell, Making, Study, check_grid
from vbbench.reproduction.report import Report, paragraphs
from vbbench.reproduction.variants import Variant, registered_variants
from vbbench.scene import Scene
from vbbench.scoring.metrics import METRICS
from vbbench.table import Table

REAL, TIER, DT = "kitti", "field", 0.1
"""The real split, the tier that is compared with it, and seconds between KITTI's frames."""
TARGETS = {
    "spearman": ("Spearman", "≥ .80"),
    "spearman_without_feet": ("without feet", "≥ .70"),
    "pairs": ("equal pairs", "≥ .90"),
    "pairs_without_feet": ("without feet", ""),
    "ratio": ("error ratio", ".67 to 1.50"),
    "regret": ("regret", "≤ 1.15"),
}
"""Titles of the figures of `agreement`, and what is fair to require of each."""
TITLE = "Does tier field rank as KITTI does?"


class Comparison(NamedTuple):
    """Every how many frames, protocol and metric; the variants' errors in their order; and their agreement."""

    every: int
    protocol: str
    metric: str
    made: Errors
    real: Errors
    agreement: dict[str, Estimate]

    @property
    def title(self) -> str:
        """Of its row and panel."""
        frames = "every frame" if self.every == 1 else f"every {self.every}th frame"
        return f"{frames}, {self.protocol}, {METRICS[self.metric].label}"


@dataclass(frozen=True, kw_only=True)
class TransferStudy(Study):
    """Ranks of variants on KITTI and on tier `field`.

    Parameters
    ----------
    kitti : folder of KITTI's tracking benchmark, as split `kitti` reads it.
    poses : folder of the camera's poses by another method, used where they keep parked cars in place better.
    variants : by name.
    solvers : further ones to rank: registered names or ``module:attribute``.
    every : every how many of KITTI's frames; ``None`` for every 4th and for all. The made datasets have the same
        seconds a frame.
    split : whose people the made datasets show; between their frames people follow smooth curves.
    protocols : names of protocols.
    sequences : at most, of a made dataset.
    seed : of the made datasets.
    """

    name = "transfer"
    kitti: Path | None = None
    poses: Path | None = None
    variants: Mapping[str, Variant] = field(default_factory=registered_variants)
    solvers: Sequence[str] = ()
    every: int | None = None
    split: str = "eth-15fps"
    protocols: Sequence[str] = ("sequential", "one-step")
    sequences: int | None = 60
    seed: int = 0

    @cached_property
    def ranked(self) -> dict[str, Variant]:
        """All that are ranked, by name."""
        return {**self.variants, **{name: Variant(solver=name) for name in self.solvers}}

    @property
    def steps(self) -> tuple[int, ...]:
        """Every how many frames, a case each."""
        return (4, 1) if self.every is None else (self.every,)

    def real(self, every: int) -> Options:
        """Options of KITTI's dataset."""
        return Options(source=self.kitti, footage=FootageOptions(every=every, poses=self.poses))

    def check(self) -> None:
        """Raise VbbenchError if a solver or protocol is unknown, variants are too few, or a number is out of range."""
        if len(self.ranked) < 3:
            raise VbbenchError(f"{len(self.ranked)} solvers have no ranks to compare; name at least three")
        for every in self.steps:
            self.real(every)
        load("generator", self.split)
        check_grid((variant.solver for variant in self.ranked.values()), self.protocols)

    def measure(self, out: Path, making: Making) -> list[Comparison]:
        """Two datasets for each number of frames."""
        feet = np.array([variant.feet for variant in self.ranked.values()])
        solvers, found = [variant.solver for variant in self.ranked.values()], []
        for every in self.steps:
            real = making.dataset(REAL, out / f"{REAL}-{every}" / "dataset", self.real(every))
            split, options = self._people(every, out)
            made = making.dataset(split, out / f"{TIER}-{every}" / "dataset", options)
            for protocol in self.protocols:
                cells = [making.cells(dataset, solvers, [protocol]) for dataset in (made, real)]
                for metric in ("dx", "dt"):
                    own, theirs = (errors_of(one, metric) for one in cells)
                    found.append(Comparison(every, protocol, metric, own, theirs, agreement(own, theirs, feet)))
        return found

    def _people(self, every: int, out: Path) -> tuple[str, Options]:
        """The split and the options of a made dataset; of a file made of the split if its frames differ."""
        options = Options(tier=TIER, observer="vehicle", detector=False, seed=self.seed, limit=self.sequences)
        generator: Generator = load("generator", self.split)
        scene, dt = generator.plan(Options(seed=self.seed)).scenes[0], every * DT
        if abs(scene.dt - dt) < 1e-6:
            return self.split, options
        path, text = out / f"{self.split}-{every}.txt", people_as_text(scene, dt)
        if not path.is_file() or path.read_text("utf-8") != text:
            write_text_atomically(path, text)
        return "custom", replace(options, source=path, dt=dt)

    def report(self, found: Sequence[Comparison]) -> Report:
        """How equally they rank, a row a case, and below every variant's errors."""
        ranks = Table(
            title="How equally they rank",
            facts=paragraphs("transfer_ranks"),
            head=[
                "",
                *(title for title, _ in TARGETS.values()),
                *("KITTI's halves", "pairs that KITTI separates", "blocks, field and KITTI"),
            ],
            rows=[["asked", *(target for _, target in TARGETS.values()), "", "", ""], *map(_line, found)],
        )
        errors = Table(
            title="Errors",
            head=["field / KITTI, capped means", *(one.title for one in found)],
            rows=[
                [f"`{name}`", *(f"{one.made.means[n]:.3f} / {one.real.means[n]:.3f}" for one in found)]
                for n, name in enumerate(self.ranked)
            ],
        )
        return Report(
            name=self.name,
            title=f"{TITLE} {len(self.ranked)} solvers and variants, seed {self.seed}",
            tables=[ranks, errors],
            values={
                "variants": {name: asdict(variant) for name, variant in self.ranked.items()},
                "seed": self.seed,
                "cases": [self._values(one) for one in found],
            },
            pictures={"": self.plot(found)},
        )

    def _values(self, one: Comparison) -> dict[str, Any]:
        means = zip(self.ranked, one.made.means.tolist(), one.real.means.tolist(), strict=True)
        return {
            "every": one.every,
            "protocol": one.protocol,
            "metric": one.metric,
            **{name: estimate._asdict() for name, estimate in one.agreement.items()},
            "halves": halves(one.real),
            "pairs_separated": int(separated(one.real).sum()),
            "blocks": [one.made.blocks, one.real.blocks],
            "sequences": [one.made.values.shape[1], one.real.values.shape[1]],
            "errors": {name: {"field": made, "kitti": real} for name, made, real in means},
        }

    def plot(self, found: Sequence[Comparison]) -> Figure:
        """A panel for each case: a numbered point a variant, its error on field across and on KITTI upwards."""
        columns = max(1, -(-len(found) // 2))
        width, height = _LEFT + columns * _STEP[0] + _KEY, _HEAD + 2 * _STEP[1]
        places = {
            one.title: (_LEFT + n // 2 * _STEP[0], _FOOT + (1 - n % 2) * _STEP[1], _PANEL, _PANEL)
            for n, one in enumerate(found)
        }
        figure = style.lay_out((width, height), places)
        families = list(dict.fromkeys(map(_family, self.ranked)))
        colours = {name: _COLOURS[families.index(_family(name)) % len(_COLOURS)] for name in self.ranked}
        for axes, one in zip(figure.axes, found, strict=True):
            self._draw_panel(axes, one, colours)
        facts = "mean of each sequence's error, at most 2 m; lines: 95 % intervals by blocks; hollow: relies on feet"
        style.write_heading(figure, _LEFT, TITLE, facts)
        gap, top = min(0.22, (height - _HEAD) / len(self.ranked)), _HEAD + 0.45
        for n, (name, colour) in enumerate(colours.items()):
            place = 1 - (_KEY - 0.1) / width, 1 - (top + n * gap) / height
            figure.text(*place, f"{n + 1}  {name}", fontsize=style.TEXT_SIZE, color=colour, va="center")
        return figure

    def _draw_panel(self, axes: Axes, one: Comparison, colours: Mapping[str, str]) -> None:
        made, real = one.made.means, one.real.means
        spreads = [np.quantile(errors.resampled(500, 0), LEVEL, axis=0) for errors in (one.made, one.real)]
        axes.set(xscale="log", yscale="log")
        for axis in (axes.xaxis, axes.yaxis):
            style.plain_logarithm(axis, LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_minor_locator(NullLocator())
        low, high = 0.8 * min(made.min(), real.min()), 1.25 * max(made.max(), real.max())
        axes.plot([low, high], [low, high], color=style.TRUTH_FAINT, linewidth=1.0, zorder=0)
        shift: dict[str, Any] = {"xytext": (3.0, 2.0), "textcoords": "offset points"}
        for n, (name, colour) in enumerate(colours.items()):
            axes.plot(spreads[0][:, n], [real[n]] * 2, color=colour, alpha=0.2, linewidth=0.8, zorder=1)
            axes.plot([made[n]] * 2, spreads[1][:, n], color=colour, alpha=0.2, linewidth=0.8, zorder=1)
            face = "white" if self.ranked[name].feet else colour
            axes.plot(made[n], real[n], "o", color=colour, markerfacecolor=face, markersize=4.5, zorder=2)
            axes.annotate(str(n + 1), (made[n], real[n]), fontsize=style.LABEL_SIZE, color=style.INK, **shift)
        axes.set(xlim=(low, high), ylim=(low, high))
        axes.set_title(
            f"{one.title}\nSpearman {_cell(one.agreement['spearman'])}", fontsize=style.TEXT_SIZE, color=style.INK
        )
        style.name_axes(axes, "on field", "on KITTI")
        axes.grid(color=style.FAINT, linewidth=0.6)


def _line(one: Comparison) -> list[str]:
    cells = [_cell(one.agreement[name]) for name in TARGETS]
    count = len(one.real.values)
    pairs = f"{separated(one.real).sum()} of {count * (count - 1) // 2}"
    return [one.title, *cells, f"{halves(one.real):.2f}", pairs, f"{one.made.blocks}, {one.real.blocks}"]


def _cell(figure: Estimate) -> str:
    return "–" if np.isnan(figure.value) else f"{figure.value:.2f} [{figure.low:.2f}, {figure.high:.2f}]"


def _family(name: str) -> str:
    """``vb-cv`` of ``vb-cv-noise-4``."""
    parts = name.split("-")
    return "-".join(parts[: 2 if parts[0] in ("vb", "map") else 1])


_PANEL, _LEFT, _FOOT, _HEAD, _KEY = 3.1, 0.65, 0.55, 0.65, 2.4
_STEP = (3.7, 4.05)
"""Inches from a panel to the next one across and downwards."""
_COLOURS = ("#56b4e9", "#009e73", "#0072b2", "#d55e00", "#cc79a7", "#444444", "#e69f00")


def people_as_text(scene: Scene, dt: float) -> str:
    """A scene at frames of ``dt`` s, a line ``frame id x y`` for each person, on cubic splines through their places."""
    from scipy.interpolate import CubicSpline

    times, lines = np.asarray(scene.dt * np.arange(scene.frames), np.float64), []
    for column, person in enumerate(scene.people.tolist()):
        for first, last in runs_of_true(scene.present[:, column]).tolist():
            if last - first < 2:
                continue
            own, places = times[first:last], scene.positions[first:last, column]
            frames = np.arange(np.ceil(own[0] / dt - 1e-9), own[-1] / dt + 1e-9)
            found: FloatArray = np.asarray(CubicSpline(own, places)(frames * dt))
            lines += [f"{frame:.0f} {person} {x:.4f} {y:.4f}" for frame, (x, y) in zip(frames, found, strict=True)]
    return "\n".join(lines) + "\n"


def errors_of(cells: Sequence[Cell], metric: str) -> Errors:
    """The errors of all solvers on one dataset, without sequences that have none; other NaN count as the cap."""
    values = np.stack([cell.score.per_sequence.figures[metric] for cell in cells])
    known = np.asarray(~np.isnan(values).all(axis=0))
    capped = np.fmin(values[:, known], cells[0].score.protocol.caps[metric])
    return Errors(values=capped, timeline=cells[0].score.per_sequence.select(known).timeline)
