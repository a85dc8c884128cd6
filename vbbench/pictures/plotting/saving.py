"""Figures as files: pixels as PNG, or shapes and searchable text as PDF and SVG. The same figure has the same bytes."""

import io
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from vbbench.errors import FileError
from vbbench.folders.replacing import write_bytes_atomically

DPI = 150
_NO_DATES: dict[str, dict[str, Any]] = {
    ".png": {"Software": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    ".svg": {"Date": None, "Creator": None},
}
"""By the endings of files: facts about their making that are not written."""

_TEXT_AS_TEXT = {"pdf.fonttype": 42, "svg.fonttype": "none", "svg.hashsalt": "vbbench"}
"""Fonts are TrueType, embedded in a PDF; names in an SVG follow from its shapes, not from chance."""


def save_picture(figure: Figure, path: Path | str) -> None:
    """Write a figure as PNG, PDF or SVG, as its name ends; the file is there whole or not at all.

    Raises
    ------
    FileError
        If the name ends in something else.
    """
    path = Path(path)
    check_ending(path)
    ending = path.suffix.lower()
    picture = io.BytesIO()
    with mpl.rc_context(_TEXT_AS_TEXT):  # type: ignore[arg-type]
        figure.savefig(picture, format=ending[1:], dpi=DPI, metadata=_NO_DATES[ending])
    write_bytes_atomically(path, picture.getvalue())


def check_ending(path: Path | str) -> None:
    """Raise FileError unless a picture of that name can be written: before the work that the picture takes."""
    if Path(path).suffix.lower() not in _NO_DATES:
        raise FileError(
            Path(path), "pictures are written as PNG, PDF or SVG; give a name that ends in .png, .pdf or .svg"
        )
