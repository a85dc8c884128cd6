"""The paper's Table 4: split `street` with centre lines drawn by hand, and with boxes of a tracker.

The inputs are centre lines with jitter, boxes of a tracker by the paper's rule of tracks, and these boxes under the ids
of the people.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import LogLocator

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Options, Simulation
from vbbench.generation.planning import DerivedPlan
from vbbench.paper import COLUMNS, PROTOCOLS, the_paper
from vbbench.pictures.plotting import style
from vbbench.protocol import arrivals_given
from vbbench.registry import load
from vbbench.reproduction.grid import Making, Row, Study, check_grid, row_at, rows_at
from vbbench.reproduction.report import Report, paragraphs
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import Summary
from vbbench.sequence import NOBODY, SequenceData, Truth, held_persons
from vbbench.table import Table

SPLIT = "street"
LEAST_TRACK = 4
"""The paper keeps who is tracked in more than three frames."""
KEPT, LINKED = f"tracked-{LEAST_TRACK}", f"linked-{LEAST_TRACK}"
"""Boxes of the tracker by the paper's rule, and the same under true ids."""
LABELS = {
    KEPT: f"tracked, {LEAST_TRACK} frames or more",
    LINKED: "tracked, true ids",
}


@dataclass(frozen=True)
class LinkedByTruth(DerivedPlan):
    """A plan's sequences as a tracker without identity switches gives them.

    The boxes stay; each goes to the track of the person behind it, and those of nobody are removed.
    """

    @cached_property
    def info(self) -> DatasetInfo:
        """The published facts."""
        info = self.whole.info
        return replace(info, definition={**info.definition, "linked": "by truth"})

    def build(self, index: int) -> SequenceData:
        """One sequence."""
        return linked_by_truth(self.whole.build(index))


def linked_by_truth(data: SequenceData) -> SequenceData:
    """A tracked sequence with a track for each person; see `LinkedByTruth`.

    Raises
    ------
    VbbenchError
        If its tracks are no tracker's, or its scene is not its own.
    """
    if data.persons is None or data.scene is None:
        raise VbbenchError("only tracks of a simulated crowd can be linked by truth; take tier tracked of street")
    found, scene = data.sequence, data.scene
    frame, track = np.nonzero(found.observed & (data.persons != NOBODY))
    people, column = np.unique(data.persons[frame, track], return_inverse=True)
    shape = (found.frames, len(people))
    boxes, visible = np.full((*shape, 3), np.nan), np.full(shape, np.nan)
    boxes[frame, column], visible[frame, column] = found.observations[frame, track], found.visible[frame, track]
    observed = ~np.isnan(visible)
    persons = held_persons(np.broadcast_to(people, shape), observed)
    column = np.searchsorted(scene.people, people)
    places = scene.positions[found.first_frame :][: found.frames, column]
    positions = np.where((persons == NOBODY)[..., None], np.nan, places)
    truth = Truth(poses=data.truth.poses, positions=positions, heights=scene.heights[column])
    tracks, given = np.arange(len(people)), arrivals_given(truth, observed)
    sequence = replace(found, tracks=tracks, observations=boxes, visible=visible, given=given)
    return replace(data, sequence=sequence, truth=truth, persons=persons)


class Table4(NamedTuple):
    """Number of sequences, what each input is, a row for each protocol, input and solver, and the frame to draw."""

    sequences: int
    inputs: list[Row]
    rows: list[Row]
    lines: Dataset
    tracks: Dataset

    def figures(self, protocol: str, solver: str, source: str) -> dict[str, Summary]:
        """Metric → summary of one row."""
        found: dict[str, Summary] = row_at(self.rows, protocol=protocol, solver=solver, input=source)["figures"]
        return found


