"""The paper's figure of the five-point method: static points at a distance, and from where on people are better.

Poses from static points at every distance, by three estimators, next to the errors of view birdification. An estimate
gets the direction of its translation from pixels and the length from truth, except in one reading of the paper.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
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
from vbbench.reproduction.agreement import LEVEL, Estimate
from vbbench.reproduction.grid import Cell, Making, Study, check_every, check_grid, each, stride_of
from vbbench.reproduction.report import Report, paragraphs
from vbbench.reproduction.two_views import (
    ANY_DISTANCE,
    OPENCVS,
    Method,
    Setting,
    better_fit,
    bound,
    check_opencv,
    draw_views,
    five_point,
    pinhole,
    refined,
)
from vbbench.table import Table, csv_text

FIVE_POINT, LEAST_SQUARES, FROM_TRUTH = "five-point", "least squares", "from truth"
"""OpenCV's answer; the best fit to all points; the fit next to the truth, which only truth can find."""
GOOD, LOST = 0.1, 1.0
"""In m, what is taken for the paper's "good"; in rad, a larger error is of another of the four poses of a matrix."""
DISTANCES = tuple(float(distance) for distance in range(2, 41, 2))
"""In m, between the paper's bounds."""
RESAMPLES = 1000
KITTI, FIELD = "kitti", "field"
PAPER_LINE = ("street", "tracked")
"""Split and tier of the paper's error that other readings are held against: boxes of a tracker, as a robot has them."""


class Reading(NamedTuple):
    """One way to read the text: what is drawn, and how it is solved.

    With ``unit_length`` every translation is taken to be as long as its bound; otherwise as long as it truly is.
    """

    name: str
    setting: Setting
    method: Method = OPENCVS
    unit_length: bool = False


