"""The paper's Table 1: sequences, frames and people of every split, the paper's next to ours.

People are counted from a split's plan: no dataset is made, and boxes only where nothing else shows who is seen.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vbbench.files.dataset_info import DatasetInfo, summary
from vbbench.generation.generator import ForesightedPlan, Plan
from vbbench.geometry import IntArray
from vbbench.paper import the_paper
from vbbench.reproduction.grid import Making, Study, check_splits, how_to_get, plan_if_here
from vbbench.reproduction.report import Report, paragraphs
from vbbench.table import Table

IN_A_FRAME, DURING, OF_THE_SCENE = "in a frame", "during a sequence", "of the scene"
"""Whom the paper's people are taken to be."""


@dataclass(frozen=True, kw_only=True)
class Tally:
    """Who is seen in a split.

    Parameters
    ----------
    info : the split's facts, without counts.
    spans : [N] frames of each sequence from its first to its last.
    frames : [N] those in which a person is seen: only they count.
    seen : [F] people seen in each frame that counts, without the observer.
    passing : [N] people seen at any time in each sequence.
    crowd : [N] people of each sequence's own scene, the observer included; ``None`` where sequences share scenes.
    """

    info: DatasetInfo
    spans: IntArray
    frames: IntArray
    seen: IntArray
    passing: IntArray
    crowd: IntArray | None = None

    @cached_property
    def row(self) -> dict[str, Any]:
        """The row of Table 1 as ``vbbench info`` has it."""
        counts: dict[str, float] = {
            "sequences": len(self.frames),
            "frames": int(self.frames.sum()),
            "observations": int(self.seen.sum()),
            "people_min": int(self.seen.min()),
            "people_max": int(self.seen.max()),
        }
        return summary(replace(self.info, counts=counts))

    def people(self, counted: str) -> IntArray:
        """The numbers of people that are compared with the paper's."""
        if counted == OF_THE_SCENE and self.crowd is not None:
            return self.crowd
        # In a frame with the observer where the split's recipe counts the observer.
        return self.passing if counted == DURING else self.seen + (int(self.row["people_min"]) - int(self.seen.min()))


def count_people(plan: Plan) -> Tally:
    """Count a split's people, sequence by sequence."""
    spans, frames, seen, passing, crowd = [], [], [], [], []
    for index in range(len(plan)):
        own = plan.seen(index) if isinstance(plan, ForesightedPlan) else None
        if own is None:
            data = plan.build(index)
            own = data.sequence.observed
            crowd += [] if data.scene is None else [len(data.scene.people)]
        people = own.sum(axis=1)
        spans.append(len(people))
        frames.append(np.count_nonzero(people))
        seen.append(people[people > 0])
        passing.append(np.count_nonzero(own.any(axis=0)))
    counts = {"spans": np.array(spans), "frames": np.array(frames), "passing": np.array(passing)}
    return Tally(info=plan.info, seen=np.concatenate(seen), crowd=np.array(crowd) if crowd else None, **counts)


class Printed(NamedTuple):
    """What the paper prints, "–" for what it does not: sequences, mean frames, and people."""

    sequences: str
    frames: str
    people: str


class Counted(NamedTuple):
    """One of our splits next to a row of the paper; nobody is tallied where the split's source is missing.

    ``counted`` is who the paper's people are taken to be, ``differs`` what differs and why.
    """

    split: str
    title: str
    printed: Printed
    counted: str
    differs: str
    tally: Tally | None = None


def all_rows() -> list[Counted]:
    """Every row, in the order of the paper."""
    paper = the_paper()
    printed = {split: Printed(str(row.sequences), row.frames, row.people) for split, row in paper.table1.items()}
    printed["game"] = Printed("–", str(paper.photorealistic.frames), str(paper.photorealistic.people))
    return [
        Counted(split, title, printed[of], counted, _differs(split)) for split, (title, of, counted) in _ROWS.items()
    ]