@dataclass(frozen=True, kw_only=True)
class Table4Study(Study):
    """Every solver under both protocols on every input.

    Parameters
    ----------
    solvers : registered names or ``module:attribute``.
    jitter : standard deviations in px of column, top and bottom of centre lines.
    sequences : of each input; ``None`` for as many as the scenario has.
    seed : of the datasets.
    """

    name = "table4"
    solvers: Sequence[str] = ("vb-cv", "vb-sf", "vb-sf-literal", "map-causal")
    jitter: Sequence[float] = (0.0, 1.0, 2.0, 4.0)
    sequences: int | None = None
    seed: int = 0

    def check(self) -> None:
        """Raise VbbenchError if a solver or the jitter is invalid."""
        check_grid(self.solvers, PROTOCOLS)
        if not self.jitter or len(set(self.jitter)) < len(self.jitter) or min(self.jitter) < 0.0:
            raise VbbenchError(f"jitter is one or more different numbers of px, 0 or more, not {list(self.jitter)}")

    @property
    def lines(self) -> dict[str, float]:
        """Jitter in px of each input of centre lines."""
        return {f"cline-{jitter:g}px": jitter for jitter in self.jitter}

    def measure(self, out: Path, making: Making) -> Table4:
        """A dataset for each input."""
        simulation = None if self.sequences is None else Simulation(sequences=self.sequences)
        plain = Options(seed=self.seed, simulation=simulation)
        least_tracks = {**dict.fromkeys(self.lines), KEPT: LEAST_TRACK, LINKED: LEAST_TRACK}
        inputs: list[Row] = [
            {"kind": name.partition("-")[0], "jitter": self.lines.get(name, 0.0), "least_track": least, "name": name}
            for name, least in least_tracks.items()
        ]
        datasets = {}
        for one in inputs:
            folder = out / str(one["name"]) / "dataset"
            options = replace(plain, tier="tracked", least_track=one["least_track"])
            if one["kind"] == "cline":
                options = replace(plain, tier="noisy", noise=one["jitter"]) if one["jitter"] else plain
            if one["kind"] == "linked":
                plan = LinkedByTruth(load("generator", SPLIT).plan(options))
                datasets[one["name"]] = making.planned(plan, folder)
            else:
                datasets[one["name"]] = making.dataset(SPLIT, folder, options)
        rows = [
            {
                "protocol": protocol,
                "solver": cell.solver,
                "input": name,
                "figures": {metric: cell.summaries[metric] for metric in COLUMNS},
            }
            for protocol, (name, dataset) in product(PROTOCOLS, datasets.items())
            for cell in making.cells(dataset, self.solvers, [protocol])
        ]
        lines = datasets[list(self.lines)[-1]]
        return Table4(len(lines), inputs, rows, lines, datasets[KEPT])

    def report(self, found: Table4) -> Report:
        """The rows of both protocols, and their ratios."""
        names = {"cline": "ideal", "tracked": "tracked"}
        rows = {name: the_paper().select(SPLIT, tier) for name, tier in names.items()}
        paper = {name: {metric: row.figures[metric] for metric in COLUMNS} for name, (row,) in rows.items()}
        paper["ratio"] = {metric: paper["tracked"][metric] / paper["cline"][metric] for metric in COLUMNS}
        ratios = [*self._ratios(found)]
        return Report(
            name=self.name,
            title=f"Table 4: split {SPLIT}, seed {self.seed}, {found.sequences} sequences",
            facts=paragraphs("table4", least=LEAST_TRACK),
            tables=[
                *(self._errors(found, protocol, paper) for protocol in PROTOCOLS),
                _ratio_table(ratios, paper["ratio"]),
            ],
            values={
                "sequences": found.sequences,
                "seed": self.seed,
                "paper": paper,
                "inputs": found.inputs,
                "rows": found.rows,
                "ratios": ratios,
            },
            pictures={"": self.plot(found, paper)},
        )

    def _errors(self, found: Table4, protocol: str, paper: dict[str, dict[str, float]]) -> Table:
        labels = LABELS | {name: f"cline, {px:g} px" if px else "cline, exact" for name, px in self.lines.items()}
        head = ["solver", "input", *(METRICS[metric].label for metric in COLUMNS)]
        rows = [["the paper", name, *(f"{paper[name][m]:.3f}" for m in COLUMNS)] for name in ("cline", "tracked")]
        rows += [
            [f"`{row['solver']}`", labels[row["input"]], *map(_cell, row["figures"].values())]
            for row in rows_at(found.rows, protocol=protocol)
        ]
        return Table(title=f"Errors, {protocol}", head=head, rows=rows, names=2)

    def _ratios(self, found: Table4) -> Iterator[Row]:
        """Of every protocol, solver and jitter: with the tracker's ids and with true ones, metric by metric."""
        for protocol, solver, (line, jitter) in product(PROTOCOLS, dict.fromkeys(self.solvers), self.lines.items()):
            below = found.figures(protocol, solver, line)
            times = {
                kind: {
                    metric: {
                        "sequences": own.mean / below[metric].mean,
                        "frames": own.frame_mean / below[metric].frame_mean,
                    }
                    for metric, own in found.figures(protocol, solver, source).items()
                }
                for kind, source in (("tracked", KEPT), ("linked", LINKED))
            }
            yield {"protocol": protocol, "solver": solver, "jitter": jitter, **times}

    def plot(self, found: Table4, paper: dict[str, dict[str, float]]) -> Figure:
        """Draw a frame with both inputs, and the errors that come of them, with the paper's."""
        rectangles: style.Rectangles = {
            **{name: (_LEFT + n * (_VIEW[0] + 0.1), 3.55, *_VIEW) for n, name in enumerate(("lines", "boxes"))},
            **{name: (_LEFT + n * _STEP, 0.75, *_PANEL) for n, name in enumerate(COLUMNS)},
        }
        drawn = style.lay_out((_WIDTH, _HEIGHT), rectangles)
        axes = {str(one.get_label()): one for one in drawn.axes}
        _draw_example(axes["lines"], axes["boxes"], found, self.jitter[-1])
        for metric in COLUMNS:
            self._draw_panel(axes[metric], metric, found, paper)
        facts = (
            f"split {SPLIT}, seed {self.seed}, {found.sequences} sequences; below: means over frames, as the paper "
            "has them; tracks of 4 frames or more"
        )
        style.draw_heading(drawn, _LEFT, "Centre lines and a tracker's boxes", facts, axes["lines"])
        point: dict[str, Any] = {"marker": "o", "markersize": 4.0}
        handles = [Line2D([], [], color=colour, label=solver, **point) for solver, colour in self._colours.items()]
        handles += [Line2D([], [], color=style.TRUTH, label=name, **point, **look) for name, look in LOOKS.items()]
        handles.append(Line2D([], [], color=style.INK, linewidth=2.2, label="the paper"))
        look: dict[str, Any] = {"borderaxespad": 0.0, "frameon": False, "fontsize": style.TEXT_SIZE}
        place = (_LEFT / _WIDTH, 0.12 / _HEIGHT)
        drawn.legend(handles=handles, loc="lower left", bbox_to_anchor=place, ncols=len(handles), **look)
        return drawn

    @property
    def _colours(self) -> dict[str, str]:
        return {solver: COLOURS[n % len(COLOURS)] for n, solver in enumerate(dict.fromkeys(self.solvers))}

    def _draw_panel(self, axes: Axes, metric: str, found: Table4, paper: dict[str, dict[str, float]]) -> None:
        inputs, lines = [*self.lines, KEPT, LINKED], len(self.lines)
        places = np.arange(len(inputs))
        for (solver, colour), protocol in product(self._colours.items(), PROTOCOLS):
            means = [found.figures(protocol, solver, name)[metric].frame_mean for name in inputs]
            look: dict[str, Any] = {"color": colour, "marker": "o", "markersize": 4.0, **LOOKS[protocol]}
            axes.plot(places[:lines], means[:lines], **look)
            axes.plot(places[lines:], means[lines:], **look)
        axes.axvspan(lines - 0.5, len(inputs) - 0.5, color="#f6f6f6", zorder=0)
        look = {"color": style.INK, "linewidth": 2.2, "zorder": 5, "solid_capstyle": "butt"}
        axes.plot([-0.4, lines - 0.6], [paper["cline"][metric]] * 2, **look)
        axes.plot([lines - 0.4, len(inputs) - 0.6], [paper["tracked"][metric]] * 2, **look)
        middle = (lines + len(inputs) - 1) / 2
        look = {"ha": "center", "va": "bottom", "fontsize": style.TEXT_SIZE, "color": style.INK}
        axes.text(middle, 1.08 * paper["tracked"][metric], f"× {paper['ratio'][metric]:.2f}", **look)
        axes.set_yscale("log")
        style.plain_logarithm(axes.yaxis, LogLocator(numticks=8))
        axes.set_xlim(-0.5, len(inputs) - 0.5)
        names = [f"{jitter:g} px" if jitter else "exact" for jitter in self.jitter]
        axes.set_xticks(places, [*names, "tracked", "true\nids"], fontsize=7.0)
        style.name_axes(axes, title=METRICS[metric].label)
        style.draw_grid(axes)


