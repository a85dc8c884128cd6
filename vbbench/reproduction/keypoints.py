"""The paper's figure of the five-point method: static points at a distance, and from where on people are better.

Poses from static points at every distance, next to the errors of view birdification. An estimate gets the direction of
its translation from pixels and the length from truth.

Coordinates are those of the first camera, (right, down, forward) in m. The second stands at the centre c and is turned
by R: a point x of the first is R(x − c) for the second. The length of c is not observable from pixels. OpenCV's answer
is the five-point method of Nistér (2004) within RANSAC: the essential matrix of the best sample of five points, which
no other point corrects.
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
from scipy.spatial.transform import Rotation

from vbbench.camera import PerspectiveCamera, camera_to_dict
from vbbench.errors import SourceMissingError, VbbenchError, needs_extra
from vbbench.generation.footage import FOOTAGE, FootageOptions
from vbbench.generation.generator import Observer, Options
from vbbench.geometry import BoolArray, FloatArray
from vbbench.paper import the_paper
from vbbench.parsing.json_text import finite_or_none
from vbbench.pictures.plotting import style
from vbbench.reproduction.agreement import Estimate
from vbbench.reproduction.grid import Cell, Making, Study, check_every, check_grid, each, stride_of
from vbbench.reproduction.report import Report, paragraphs
from vbbench.table import Table

MOST_ROUNDS = 2000
"""After so many draws for a point without one that is seen, there is none."""
FEWEST = 5


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What is drawn. The numbers are the paper's; what else a reading of its text must fix comes first.

    Parameters
    ----------
    camera : both cameras.
    voxel : sides in m to the right, down and forward; the paper does not state which of its lengths is which.
    points : of a trial.
    rotation, translation : bounds in rad and m.
    noise : on every coordinate of a projection, uniform up to ± so many px.
    """

    camera: PerspectiveCamera = field(default_factory=PerspectiveCamera)
    voxel: tuple[float, float, float] = (20.0, 5.0, 10.0)
    points: int = the_paper().keypoints.points
    rotation: float = the_paper().keypoints.rotation
    translation: float = the_paper().keypoints.translation
    noise: float = the_paper().keypoints.noise


class Poses(NamedTuple):
    """Poses of the second cameras of N trials: R [N, 3, 3], and directions of c [N, 3], 0 without an answer."""

    rotation: FloatArray
    direction: FloatArray


@dataclass(frozen=True, kw_only=True)
class Views:
    """N trials at one distance.

    Parameters
    ----------
    camera : both cameras.
    rotation : [N, 3, 3] R of the second camera.
    centre : [N, 3] c of the second camera, in m.
    first, second : [N, P, 2] projections in px.
    """

    camera: PerspectiveCamera
    rotation: FloatArray
    centre: FloatArray
    first: FloatArray
    second: FloatArray

    @property
    def lengths(self) -> FloatArray:
        """[N] distance between the cameras, in m."""
        return np.asarray(np.linalg.norm(self.centre, axis=-1))

    def translation_errors(self, poses: Poses) -> FloatArray:
        """[N] in m, where translations are as long as they truly are."""
        return np.asarray(np.linalg.norm(self.lengths[:, None] * poses.direction - self.centre, axis=-1))

    def rotation_errors(self, poses: Poses) -> FloatArray:
        """[N] angles in rad between estimated and true rotations."""
        return np.asarray(Rotation.from_matrix(poses.rotation @ self.rotation.transpose(0, 2, 1)).magnitude())


def draw_views(setting: Setting, distance: float, trials: int, seed: int) -> Views:
    """Draw trials whose voxel begins at a distance in m: points until so many are seen by both cameras.

    Points and motions do not depend on the noise.

    Raises VbbenchError if the cameras do not see the voxel.
    """
    random = np.random.default_rng([seed, round(1000.0 * distance)])
    rotation, centre = _motions(setting, trials, random)
    first, second = np.full((2, trials, setting.points, 2), np.nan)
    missing = np.ones((trials, setting.points), bool)
    middle = np.array([0.0, 0.0, distance + 0.5 * setting.voxel[2]])
    for _ in range(MOST_ROUNDS):
        trial, point = np.nonzero(missing)
        places = middle + random.uniform(-0.5, 0.5, (len(trial), 3)) * setting.voxel
        turned = np.einsum("nij,nj->ni", rotation[trial], places - centre[trial])
        both = np.stack([places, turned])
        seen = both @ setting.camera.intrinsics.T
        projected = seen[..., :2] / seen[..., 2:]
        counts = _both_see(setting.camera, both, projected)
        kept = trial[counts], point[counts]
        first[kept], second[kept] = projected[:, counts]
        missing[kept] = False
        if not missing.any():
            break
    else:
        raise VbbenchError(f"the camera does not see the voxel at {distance:g} m; give one with a wider field of view")
    noise = setting.noise * random.uniform(-1.0, 1.0, (2, *first.shape))
    first, second = first + noise[0], second + noise[1]
    return Views(camera=setting.camera, rotation=rotation, centre=centre, first=first, second=second)


def _motions(setting: Setting, trials: int, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Rotations [N, 3, 3] and centres [N, 3] of the second camera, which moves on the ground plane, as people do."""
    share = random.uniform(0.0, 1.0, (2, trials))
    axis, direction = random.normal(size=(2, trials, 3))
    axis[:, ::2] = 0.0
    direction[:, 1] = 0.0
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    rotation = Rotation.from_rotvec(axis * (setting.rotation * share[0])[:, None]).as_matrix()
    return rotation, direction * (setting.translation * share[1])[:, None]


def _both_see(camera: PerspectiveCamera, points: FloatArray, projected: FloatArray) -> BoolArray:
    """[M] which points both cameras see, by coordinates [2, M, 3] for both cameras, and pixels [2, M, 2]."""
    inside = np.all((projected >= 0.0) & (projected < camera.picture_size), axis=-1)
    return np.asarray((inside & (points[..., 2] > 0.0)).all(axis=0))


def opencv() -> Any:
    """The module; raises MissingExtraError if it is not installed."""
    with needs_extra("render", "the five-point method"):
        import cv2
    return cv2


def five_point(views: Views, seed: int) -> Poses:
    """The pose of every trial; without an answer, one that has not moved."""
    cv2 = opencv()
    cv2.setRNGSeed(seed % 2**31)
    trials = len(views.centre)
    rotation, direction = np.tile(np.eye(3), (trials, 1, 1)), np.zeros((trials, 3))
    camera = views.camera.intrinsics
    for trial, pair in enumerate(zip(views.first, views.second, strict=True)):
        if len(pair[0]) < FEWEST:
            continue
        matrix, agree = cv2.findEssentialMat(*pair, camera)
        if matrix is None:
            continue
        # A sample may have several matrices, one below the other.
        found = cv2.recoverPose(matrix[:3], *pair, camera, mask=agree)
        rotation[trial], direction[trial] = found[1], -(found[1].T @ found[2])[:, 0]
    return Poses(rotation, direction)


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


class Keypoints(NamedTuple):
    """The results: errors [D, N] in m and rad of trials at distances [D] in m, how many OpenCV did not answer.

    Lines are errors of view birdification, the paper's, then ours; missing is what could not be measured, and why.
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
        """Raise VbbenchError if a solver is invalid or OpenCV is missing."""
        check_every(self.every)
        check_grid(self.solvers, self.protocols)
        opencv()

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
