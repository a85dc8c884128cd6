"""An independent reader of trajectory files, in the plainest way there is: lines, cells, and exact decimal numbers.

It knows the grammar of each format and nothing of the product's code. Where it and the product both read a file they
agree on every number. What it reads and the product refuses must be refused for one of the reasons in `STRICTER`: what
a row of numbers cannot tell, but a scene must have. What the product reads, it must read.
"""

import re
from decimal import Decimal, InvalidOperation

Row = tuple[float, ...]

STRICTER = {
    "tracks": (
        r"twice \(also on line|but the step is \d+|is no frame of (it|the sequence)|already has a box|"
        r"already (been )?given in line|does not come after|"
        r"is -?[\d.e+-]+, not an integer|(no|not a) whole number|people are class|class is |"
        r"digits are lost|the id is missing here, other boxes have one|seem to be swapped"
    ),
    "sizes": r"are too many|correct its frame numbers|no person is annotated at a multiple|holds no crowd",
    "places": r"km from the origin|it must be within ±|px; boxes are in px|the box is|visibility is|beyond its horizon",
    "poses": r"quaternion|leans by|fit the motion|to the camera|is not a frame's; frame n|these are detections",
    "matrices": r"is singular|has 3 rows of 3",
    "lines": r"has more than [\d,]+ characters; write one row|holds zero bytes",
}
"""Reasons for which the product refuses what has the grammar of its format, by what they protect."""

_DECIMAL = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")


def finite(cell: str) -> float | None:
    """The float nearest to the decimal number in a cell; ``None`` where there is none, or none that is finite."""
    if _DECIMAL.fullmatch(cell) is None:
        return None
    try:
        value = float(Decimal(cell))
    except (InvalidOperation, OverflowError, ValueError):
        return 0.0 if re.search(r"[eE]-", cell) else None
    return value if abs(value) != float("inf") else None


def lines(content: bytes, *, errors: str = "strict") -> list[str] | None:
    """The lines that are neither blank nor comments; ``None`` where the file is no UTF-8."""
    try:
        text = content.decode("utf-8-sig", errors)
    except UnicodeDecodeError:
        return None
    return [line for line in re.split("\r\n|\r|\n", text) if line.strip() and not line.strip().startswith("#")]


def rows_of(content: bytes, width: int, *, commas: bool, errors: str = "strict") -> list[Row] | None:
    """Rows of ``width`` numbers with white space between, or commas as well; ``None`` where a line is none."""
    rows = []
    for line in lines(content, errors=errors) or ():
        cells = (line.replace(",", " ") if commas else line).split()
        numbers = [finite(cell) for cell in cells]
        if len(cells) != width or None in numbers:
            return None
        rows.append(tuple(numbers))
    return rows or None


def boxes_of(content: bytes) -> list[Row] | None:
    """Rows of a MOTChallenge file: 6 to 10 cells with one comma between; the tenth may be anything."""
    rows = []
    for line in lines(content, errors="replace") or ():
        cells = [cell.strip(" \t") for cell in line.split(",")]
        numbers = [finite(cell) for cell in cells[:9]]
        if not 6 <= len(cells) <= 10 or None in numbers:
            return None
        rows.append(tuple(numbers))
    return rows
