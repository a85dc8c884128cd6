"""Reads MOTChallenge text of a sequence by the readers of the product, without a timeline."""

import warnings
from pathlib import Path

from vbbench.errors import VbbenchWarning
from vbbench.exchange.box_rows import BoxRows, linked_rows
from vbbench.exchange.box_tables import people_in, read_box_text


def read_mot(path: Path, frames: int) -> BoxRows:
    """The boxes of people; a warning counts what is left out."""
    table = read_box_text(path, path.read_bytes())
    kept, notes = people_in(table) if not table.ignored.all() else (~table.ignored, ())
    for note in notes:
        warnings.warn(VbbenchWarning(f"{path}: {note}"), stacklevel=2)
    table, first = table.select(kept), table.base
    return linked_rows(table, table.whole("frame", first, first + frames - 1, "no frame of it") - first)
