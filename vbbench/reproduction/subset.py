"""Every N-th sequence of a dataset, so that a long study can be tried on a part that is spread over the recording."""

from dataclasses import dataclass, replace

from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.generator import Plan
from vbbench.scene import Scene
from vbbench.sequence import SequenceData


@dataclass(frozen=True)
class Thinned:
    """A plan of every ``every``-th sequence of another one, the first included; each is as it was there."""

    whole: Plan
    every: int

    @property
    def info(self) -> DatasetInfo:
        """That of the whole, with its own id."""
        info = self.whole.info
        return replace(info, definition={**info.definition, "every": self.every})

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """Those of the whole."""
        return self.whole.scenes

    def __len__(self) -> int:
        return -(-len(self.whole) // self.every)

    def build(self, index: int) -> SequenceData:
        """One sequence under its new number."""
        data = self.whole.build(index * self.every)
        return replace(data, sequence=replace(data.sequence, index=index))


def thinned(plan: Plan, every: int) -> Plan:
    """Every ``every``-th sequence of the plan; 1 is the plan itself."""
    return plan if every == 1 else Thinned(plan, every)