def all_readings(main: Setting) -> list[Reading]:
    """The main reading, every other one with one thing changed, and three with several."""
    deep, upright = (10.0, 5.0, 20.0), (20.0, 10.0, 5.0)
    wide, small = pinhole(640, 480, 320.0), pinhole(320, 240, 160.0)
    settings: Mapping[str, Mapping[str, Any]] = {
        "as in the figure": {},
        "camera 1920 × 1080, f 960 px (90°)": {"camera": pinhole(1920, 1080, 960.0)},
        "camera 640 × 480, f 500 px (65°)": {"camera": pinhole(640, 480, 500.0)},
        "camera 640 × 480, f 320 px (90°)": {"camera": wide},
        "camera 320 × 240, f 160 px (90°)": {"camera": small},
        "voxel 20 m deep, 10 m wide, 5 m high": {"voxel": deep},
        "voxel 5 m deep, 20 m wide, 10 m high": {"voxel": upright},
        "distance to the voxel's centre": {"from_centre": True},
        "only those of 100 points that both see": {"counted": "seen"},
        "points outside the picture count": {"counted": "in front"},
        "to the centre, points behind a camera count": {"from_centre": True, "counted": "all"},
        "turned by .20 rad, moved by 1.0 m": {"at_bound": True},
        "turned and moved in any direction": {"in_space": True},
    }
    methods = {
        "threshold 0.5 px": Method(threshold=0.5),
        "threshold 2 px": Method(threshold=2.0),
        "threshold 10⁶ px: the first sample": Method(threshold=1e6),
        "least median of squares": Method(sampling="LMEDS"),
        "MAGSAC++, refined": Method(sampling="USAC_MAGSAC"),
        "points count however far away": ANY_DISTANCE,
    }
    full = replace(main, voxel=deep, at_bound=True)
    return [
        *(Reading(name, replace(main, **changes)) for name, changes in settings.items()),
        *(Reading(name, main, method) for name, method in methods.items()),
        Reading("translation taken as 1.0 m long", main, unit_length=True),
        Reading("20 m deep, moved by 1.0 m", full),
        Reading("that, 640 × 480, f 320 px", replace(full, camera=wide)),
        Reading("that, 320 × 240, f 160 px, any direction", replace(full, camera=small, in_space=True)),
    ]


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Errors [D, N] of trials at distances [D] in m; ``seed`` is of the bootstrap.

    An error grows with distance: the means at all distances are made to rise by isotonic regression, and lie on
    straight lines between. Intervals are quantiles over a bootstrap of the trials at every distance.
    """

    distances: FloatArray
    errors: FloatArray
    seed: int = 0

    def mean_at(self, distance: float) -> float:
        """Mean error at the measured distance that is nearest."""
        return float(self.errors[np.argmin(np.abs(self.distances - distance))].mean())

    def mean_from(self, distance: float) -> float:
        """Mean error over the measured distances from one on."""
        return float(self.errors[self.distances >= distance].mean())

    def rises_over(self, value: float) -> float:
        """The distance at which the mean reaches a value: the first one if it is there already, infinite if never."""
        rising = isotonic_regression(self.errors.mean(axis=1)).x
        return float(_first_over(self.distances, rising[None], np.array([value]))[0])

    def crossing(self, level: Estimate) -> Estimate:
        """Where it rises over a mean error, by its interval log-normal, as errors are positive; equal without one."""
        levels = np.full(RESAMPLES, level.value)
        if 0.0 < level.low <= level.high:
            spread = np.log(level.high / level.low) / (2.0 * 1.96)
            levels = level.value * np.exp(spread * np.random.default_rng(self.seed).normal(size=RESAMPLES))
        found = _first_over(self.distances, self._resampled, levels)
        low, high = np.quantile(found, LEVEL, method="inverted_cdf").tolist()
        return Estimate(self.rises_over(level.value), low, high)

    @cached_property
    def _resampled(self) -> FloatArray:
        """[R, D] rising means of trials drawn with replacement."""
        places, trials = self.errors.shape
        chosen = np.random.default_rng([self.seed, 1]).integers(trials, size=(RESAMPLES, places, trials))
        means = np.take_along_axis(self.errors[None], chosen, axis=2).mean(axis=2)
        return np.stack([isotonic_regression(one).x for one in means])

    def shown(self, crossing: Estimate) -> str:
        """A crossing as text: with its interval, and ≤ and > where it is not among the distances."""
        first, last = self.distances[[0, -1]]
        one, low, high = (
            f"≤ {first:g}" if value <= first else f"> {last:g}" if np.isinf(value) else f"{value:.1f}"
            for value in crossing
        )
        return f"{one} [{low}, {high}]"


def _first_over(distances: FloatArray, rising: FloatArray, levels: FloatArray) -> FloatArray:
    """[R] where rising means [R, D], straight between the distances [D], reach levels [R]."""
    after = np.sum(rising < levels[:, None], axis=1)
    last = np.clip(after, 1, len(distances) - 1)
    row = np.arange(len(levels))
    below, above = rising[row, last - 1], rising[row, last]
    share = (levels - below) / np.where(above > below, above - below, 1.0)
    between = distances[last - 1] + share * (distances[last] - distances[last - 1])
    return np.where(after == 0, distances[0], np.where(after == len(distances), np.inf, between))


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
class People:
    """Whose boxes, and which solvers.

    Parameters
    ----------
    splits, tiers, solvers, protocols : names; every combination is measured.
    every : only every so-many-th observer of a split, and in tier `field` a third of that: every so-many-th window of
        the time of a vehicle among them, of which there are fewer. KITTI is whole.
    kitti : folder of KITTI's tracking benchmark; ``None`` to search the usual places, where it may be missing.
    poses : folder of the poses of KITTI's camera.
    seed : of the datasets.
    """

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


@dataclass(frozen=True, kw_only=True)
class Keypoints:
    """The results.

    Parameters
    ----------
    errors : by estimator, of translation in m and of rotation in rad, [D, N] of trials at every distance.
    bounds : [D] Cramér–Rao bound of the RMS error of translation, in m.
    unanswered : trials without an answer of OpenCV.
    lines : errors of view birdification: the paper's, then ours.
    missing : what of ours could not be measured, and why.
    readings : the five-point method's errors of translation by reading, the first as the main one.
    curves : errors of translation over distance, by estimator.
    """

    errors: Mapping[str, tuple[FloatArray, FloatArray]]
    bounds: list[float]
    unanswered: int
    lines: list[Line]
    missing: list[str]
    readings: Mapping[str, Curve]
    curves: Mapping[str, Curve]

    @property
    def main(self) -> Curve:
        """Of the five-point method."""
        return self.curves[FIVE_POINT]


@dataclass(frozen=True, kw_only=True)
class KeypointsStudy(Study):
    """Errors of poses from static points over their distance, and from people.

    Parameters
    ----------
    setting : what is drawn.
    distances : in m, ascending.
    trials : at each distance.
    people : whose errors are set next to it.
    seed : of the trials.
    """

    name = "figure-keypoints"
    setting: Setting = field(default_factory=Setting)
    distances: Sequence[float] = DISTANCES
    trials: int = the_paper().keypoints.trials
    people: People = field(default_factory=People)
    seed: int = 0

    @property
    def trials_of_reading(self) -> int:
        """Trials of every other reading, at every second distance."""
        return max(2, self.trials // 2)

    def check(self) -> None:
        """Raise VbbenchError if distances, trials or a solver are invalid, or OpenCV is missing."""
        if len(self.distances) < 2 or not np.all(np.diff([0.0, *self.distances]) > 0.0):
            raise VbbenchError("distances are two or more lengths above 0 m, ascending")
        if self.trials < 2:
            raise VbbenchError(f"trials must be 2 or more at each distance, not {self.trials}")
        check_every(self.people.every)
        check_grid(self.people.solvers, self.people.protocols)
        check_opencv()

    def measure(self, out: Path, making: Making) -> Keypoints:
        """Datasets of every split and tier of the people, and all trials."""
        lines, missing = paper_lines(), []
        for split, tier, options in self.people.options():
            try:
                dataset = making.dataset(split, out / f"{split}-{tier}" / "dataset", options)
            except SourceMissingError as error:
                if options.source is not None:
                    raise
                missing.append(f"{split}, {tier}: {error}")
                continue
            cells = making.cells(dataset, self.people.solvers, self.people.protocols)
            lines += [_line(split, tier, cell) for cell in cells]
        readings = all_readings(self.setting)
        main = list(each(_trials_at, [(self, one) for one in self.distances], making.jobs, "five-point", "distance"))
        others = each(_reading, [(self, one) for one in readings], making.jobs, "five-point", "reading")
        names, distances = (FIVE_POINT, LEAST_SQUARES, FROM_TRUTH), np.asarray(self.distances, dtype=float)
        errors = {name: tuple(np.stack([one[0][name][k] for one in main]) for k in (0, 1)) for name in names}
        return Keypoints(
            errors={name: (own[0], own[1]) for name, own in errors.items()},
            bounds=[one[1] for one in main],
            unanswered=sum(one[2] for one in main),
            lines=lines,
            missing=missing,
            readings={
                one.name: Curve(distances=distances[::2], errors=found, seed=self.seed)
                for one, found in zip(readings, others, strict=True)
            },
            curves={name: Curve(distances=distances, errors=own[0], seed=self.seed) for name, own in errors.items()},
        )

    def report(self, found: Keypoints) -> Report:
        """Tables by distance, by line and by reading; every error of every trial as CSV."""
        return Report(
            name=self.name,
            title="Poses from static points by the five-point method, beside those from people",
            facts=self._facts(found),
            tables=[_by_distance(found), _by_line(found), self._by_reading(found)],
            values=self._values(found),
            pictures={"": self.plot(found), "readings": self.plot_readings(found)},
            texts={".csv": _csv(found)},
            whole=not found.missing,
        )

    def _facts(self, found: Keypoints) -> list[str]:
        """What the paper states, what was done, what was found, and which readings have the paper's errors."""
        paper, main, setting = the_paper().keypoints, found.main, self.setting
        over, last = main.rises_over(paper.poor_error), main.distances[-1]
        reached = f"from {over:.1f} m on" if np.isfinite(over) else f"nowhere up to {last:g} m"
        good = {name: one for name, one in found.readings.items() if one.mean_at(paper.good_to) <= GOOD}
        there = [name for name, one in good.items() if one.mean_at(paper.poor_from) >= paper.poor_error]
        on_average = [name for name, one in good.items() if one.mean_from(paper.poor_from) >= paper.poor_error]
        unit = next(reading.name for reading in all_readings(setting) if reading.unit_length)
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
            near=f"{main.mean_at(paper.good_to):.3f}",
            good_error=f"{GOOD:g}",
            far=f"{main.mean_at(paper.poor_from):.3f}",
            beyond=f"{main.mean_from(paper.poor_from):.3f}",
            reached=reached,
            floor=[f"{found.curves[LEAST_SQUARES].mean_at(one):.3f}" for one in (paper.poor_from, last)],
            last=f"{last:g}",
            length=f"{setting.translation * (1.0 if setting.at_bound else 0.5):.2f}",
            there="; ".join(there) or "none",
            on_average="; ".join(on_average) or "none",
            unit=f"{found.readings[unit].mean_at(paper.good_to):.3f}",
            missing=found.missing,
        )

    def _by_reading(self, found: Keypoints) -> Table:
        paper = the_paper().keypoints
        line = next(one for one in found.lines if not one.protocol and (one.split, one.tier) == PAPER_LINE)
        poor = f"{paper.poor_error:.2f}"
        rows = [["the paper", f"≤ {GOOD:g}", f"≥ {poor}", f"≥ {poor}", f"{paper.poor_from:g}", ""]]
        for name, one in found.readings.items():
            over = one.rises_over(paper.poor_error)
            means = [one.mean_at(paper.good_to), one.mean_at(paper.poor_from), one.mean_from(paper.poor_from)]
            last = f"{over:.1f}" if np.isfinite(over) else f"> {one.distances[-1]:g}"
            rows.append([name, *(f"{mean:.3f}" for mean in means), last, one.shown(one.crossing(line.translation))])
        facts = paragraphs("keypoints_by_reading", trials=self.trials_of_reading)
        near, far = f"{paper.good_to:g} m", f"{paper.poor_from:g} m"
        head = ["reading", f"at {near}", f"at {far}", f"from {far} on", f"{poor} m from (m)"]
        head.append(f"the paper's {line.translation.value:.3f} m beats it from (m)")
        return Table(title="What the text leaves open", facts=facts, head=head, rows=rows)

    def _values(self, found: Keypoints) -> dict[str, Any]:
        return {
            "seed": self.seed,
            "trials": self.trials,
            "camera": camera_to_dict(self.setting.camera),
            "unanswered": found.unanswered,
            "missing": found.missing,
            "distances": found.main.distances,
            "bounds": found.bounds,
            "estimators": {
                name: dict(zip(("translation", "rotation"), map(_statistics, errors), strict=True))
                for name, errors in found.errors.items()
            },
            "lines": [
                {
                    **dict(zip(Line._fields[:5], line[:5], strict=True)),
                    "dt": line.translation._asdict(),
                    "dr": line.rotation._asdict(),
                    "crossing": {
                        name: _crossing(curve.crossing(line.translation)) for name, curve in found.curves.items()
                    },
                }
                for line in found.lines
            ],
            "readings": [{"name": name, "means": curve.errors.mean(axis=1)} for name, curve in found.readings.items()],
            "poor_from": finite_or_none(found.main.rises_over(the_paper().keypoints.poor_error)),
        }

    def plot(self, found: Keypoints) -> Figure:
        """Draw the errors of translation and rotation over distance, and lines of the first solver and the paper."""
        panels = {kind: (_LEFT, bottom, _WIDTH, height) for kind, (bottom, height) in _PLACES.items()}
        drawn = style.lay_out(_SIZE, panels)
        lines = [
            line
            for line in found.lines
            if (line.solver == self.people.solvers[0] if line.protocol else (line.split, line.tier) in _DRAWN_ROWS)
        ]
        for axes, (kind, n) in zip(drawn.axes, {"translation": 0, "rotation": 1}.items(), strict=True):
            _draw_errors(axes, found, n, _RANGES[kind])
            _draw_lines(axes, lines, found.main, kind)
        upper, lower = drawn.axes
        style.name_axes(upper, up="error of translation (m)")
        style.name_axes(lower, "distance of the static points (m)", "error of rotation (rad)")
        names = {PAPER: "the paper", OURS: f"here, {self.people.solvers[0]}", CAR: "same, KITTI"}
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

    def plot_readings(self, found: Keypoints) -> Figure:
        """Draw mean errors of every reading at the paper's distances, and what the paper states of them."""
        paper, rows = the_paper().keypoints, np.arange(len(found.readings))
        height, curves = _ROW * len(rows), found.readings.values()
        drawn = style.lay_out(
            (_NAMES + _PANEL + 0.35, _FOOT + height + _HEAD), {"readings": (_NAMES, _FOOT, _PANEL, height)}
        )
        (axes,) = drawn.axes
        near, far = f"{paper.good_to:g} m", f"{paper.poor_from:g} m"
        marks: list[tuple[str, str, str, list[float]]] = [
            (f"at {near}", OURS, "o", [one.mean_at(paper.good_to) for one in curves]),
            (f"at {far}", PAPER, "o", [one.mean_at(paper.poor_from) for one in curves]),
            (f"from {far} on", CAR, "D", [one.mean_from(paper.poor_from) for one in curves]),
        ]
        for name, colour, marker, values in marks:
            axes.plot(values, rows, marker, color=colour, markersize=5.5, label=f"mean error {name}")
        axes.axvline(GOOD, color=OURS, linewidth=1.1, label=f"{GOOD:g} m: good")
        label = f"the paper's {paper.poor_error:.2f} m from {far} on"
        axes.axvline(paper.poor_error, color=PAPER, linewidth=1.1, label=label)
        axes.set_xscale("log")
        style.plain_logarithm(axes.xaxis, LogLocator(subs=(1.0, 2.0, 5.0)))
        style.name_rows(axes, list(found.readings))
        style.name_axes(axes, "mean error of translation (m)")
        style.draw_grid(axes)
        trials = f"{self.trials_of_reading} trials at every second distance"
        facts = f"five-point method, {trials}; one thing of the figure is changed in a row, in the last three several"
        style.draw_heading(drawn, 0.3, "What the text leaves open", facts, axes)
        return drawn


