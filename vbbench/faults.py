"""Collects the faults of a submission, so that all of them are reported at once."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.arrays import BoolArray
from vbbench.errors import FileError
from vbbench.quoting import one_line

LISTED = 20
"""Faults of one kind that are listed one by one; of the others the number is given."""


class Faults:
    """The faults found so far, by kind."""

    def __init__(self) -> None:
        self._listed: dict[str, list[str]] = {}
        self._count: dict[str, int] = {}

    def __bool__(self) -> bool:
        return bool(self._count)

    def add(self, fault: str, kind: str | None = None) -> None:
        """One fault: the file and place, what is wrong, what to do. Faults without a kind are always listed."""
        self._add(kind or fault, [fault], 1)

    def add_error(self, error: FileError) -> None:
        """What is wrong with a file of the submission, by its name without the folder."""
        line = "" if error.line is None else f", line {error.line}"
        self.add(f"{error.path.name}{line}: {error.problem}")

    def add_rows(self, file: str, problem: str, columns: Mapping[str, NDArray[Any]], bad: BoolArray) -> None:
        """The same fault in every row marked in ``bad`` [R]; ``columns`` hold what names a row (ids, CSV line)."""
        rows = np.flatnonzero(bad)
        if len(rows):
            names = [_row_name(columns, row) for row in rows[:LISTED]]
            self._add(f"{file}: {problem}", [f"{file}, {name}: {problem}" for name in names], len(rows))

    def listing(self) -> tuple[str, ...]:
        """Every fault, one line each."""
        lines = []
        for kind, listed in self._listed.items():
            rest = self._count[kind] - len(listed)
            lines += [*listed, f"{one_line(kind)} ({rest} more)"] if rest else listed
        return tuple(lines)

    def _add(self, kind: str, faults: list[str], count: int) -> None:
        listed = self._listed.setdefault(kind, [])
        listed.extend(map(one_line, faults[: LISTED - len(listed)]))
        self._count[kind] = self._count.get(kind, 0) + count


def _row_name(columns: Mapping[str, NDArray[Any]], row: int) -> str:
    return ", ".join(
        f"{name} {columns[name][row]}" for name in ("line", "sequence", "frame", "track") if name in columns
    )
