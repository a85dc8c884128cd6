"""Boxes of any detector or tracker on the pictures of a recording."""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.exchange.box_rows import BoxRows
from vbbench.exchange.box_tables import UNLINKED, scores_as_shares
from vbbench.exchange.own.box_files import read_boxes, rows_in_frames

LEAST_SCORE = 0.0
"""Log-odds that a detection must have more of to count; even odds."""
UNKNOWN = -1.0
"""A score that says nothing."""


def read_found(
    path: Path, frames: int, dt: float, picture: tuple[float, float], person_class: str | None = None
) -> BoxRows:
    """Sure enough boxes of people on a recording of ``frames`` frames, in any form that `birdify` reads.

    Parameters
    ----------
    dt : seconds per frame, by which time stamps are frames; 0 is the first one.
    picture : width and height in px, for boxes that are shares of it.
    person_class : class of people, by number or name, where the file does not show it.

    Raises
    ------
    FileError
        At the first row that is not valid, or of no frame of the recording.
    """
    rows = read_boxes(path, dt, picture=picture, person_class=person_class)
    for note in rows.notes:
        warnings.warn(VbbenchWarning(f"{path}: {note}"), stacklevel=2)
    return sure_boxes(rows_in_frames(rows, frames, dt))


def sure_boxes(rows: BoxRows) -> BoxRows:
    """Those of the boxes that are sure enough: their scores are above `LEAST_SCORE`, log-odds or shares.

    Where all are −1, as MOTChallenge writes what is not known, all count.

    Raises
    ------
    FileError
        If some rows have ids and others none.
    """
    known = np.where((rows.scores == UNKNOWN).all(), np.nan, rows.scores)
    track, shares = np.where(rows.track < 0, UNLINKED, rows.track), scores_as_shares(known)
    found = replace(rows, track=track, scores=shares).select(~(known <= LEAST_SCORE))
    loose = found.track == UNLINKED
    if loose.any() and not loose.all():
        problem = "id is -1, but other rows have ids; write ids in all rows, or in none, to have them linked"
        raise found.fault(int(loose.argmax()), problem)
    return found


def file_for(given: Path, name: str, several: bool) -> Path:
    """The file of a sequence in a folder that the user names, or the file itself if there is one sequence alone.

    Text is looked for first, then whatever else is called like the sequence.

    Raises
    ------
    VbbenchError
        If one file is named for several sequences, or the file is not there.
    """
    if given.is_file():
        if several:
            raise VbbenchError(
                f"{given} is one file; name a folder with a file for each sequence, {name}.txt and so on"
            )
        return given
    path = given / f"{name}.txt"
    if path.is_file():
        return path
    other = next((one for one in sorted(given.iterdir()) if one.stem == name), None) if given.is_dir() else None
    if other is None:
        raise FileError(path, "is missing; files for a sequence are called like it, in a folder or named alone")
    return other
