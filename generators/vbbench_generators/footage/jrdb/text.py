"""JRDB's boxes and places as text: the sample of JRDB-Traj, and results of trackers as JRDB's evaluation reads them.

The sample has both in one table with commas. ``tracks_2d/NAME.txt`` and ``tracks_3d/NAME.txt`` have KITTI's 18 columns:
boxes in the stitched panorama in px; and places x right, y down, z forward in m, with sizes l, w, h of people around
the robot. Frames count from 0; whatever is not known is −1.
"""

from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.box_rows import BoxRows, rows_of
from vbbench.exchange.box_tables import UNLINKED
from vbbench.files.tables import first_repetition
from vbbench.geometry import FloatArray, IntArray
from vbbench_generators.footage.found_boxes import sure_boxes
from vbbench_generators.footage.jrdb.labels import MOST_METRES, MOST_PIXELS, TALLEST, PictureLabels, PlaceLabels
from vbbench_generators.footage.kitti.text import LONGEST_ID, Layout, Rows, first_cells, names, parse_rows, read_content

BOXES, PLACES = "tracks_2d", "tracks_3d"
"""Folders of the two kinds of results."""

MOST_FRAMES = 10**6
_SAMPLE = names("frame id x y h w l rot_z left top width height")
_RESULT = names("frame id type truncated occluded alpha left top width height x y z l h w rot score")
_OF_SAMPLE = Layout(columns=_SAMPLE, wanted=_SAMPLE, commas=True)
_OF_RESULT = Layout(columns=_RESULT, wanted=tuple(name for name in _RESULT if name != "type"))


def are_results(path: Path) -> bool:
    """Whether a file is text of 18 columns with blanks between."""
    return path.is_file() and len(first_cells(read_content(path, "boxes in the panorama"), _OF_RESULT)) == len(_RESULT)


def read_sample(path: Path) -> tuple[PictureLabels, PlaceLabels]:
    """Both kinds of labels: a row for each person in each frame; x forward, y left.

    Raises
    ------
    FileError
        At the first row that has other columns, what is no number, or what cannot be.
    """
    rows = _read(path, "JRDB-Traj's sample", _OF_SAMPLE)
    return pictures_of(_boxes(rows, np.ones(len(rows)))), _places(rows, rows.numbers("x", "y"))


def read_boxes(path: Path) -> BoxRows:
    """The boxes of ``tracks_2d/NAME.txt``.

    Raises
    ------
    FileError
        At the first row that is no box of a person.
    """
    rows = _read(path, "a tracker's boxes", _OF_RESULT)
    return _boxes(rows, rows.columns["score"])


def pictures_of(found: BoxRows) -> PictureLabels:
    """Tracked boxes as labels, visible as much as they are sure; raises FileError at the first that has no id."""
    loose = found.track == UNLINKED
    if loose.any():
        raise FileError(found.path, "id is -1: these are detections; link them first", int(found.lines[loose.argmax()]))
    return PictureLabels(
        path=found.path,
        frames=found.frame,
        people=found.track,
        boxes=found.boxes,
        visible=found.scores,
        interpolated=np.zeros(len(found), np.bool_),
    )


def read_places(path: Path) -> PlaceLabels:
    """The places of ``tracks_3d/NAME.txt``.

    Raises
    ------
    FileError
        At the first row that is no place of a tracked person.
    """
    rows = _read(path, "a tracker's places", _OF_RESULT)
    return _places(rows, np.stack([rows.columns["z"], -rows.columns["x"]], axis=-1))


def _read(path: Path, wanted: str, layout: Layout) -> Rows:
    """Rows with whole frames and ids, a person once in a frame."""
    rows = parse_rows(path, read_content(path, wanted), layout)
    frames = rows.whole("frame", 0, MOST_FRAMES, "no frame: those are whole numbers from 0 on")
    people = rows.whole("id", UNLINKED, LONGEST_ID, "no id: those are whole numbers from 0 on, or -1 for none")
    linked = np.flatnonzero(people != UNLINKED)
    found = first_repetition(frames[linked], people[linked])
    if found is not None:
        again = linked[found[1]]
        raise FileError(path, f"id {people[again]} stands in frame {frames[again]} twice", int(rows.lines[again]))
    return rows


def _boxes(rows: Rows, scores: FloatArray) -> BoxRows:
    boxes = rows.numbers("left", "top", "width", "height")
    far = np.abs(boxes).max(axis=1)
    rows.refuse(far > MOST_PIXELS, "the box reaches {0:g} px; boxes are in px of the panorama", far)
    rows.refuse(boxes[:, 2:].min(axis=1) <= 0.0, "its box is {0:g} px wide and {1:g} px high", *boxes[:, 2:].T)
    frames, people = _of_whom(rows)
    return sure_boxes(rows_of(rows.path, frames, people, boxes, scores, rows.lines))


def _places(rows: Rows, places: FloatArray) -> PlaceLabels:
    """Places [N, 2] forward and to the left, of people who are as tall as people are."""
    far, heights = np.abs(places).max(axis=1), rows.columns["h"]
    rows.refuse(far > MOST_METRES, "the place is {0:g} m away; x, y and z are in m", far)
    rows.refuse((heights <= 0.0) | (heights > TALLEST), "h is {0:g}; people are up to 4 m tall", heights)
    frames, people = _of_whom(rows)
    return PlaceLabels(path=rows.path, frames=frames, people=people, places=places, heights=heights)


def _of_whom(rows: Rows) -> IntArray:
    """[2, N] frames and ids."""
    return rows.numbers("frame", "id").astype(np.int64).T
