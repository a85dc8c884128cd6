"""The paper's Table 1: sequences, frames and people of every split, the paper's beside ours."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import UnknownNameError
from vbbench.folders.locks import loose_files
from vbbench.geometry import IntArray
from vbbench.reproduction.at_hand import AtHand, how_to_get
from vbbench.reproduction.making import Making
from vbbench.reproduction.report import Report
from vbbench.reproduction.simulated_recording import stand_in_plan
from vbbench.reproduction.tables.counting import Tally, count_people
from vbbench.reproduction.tables.table1_picture import plot_table1
from vbbench.reproduction.tables.table1_rows import Row, all_rows
from vbbench.table import Table

NAME = "table1"
SPLITS = tuple(dict.fromkeys(row.split for row in all_rows()))
"""Ours that stand for the paper's, in its order."""


@dataclass(frozen=True, kw_only=True)
class Table1Study:
    """What to count.

    Parameters
    ----------
    splits : of `SPLITS`.
    at_hand : where the user's own downloads are.
    seed : of the splits that are simulated.
    """

    splits: Sequence[str] = SPLITS
    at_hand: AtHand = field(default_factory=AtHand)
    seed: int = 0

    @property
    def rows(self) -> tuple[Row, ...]:
        """Those of the splits, in the paper's order.

        Raises
        ------
        UnknownNameError
            If a split is not in the table.
        """
        for split in self.splits:
            if split not in SPLITS:
                raise UnknownNameError("split of the paper's Table 1", split, SPLITS)
        return tuple(row for row in all_rows() if row.split in self.splits)


@dataclass(frozen=True, kw_only=True)
class CountedRow:
    """A row, and who was counted; nobody where the split's source is missing."""

    row: Row
    tally: Tally | None


@dataclass(frozen=True, kw_only=True)
class Table1:
    """The results of a study."""

    study: Table1Study
    rows: tuple[CountedRow, ...]


def measure_table1(study: Table1Study, out: Path | str, making: Making = Making()) -> Table1:  # noqa: B008
    """Count the people of every split, where CroHD's labels are missing also of a simulated recording in ``out``.

    Raises
    ------
    VbbenchError
        If a split is not in the table, a source cannot be read, or something else is in the way in ``out``.
    """
    out, rows, missing = Path(out), [], set()
    with loose_files(out):
        for row in study.rows:
            if row.simulated and row.split not in missing:
                continue
            tally = _simulated(row, study, out, making) if row.simulated else _at_hand(row, study)
            if tally is None:
                missing.add(row.split)
            rows.append(CountedRow(row=row, tally=tally))
    return Table1(study=study, rows=tuple(rows))


def _at_hand(row: Row, study: Table1Study) -> Tally | None:
    plan = study.at_hand.plan(row.split, study.seed)
    return None if plan is None else count_people(plan)


def _simulated(row: Row, study: Table1Study, out: Path, making: Making) -> Tally:
    return count_people(stand_in_plan(row.split, out / f"like-{row.split}", study.seed, making))


def table1_report(found: Table1) -> Report:
    """Two lines a row, the paper's and ours; what differs; and a picture of the distributions."""
    numbers = Table(
        facts=(
            "People are least / mean / most. The paper does not say whom it counts; each row counts those with whom "
            "its figures agree. The mean is over all frames together, or over sequences where people are of these.",
            "Frames are those in which anybody is seen; in brackets, where it differs, from the first to the last.",
        ),
        head=["", "", "sequences", "mean frames", "people", "counted", "seen in a frame", "seen during a sequence"],
        rows=[line for one in found.rows for line in _lines(one)],
        names=2,
    )
    why = Table(
        title="What differs, and why",
        head=["split", "difference"],
        rows=[[one.row.title, one.row.differs] for one in found.rows],
        names=2,
    )
    return Report(
        name=NAME,
        title="Table 1: sequences and people of every split",
        tables=[numbers, why],
        values={"seed": found.study.seed, "rows": [_values(one) for one in found.rows]},
        pictures={"": plot_table1([(one.row, one.tally) for one in found.rows])},
        whole=all(one.tally is not None for one in found.rows),
    )


def _lines(one: CountedRow) -> list[list[str]]:
    printed, tally = one.row.printed, one.tally
    paper = [one.row.title, "the paper", printed.sequences, printed.frames, printed.people, "", "", ""]
    if tally is None:
        return [paper, ["", f"missing: {how_to_get(one.row.split)}", *[""] * 6]]
    frames, span = tally.row["mean_frames"], float(tally.spans.mean())
    ours = [
        "",
        f"`{one.row.split}`",
        str(len(tally.frames)),
        f"{frames:.2f}" + (f" ({span:.2f})" if f"{span:.2f}" != f"{frames:.2f}" else ""),
        _three(one.row.people(tally)),
        one.row.counted,
        _three(tally.seen),
        _three(tally.passing),
    ]
    return [paper, ours]


def _three(counts: IntArray) -> str:
    return f"{counts.min()} / {counts.mean():.2f} / {counts.max()}"


def _values(one: CountedRow) -> dict[str, Any]:
    printed, tally = one.row.printed, one.tally
    values: dict[str, Any] = {
        "split": one.row.split,
        "title": one.row.title,
        "simulated": one.row.simulated,
        "paper": {"sequences": printed.sequences, "frames": printed.frames, "people": printed.people},
        "counted": one.row.counted,
    }
    if tally is None:
        return values | {"missing": how_to_get(one.row.split).replace("`", "")}
    counts = {"seen": tally.seen, "passing": tally.passing, "frames": tally.frames, "spans": tally.spans}
    if tally.crowd is not None:
        counts["crowd"] = tally.crowd
    people = one.row.people(tally)
    bounds = {"least": int(people.min()), "mean": float(people.mean()), "most": int(people.max())}
    return values | {
        "ours": tally.row,
        "people": bounds,
        "histograms": {name: _tallied(n) for name, n in counts.items()},
    }


def _tallied(counts: IntArray) -> dict[str, int]:
    """How often each number occurs."""
    numbers, often = np.unique(counts, return_counts=True)
    return dict(zip(map(str, numbers.tolist()), often.tolist(), strict=True))