def _line(split: str, tier: str, cell: Cell) -> Line:
    levels = (Estimate(own.capped, *own.capped_ci95) for own in (cell.summaries["dt"], cell.summaries["dr"]))
    return Line(split, tier, cell.solver, cell.protocol, len(cell.score.per_sequence.sequence), *levels)


def _trials_at(study: KeypointsStudy, distance: float) -> tuple[dict[str, tuple[FloatArray, FloatArray]], float, int]:
    """At one distance: errors of translation and rotation by estimator, the bound in m, and trials without answer."""
    views = draw_views(study.setting, distance, study.trials, study.seed)
    answer, near = five_point(views, OPENCVS, study.seed), refined(views, views.truth)
    # With every point in the choice among four poses, so that least squares has no wrong turn to begin with.
    found = refined(views, five_point(views, ANY_DISTANCE, study.seed))
    estimates = {FIVE_POINT: answer, LEAST_SQUARES: better_fit(views, found, near), FROM_TRUTH: near}
    errors = {
        name: (views.translation_errors(one, views.lengths), views.rotation_errors(one))
        for name, one in estimates.items()
    }
    rms = bound(study.setting, distance, study.trials, study.seed)
    return errors, rms, int(np.sum(~answer.direction.any(axis=-1)))


def _reading(study: KeypointsStudy, reading: Reading) -> FloatArray:
    """[D, N] errors of translation in m of the five-point method, at every second distance."""
    found = []
    for distance in study.distances[::2]:
        views = draw_views(reading.setting, distance, study.trials_of_reading, study.seed)
        poses = five_point(views, reading.method, study.seed)
        length = np.full(len(views.centre), reading.setting.translation) if reading.unit_length else views.lengths
        found.append(views.translation_errors(poses, length))
    return np.stack(found)


