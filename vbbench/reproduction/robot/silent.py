"""The same recording by a camera alone: a plan without the odometry of whoever carries it."""

from dataclasses import dataclass, replace
from functools import cached_property

from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.tables import ODOMETRY_TABLE
from vbbench.generation.planning import DerivedPlan
from vbbench.sequence import Given, SequenceData


@dataclass(frozen=True)
class CameraAlone(DerivedPlan):
    """A plan's sequences as they are, without odometry; the dataset's definition, and so its id, says so."""

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
