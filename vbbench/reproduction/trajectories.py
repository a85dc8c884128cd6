"""One sequence of every split that is here: true and estimated trajectories of people and observer, on one sheet."""

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vbbench.errors import VbbenchError
from vbbench.generation.generator import Plan
from vbbench.generation.planning import Single
from vbbench.geometry import FloatArray
from vbbench.paper import COLUMNS
from vbbench.pictures.plotting import style
from vbbench.pictures.replay import Replay, load_replay
from vbbench.registry import registered
from vbbench.reproduction import grid
from vbbench.reproduction.grid import Making, Study
from vbbench.reproduction.report import Report, paragraphs
from vbbench.scoring.metrics import METRICS
from vbbench.table import Table

USERS_OWN = ("custom", "own")
"""Splits that show the user's own recordings alone."""
CANDIDATES = 60
"""Most sequences of a split among which one is chosen, evenly spread over it."""
MOST_PEOPLE = 20
"""In larger crowds only so many are drawn: those who come nearest to the observer."""
_ORDER = (
    *("sim", "hotel", "eth", "eth-15fps", "students", "students-resampled", "zara01", "zara02"),
    *("shibuya01", "shibuya02", "street", "motsynth", "kitti", "jrdb", "demo"),
)


class Example(NamedTuple):
    """One sequence: its name and number, what is drawn, and the means over it of the errors whose truth is known."""

    name: str
    number: int
    protocol: str
    replay: Replay
    errors: Mapping[str, float]

    @property
    def values(self) -> dict[str, Any]:
        """Its facts and errors, for JSON."""
        sequence, info = self.replay.sequence, self.replay.info
        return {
            "split": self.name,
            "sequence": self.number,
            "protocol": self.protocol,
            "frames": sequence.frames,
            "seconds": (sequence.frames - 1) * info.dt,
            "people": int(sequence.observed.any(axis=0).sum()),
            "dataset": info.id,
            "errors": dict(self.errors),
        }


class Trajectories(NamedTuple):
    """The examples, and how the sources of missing splits are got."""

    examples: list[Example]
    missing: dict[str, str]


def shown_splits() -> list[str]:
    """Names of the splits that have an example, in the order of the sheet; those of other packages last."""
    names = set(registered("generator")) - set(USERS_OWN)
    return sorted(names, key=lambda name: (_ORDER.index(name) if name in _ORDER else len(_ORDER), name))