def _by_distance(found: Keypoints) -> Table:
    best, squares, near = (found.errors[name] for name in (FIVE_POINT, LEAST_SQUARES, FROM_TRUTH))
    rows = []
    for n, distance in enumerate(found.main.distances):
        quarter, middle, three = np.quantile(best[0][n], (0.25, 0.5, 0.75))
        rows.append(
            [
                f"{distance:g}",
                f"{best[0][n].mean():.3f}",
                f"{middle:.3f} ({quarter:.3f} to {three:.3f})",
                *(f"{errors[0][n].mean():.3f}" for errors in (squares, near)),
                f"{np.sqrt(np.mean(near[0][n] ** 2)):.3f} / {found.bounds[n]:.3f}",
                *(f"{np.median(errors[1][n]):.4f}" for errors in (best, squares)),
                f"{np.mean(best[1][n] > LOST):.0%}",
            ]
        )
    head = ["distance (m)", "mean", "median (quartiles)", "least squares, mean", "next to the truth, mean"]
    head += ["its RMS / bound", "rotation, median", "least squares", "lost"]
    return Table(title="By distance", facts=paragraphs("keypoints_by_distance"), head=head, rows=rows)


def _by_line(found: Keypoints) -> Table:
    rows = []
    for line in found.lines:
        who = [f"here, {line.protocol}", f"`{line.solver}`"] if line.protocol else ["the paper", line.solver]
        level = line.translation
        error = f"{level.value:.3f}" + ("" if np.isnan(level.low) else f" [{level.low:.3f}, {level.high:.3f}]")
        crossings = [found.main.shown(curve.crossing(level)) for curve in (found.main, found.curves[LEAST_SQUARES])]
        place = [f"{line.split}, {line.tier}", str(line.sequences or "")]
        rows.append([*who, *place, error, *crossings, f"{line.rotation.value:.3f}"])
    head = ["", "solver", "boxes", "sequences", "Δt (m)", "beats five points from (m)", "least squares from (m)", "Δr"]
    title, facts = "From where on people are better than points", paragraphs("keypoints_by_line")
    return Table(title=title, facts=facts, head=head, rows=rows, names=3)


