"""The paper's experiment with a robot: the camera's motion is not given, and odometry is the reference.

Recordings: a simulated robot that sees all around, as JRDB's does, whose true path is known, so that drift of its
odometry is measured, too; KITTI's car; and JRDB. Solvers: `vb-sf` with nothing expected of the observer, as in the
paper, and one that models real cameras, by the camera alone and with odometry.

Drift is that of KITTI's odometry benchmark, from every frame i to the first frame j by which the camera has gone L m
along the true path, with places x, yaws ψ, estimates ^ and truth *:

    shift = ‖(x_j − x_i)^ − (x_j − x_i)*‖ / L, in the axes of frame i;   turn = |wrap((ψ_j − ψ_i)^ − (ψ_j − ψ_i)*)| / L.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from vbbench.errors import SourceMissingError, VbbenchError
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.submission_tables import SubmittedEstimates
from vbbench.files.tables import ODOMETRY_TABLE
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options, Simulation, tables_of
from vbbench.generation.planning import DerivedPlan
from vbbench.generation.sources import data_folders
from vbbench.geometry import FloatArray, IntArray, motion_between, moved_as_one, wrap_angle
from vbbench.pictures.plotting import style
from vbbench.registry import load
from vbbench.reproduction.grid import Making, Study, check_grid
from vbbench.reproduction.report import Report, paragraphs
from vbbench.reproduction.variants import registered_variants
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import Summary
from vbbench.sequence import Given, Odometry, SequenceData
from vbbench.sequence import Sequence as Observed
from vbbench.table import Table

PAPER_VARIANT, SOLVER = "vb-sf-free", "map-causal"
"""The paper's solver with nothing expected of the observer, as a registered variant; and one that uses odometry."""
SCENARIO, TIER = "concourse", "field"
"""The crowd that the simulated robot drives through, and the tier of its boxes: drawn by hand, as JRDB's are."""
LONGEST = 400
"""Frames after which a recording is cut: splits cut earlier, within less than 40 m."""
LENGTHS = tuple(float(length) for length in range(5, 45, 5))
"""m of the curve's points."""
TABLE_LENGTHS = (5.0, 10.0, 20.0, 40.0)
"""m of the table's columns."""
PLACES = ("dx_rel", "dx")
"""Metrics of people's places: as seen from the camera, and on the map."""


class Entrant(NamedTuple):
    """A solver and its title; with ``odometry`` it gets odometry, where there is any."""

    solver: str
    title: str
    odometry: bool = False


def default_entrants() -> tuple[Entrant, ...]:
    """The paper's, and one more without odometry and with it."""
    return (Entrant(registered_variants()[PAPER_VARIANT].solver, "vb-sf, observer free"), *with_and_without(SOLVER))


def with_and_without(solver: str) -> tuple[Entrant, Entrant]:
    """A solver by the camera alone, and with odometry."""
    return Entrant(solver, solver), Entrant(solver, f"{solver} with odometry", odometry=True)


class Recording(NamedTuple):
    """A recording to be measured.

    Its ``reference`` names the path that was measured without people; it comes from a dataset with the options
    ``other``, or from odometry.
    """

    name: str
    title: str
    split: str
    options: Options
    reference: str
    other: Options | None = None


class Drift(NamedTuple):
    """Errors of all N segments of one length in m: shift [N] as a share of it, and turn [N] in rad for each m."""

    length: float
    shift: FloatArray
    turn: FloatArray

    @property
    def values(self) -> dict[str, float | int | None]:
        """Its figures, with ``None`` for those of no segment."""
        figures = (
            [self.shift.mean(), *np.quantile(self.shift, (0.25, 0.5, 0.75)), self.turn.mean()]
            if len(self.shift)
            else [None] * 5
        )
        names = ("mean", "quartile", "median", "upper_quartile", "turn_mean")
        return {"length": self.length, "segments": len(self.shift), **dict(zip(names, figures, strict=True))}


def distances(poses: FloatArray) -> FloatArray:
    """[T] metres driven since frame 0, by poses [T, 3]."""
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def drift(pairs: Sequence[tuple[FloatArray, FloatArray]], length: float) -> Drift:
    """The errors of all segments of ``length`` m.

    Parameters
    ----------
    pairs : of each sequence, the estimated and the true poses [T, 3] (x, y, yaw); NaN where nothing was estimated.
    """
    errors = np.concatenate([np.empty((0, 2)), *(_segments(*pair, length) for pair in pairs)])
    return Drift(length, errors[:, 0], errors[:, 1])


