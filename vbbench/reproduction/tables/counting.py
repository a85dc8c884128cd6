"""Who is seen in a split, counted from its plan: no dataset is made, and boxes only where nothing else tells."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from vbbench.files.dataset_info import DatasetInfo, summary
from vbbench.generation.generator import ForesightedPlan, Plan
from vbbench.geometry import IntArray


@dataclass(frozen=True, kw_only=True)
class Tally:
    """Who is seen in a split.

    Parameters
    ----------
    info : the split's facts, without counts.
    spans : [N] frames of each sequence from its first to its last.
    frames : [N] those in which anybody is seen: only they count.
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
        """What ``vbbench info`` says of the dataset: its row of Table 1."""
        counts: dict[str, float] = {
            "sequences": len(self.frames),
            "frames": int(self.frames.sum()),
            "observations": int(self.seen.sum()),
            "people_min": int(self.seen.min()),
            "people_max": int(self.seen.max()),
        }
        return summary(replace(self.info, counts=counts))

    @property
    def in_a_frame(self) -> IntArray:
        """[F] people in each frame that counts; with the observer where the split's recipe says so."""
        return self.seen + (int(self.row["people_min"]) - int(self.seen.min()))


@dataclass(frozen=True)
class _Counted:
    """One sequence: people seen [T] in each frame, people seen at any time, and people of its own scene, if any."""

    seen: IntArray
    passing: int
    crowd: int | None


def count_people(plan: Plan) -> Tally:
    """Count a split's people, sequence by sequence."""
    counted = [_count(plan, index) for index in range(len(plan))]
    crowd = [one.crowd for one in counted if one.crowd is not None]
    return Tally(
        info=plan.info,
        spans=np.array([len(one.seen) for one in counted]),
        frames=np.array([np.count_nonzero(one.seen) for one in counted]),
        seen=np.concatenate([one.seen[one.seen > 0] for one in counted]),
        passing=np.array([one.passing for one in counted]),
        crowd=np.array(crowd) if crowd else None,
    )


def _count(plan: Plan, index: int) -> _Counted:
    seen, crowd = plan.seen(index) if isinstance(plan, ForesightedPlan) else None, None
    if seen is None:
        data = plan.build(index)
        seen, crowd = data.sequence.observed, None if data.scene is None else len(data.scene.people)
    return _Counted(seen.sum(axis=1), int(np.count_nonzero(seen.any(axis=0))), crowd)