def _statistics(values: FloatArray) -> dict[str, FloatArray]:
    """Of errors [D, N]: mean, quartiles and the 95th percentile at every distance."""
    shares = {"q25": 0.25, "median": 0.5, "q75": 0.75, "p95": 0.95}
    return {"mean": values.mean(axis=1), **{name: np.quantile(values, share, axis=1) for name, share in shares.items()}}


def _crossing(found: Estimate) -> dict[str, float]:
    return {"distance": found.value, "low": found.low, "high": found.high}


def _csv(found: Keypoints) -> str:
    """Errors of every trial: a row for each distance (m), trial and estimator."""
    rows = (
        [distance, trial, name, *(f"{value:.6g}" for value in pair)]
        for n, distance in enumerate(found.main.distances.tolist())
        for name, (translation, rotation) in found.errors.items()
        for trial, pair in enumerate(zip(translation[n].tolist(), rotation[n].tolist(), strict=True))
    )
    return csv_text(("distance", "trial", "estimator", "translation", "rotation"), rows)


PAPER, OURS, CAR = style.ESTIMATE, style.GIVEN, "#009e73"
"""Colours of the lines: the paper's, ours, and ours on KITTI."""
_SQUARES = "#aa4499"
_DRAWN_ROWS = (("hotel", "ideal"), ("eth", "ideal"), ("students", "ideal"), ("street", "tracked"))
"""Split and tier of the paper's rows in the picture; the table has all of them."""
_SIZE, _LEFT, _WIDTH = (12.4, 9.6), 0.85, 8.1
_PLACES = {"translation": (3.7, 4.85), "rotation": (0.6, 2.65)}
"""Bottom and height in inches of the panels."""
_RANGES = {"translation": (3e-3, 3.0), "rotation": (3e-4, 4.0)}
_GAP = 0.185
"""Inches from one label to the next."""
_NAMES, _PANEL, _ROW, _HEAD, _FOOT = 3.6, 6.4, 0.235, 1.15, 0.65
"""Inches: names, width of the panel, height of a row, over and under the panel."""


def _draw_errors(axes: Axes, found: Keypoints, kind: int, limits: tuple[float, float]) -> None:
    distances, errors = found.main.distances, {name: own[kind] for name, own in found.errors.items()}
    look: dict[str, Any] = {"color": style.TRUTH, "linewidth": 0.8}
    axes.boxplot(
        list(np.maximum(errors[FIVE_POINT], limits[0])),
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
    if kind == 0:
        best, squares, near = (errors[name].mean(axis=1) for name in (FIVE_POINT, LEAST_SQUARES, FROM_TRUTH))
        axes.plot(distances, best, color=style.INK, linewidth=1.0, marker="D", markersize=3.5, label="mean")
        axes.plot(distances, squares, color=_SQUARES, linewidth=1.6, label="least squares: mean")
        axes.plot(distances, near, color=_SQUARES, linewidth=1.2, linestyle=":", label="next to the truth")
    else:
        axes.plot(distances, np.median(errors[LEAST_SQUARES], axis=1), color=_SQUARES, linewidth=1.6)
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
