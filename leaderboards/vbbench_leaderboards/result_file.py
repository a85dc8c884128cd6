"""Result files: what a solver scored on a split, and each sequence's own figures.

One file a split, protocol, tier and solver: ``SPLIT/PROTOCOL-TIER/SOLVER.json`` below ``leaderboards/results``. Time is
not in it, so that the same code gives the same file.
"""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench import __version__
from vbbench.arrays import FloatArray
from vbbench.scorecard import METRICS, Score
from vbbench.tables import write_text_atomically

RESULTS = Path(__file__).parents[1] / "results"

_DECIMALS = 7
"""Digits kept of a sequence's figures: finer than any drift that counts, and small files."""


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One result: a solver under a protocol on a split in a tier."""

    split: str
    tier: str
    protocol: str
    solver: str

    @property
    def path(self) -> Path:
        """Where its file lies below the folder of results."""
        return Path(self.split, f"{self.protocol}-{self.tier}", f"{self.solver}.json")


def to_values(result: Score) -> dict[str, Any]:
    """A score as its file has it."""
    values = {name: value for name, value in result.values().items() if name != "seconds_per_frame"}
    own = result.per_sequence
    figures = {name: _rounded(own.figures[name]) for name in METRICS}
    return {
        "package_version": __version__,
        "score": values,
        "per_sequence": {"sequence": own.sequence.tolist(), **figures},
    }


def to_json(values: dict[str, Any]) -> str:
    """The text of a result file: the score by lines, each list of figures in one."""
    head = json.dumps({name: values[name] for name in ("package_version", "score")}, indent=1, ensure_ascii=False)
    rows = ",\n".join(
        f'  "{name}": {json.dumps(row, separators=(",", ":"))}' for name, row in values["per_sequence"].items()
    )
    return f'{head[:-2]},\n "per_sequence": {{\n{rows}\n }}\n}}\n'


def read(cell: Cell, results: Path = RESULTS) -> dict[str, Any]:
    """The committed result of a cell."""
    values: dict[str, Any] = json.loads((results / cell.path).read_text(encoding="utf-8"))
    return values


def write(cell: Cell, values: dict[str, Any], results: Path = RESULTS) -> None:
    """Write the result of a cell."""
    write_text_atomically(results / cell.path, to_json(values))


def first_sequences(values: dict[str, Any], count: int) -> dict[str, Any]:
    """The figures of sequences 0 … count − 1 alone."""
    rows = values["per_sequence"]
    kept = int(np.searchsorted(rows["sequence"], count))
    return {name: row[:kept] for name, row in rows.items()}


def _rounded(figures: FloatArray) -> list[float | None]:
    return [None if np.isnan(figure) else round(float(figure), _DECIMALS) for figure in figures]
