"""Plans made of another plan: some of its sequences, or all of them changed."""

from dataclasses import dataclass

from vbbench.generation.generator import Plan, tables_of
from vbbench.scene import Scene


@dataclass(frozen=True)
class DerivedPlan:
    """What a plan has in common with the ``whole`` that it is made of; ``info`` and ``build`` are its own."""

    whole: Plan

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """The scenes that sequences share: all of the whole."""
        return self.whole.scenes

    @property
    def tables(self) -> tuple[str, ...]:
        """See `vbbench.generation.generator.FootagePlan.tables`: those of the whole."""
        return tables_of(self.whole)

    def __len__(self) -> int:
        return len(self.whole)
