"""The paper's figure of the five-point method: static points at a distance, and from where on people are better.

Poses from static points at every distance, next to the errors of view birdification. An estimate gets the direction of
its translation from pixels and the length from truth.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator
from scipy.optimize import isotonic_regression

from vbbench.camera import camera_to_dict
from vbbench.errors import SourceMissingError, VbbenchError
from vbbench.generation.footage import FOOTAGE, FootageOptions
from vbbench.generation.generator import Observer, Options
from vbbench.geometry import FloatArray
from vbbench.paper import the_paper
from vbbench.parsing.json_text import finite_or_none
from vbbench.pictures.plotting import style
from vbbench.reproduction.agreement import Estimate
from vbbench.reproduction.grid import Cell, Making, Study, check_every, check_grid, each, stride_of
from vbbench.reproduction.report import Report, paragraphs
from vbbench.reproduction.two_views import Setting, check_opencv, draw_views, five_point
from vbbench.table import Table

GOOD, LOST = 0.1, 1.0
"""In m, what is taken for the paper's "good"; in rad, a larger error is of another of the four poses of a matrix."""
DISTANCES = tuple(float(distance) for distance in range(2, 41, 2))
"""In m, between the paper's bounds."""
KITTI, FIELD = "kitti", "field"


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Mean errors [D] of translation at distances [D] in m.

    An error grows with distance: the means are made to rise by isotonic regression, and lie on straight lines between.
    """

    distances: FloatArray
    means: FloatArray

    def mean_at(self, distance: float) -> float:
        """Mean error at the measured distance that is nearest."""
        return float(self.means[np.argmin(np.abs(self.distances - distance))])

    def mean_from(self, distance: float) -> float:
        """Mean error over the measured distances from one on."""
        return float(self.means[self.distances >= distance].mean())

    def rises_over(self, value: float) -> float:
        """The distance at which the mean reaches a value: the first one if it is there already, infinite if never."""
        rising = isotonic_regression(self.means).x
        if value > rising[-1]:
            return float("inf")
        after = max(1, int(np.searchsorted(rising, value)))
        below, above = rising[after - 1 : after + 1]
        share = np.clip((value - below) / (above - below), 0.0, 1.0) if above > below else 0.0
        return float(self.distances[after - 1] + share * (self.distances[after] - self.distances[after - 1]))

    def shown(self, distance: float) -> str:
        """Where it rises over something as text, with ≤ and > where that is not among the distances."""
        first, last = self.distances[[0, -1]]
        return f"≤ {first:g}" if distance <= first else f"> {last:g}" if np.isinf(distance) else f"{distance:.1f}"


class Line(NamedTuple):
    """One error of view birdification: mean over sequences of min(error, cap) in m and rad; the paper's as printed.

    The paper's has 0 sequences, and no protocol, because which one it is of is open.
    """

    split: str
    tier: str
    solver: str
    protocol: str
    sequences: int
    translation: Estimate
    rotation: Estimate


def paper_lines() -> list[Line]:
    """Rows of the paper's Tables 2 to 4 that have an error of the camera, of the better of two solvers."""
    return [
        Line(row.split, row.tier, row.solver, "", 0, *(Estimate(row.figures[m], np.nan, np.nan) for m in ("dt", "dr")))
        for row in the_paper().rows
        if "dt" in row.figures and row.solver != "VB-CV"
    ]


@dataclass(frozen=True, kw_only=True)
class Keypoints:
    """The results.

    Parameters
    ----------
    distances : [D] in m.
    translation, rotation : [D, N] errors of trials at every distance, in m and rad.
    unanswered : trials without an answer of OpenCV.
    lines : errors of view birdification: the paper's, then ours.
    missing : what of ours could not be measured, and why.
    """

    distances: FloatArray
    translation: FloatArray
    rotation: FloatArray
    unanswered: int
    lines: list[Line]
    missing: list[str]

    @property
    def curve(self) -> Curve:
        """Mean errors of translation over distance."""
        return Curve(distances=self.distances, means=self.translation.mean(axis=1))


