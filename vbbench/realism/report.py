"""Realism report: how the people of a dataset walk, beside recorded people. It reports and does not judge."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo, describe, summary
from vbbench.files.sequence_tables import SequenceTable
from vbbench.generation.generator import Generator, Options
from vbbench.generation.sources import is_here
from vbbench.realism.walking import COLLISION, SHORTEST_PATH, Walking, walking_statistics
from vbbench.registry import load
from vbbench.scene import Scene

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

    Raises
    ------
    VbbenchError
        If the dataset's truth is withheld.
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

    Raises
    ------
    VbbenchError
        If the truth is withheld, or less is known than where people really are.
    """
    if dataset.info.truth != "whole":
        raise VbbenchError(f"{dataset.folder}: where people really are was never measured, and so not how they walk")
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
    """The dataset's summary as JSON, with all figures and bins of the report under ``realism``, on one line."""
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
    for histograms in zip(*(w.distributions for w in walkings), strict=True):
        yield f"{histograms[0].axis.title:<25}samples", [f"{h.count}" for h in histograms]
        yield f"{'':<25}mean", [_number(h.mean) for h in histograms]
        for name, share in (("5 %", 0.05), ("median", 0.5), ("95 %", 0.95)):
            yield f"{'':<25}{name}", [_number(h.quantile(share)) for h in histograms]
    yield f"walks under {SHORTEST_PATH:g} m, left out", [f"{w.short_walks}" for w in walkings]
    yield f"collisions (pairs < {COLLISION:g} m, each frame)", [f"{w.collisions}" for w in walkings]
    yield "  per person-minute", [_number(w.collisions_a_minute) for w in walkings]
    yield "  seconds per person-minute", [_number(w.collision_seconds_a_minute) for w in walkings]


def _number(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.3f}"
