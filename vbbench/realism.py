"""Realism report: how the people of a dataset walk, next to recorded people. It reports and does not judge."""

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.spatial.distance import cdist

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo, describe, summary
from vbbench.files.sequence_tables import SequenceTable
from vbbench.generation.generator import Generator, Options
from vbbench.generation.sources import is_here
from vbbench.geometry import BoolArray, FloatArray
from vbbench.parsing.json_text import finite_or_none
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import Rectangles, draw_heading, lay_out, save_picture
from vbbench.registry import load
from vbbench.scene import Scene


@dataclass(frozen=True)
class Samples:
    """Samples [N] of one statistic: its name, its unit ("" for none), and its values."""

    name: str
    unit: str
    values: FloatArray

    def __add__(self, other: "Samples") -> "Samples":
        return Samples(self.name, self.unit, np.concatenate([self.values, other.values]))

    @property
    def title(self) -> str:
        """The name with its unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name

    @property
    def mean(self) -> float:
        """Of the samples; NaN without any."""
        return float(self.values.mean()) if len(self.values) else np.nan

    def quantile(self, share: float) -> float:
        """The value below which lies that share of the samples; NaN without any."""
        return float(np.quantile(self.values, share)) if len(self.values) else np.nan

    def density(self, edges: FloatArray) -> FloatArray:
        """[M − 1] share of all samples per unit, between ascending edges [M]."""
        return np.asarray(np.histogram(self.values, edges)[0] / np.diff(edges) / max(len(self.values), 1))

    def to_json(self) -> dict[str, Any]:
        """Figures; null without samples."""
        shares = {"median": 0.5, "p5": 0.05, "p95": 0.95}
        figures = {"mean": self.mean, **{name: self.quantile(share) for name, share in shares.items()}}
        known = {name: finite_or_none(value) for name, value in figures.items()}
        return {"unit": self.unit, "count": len(self.values), **known}


COLLISION = 0.4
"""Two people nearer than this, in m, collide."""
SHORTEST_PATH = 1.0
"""Walks along a shorter path, in m, have no efficiency: for people who stand, jitter decides it."""

SPEED, NEAREST = Samples("speed", "m/s", np.empty(0)), Samples("nearest distance", "m", np.empty(0))
ACCELERATION, EFFICIENCY = Samples("acceleration", "m/s²", np.empty(0)), Samples("path efficiency", "", np.empty(0))


@dataclass(frozen=True, kw_only=True)
class Walking:
    """Statistics of scenes; those of more scenes are their sum.

    A walk is one uninterrupted stay of a person in a scene.

    Parameters
    ----------
    scenes : number of scenes.
    person_frames, person_seconds : how long people are present, summed over them.
    collisions, collision_seconds : pairs of people nearer than `COLLISION`, counted in each frame, and their time.
    short_walks : walks that do not count in the path efficiency, being shorter than `SHORTEST_PATH`.
    speed : between frames that follow one another, in m/s.
    nearest_distance : from each person in each frame to the nearest other one, in m.
    acceleration : second difference over three frames that follow one another, divided by dt², in m/s².
    path_efficiency : net displacement divided by path length, of each walk.
    """

    scenes: int = 0
    person_frames: int = 0
    person_seconds: float = 0.0
    collisions: int = 0
    collision_seconds: float = 0.0
    short_walks: int = 0
    speed: Samples = SPEED
    nearest_distance: Samples = NEAREST
    acceleration: Samples = ACCELERATION
    path_efficiency: Samples = EFFICIENCY

    def __add__(self, other: "Walking") -> "Walking":
        return Walking(**{name: value + getattr(other, name) for name, value in vars(self).items()})

    @property
    def dt(self) -> float:
        """Seconds per frame, the mean if scenes differ; NaN without people."""
        return self.person_seconds / self.person_frames if self.person_frames else np.nan

    @property
    def collisions_a_minute(self) -> float:
        """Colliding pairs, counted in each frame, per person-minute; it grows with the frame rate."""
        return 60.0 * self.collisions / self.person_seconds if self.person_seconds else np.nan

    @property
    def collision_seconds_a_minute(self) -> float:
        """Seconds that pairs collide per person-minute, independent of the frame rate."""
        return 60.0 * self.collision_seconds / self.person_seconds if self.person_seconds else np.nan

    @property
    def distributions(self) -> tuple[Samples, ...]:
        """The four statistics."""
        return self.speed, self.nearest_distance, self.acceleration, self.path_efficiency

    def to_json(self) -> dict[str, Any]:
        """All figures."""
        there = self.person_frames > 0
        return {
            "dt": self.dt if there else None,
            "scenes": self.scenes,
            "person_frames": self.person_frames,
            "person_minutes": self.person_seconds / 60.0,
            "collisions": {
                "limit": COLLISION,
                "pair_frames": self.collisions,
                "per_person_minute": self.collisions_a_minute if there else None,
                "seconds_per_person_minute": self.collision_seconds_a_minute if there else None,
            },
            "short_walks": self.short_walks,
            **{one.name.replace(" ", "_"): one.to_json() for one in self.distributions},
        }


def walking_statistics(scenes: Iterable[Scene]) -> Walking:
    """Measure scenes one by one."""
    return sum((_of_scene(scene) for scene in scenes), Walking())


def _of_scene(scene: Scene) -> Walking:
    nearest, collisions = _neighbours(scene.positions, scene.present)
    efficiency, short = _path_efficiency(scene.positions, scene.present)
    velocity = np.diff(scene.positions, axis=0) / scene.dt
    acceleration = np.diff(velocity, axis=0) / scene.dt
    there = int(scene.present.sum())
    return Walking(
        scenes=1,
        person_frames=there,
        person_seconds=there * scene.dt,
        collisions=collisions,
        collision_seconds=collisions * scene.dt,
        short_walks=short,
        speed=replace(SPEED, values=_lengths(velocity)),
        nearest_distance=replace(NEAREST, values=nearest),
        acceleration=replace(ACCELERATION, values=_lengths(acceleration)),
        path_efficiency=replace(EFFICIENCY, values=efficiency),
    )


def _lengths(vectors: FloatArray) -> FloatArray:
    """Lengths of those vectors [..., 2] that are known."""
    lengths = np.hypot(vectors[..., 0], vectors[..., 1])
    return lengths[~np.isnan(lengths)]


def _neighbours(positions: FloatArray, present: BoolArray) -> tuple[FloatArray, int]:
    """Distance in m of everybody in every frame to the nearest other one, and the number of colliding pairs."""
    nearest, collisions = [np.empty(0)], 0
    for people, there in zip(positions, present, strict=True):
        if there.sum() < 2:
            continue
        apart = cdist(people[there], people[there])
        np.fill_diagonal(apart, np.inf)
        nearest.append(apart.min(axis=1))
        collisions += int(np.sum(apart < COLLISION)) // 2
    return np.concatenate(nearest), collisions


def _path_efficiency(positions: FloatArray, present: BoolArray) -> tuple[FloatArray, int]:
    """Net displacement divided by path length of each walk that is long enough, and how many are not."""
    absent = np.zeros((1, present.shape[1]), dtype=np.bool_)
    earlier, later = np.vstack([absent, present[:-1]]), np.vstack([present[1:], absent])
    first, last = (np.flatnonzero((present & ~near).T) for near in (earlier, later))
    if not len(first):
        return np.empty(0), 0
    steps = np.diff(positions, axis=0, prepend=positions[:1])
    path = np.add.reduceat(np.nan_to_num(np.hypot(steps[..., 0], steps[..., 1])).T.ravel(), first)
    points = positions.transpose(1, 0, 2).reshape(-1, 2)
    net = np.linalg.norm(points[last] - points[first], axis=1)
    long_enough = path >= SHORTEST_PATH
    return np.minimum(net[long_enough] / path[long_enough], 1.0), int(np.sum(~long_enough))


REFERENCES = ("students", "eth-15fps")
"""Recorded splits to compare with; not `eth`, whose file is 1.67 times too fast."""
SCENES_AT_ONCE = 16
"""Scenes read at once."""


@dataclass(frozen=True, kw_only=True)
class Realism:
    """What was measured.

    Parameters
    ----------
    info : the facts of the dataset.
    columns : statistics of the dataset and then of every available reference, by the heading of their column.
    remarks : notes on the references, a line each.
    missing : references whose sources are not available.
    """

    info: DatasetInfo
    columns: dict[str, Walking]
    remarks: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()


def measure_realism(dataset: Dataset, references: Sequence[str] = REFERENCES) -> Realism:
    """Measure how the people of a dataset walk, and those of the recorded splits whose sources are available.

    Raises VbbenchError if the dataset's truth is withheld.
    """
    columns = {f"this: {dataset.info.split}": walking_statistics(dataset_scenes(dataset))}
    remarks, missing = [], []
    for name in references:
        generator: Generator = load("generator", name)
        if not all(map(is_here, generator.card.sources)):
            missing.append(name)
            continue
        plan = generator.plan(Options())
        columns[name] = walking_statistics(plan.scenes)
        remarks.append(": ".join(filter(None, [name, plan.info.title, plan.info.caution])))
    return Realism(info=dataset.info, columns=columns, remarks=tuple(remarks), missing=tuple(missing))


def dataset_scenes(dataset: Dataset) -> Iterator[Scene]:
    """The scenes that a dataset's sequences are taken from, each once, a few in memory at a time.

    Raises VbbenchError if the truth is withheld, or less is known than where people really are.
    """
    if dataset.info.truth != "whole":
        raise VbbenchError(f"{dataset.folder}: true positions were never measured, and so walking has no statistics")
    path = dataset.table_path("truth/scenes")
    if not path.is_file():
        raise VbbenchError(f"{dataset.folder} has no truth; name the folder that holds it with `truth`")
    table = SequenceTable(path, "truth/scenes", "scene")
    wanted = np.unique(dataset.rows["scene"])
    for start in range(0, len(wanted), SCENES_AT_ONCE):
        numbers = wanted[start : start + SCENES_AT_ONCE]
        rows = table.read(int(numbers[0]), int(numbers[-1]) + 1)
        for number in numbers:
            here = slice(*np.searchsorted(rows["scene"], [number, number + 1]))
            yield _scene(int(number), dataset.info.dt, {name: values[here] for name, values in rows.items()})


def _scene(number: int, dt: float, rows: dict[str, Any]) -> Scene:
    people, column = np.unique(rows["person"], return_inverse=True)
    frame = rows["frame"] - rows["frame"].min(initial=np.iinfo(np.int32).max)
    positions = np.full((int(frame.max(initial=-1)) + 1, len(people), 2), np.nan)
    positions[frame, column] = np.stack([rows["x"], rows["y"]], axis=-1)
    return Scene(name=str(number), dt=dt, people=people, positions=positions, heights=np.full(len(people), np.nan))


def describe_realism(report: Realism) -> str:
    """The dataset's facts, and the table: a row per statistic, a column per source."""
    widths = [max(len(heading), 9) + 3 for heading in report.columns]
    rows = [("", list(report.columns)), *_rows(list(report.columns.values()))]
    table = [
        f"{title:<38}" + "".join(f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True))
        for title, cells in rows
    ]
    notes = [*report.remarks, *(f"{name}: source not available (vbbench fetch {name})" for name in report.missing)]
    if len({round(walking.dt, 6) for walking in report.columns.values()}) > 1:
        notes.append(
            "dt differs: the shorter it is, the more of speeds and accelerations is sway and jitter; compare with care"
        )
    return "\n".join([describe(report.info), "", *table, "", *notes])


