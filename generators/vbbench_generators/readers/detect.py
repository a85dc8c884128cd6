"""Which format a user's own file has."""

from pathlib import Path
from typing import Literal

from vbbench.errors import FileError
from vbbench_generators.readers import obsmat, trajnet
from vbbench_generators.readers.textfile import read_lines
from vbbench_generators.readers.vsp import is_spline_header

Format = Literal["trajnet", "obsmat", "vsp"]


def detect_format(path: Path) -> Format:
    """The format, told by the first line that is neither blank nor a comment.

    Raises
    ------
    FileError
        If it is none that can be read.
    """
    number, line = read_lines(path)[0]
    if is_spline_header(line):
        return "vsp"
    columns = len(line.replace(",", " ").split())
    if columns == len(trajnet.COLUMNS):
        return "trajnet"
    if columns == len(obsmat.COLUMNS):
        return "obsmat"
    known = f"4 columns ({' '.join(trajnet.COLUMNS)}), 8 ({' '.join(obsmat.COLUMNS)}), or a UCY .vsp spline file"
    raise FileError(path, f"has {columns} columns; known are {known}", number)
