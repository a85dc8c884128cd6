"""The examples as a report: one sheet with a map of each, a table, and every number."""

import textwrap
from typing import Any

from matplotlib.figure import Figure

from vbbench.paper import COLUMNS
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import Rectangles, lay_out
from vbbench.reproduction.report import Report
from vbbench.reproduction.trajectories.choice import CANDIDATES
from vbbench.reproduction.trajectories.map import MOST_PEOPLE, draw_map, map_legend
from vbbench.reproduction.trajectories.study import Example, Trajectories
from vbbench.scoring.metrics import METRICS
from vbbench.table import Table

NAME = "figure-trajectories"
RULE = (
    f"Of up to {CANDIDATES} sequences, evenly spread over the split, the one with the most ordinary length and number "
    "of people is shown, among those whose observer gets at least as far as half of them do: the least |ln(T/median)| "
    "+ |ln(K/median)| over frames T and people K seen in a frame."
)


def trajectories_report(found: Trajectories) -> Report:
    """A row an example, and what is missing; the picture has a map of each."""
    study = found.study
    table = Table(
        facts=(
            f"Every sequence as `{study.solver}` answers it under protocol `{study.protocol}`, seed {study.seed}, each "
            "split with its own camera and exact boxes; footage has its own boxes and, where not all of its truth is "
            "known, is solved from a cold start. Errors are means over the sequence.",
            RULE,
        ),
        head=["split", "sequence", "frames", "seconds", "people", *(METRICS[name].label for name in COLUMNS)],
        rows=[
            *map(_row, found.examples),
            *([split, f"missing: {how}", *[""] * 7] for split, how in found.missing.items()),
        ],
    )
    return Report(
        name=NAME,
        title="Trajectories: an example of every split",
        tables=[table],
        values={
            "solver": study.solver,
            "protocol": study.protocol,
            "seed": study.seed,
            "examples": [_values(one) for one in found.examples],
            "missing": {split: how.replace("`", "") for split, how in found.missing.items()},
        },
        pictures={"": plot_trajectories(found)},
        whole=not found.missing,
    )


def _row(one: Example) -> list[str]:
    cells = [f"{one.errors[name]:.3f}" if name in one.errors else "–" for name in COLUMNS]
    return [one.name, str(one.number), str(one.frames), f"{one.seconds:.1f}", str(one.people), *cells]


def _values(one: Example) -> dict[str, Any]:
    counts = {
        "sequence": one.number,
        "protocol": one.protocol,
        "frames": one.frames,
        "seconds": one.seconds,
        "people": one.people,
    }
    return {"split": one.name, **counts, "dataset": one.replay.info.id, "errors": dict(one.errors)}


_COLUMNS, _PANEL, _STEP = 4, (2.62, 2.05), (2.8, 2.78)  # inches
_LEFT, _HEAD, _FOOT = 0.3, 0.78, 0.3
_LINE = 0.17  # height of a line of the note in inches
_NOTE_WIDTH = 165  # characters


def plot_trajectories(found: Trajectories) -> Figure:
    """Draw the sheet: a map of each example, what is missing below."""
    notes = _notes(found)
    size, panels = _layout(found.examples, len(notes))
    sheet = lay_out(size, panels)
    for axes, one in zip(sheet.axes, found.examples, strict=True):
        draw_map(axes, one.replay)
        _write_title(sheet, panels[one.name], one, found.study.protocol)
    left = _LEFT / size[0]
    title = "Where people and observer walk, and where the solver says: an example of every split"
    sheet.text(left, 1.0 - 0.36 / size[1], title, fontsize=12.5, weight="bold", color=style.INK)
    look: dict[str, Any] = {"frameon": False, "fontsize": style.TEXT_SIZE, "borderpad": 0.0, "borderaxespad": 0.0}
    handles = map_legend(f"{found.study.solver} ({found.study.protocol})")
    sheet.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(left, 1.0 - 0.48 / size[1]), ncols=len(handles), **look
    )
    for number, line in enumerate(reversed(notes)):
        height = (_FOOT * 0.6 + number * _LINE) / size[1]
        sheet.text(left, height, line, fontsize=style.TEXT_SIZE, color=style.TRUTH)
    return sheet


def _layout(examples: tuple[Example, ...], notes: int) -> tuple[tuple[float, float], Rectangles]:
    rows = -(-len(examples) // _COLUMNS)
    foot = _FOOT + notes * _LINE
    panels = {}
    for number, one in enumerate(examples):
        row, column = divmod(number, _COLUMNS)
        panels[one.name] = (_LEFT + column * _STEP[0], foot + (rows - 1 - row) * _STEP[1], *_PANEL)
    width = _LEFT + _COLUMNS * _STEP[0] + _LEFT - (_STEP[0] - _PANEL[0])
    return (width, foot + rows * _STEP[1] + _HEAD - (_STEP[1] - _PANEL[1] - 0.5)), panels


def _write_title(sheet: Figure, panel: tuple[float, float, float, float], one: Example, protocol: str) -> None:
    width, height = sheet.get_size_inches()
    left, top = panel[0] / width, (panel[1] + panel[3]) / height
    sheet.text(left, top + 0.27 / height, one.name, fontsize=10.0, weight="bold", color=style.INK)
    counts = ", ".join([f"{one.people} people", f"{one.frames} frames", *({one.protocol} - {protocol})])
    sheet.text(left, top + 0.09 / height, counts, fontsize=style.TEXT_SIZE, color=style.TRUTH)
    errors = [f"{METRICS[name].symbol} {one.errors[name]:.2f}" for name in _shown_errors(one)]
    text = f"{'  '.join(errors)} m" if errors else "no truth"
    look: dict[str, Any] = {"ha": "right", "fontsize": style.TEXT_SIZE, "color": style.INK}
    sheet.text(left + panel[2] / width, top + 0.09 / height, text, **look)


def _shown_errors(one: Example) -> list[str]:
    """Δx and Δt; where only places relative to the camera are known, Δx̃."""
    known = [name for name in ("dx", "dt") if name in one.errors]
    return known or [name for name in ("dx_rel",) if name in one.errors]


def _notes(found: Trajectories) -> list[str]:
    """Lines below the maps."""
    notes = [f"The observer gets from left to right. Of larger crowds the {MOST_PEOPLE} who come nearest are drawn."]
    if found.missing:
        missing = ";  ".join(f"{split}: {how}".replace("`", "") for split, how in found.missing.items())
        notes += textwrap.wrap(f"Not here:  {missing}", _NOTE_WIDTH)
    return notes