def _segments(estimate: FloatArray, truth: FloatArray, length: float) -> FloatArray:
    """[N, 2] shift and turn by ``length`` of each segment of one sequence."""
    way = distances(truth)
    last = np.searchsorted(way, way + length)
    first = np.flatnonzero(last < len(way))
    last = last[first]
    off: FloatArray = motion_between(estimate[first], estimate[last]) - motion_between(truth[first], truth[last])
    errors = np.stack([np.hypot(off[:, 0], off[:, 1]), np.abs(wrap_angle(off[:, 2]))], axis=-1) / length
    kept: FloatArray = errors[np.isfinite(errors).all(axis=1)]
    return kept


def dead_reckoning(odometry: Odometry, start: FloatArray) -> FloatArray:
    """[T, 3] the poses that measured motions lead to from the pose ``start`` [3]; NaN after one that is missing."""
    moved = np.array(odometry.motions)
    moved[0] = 0.0
    yaw = start[2] + np.cumsum(moved[:, 2])
    before = np.concatenate([[start[2]], yaw[:-1]])
    forward, left, cos, sin = moved[:, 0], moved[:, 1], np.cos(before), np.sin(before)
    x, y = np.cumsum(cos * forward - sin * left), np.cumsum(sin * forward + cos * left)
    return np.stack([start[0] + x, start[1] + y, wrap_angle(yaw)], axis=-1)


@dataclass(frozen=True)
class CameraAlone(DerivedPlan):
    """A plan's sequences without odometry; the dataset's definition, and so its id, states that."""

    @cached_property
    def info(self) -> DatasetInfo:
        """The published facts."""
        info = self.whole.info
        return replace(info, definition={**info.definition, "odometry": False})

    @property
    def tables(self) -> tuple[str, ...]:
        """Those of the whole but for odometry's."""
        return tuple(name for name in super().tables if name != ODOMETRY_TABLE)

    def build(self, index: int) -> SequenceData:
        """One sequence."""
        data = self.whole.build(index)
        given = data.sequence.given
        alone = Given(poses=given.poses, positions=given.positions)
        return replace(data, sequence=replace(data.sequence, given=alone))


class Way(NamedTuple):
    """What a solver, or a reference, did in one recording under one protocol ("" for a reference).

    Drift at each of `LENGTHS`; figures by metric, none for a reference; and its answer to the sequence that is drawn.
    """

    title: str
    protocol: str
    drifts: list[Drift]
    figures: Mapping[str, Summary]
    poses: FloatArray
    positions: FloatArray | None


class Course(NamedTuple):
    """One recording measured: metres [N] gone in each sequence, paths, and the sequence in which it went farthest."""

    recording: Recording
    metres: FloatArray
    paths: list[Way]
    dataset: Dataset
    sequence: Observed


class Robot(NamedTuple):
    """What the study found: recordings, and why others are missing."""

    courses: list[Course]
    missing: list[str]


