"""The same recording by a camera alone: a plan without the odometry of whoever carries it."""

from dataclasses import dataclass, replace
from functools import cached_property

from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.tables import ODOMETRY_TABLE
from vbbench.generation.generator import FootagePlan
from vbbench.scene import Scene
from vbbench.sequence import Given, SequenceData


@dataclass(frozen=True)
class CameraAlone:
    """A plan's sequences as they are, without odometry; the dataset's definition, and so its id, says so."""

    whole: FootagePlan

    @cached_property
    def info(self) -> DatasetInfo:
        """The published facts."""
        info = self.whole.info
        return replace(info, definition={**info.definition, "odometry": False})

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """The scenes that sequences share."""
        return self.whole.scenes

    @property
    def tables(self) -> tuple[str, ...]:
        """See `vbbench.generation.generator.FootagePlan.tables`."""
        return tuple(name for name in self.whole.tables if name != ODOMETRY_TABLE)

    def __len__(self) -> int:
        return len(self.whole)

    def build(self, index: int) -> SequenceData:
        """One sequence."""
        data = self.whole.build(index)
        given = data.sequence.given
        alone = Given(poses=given.poses, positions=given.positions)
        return replace(data, sequence=replace(data.sequence, given=alone))