def realism_json(report: Realism, picture: Path) -> str:
    """The dataset's summary as JSON, with all figures of the report under ``realism``, on one line."""
    realism = {
        "dataset": next(iter(report.columns)),
        "sources": {heading: walking.to_json() for heading, walking in report.columns.items()},
        "remarks": report.remarks,
        "missing": report.missing,
        "picture": str(picture),
    }
    return json.dumps({**summary(report.info), "realism": realism}, ensure_ascii=False)


def _rows(walkings: list[Walking]) -> Iterator[tuple[str, list[str]]]:
    """Title and cells of every row."""
    yield "dt (s)", [f"{w.dt:.3g}" for w in walkings]
    yield "scenes", [f"{w.scenes}" for w in walkings]
    yield "person-minutes", [f"{w.person_seconds / 60.0:.1f}" for w in walkings]
    for samples in zip(*(w.distributions for w in walkings), strict=True):
        yield f"{samples[0].title:<25}samples", [f"{len(one.values)}" for one in samples]
        yield f"{'':<25}mean", [_number(one.mean) for one in samples]
        for name, share in (("5 %", 0.05), ("median", 0.5), ("95 %", 0.95)):
            yield f"{'':<25}{name}", [_number(one.quantile(share)) for one in samples]
    yield f"walks under {SHORTEST_PATH:g} m, not counted", [f"{w.short_walks}" for w in walkings]
    yield f"collisions (pairs < {COLLISION:g} m, each frame)", [f"{w.collisions}" for w in walkings]
    yield "  per person-minute", [_number(w.collisions_a_minute) for w in walkings]
    yield "  seconds per person-minute", [_number(w.collision_seconds_a_minute) for w in walkings]