def _cell(own: Summary) -> str:
    places = 4 if own.mean < 0.1 else 3 if own.mean < 1.0 else 2
    return f"{own.mean:.{places}f} ({own.frame_mean:.{places}f} ± {own.frame_std:.{places}f})"


def _ratio_table(ratios: Sequence[Row], paper: dict[str, float]) -> Table:
    plain = [METRICS[metric].symbol for metric in COLUMNS]
    rows = [["the paper", "", "by hand", *(f"{value:.2f}" for value in paper.values()), "", ""]]
    for one in ratios:
        pairs = [*one["tracked"].values(), *list(one["linked"].values())[:2]]
        cells = [
            " / ".join(f"{value:.2f}" if value < 10.0 else f"{value:.0f}" for value in own.values()) for own in pairs
        ]
        jitter = f"{one['jitter']:g} px" if one["jitter"] else "exact"
        rows.append([f"`{one['solver']}`", one["protocol"], jitter, *cells])
    head = ["solver", "protocol", "cline", *plain, *(f"{label}, true ids" for label in plain[:2])]
    return Table(title="The ratio of the two rows", facts=paragraphs("table4_ratios"), head=head, rows=rows, names=3)


COLOURS = (style.GIVEN, style.ESTIMATE, "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
LOOKS: dict[str, dict[str, Any]] = {
    "one-step": {"linestyle": "-", "linewidth": 1.6},
    "sequential": {"linestyle": (0, (2.5, 2.0)), "linewidth": 1.0, "fillstyle": "none"},
}
ASPECT = 0.36
"""Width of a person's box over its height, as the tracker's boxes have it."""
SKY = 0.2
"""Upper part of the picture that is not drawn: nobody is there."""
_WIDTH, _HEIGHT, _LEFT = 13.0, 7.25, 0.7  # inches
_VIEW, _PANEL, _STEP = (5.95, 2.68), (2.45, 2.35), 3.12


def _draw_example(left: Axes, right: Axes, found: Table4, jitter: float) -> None:
    """Centre lines and tracked boxes in the frame of the first sequence with most tracks after an identity switch."""
    drawn, tracked = found.lines.sequence(0), found.tracks.sequence(0)
    persons, observed = found.tracks.track_persons(tracked), tracked.observed
    begun = persons[(persons != NOBODY).argmax(axis=0), np.arange(len(tracked.tracks))]
    frame = int((observed & (persons != NOBODY) & (persons != begun)).sum(axis=1).argmax())
    seen = observed[frame]
    camera = found.tracks.camera(tracked)
    width, height = camera.picture_size
    horizon = float(camera.horizon(np.array([width / 2.0]))[0])
    hand = f"jitter of {jitter:g} px" if jitter else "exact"
    titles = {
        left: f"cline ({hand}), sequence 0, frame {frame}",
        right: "tracked, the same frame: that with the most tracks after an identity switch",
    }
    for axes, title in titles.items():
        axes.add_patch(Rectangle((0, 0), width, horizon, color="#f4f7fa", zorder=0))
        axes.add_patch(Rectangle((0, horizon), width, height - horizon, color=style.FIELD, zorder=0))
        axes.axhline(horizon, color=style.FIELD_EDGE, linewidth=0.8, zorder=1)
        axes.set(xlim=(0, width), ylim=(height, SKY * height), xticks=[], yticks=[])
        style.name_axes(axes, title=title)
    lines = drawn.observations[frame, drawn.observed[frame]]
    u, v, length = lines[np.argsort(lines[:, 2])].T
    ends = np.stack([np.stack([u, v - length / 2], axis=-1), np.stack([u, v + length / 2], axis=-1)], axis=1)
    style.draw_lines(left, ends, style.INK, 1.2, 3)
    left.plot(*ends.reshape(-1, 2).T, linestyle="none", marker="o", markersize=2.6, color=style.INK, zorder=4)
    labels = {
        style.GIVEN: "still the person it began with",
        style.ESTIMATE: "another person by now",
        style.UNSEEN: "nobody",
    }
    for (u, v, length), person, first in zip(
        tracked.observations[frame, seen], persons[frame, seen], begun[seen], strict=True
    ):
        colour = style.UNSEEN if person == NOBODY else style.GIVEN if person == first else style.ESTIMATE
        corner, size = (u - ASPECT * length / 2, v - length / 2), (ASPECT * length, length)
        right.add_patch(Rectangle(corner, *size, facecolor=(*to_rgb(colour), 0.12), edgecolor="none", zorder=2))
        right.add_patch(Rectangle(corner, *size, fill=False, edgecolor=colour, linewidth=1.3, zorder=3))
    handles = [Line2D([], [], color=colour, linewidth=2.0, label=label) for colour, label in labels.items()]
    right.legend(handles=handles, loc="upper right", fontsize=style.TEXT_SIZE, frameon=True, framealpha=0.9, ncols=3)
