"""What is wanted of each figure, and what a prototype reached; the numbers are in ``targets.toml``."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

Values = tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class Target:
    """What is wanted of a row's figures, each at most; empty where nothing is known.

    Parameters
    ----------
    prototype, wanted : of any solver.
    batch, batch_wanted : of a solver of whole sequences, where those are other ones.
    within : the least and the most of every figure, instead.
    """

    prototype: Values = ()
    wanted: Values = ()
    batch: Values = ()
    batch_wanted: Values = ()
    within: Values = ()

    def bounds(self, whole: bool) -> Values:
        """The figures wanted, of a solver of ``whole`` sequences or any; without word on it, the prototype's."""
        anybody = self.wanted or self.prototype
        return (self.batch_wanted or self.batch or anybody) if whole else anybody

    def missed(self, values: Values, whole: bool) -> bool:
        """Whether one of the figures is not as wanted."""
        if self.within:
            least, most = self.within
            return any(not least <= value <= most for value in values)
        bounds = self.bounds(whole)
        return any(not round(value, 3) <= bound for value, bound in zip(values, bounds, strict=False))

    @property
    def texts(self) -> tuple[str, str]:
        """What the prototype reached and what is wanted; of whole sequences in brackets."""
        if self.within:
            return "", " to ".join(map(plain, self.within))
        batch, batch_wanted = (f" ({joined(values)})" if values else "" for values in (self.batch, self.batch_wanted))
        return joined(self.prototype) + batch, joined(self.wanted or self.prototype) + (batch_wanted or batch)


def read_targets() -> dict[str, dict[str, Target]]:
    """Targets by cell and row."""
    found = tomllib.loads(Path(__file__).with_name("targets.toml").read_text("utf-8"))
    return {
        cell: {row: Target(**{name: tuple(values) for name, values in target.items()}) for row, target in rows.items()}
        for cell, rows in found.items()
    }


def target_of(rows: dict[str, Target], trial: str, figure: str) -> Target:
    """That of a trial's figure, or of the figure in every trial."""
    return rows.get(f"{trial} {figure}", rows.get(figure, Target()))


def joined(values: Values) -> str:
    """Figures with slashes between."""
    return " / ".join(map(plain, values))


def plain(value: float) -> str:
    """A figure, in as many digits as it is worth."""
    if value != value or abs(value) == float("inf"):
        return "–" if value != value else "∞"
    return f"{value:.3f}" if abs(value) < 1.0 else f"{value:.2f}" if abs(value) < 100.0 else f"{value:.0f}"
