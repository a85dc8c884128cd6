"""Which splits can be made on this machine, and how the sources of the others are got."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from vbbench.errors import SourceMissingError
from vbbench.generation.generator import Generator, Options, Plan
from vbbench.registry import load


@dataclass(frozen=True, kw_only=True)
class AtHand:
    """Where the user's own downloads are: folders by split; the other splits are searched in the usual places."""

    folders: Mapping[str, Path] = field(default_factory=dict)

    @classmethod
    def of(cls, **folders: Path | None) -> "AtHand":
        """Of folders by split; ``None`` for the usual places."""
        return cls(folders={split: folder for split, folder in folders.items() if folder is not None})

    def plan(self, split: str, seed: int = 0) -> Plan | None:
        """The split as it is by default; ``None`` if its source is not here.

        Raises
        ------
        VbbenchError
            If the source is here and cannot be read.
        """
        generator: Generator = load("generator", split)
        try:
            return generator.plan(Options(source=self.folders.get(split), seed=seed))
        except SourceMissingError:
            if split in self.folders:
                raise
            return None


def how_to_get(split: str) -> str:
    """The command that gets a split's source, or names the user's own download."""
    generator: Generator = load("generator", split)
    return f"`vbbench fetch {split}`" if generator.card.sources else f"your own download, named with `--{split} DIR`"