@dataclass(frozen=True, kw_only=True)
class RobotStudy(Study):
    """Drift and errors on every recording that is here.

    Parameters
    ----------
    jrdb, bags : JRDB's folder, and that of its rosbags, which hold how the robot moved.
    kitti, poses : KITTI's folder, and that of the camera's poses by another method; both are looked for in the data
        folders where no ``kitti`` is named.
    sequences : of the simulated robot, a minute each.
    seed : of all random numbers.
    entrants : the solvers of the experiment.
    solvers : further ones, each without odometry and with it: registered names or ``module:attribute``.
    protocols : names of protocols; maps show the first.
    """

    name = "figure-robot"
    jrdb: Path | None = None
    bags: Path | None = None
    kitti: Path | None = None
    poses: Path | None = None
    sequences: int = 6
    seed: int = 0
    entrants: Sequence[Entrant] = field(default_factory=default_entrants)
    solvers: Sequence[str] = ()
    protocols: Sequence[str] = ("sequential", "cold-start")

    @property
    def everybody(self) -> list[Entrant]:
        """All solvers, each once."""
        further = (entrant for solver in self.solvers for entrant in with_and_without(solver))
        return list(dict.fromkeys([*self.entrants, *further]))

    def check(self) -> None:
        """Raise VbbenchError if a solver or a protocol is unknown, or JRDB is named without bags."""
        if self.jrdb is not None and self.bags is None:
            raise VbbenchError(f"{self.jrdb}: only its rosbags hold how JRDB's robot moved; name their folder (--bags)")
        check_grid((entrant.solver for entrant in self.everybody), self.protocols)
        self.recordings()

    def recordings(self) -> list[Recording]:
        """Those that are measured, if their files are here."""
        simulated = Options(
            camera=load("generator", "jrdb").camera,
            tier=TIER,
            observer="robot",
            detector=False,
            seed=self.seed,
            simulation=Simulation(scenario=SCENARIO, sequences=self.sequences),
        )
        poses = self.poses
        if self.kitti is None and poses is None:
            nearby = (folder / "kitti" / "poses" for folder in data_folders())
            poses = next((folder for folder in nearby if folder.is_dir()), None)
        kitti = Options(source=self.kitti, footage=FootageOptions(longest=LONGEST, poses=poses))
        other = None if poses is None else replace(kitti, footage=FootageOptions(longest=LONGEST))
        jrdb = Options(source=self.jrdb, footage=FootageOptions(longest=LONGEST, bags=self.bags))
        found = [
            Recording("simulated", "A simulated robot", "sim", simulated, "odometry of wheels and gyro, filtered"),
            Recording("kitti", "KITTI's car", "kitti", kitti, "GPS and IMU against stereo SLAM", other),
            Recording("jrdb", "JRDB's robot", "jrdb", jrdb, "odometry of the wheels alone"),
        ]
        return found if self.jrdb is not None else found[:2]

    def measure(self, out: Path, making: Making) -> Robot:
        """Datasets with and without odometry of every recording that is here."""
        found = Robot([], [])
        for recording in self.recordings():
            try:
                found.courses.append(self._course(recording, out / recording.name, making))
            except SourceMissingError as error:
                found.missing.append(f"{recording.name} is missing: {error}")
        if self.jrdb is None:
            found.missing.extend(paragraphs("jrdb_missing"))
        return found

    def _course(self, recording: Recording, out: Path, making: Making) -> Course:
        plan = load("generator", recording.split).plan(recording.options)
        whole = making.dataset(recording.split, out / "whole" / "dataset", recording.options)
        if whole.info.truth != "whole":
            raise VbbenchError(f"{recording.name}: its poses are not known, and no drift can be measured")
        alone = whole
        if ODOMETRY_TABLE in tables_of(plan):
            alone = making.planned(CameraAlone(plan), out / "camera-alone" / "dataset")
        sequences = list(whole.sequences())
        truths = [whole.truth(sequence).poses for sequence in sequences]
        metres = np.array([distances(poses)[-1] for poses in truths])
        shown, paths = int(metres.argmax()), list[Way]()

        def add(title: str, ways: Sequence[FloatArray], protocol: str = "", **more: Any) -> None:
            pairs = list(zip(ways, truths, strict=True))
            drifts = [drift(pairs, length) for length in LENGTHS]
            paths.append(Way(title, protocol, drifts, poses=ways[shown], **{"figures": {}, "positions": None, **more}))

        if recording.other is not None:
            other = making.dataset(recording.split, out / "other" / "dataset", recording.other)
            ways = [other.truth(sequence).poses for sequence in sequences]
            same = [np.array_equal(way, own) for way, own in zip(ways, truths, strict=True)]
            moved = [moved_as_one(way, way[0], own[0]) for way, own in zip(ways, truths, strict=True)]
            # NaN where the other source is the truth itself.
            add(recording.reference, [np.full(w.shape, np.nan) if n else w for w, n in zip(moved, same, strict=True)])
        elif alone is not whole:
            measured = [(one.given.odometry, own[0]) for one, own in zip(sequences, truths, strict=True)]
            add(recording.reference, [dead_reckoning(moved, start) for moved, start in measured if moved is not None])
        for protocol in self.protocols:
            for solver, title, odometry in self.everybody:
                if odometry and alone is whole:
                    continue
                dataset = whole if odometry else alone
                cell = making.cell(dataset, solver, protocol)
                submitted = SubmittedEstimates(dataset, cell.submission)
                answers: list[Estimate] = [submitted.of(sequence) for sequence in dataset.sequences()]
                positions = answers[shown].positions
                add(title, [one.poses for one in answers], protocol, figures=cell.summaries, positions=positions)
        return Course(recording, metres, paths, whole, sequences[shown])

    def report(self, found: Robot) -> Report:
        """A table and a picture for each recording."""
        labels = " and ".join(METRICS[name].label for name in PLACES)
        values = {"seed": self.seed, "tier": TIER, "missing": found.missing}
        conditions = f"simulated robot in tier {TIER}, seed {self.seed}"
        return Report(
            name=self.name,
            title=f"A camera whose motion is not given: drift over the distance gone; {conditions}",
            facts=paragraphs("robot", labels=labels, missing=found.missing),
            tables=list(map(_table, found.courses)),
            values={**values, "recordings": list(map(_values, found.courses))},
            pictures={course.recording.name: plot_course(course, self.protocols) for course in found.courses},
        )