def _number(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.3f}"


_SIZE = (11.0, 7.4)
_PARTS: Rectangles = {
    "speed": (0.75, 3.75, 4.7, 2.45),
    "nearest distance": (6.15, 3.75, 4.7, 2.45),
    "acceleration": (0.75, 0.6, 4.7, 2.45),
    "path efficiency": (6.15, 0.6, 4.7, 2.45),
}
_COLOURS = (style.ESTIMATE, style.GIVEN, style.INK, style.TRUTH)
_LINES = ("-", "--", ":", "-.")
_STEPS, _WALK_STEPS = 60, 25
"""Steps of a line over its panel, and of path efficiency's, as there are few walks."""
_REACH = 0.95
"""Share of the samples of every source that a panel holds at least."""
_FLOOR = 0.01
"""Least density shown on a logarithmic scale."""


def plot_realism(report: Realism) -> Figure:
    """Draw the four distributions of every source of the report."""
    figure = lay_out(_SIZE, _PARTS)
    columns = zip(*(walking.distributions for walking in report.columns.values()), strict=True)
    for axes, samples in zip(figure.axes, columns, strict=True):
        _draw_panel(axes, samples, list(report.columns))
    facts = [f"every panel holds {_REACH:.0%} of each source, or more"]
    facts += [f"{name} not available" for name in report.missing]
    legend = next(axes for axes in figure.axes if axes.get_label() == NEAREST.name)
    title = f"How people walk: {report.info.split} next to recordings"
    draw_heading(figure, 0.75, title, ";  ".join(facts), legend)
    return figure


