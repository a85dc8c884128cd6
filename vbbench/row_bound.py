"""How many rows a submission's table can have, so that nothing larger is ever read."""

from dataclasses import dataclass
from pathlib import Path

from vbbench.errors import FileError

SPARE_ROWS = 1 << 16
"""Rows that may be too many before a table is refused unread: their faults are listed one by one."""


@dataclass(frozen=True)
class RowBound:
    """The rows that a table can have.

    Parameters
    ----------
    possible : one for each frame, or for each track in each frame, of the dataset.
    """

    possible: int

    @property
    def most(self) -> int:
        """Rows that are read: each of the possible ones twice, and some to spare."""
        return 2 * self.possible + SPARE_ROWS

    def check(self, path: Path, rows: int) -> None:
        """Check a number of rows.

        Raises
        ------
        FileError
            If there are more than `most`.
        """
        if rows > self.most:
            raise FileError(path, f"{rows} rows or more; the dataset has {self.possible} at most, remove the others")