@dataclass(frozen=True, kw_only=True)
class TrajectoriesStudy(Study):
    """An example of every split.

    Parameters
    ----------
    splits : names; none for all that `vbbench splits` lists, but for the user's own recordings.
    solvers : one registered name or ``module:attribute``.
    protocols : one, which truth it is given, and when; footage without its whole truth is solved from a cold start.
    kitti, jrdb, motsynth, argoverse2, nuscenes : the user's own downloads.
    seed : of the datasets.
    """

    name = "figure-trajectories"
    splits: tuple[str, ...] = ()
    solvers: Sequence[str] = ("vb-sf",)
    protocols: Sequence[str] = ("sequential",)
    kitti: Path | None = None
    jrdb: Path | None = None
    motsynth: Path | None = None
    argoverse2: Path | None = None
    nuscenes: Path | None = None
    seed: int = 0

    def check(self) -> None:
        """Raise VbbenchError if a split, the solver or the protocol is unknown."""
        grid.check_grid(self.solvers, self.protocols)
        if len(self.solvers) + len(self.protocols) > 2:
            raise VbbenchError("a sheet shows one solver under one protocol; name one each")
        grid.check_splits(self.splits or shown_splits(), shown_splits(), "split with an example")

    def measure(self, out: Path, making: Making) -> Trajectories:
        """Choose and solve a sequence of each split."""
        found = Trajectories([], {})
        folders = {name: getattr(self, name) for name in ("kitti", "jrdb", "motsynth", "argoverse2", "nuscenes")}
        for split in self.splits or shown_splits():
            plan = grid.plan_if_here(split, folders.get(split), self.seed)
            if plan is None:
                found.missing[split] = grid.how_to_get(split)
                continue
            number = typical_sequence(plan)
            dataset = making.planned(Single(plan, number), out / split / "dataset")
            protocol = self.protocols[0] if dataset.info.truth == "whole" else "cold-start"
            cell = making.cell(dataset, self.solvers[0], protocol)
            means = {metric: float(own.mean) for metric, own in cell.summaries.items() if np.isfinite(own.mean)}
            found.examples.append(Example(split, number, protocol, load_replay(dataset, 0, [cell.submission]), means))
        if not found.examples:
            raise VbbenchError(
                f"nothing to show: the source of {', '.join(found.missing)} is not here; 'vbbench splits' has more"
            )
        return found

    def report(self, found: Trajectories) -> Report:
        """A row an example, and what is missing; the picture has a map of each."""
        facts = {"solver": self.solvers[0], "protocol": self.protocols[0], "seed": self.seed}
        table = Table(
            facts=paragraphs("trajectories", candidates=CANDIDATES, **facts),
            head=["split", "sequence", "frames", "seconds", "people", *(METRICS[name].label for name in COLUMNS)],
            rows=[
                *(_line(one.values) for one in found.examples),
                *([split, f"missing: {how}", *[""] * 7] for split, how in found.missing.items()),
            ],
        )
        examples = [one.values for one in found.examples]
        missing = {split: how.replace("`", "") for split, how in found.missing.items()}
        return Report(
            name=self.name,
            title="Trajectories: an example of every split",
            tables=[table],
            values={**facts, "examples": examples, "missing": missing},
            pictures={"": self.plot(found)},
        )

    def plot(self, found: Trajectories) -> Figure:
        """Draw the sheet: a map of each example, what is missing below."""
        notes = [f"In m; the observer walks to the right. Of larger crowds the nearest {MOST_PEOPLE} are drawn."]
        if found.missing:
            missing = ";  ".join(f"{split}: {how}".replace("`", "") for split, how in found.missing.items())
            notes += textwrap.wrap(f"Not here:  {missing}", _NOTE_WIDTH)
        rows, foot = -(-len(found.examples) // _COLUMNS), _FOOT + len(notes) * _LINE
        width = _LEFT + _COLUMNS * _STEP[0] + _LEFT - (_STEP[0] - _PANEL[0])
        height = foot + rows * _STEP[1] + _HEAD - (_STEP[1] - _PANEL[1] - 0.5)
        panels: style.Rectangles = {
            one.name: (_LEFT + n % _COLUMNS * _STEP[0], foot + (rows - 1 - n // _COLUMNS) * _STEP[1], *_PANEL)
            for n, one in enumerate(found.examples)
        }
        sheet = style.lay_out((width, height), panels)
        for axes, one in zip(sheet.axes, found.examples, strict=True):
            draw_map(axes, one.replay)
            self._write_title(sheet, panels[one.name], one)
        left = _LEFT / width
        title = "Where people and observer walk, and where the solver says: an example of every split"
        style.write_heading(sheet, _LEFT, title)
        handles = _legend(f"{self.solvers[0]} ({self.protocols[0]})")
        look: dict[str, Any] = {"frameon": False, "fontsize": style.TEXT_SIZE, "borderpad": 0.0, "borderaxespad": 0.0}
        look |= {"loc": "upper left", "bbox_to_anchor": (left, 1.0 - 0.48 / height), "ncols": len(handles)}
        sheet.legend(handles=handles, **look)
        for n, line in enumerate(reversed(notes)):
            place = (_FOOT * 0.6 + n * _LINE) / height
            sheet.text(left, place, line, fontsize=style.TEXT_SIZE, color=style.TRUTH)
        return sheet

    def _write_title(self, sheet: Figure, panel: tuple[float, float, float, float], one: Example) -> None:
        width, height = sheet.get_size_inches()
        left, top = panel[0] / width, (panel[1] + panel[3]) / height
        sheet.text(left, top + 0.27 / height, one.name, fontsize=10.0, weight="bold", color=style.INK)
        counts = f"{one.values['people']} people, {one.values['frames']} frames"
        counts += f", {one.protocol}" if one.protocol != self.protocols[0] else ""
        sheet.text(left, top + 0.09 / height, counts, fontsize=style.TEXT_SIZE, color=style.TRUTH)
        # Where only places relative to the camera are known, Δx̃.
        shown = [name for name in ("dx", "dt") if name in one.errors] or [n for n in ("dx_rel",) if n in one.errors]
        text = "  ".join(f"{METRICS[name].symbol} {one.errors[name]:.2f}" for name in shown)
        look: dict[str, Any] = {"ha": "right", "fontsize": style.TEXT_SIZE, "color": style.INK}
        sheet.text(left + panel[2] / width, top + 0.09 / height, f"{text} m" if text else "no truth", **look)


def typical_sequence(plan: Plan) -> int:
    """The number of the first sequence with the most ordinary length and number of people, as the report defines it."""
    numbers = np.unique(np.linspace(0, len(plan) - 1, min(len(plan), CANDIDATES)).round().astype(int))
    built = [plan.build(int(number)) for number in numbers]
    people = [data.sequence.observed.sum(axis=1).mean() for data in built]
    frames = [len(data.sequence.observed) for data in built]
    ways = np.array([np.hypot(*(data.truth.poses[-1, :2] - data.truth.poses[0, :2])) for data in built])
    apart = sum(np.abs(np.log(values / np.median(values))) for values in (np.array(frames), np.array(people)))
    known = np.isfinite(ways)
    if known.any():
        apart[ways < np.median(ways[known])] = np.inf
    return int(numbers[apart.argmin()])


def _line(one: dict[str, Any]) -> list[str]:
    cells = [f"{one['errors'][name]:.3f}" if name in one["errors"] else "–" for name in COLUMNS]
    return [one["split"], str(one["sequence"]), str(one["frames"]), f"{one['seconds']:.1f}", str(one["people"]), *cells]


_COLUMNS, _PANEL, _STEP = 4, (2.72, 2.05), (3.17, 2.84)  # inches
_LEFT, _HEAD, _FOOT = 0.42, 0.78, 0.5
_LINE = 0.17  # height of a line of the note in inches
_NOTE_WIDTH = 165  # characters
_PERSON, _TRUE_PERSON = style.distance_colours()(0.35), "#c9c9c9"


def _legend(answered: str) -> list[Line2D]:
    person: dict[str, Any] = {"color": _PERSON, "linewidth": 1.0, "marker": "o", "markersize": 3.0}
    return [
        Line2D([], [], color=style.TRUTH, linewidth=3.4, label="observer, truth"),
        Line2D([], [], color=style.ESTIMATE, linewidth=1.5, label=f"observer, estimate of {answered}"),
        Line2D([], [], color=_TRUE_PERSON, linewidth=3.0, label="people, truth"),
        Line2D([], [], label="people, estimate; a dot where each is last", **person),
    ]


def draw_map(axes: Axes, replay: Replay) -> None:
    """Draw true and estimated paths, turned so that the observer gets from left to right, in m."""
    turned = style.along_path(replay.viewpoints[:, :2])
    distance = np.where(np.isfinite(replay.distances), replay.distances, np.inf).min(axis=0)
    shown = np.argsort(distance, kind="stable")[: min(MOST_PEOPLE, int(np.isfinite(distance).sum()))]
    truth = np.where(replay.sequence.observed[..., None], replay.known.positions, np.nan)
    truth, estimated = turned(truth[:, shown]), turned(replay.estimated[:, shown])
    thin = float(np.clip(np.sqrt(15.0 / max(len(shown), 1)), 0.5, 1.0))
    for places, colour, width, zorder in ((truth, _TRUE_PERSON, 3.6, 1.0), (estimated, _PERSON, 1.1, 2.0)):
        lines = style.draw_lines(axes, np.swapaxes(places, 0, 1), [colour], width * thin, zorder)
        lines.set_capstyle("round")
    x, y = _ends(estimated)
    axes.scatter(x, y, s=10.0 * thin, color=_PERSON, linewidths=0.0, zorder=2.5)
    axes.plot(*turned(replay.known.poses[:, :2]).T, color=style.TRUTH, linewidth=3.4, zorder=3.0)
    if replay.answer is not None:
        found = turned(replay.answer.estimate.poses[:, :2])
        axes.plot(*found.T, color=style.ESTIMATE, linewidth=1.5, zorder=4.0)
        end = _ends(found[:, None])
        axes.plot(*end, marker="o", markersize=5.5, color=style.ESTIMATE, markeredgecolor="white", zorder=5.0)
    places = np.vstack([truth.reshape(-1, 2), turned(replay.viewpoints[:, :2])])
    low, high = np.nanmin(places, axis=0), np.nanmax(places, axis=0)
    margin = 0.06 * max(*(high - low), 2.0)
    style.fit(axes, low - margin, high + margin)
    style.draw_grid(axes)
    axes.tick_params(labelsize=style.LABEL_SIZE)


def _ends(places: FloatArray) -> FloatArray:
    """[2, N] the last known place of everybody who has any in ``places`` [T, K, 2]."""
    known = np.isfinite(places[..., 0])
    last = len(known) - 1 - known[::-1].argmax(axis=0)
    ever = np.flatnonzero(known.any(axis=0))
    return np.asarray(places[last[ever], ever].T)