def plot_realism_to_file(report: Realism, out: Path | str) -> Path:
    """Draw the report into a PNG, PDF or SVG file; see `save_picture`."""
    save_picture(plot_realism(report), out)
    return Path(out)


def _draw_panel(axes: Axes, samples: tuple[Samples, ...], headings: list[str]) -> None:
    shown, edges = samples[0], _edges(samples)
    if shown.name == NEAREST.name:
        label = f"collision: under {COLLISION:g} m"
        axes.axvspan(0.0, COLLISION, color=style.TRUTH_FAINT, label=label, gid="collision")
    for one, heading, colour, line in zip(samples, headings, cycle(_COLOURS), cycle(_LINES), strict=False):
        look: dict[str, Any] = {"color": colour, "linestyle": line, "linewidth": 1.4, "label": heading, "gid": heading}
        axes.stairs(one.density(edges), edges, baseline=None, **look)
    axes.set_xlim(0.0, edges[-1])
    axes.set_xlabel(shown.title, fontsize=style.TEXT_SIZE)
    axes.set_ylabel(
        f"share of samples per {shown.unit}" if shown.unit else "density of walks", fontsize=style.TEXT_SIZE
    )
    if shown.name in (ACCELERATION.name, EFFICIENCY.name):  # a linear scale would show the peak alone
        axes.set_yscale("log", nonpositive="clip")
        axes.set_ylim(bottom=_FLOOR)
    else:
        axes.set_ylim(bottom=0.0)


def _edges(samples: tuple[Samples, ...]) -> FloatArray:
    """Edges of the steps, as far as the panel reaches."""
    if samples[0].name == EFFICIENCY.name:
        return np.linspace(0.0, 1.0, _WALK_STEPS + 1)
    return np.linspace(0.0, max((one.quantile(_REACH) for one in samples if len(one.values)), default=1.0), _STEPS + 1)