def _differs(split: str) -> str:
    """What differs from the paper, and why."""
    if split not in _SHIBUYA:
        return paragraphs(f"table1_{split}")[0]
    tracks, removed, length = _SHIBUYA[split]
    paper = the_paper().table1[split]
    at_a_time = f"{paper.sequences * float(paper.frames) / length:.0f}"
    counts = {"tracks": tracks, "removed": removed, "length": length, "at_a_time": at_a_time}
    return paragraphs("table1_shibuya", paper=paper, mean=f"{paper.bounds[1]:.0f}", **counts)[0]


_ROWS: Mapping[str, tuple[str, str, str]] = {
    "sim": ("Sim", "sim", OF_THE_SCENE),
    "hotel": ("Hotel", "hotel", IN_A_FRAME),
    "eth": ("ETH", "eth", IN_A_FRAME),
    "students": ("Students", "students", IN_A_FRAME),
    "shibuya01": ("Shibuya01", "shibuya01", DURING),
    "shibuya02": ("Shibuya02", "shibuya02", DURING),
    "street": ("GTAV, as street", "game", OF_THE_SCENE),
    "motsynth": ("GTAV, as MOTSynth", "game", IN_A_FRAME),
}
"""By our split: title, the paper's row, and whom it counts."""
_SHIBUYA = {"shibuya01": (811, 5, 1000), "shibuya02": (580, 12, 997)}
"""Tracks of the recording, how many of them the paper removes, and frames."""


@dataclass(frozen=True, kw_only=True)
class Table1Study(Study):
    """The rows of some ``splits``; ``motsynth`` is the user's own download, and the seed is of what is simulated."""

    name = "table1"
    splits: Sequence[str] = tuple(_ROWS)
    motsynth: Path | None = None
    seed: int = 0

    def check(self) -> None:
        """Raise VbbenchError if a split is not in the table."""
        check_splits(self.splits, tuple(_ROWS), "split of the paper's Table 1")

    def measure(self, out: Path, making: Making) -> list[Counted]:  # noqa: ARG002  nothing is made
        """Count every split whose source is here."""
        rows = []
        for row in all_rows():
            if row.split in self.splits:
                plan = plan_if_here(row.split, self.motsynth if row.split == "motsynth" else None, self.seed)
                rows.append(row if plan is None else row._replace(tally=count_people(plan)))
        return rows

    def report(self, found: list[Counted]) -> Report:
        """Two lines a row, the paper's and ours, and what differs."""
        numbers = Table(
            facts=paragraphs("table1"),
            head=["", "", "sequences", "mean frames", "people", "counted", "seen in a frame", "seen during a sequence"],
            rows=[line for row in found for line in _lines(row)],
            names=2,
        )
        why = Table(
            title="What differs, and why",
            head=["split", "difference"],
            rows=[[row.title, row.differs] for row in found],
            names=2,
        )
        return Report(
            name=self.name,
            title="Table 1: sequences and people of every split",
            tables=[numbers, why],
            values={"seed": self.seed, "rows": list(map(_values, found))},
        )


def _lines(row: Counted) -> list[list[str]]:
    tally = row.tally
    paper = [row.title, "the paper", row.printed.sequences, row.printed.frames, row.printed.people, "", "", ""]
    if tally is None:
        return [paper, ["", f"missing: {how_to_get(row.split)}", *[""] * 6]]
    frames, span = f"{tally.row['mean_frames']:.2f}", f"{tally.spans.mean():.2f}"
    counts = [_three(tally.people(row.counted)), row.counted, _three(tally.seen), _three(tally.passing)]
    shown = frames if span == frames else f"{frames} ({span})"
    return [paper, ["", f"`{row.split}`", str(len(tally.frames)), shown, *counts]]


def _three(counts: IntArray) -> str:
    return f"{counts.min()} / {counts.mean():.2f} / {counts.max()}"


def _values(row: Counted) -> dict[str, Any]:
    tally = row.tally
    values: dict[str, Any] = {
        "split": row.split,
        "title": row.title,
        "paper": row.printed._asdict(),
        "counted": row.counted,
    }
    if tally is None:
        return values | {"missing": how_to_get(row.split).replace("`", "")}
    people = tally.people(row.counted)
    bounds = {"least": int(people.min()), "mean": float(people.mean()), "most": int(people.max())}
    return values | {"ours": tally.row, "people": bounds}
