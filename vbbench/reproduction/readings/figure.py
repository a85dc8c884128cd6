"""The readings of the paper as a report: a table, every number, and a picture with a row a reading."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from vbbench.paper import BEST, HEADLINE, the_paper
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import Rectangles, draw_heading, lay_out
from vbbench.reproduction.readings.study import (
    HALF_WIDTH,
    SOLVER,
    MeasuredReading,
    Reading,
    Readings,
)
from vbbench.reproduction.report import Report
from vbbench.scoring.metrics import METRICS, section
from vbbench.table import Table

NAME = "readings"
_WHAT_IS_KNOWN = {"learned": "learned", "known": "known", "prior": "N(μ, σ²)"}


def readings_report(found: Readings) -> Report:
    """A row a reading: Δx averaged over sequences and over frames, and how many times the paper's it is."""
    splits, label = found.study.splits, METRICS[HEADLINE].label
    printed = [f"{the_paper().figures(split, BEST)[HEADLINE]:.3f}" for split in splits]
    table = Table(
        head=["protocol", "heights", "observer walks", "field", "solver", *splits, "times the paper's"],
        rows=[["the paper", "", "", "", BEST, *printed, "1"], *map(_row, found.rows)],
        names=5,
    )
    facts = (
        f"{label}: mean over sequences / over frames. Last column: geometric mean over splits of the same by the "
        f"paper's. Scaled: to [−{HALF_WIDTH:g}, {HALF_WIDTH:g}] m, in metres of the scaled field.",
    )
    return Report(
        name=NAME,
        title=f"Every reading of the paper's {BEST}, tier ideal, {conditions(found)}",
        facts=facts,
        tables=[table],
        values=readings_values(found),
        pictures={"": plot_readings(found)},
    )


def conditions(found: Readings) -> str:
    """Which sequences the study used, as text."""
    counts = ", ".join(f"{split} {count}" for split, count in found.sequences.items())
    some = "all sequences" if found.study.every == 1 else f"every {found.study.every}th sequence"
    return f"seed {found.study.seed}, {some} ({counts})"


def readings_values(found: Readings) -> dict[str, Any]:
    """Every figure: the study, the paper's row, and a row a reading with all metrics of all splits."""
    study = found.study
    return {
        "every": study.every,
        "seed": study.seed,
        "sequences": dict(found.sequences),
        "paper": {split: dict(the_paper().figures(split, BEST)) for split in study.splits},
        "readings": [
            {
                **vars(row.reading),
                "text": row.reading.is_text,
                "figures": {
                    split: {name: summary.to_dict() for name, summary in own.items()}
                    for split, own in row.summaries.items()
                },
                "times_the_paper": {
                    name: {"sequences": row.times_the_paper(name), "frames": row.times_the_paper(name, frames=True)}
                    for name in section("metrics")
                },
            }
            for row in found.rows
        ],
    }


def _row(row: MeasuredReading) -> list[str]:
    one = row.reading
    cells = [f"{own[HEADLINE].mean:.3f} / {own[HEADLINE].frame_mean:.3f}" for own in row.summaries.values()]
    times = f"{row.times_the_paper():.2f} / {row.times_the_paper(frames=True):.2f}"
    facts = [one.protocol, _WHAT_IS_KNOWN[one.heights], "yes" if one.ego_prior else "no"]
    name = f"`{one.solver}`" if one.literal or one.solver == SOLVER else f"`{SOLVER}`, changed"
    return [*facts, "scaled" if one.scaled else "metres", name, *cells, times]


_LEFT, _PANEL, _GAP, _LINE = 3.6, 2.6, 0.25, 0.2  # inches: names, width of a panel, between panels, height of a row
_HEAD, _FOOT = 1.15, 0.65


def plot_readings(found: Readings) -> Figure:
    """Draw Δx of every reading, a panel a split, the paper's as a line."""
    splits, height = found.study.splits, _LINE * len(found.rows)
    width = _LEFT + len(splits) * (_PANEL + _GAP)
    panels: Rectangles = {split: (_LEFT + n * (_PANEL + _GAP), _FOOT, _PANEL, height) for n, split in enumerate(splits)}
    drawn = lay_out((width, _FOOT + height + _HEAD), panels)
    for axes, split in zip(drawn.axes, splits, strict=True):
        _draw_panel(axes, split, found)
    drawn.axes[0].set_yticks(range(len(found.rows)), [_name(row.reading) for row in found.rows])
    title = f"{METRICS[HEADLINE].label} of every reading of the paper"
    draw_heading(drawn, 0.3, title, f"tier ideal, {conditions(found)}", drawn.axes[0])
    return drawn


def _draw_panel(axes: Axes, split: str, found: Readings) -> None:
    rows = np.arange(len(found.rows))
    own = [row.summaries[split][HEADLINE] for row in found.rows]
    axes.axvline(
        the_paper().figures(split, BEST)[HEADLINE], color=style.ESTIMATE, linewidth=1.2, label="the paper's figure"
    )
    look: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 4.5}
    axes.plot([s.frame_mean for s in own], rows, color=style.TRUTH, fillstyle="none", label="over frames", **look)
    axes.plot([s.mean for s in own], rows, color=style.GIVEN, label="over sequences", **look)
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_yticks(rows, [])
    axes.set_title(split, fontsize=10.0, loc="left", color=style.INK)
    axes.set_xlabel(METRICS[HEADLINE].label, fontsize=style.TEXT_SIZE)
    axes.grid(color=style.FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
    for row in rows[:-1]:
        if found.rows[row].reading.protocol != found.rows[row + 1].reading.protocol:
            axes.axhline(row + 0.5, color=style.INK, linewidth=0.6)


def _name(one: Reading) -> str:
    heights = {"learned": "heights learned", "known": "heights known", "prior": "heights N(μ, σ²)"}[one.heights]
    observer = "to the letter" if one.literal else "observer walks" if one.ego_prior else "observer free"
    return f"{one.protocol}, {'scaled, ' if one.scaled else ''}{heights}, {observer}"