@dataclass(frozen=True, kw_only=True)
class KeypointsStudy(Study):
    """Errors of poses from static points over their distance, and from people.

    Parameters
    ----------
    setting : what is drawn.
    distances : in m, ascending.
    trials : at each distance.
    splits, tiers, solvers, protocols : whose boxes and which solvers are set next to it; every combination is measured.
    every : only every so-many-th observer of a split, and in tier `field` a third of that: every so-many-th window of
        the time of a vehicle among them, of which there are fewer. KITTI is whole.
    kitti : folder of KITTI's tracking benchmark; ``None`` to search the usual places, where it may be missing.
    poses : folder of the poses of KITTI's camera.
    seed : of the trials and the datasets.
    """

    name = "figure-keypoints"
    setting: Setting = field(default_factory=Setting)
    distances: Sequence[float] = DISTANCES
    trials: int = the_paper().keypoints.trials
    splits: Sequence[str] = ("hotel", "eth")
    tiers: Sequence[str] = ("tracked", FIELD)
    solvers: Sequence[str] = ("map-causal", "vb-sf")
    protocols: Sequence[str] = ("one-step", "sequential")
    every: int = 6
    kitti: Path | None = None
    poses: Path | None = None
    seed: int = 0

    def options(self) -> Iterator[tuple[str, str, Options]]:
        """Every split and tier with its options; a walker's camera with borders hardly sees people whole."""
        for split in self.splits:
            for tier in self.tiers:
                stride = max(1, self.every // 3) if tier == FIELD else self.every
                observer: Observer = "vehicle" if tier == FIELD else "walker"
                yield split, tier, Options(tier=tier, seed=self.seed, stride=stride_of(stride), observer=observer)
        yield KITTI, FOOTAGE, Options(source=self.kitti, footage=FootageOptions(poses=self.poses))

    def check(self) -> None:
        """Raise VbbenchError if distances, trials or a solver are invalid, or OpenCV is missing."""
        if len(self.distances) < 2 or not np.all(np.diff([0.0, *self.distances]) > 0.0):
            raise VbbenchError("distances are two or more lengths above 0 m, ascending")
        if self.trials < 2:
            raise VbbenchError(f"trials must be 2 or more at each distance, not {self.trials}")
        check_every(self.every)
        check_grid(self.solvers, self.protocols)
        check_opencv()

    def measure(self, out: Path, making: Making) -> Keypoints:
        """Datasets of every split and tier of the people, and all trials."""
        lines, missing = paper_lines(), []
        for split, tier, options in self.options():
            try:
                dataset = making.dataset(split, out / f"{split}-{tier}" / "dataset", options)
            except SourceMissingError as error:
                if options.source is not None:
                    raise
                missing.append(f"{split}, {tier}: {error}")
                continue
            cells = making.cells(dataset, self.solvers, self.protocols)
            lines += [_line(split, tier, cell) for cell in cells]
        calls = [(self, one) for one in self.distances]
        trials = list(each(_trials_at, calls, making.jobs, "five-point", "distance"))
        translation, rotation, unanswered = zip(*trials, strict=True)
        return Keypoints(
            distances=np.asarray(self.distances, dtype=float),
            translation=np.stack(translation),
            rotation=np.stack(rotation),
            unanswered=sum(unanswered),
            lines=lines,
            missing=missing,
        )

    def report(self, found: Keypoints) -> Report:
        """Tables by distance and by line."""
        return Report(
            name=self.name,
            title="Poses from static points by the five-point method, next to those from people",
            facts=self._facts(found),
            tables=[_by_distance(found), _by_line(found)],
            values=self._values(found),
            pictures={"": self.plot(found)},
            whole=not found.missing,
        )

    def _facts(self, found: Keypoints) -> list[str]:
        """What the paper states, what was done, and what was found."""
        paper, curve, setting = the_paper().keypoints, found.curve, self.setting
        over, last = curve.rises_over(paper.poor_error), curve.distances[-1]
        return paragraphs(
            "keypoints",
            paper=paper,
            sides=" × ".join(f"{side:g}" for side in paper.voxel),
            good=f"{paper.good_to:g}",
            poor=f"{paper.poor_from:g}",
            trials=self.trials,
            seed=self.seed,
            camera=setting.camera,
            voxel=[f"{side:g}" for side in setting.voxel],
            near=f"{curve.mean_at(paper.good_to):.3f}",
            good_error=f"{GOOD:g}",
            far=f"{curve.mean_at(paper.poor_from):.3f}",
            beyond=f"{curve.mean_from(paper.poor_from):.3f}",
            reached=f"from {over:.1f} m on" if np.isfinite(over) else f"nowhere up to {last:g} m",
            length=f"{0.5 * setting.translation:.2f}",
            missing=found.missing,
        )

    def _values(self, found: Keypoints) -> dict[str, Any]:
        return {
            "seed": self.seed,
            "trials": self.trials,
            "camera": camera_to_dict(self.setting.camera),
            "unanswered": found.unanswered,
            "missing": found.missing,
            "distances": found.distances,
            "translation": _statistics(found.translation),
            "rotation": _statistics(found.rotation),
            "lines": [
                {
                    **dict(zip(Line._fields[:5], line[:5], strict=True)),
                    "dt": line.translation._asdict(),
                    "dr": line.rotation._asdict(),
                    "better_from": finite_or_none(found.curve.rises_over(line.translation.value)),
                }
                for line in found.lines
            ],
            "poor_from": finite_or_none(found.curve.rises_over(the_paper().keypoints.poor_error)),
        }

    def plot(self, found: Keypoints) -> Figure:
        """Draw the errors of translation and rotation over distance, and lines of the first solver and the paper."""
        panels = {kind: (_LEFT, bottom, _WIDTH, height) for kind, (bottom, height) in _PLACES.items()}
        drawn = style.lay_out(_SIZE, panels)
        lines = [
            line
            for line in found.lines
            if (line.solver == self.solvers[0] if line.protocol else (line.split, line.tier) in _DRAWN_ROWS)
        ]
        for axes, kind in zip(drawn.axes, _PLACES, strict=True):
            _draw_errors(axes, found, kind)
            _draw_lines(axes, lines, found.curve, kind)
        upper, lower = drawn.axes
        style.name_axes(upper, up="error of translation (m)")
        style.name_axes(lower, "distance of the static points (m)", "error of rotation (rad)")
        names = {PAPER: "the paper", OURS: f"here, {self.solvers[0]}", CAR: "same, KITTI"}
        for colour, name in names.items():
            upper.plot([], [], color=colour, linewidth=1.6, label=name)
        camera = self.setting.camera
        facts = (
            f"{self.trials} trials at each distance, 100 points, ±1 px, {camera.width} × {camera.height} px, "
            f"f {camera.focal:g} px, length of translation true; boxes: quartiles, "
            "whiskers: 1.5 times their distance; dashed: sequential"
        )
        title = "How far off is the camera? Static points at a distance, and people around it"
        style.draw_heading(drawn, _LEFT, title, facts, upper)
        return drawn


def _line(split: str, tier: str, cell: Cell) -> Line:
    levels = (Estimate(own.capped, *own.capped_ci95) for own in (cell.summaries["dt"], cell.summaries["dr"]))
    return Line(split, tier, cell.solver, cell.protocol, len(cell.score.per_sequence.sequence), *levels)


def _trials_at(study: KeypointsStudy, distance: float) -> tuple[FloatArray, FloatArray, int]:
    """At one distance: errors [N] of translation and rotation, and the number of trials without an answer."""
    views = draw_views(study.setting, distance, study.trials, study.seed)
    answer = five_point(views, study.seed)
    unanswered = int(np.sum(~answer.direction.any(axis=-1)))
    return views.translation_errors(answer), views.rotation_errors(answer), unanswered


def _by_distance(found: Keypoints) -> Table:
    rows = []
    for distance, moved, turned in zip(found.distances, found.translation, found.rotation, strict=True):
        quarter, middle, three = np.quantile(moved, (0.25, 0.5, 0.75))
        quartiles = f"{middle:.3f} ({quarter:.3f} to {three:.3f})"
        lost = f"{np.mean(turned > LOST):.0%}"
        rows.append([f"{distance:g}", f"{moved.mean():.3f}", quartiles, f"{np.median(turned):.4f}", lost])
    head = ["distance (m)", "mean", "median (quartiles)", "rotation, median", "lost"]
    return Table(title="By distance", facts=paragraphs("keypoints_by_distance"), head=head, rows=rows)


def _by_line(found: Keypoints) -> Table:
    rows = []
    for line in found.lines:
        who = [f"here, {line.protocol}", f"`{line.solver}`"] if line.protocol else ["the paper", line.solver]
        level = line.translation
        error = f"{level.value:.3f}" + ("" if np.isnan(level.low) else f" [{level.low:.3f}, {level.high:.3f}]")
        better = found.curve.shown(found.curve.rises_over(level.value))
        place = [f"{line.split}, {line.tier}", str(line.sequences or "")]
        rows.append([*who, *place, error, better, f"{line.rotation.value:.3f}"])
    head = ["", "solver", "boxes", "sequences", "Δt (m)", "beats five points from (m)", "Δr"]
    title, facts = "From where on people are better than points", paragraphs("keypoints_by_line")
    return Table(title=title, facts=facts, head=head, rows=rows, names=3)


def _statistics(values: FloatArray) -> dict[str, FloatArray]:
    """Of errors [D, N]: mean, quartiles and the 95th percentile at every distance."""
    shares = {"q25": 0.25, "median": 0.5, "q75": 0.75, "p95": 0.95}
    return {"mean": values.mean(axis=1), **{name: np.quantile(values, share, axis=1) for name, share in shares.items()}}


PAPER, OURS, CAR = style.ESTIMATE, style.GIVEN, "#009e73"
"""Colours of the lines: the paper's, ours, and ours on KITTI."""
_DRAWN_ROWS = (("hotel", "ideal"), ("eth", "ideal"), ("students", "ideal"), ("street", "tracked"))
"""Split and tier of the paper's rows in the picture; the table has all of them."""
_SIZE, _LEFT, _WIDTH = (12.4, 9.6), 0.85, 8.1
_PLACES = {"translation": (3.7, 4.85), "rotation": (0.6, 2.65)}
"""Bottom and height in inches of the panels."""
_RANGES = {"translation": (3e-3, 3.0), "rotation": (3e-4, 4.0)}
_GAP = 0.185
"""Inches from one label to the next."""


def _draw_errors(axes: Axes, found: Keypoints, kind: str) -> None:
    distances, limits = found.distances, _RANGES[kind]
    errors: FloatArray = getattr(found, kind)
    look: dict[str, Any] = {"color": style.TRUTH, "linewidth": 0.8}
    axes.boxplot(
        list(np.maximum(errors, limits[0])),
        positions=distances,
        widths=0.55 * float(np.min(np.diff(distances))),
        manage_ticks=False,
        patch_artist=True,
        boxprops={"facecolor": style.TRUTH_FAINT, "edgecolor": style.TRUTH, "linewidth": 0.8},
        medianprops={"color": style.INK, "linewidth": 1.4},
        whiskerprops=look,
        capprops=look,
        flierprops={"marker": ".", "markersize": 2.5, "markeredgecolor": style.TRUTH_TAIL},
    )
    axes.plot([], [], color=style.INK, linewidth=1.4, label="five points: median")
    if kind == "translation":
        look = {"color": style.INK, "linewidth": 1.0, "marker": "D", "markersize": 3.5}
        axes.plot(distances, errors.mean(axis=1), label="mean", **look)
    axes.set_yscale("log")
    axes.set_ylim(*limits)
    style.plain_logarithm(axes.yaxis, LogLocator(subs=(1.0, 3.0)))
    step = float(distances[1] - distances[0])
    axes.set_xlim(distances[0] - 0.7 * step, distances[-1] + 0.7 * step)
    axes.set_xticks(distances)
    axes.xaxis.set_major_formatter("{x:g}")
    style.draw_grid(axes, axis="y")


def _draw_lines(axes: Axes, lines: Sequence[Line], curve: Curve, kind: str) -> None:
    """Horizontal lines with labels, and a point where each meets the mean of the five-point method."""
    inches, (lowest, highest), last = _PLACES[kind][1], _RANGES[kind], curve.distances[-1]
    levels = [getattr(line, kind).value for line in lines]
    wanted = inches * np.log(np.array(levels) / lowest) / np.log(highest / lowest)
    heights = style.spread(wanted, _GAP, 0.1, inches - 0.1) / inches
    for line, level, place in zip(lines, levels, heights.tolist(), strict=True):
        where = line.split if line.tier in ("ideal", "footage") else f"{line.split}, {line.tier}"
        text = f"{where}{f', {line.protocol}' if line.protocol else ''} {level:.3f}"
        colour = PAPER if not line.protocol else CAR if line.split == KITTI else OURS
        if kind == "translation":
            distance = curve.rises_over(level)
            reached = f"from {distance:.0f} m on" if distance > curve.distances[0] else "everywhere"
            text += f": better {reached}" if np.isfinite(distance) else f": not up to {last:g} m"
            if curve.distances[0] < distance < np.inf:
                axes.plot(distance, level, "o", color=colour, markersize=5.5, markeredgecolor="white", zorder=4)
        dashes = "--" if line.protocol == "sequential" else "-"
        axes.axhline(level, color=colour, linewidth=1.1, linestyle=dashes, alpha=0.85, zorder=1.5)
        leader = {
            "arrowstyle": "-",
            "color": colour,
            "linewidth": 0.6,
            "shrinkA": 2,
            "shrinkB": 0,
            "relpos": (0.0, 0.5),
        }
        look: dict[str, Any] = {"va": "center", "fontsize": 7.6, "color": colour, "arrowprops": leader}
        at: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "axes fraction"}
        axes.annotate(text, xy=(1.0, level), xytext=(1.04, place), **at, **look)