def _table(course: Course) -> Table:
    gone = course.metres[course.metres >= 1.0]
    stands = len(course.metres) - len(gone)
    ways = f"{len(gone)} sequences, {gone.min():.0f} to {gone.max():.0f} m" if len(gone) else "no sequence that moves"
    standing = f", and {stands} in which the camera stands or hardly moves" if stands else ""
    figures = [f"drift over {length:g} m" for length in TABLE_LENGTHS]
    return Table(
        title=f"{course.recording.title}: {ways}{standing}",
        facts=paragraphs(f"robot_{course.recording.name}", solver=SOLVER),
        head=["way", "protocol", *figures, "turned over 10 m", *(METRICS[name].label for name in PLACES)],
        rows=list(map(_line, course.paths)),
        names=2,
    )


def _line(path: Way) -> list[str]:
    by_length = {one.length: one for one in path.drifts}
    shifts = [
        f"{100.0 * one.shift.mean():.1f} % ({100.0 * np.quantile(one.shift, 0.5):.1f})" if len(one.shift) else "–"
        for one in (by_length[length] for length in TABLE_LENGTHS)
    ]
    turn, figures = by_length[10.0].turn, [path.figures.get(metric) for metric in PLACES]
    turned = f"{10.0 * turn.mean():.3f} rad" if len(turn) else "–"
    places = ["–" if own is None else f"{own.capped:.2f} ({own.median:.2f})" for own in figures]
    return [path.title, path.protocol or "–", *shifts, turned, *places]


def _values(course: Course) -> dict[str, Any]:
    rows = [
        {
            "way": path.title,
            "protocol": path.protocol or None,
            "drift": [one.values for one in path.drifts],
            "figures": dict(path.figures),
        }
        for path in course.paths
    ]
    facts = {"name": course.recording.name, "metres": course.metres, "shown": course.sequence.index}
    return {**facts, "rows": rows}


MOST_MAPS = 3
"""Solvers that have a map: the first of the study."""
STEPS = 500
"""Steps of people on a map, about the middle of its way; with more than that nothing can be found."""
_HUES = (style.ESTIMATE, style.GIVEN, "#009e73", "#e69f00", "#56b4e9")
"""Of solvers in their order; the reference is purple (Okabe and Ito)."""
_REFERENCE = "#a4508b"
_LEFT, _MAP, _GAP, _DRIFT, _HEAD, _FOOT = 0.55, 4.0, 0.2, 3.0, 1.1, 0.5  # inches


def plot_course(course: Course, protocols: Sequence[str]) -> Figure:
    """Draw the sequence in which the camera went farthest, and the drift over all sequences."""
    observed = course.sequence.observed
    solvers = list(dict.fromkeys(path.title for path in course.paths if path.protocol))
    hues = {title: _HUES[n % len(_HUES)] for n, title in enumerate(solvers)} | {course.recording.reference: _REFERENCE}
    mapped = [path for path in course.paths if path.protocol == protocols[0]][:MOST_MAPS]
    width = _LEFT + len(mapped) * (_MAP + _GAP) + 0.4 + _DRIFT + 0.3
    panels: style.Rectangles = {
        path.title: (_LEFT + n * (_MAP + _GAP), _FOOT, _MAP, _MAP) for n, path in enumerate(mapped)
    }
    panels["drift"] = (width - _DRIFT - 0.3, _FOOT, _DRIFT, _MAP)
    drawn = style.lay_out((width, _FOOT + _MAP + _HEAD), panels)
    parts = {str(axes.get_label()): axes for axes in drawn.axes}
    seen = np.flatnonzero(observed.any(axis=1))
    around = steps_around(observed.sum(axis=1), int(seen[len(seen) // 2]))
    start = course.dataset.truth(course.sequence).poses[0, :2]
    for path in mapped:
        _draw_map(parts[path.title], course, path, hues[path.title], around)
        parts[path.title].tick_params(labelleft=path is mapped[0])
        for other in [path for path in course.paths if not path.protocol]:
            moved = (other.poses[:, :2] - start).T
            parts[path.title].plot(*moved, color=_REFERENCE, linewidth=1.3, linestyle=(0, (3, 2)), zorder=3.4)
    _draw_drift(parts["drift"], course, protocols, hues)
    dt = course.dataset.info.dt
    facts = (
        f"maps: {protocols[0]}, sequence {course.sequence.index}, {course.metres.max():.0f} m in "
        f"{course.sequence.frames * dt:.0f} s; people for {(around.stop - around.start) * dt:.0f} s half-way, grey "
        "where they truly were"
    )
    style.draw_heading(drawn, _LEFT, course.recording.title, facts, parts["drift"])
    return drawn


def steps_around(people: IntArray, frame: int) -> slice:
    """The frames about a frame in which people [T] make `STEPS` steps, or all of them."""
    reach = 1
    while people[max(frame - reach, 0) : frame + reach + 1].sum() < STEPS and reach < len(people):
        reach += 1
    return slice(max(frame - reach, 0), min(frame + reach + 1, len(people)))


def _draw_map(axes: Axes, course: Course, path: Way, hue: str, around: slice) -> None:
    """One solver's map in m from where the camera truly began, with what lies up to 25 m from its true path."""
    truth, observed = course.dataset.truth(course.sequence), course.sequence.observed
    true, start = truth.poses[:, :2], truth.poses[0, :2]
    near = truth.positions[observed].clip(true.min(axis=0) - 25.0, true.max(axis=0) + 25.0)
    points = np.concatenate([true, near]) - start
    style.fit(axes, np.nanmin(points, axis=0) - 1.0, np.nanmax(points, axis=0) + 1.0)
    style.name_axes(axes, "m")
    style.draw_grid(axes)
    seen = observed[around, :, None]
    estimated = np.full_like(truth.positions, np.nan) if path.positions is None else path.positions
    for positions, colour, width in ((truth.positions, style.TRUTH_TAIL, 1.6), (estimated, hue, 0.8)):
        lines = np.where(seen, positions[around], np.nan) - start
        style.draw_lines(axes, np.swapaxes(lines, 0, 1), colour, width, 2.0)
    axes.plot(*(true - start).T, color=style.INK, linewidth=2.4, zorder=3.0)
    way = path.poses[:, :2] - start
    axes.plot(*way[np.isfinite(way).all(axis=1)].T, color=hue, linewidth=1.8, zorder=3.2)
    axes.set_title(path.title, fontsize=10.0, loc="left", color=hue, weight="bold")


def _draw_drift(axes: Axes, course: Course, protocols: Sequence[str], hues: Mapping[str, str]) -> None:
    """Mean drift of every path; dotted under all protocols but the first."""
    dotted: dict[str, Any] = {"linewidth": 1.4, "linestyle": (0, (1, 1.4))}
    for path in course.paths:
        known = [(one.length, 100.0 * one.shift.mean()) for one in path.drifts if len(one.shift)]
        look: dict[str, Any] = {"linewidth": 2.0, "marker": "o", "markersize": 3.5, "label": path.title}
        if path.protocol not in ("", protocols[0]):
            look = dotted
        if not path.protocol:
            look["linestyle"] = (0, (3, 2))
        axes.plot(*np.array(known).reshape(-1, 2).T, color=hues[path.title], **look)
    axes.plot([], [], color=style.INK, linewidth=2.2, label="the true way")
    for protocol in protocols[1:]:
        axes.plot([], [], color=style.TRUTH, label=f"{protocol} (right)", **dotted)
    axes.set_yscale("log")
    style.plain_logarithm(axes.yaxis, FixedLocator([0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0]))
    style.draw_grid(axes)
    style.name_axes(axes, "distance gone (m)")
    axes.set_title("drift, % of the distance", fontsize=10.0, loc="left", color=style.INK, weight="bold")
