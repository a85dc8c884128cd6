"""Results of trackers as JRDB's evaluation reads them: KITTI's 18 columns, with left, top, width and height of boxes.

``tracks_2d/NAME.txt``: boxes in the stitched panorama in px. ``tracks_3d/NAME.txt``: places x right, y down, z forward
in m, and sizes l, w, h of people around the robot. Frames count from 0; whatever is not known is −1.
"""

from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.box_tables import UNLINKED
from vbbench.geometry import IntArray
from vbbench.parsing.rows import first_repetition
from vbbench_generators.footage.found_boxes import FoundBoxes, found_boxes
from vbbench_generators.footage.jrdb.labels import MOST_METRES, MOST_PIXELS, TALLEST, PictureLabels, PlaceLabels
from vbbench_generators.footage.kitti.text import LONGEST_ID, Layout, Rows, first_cells, names, parse_rows, read_content

BOXES, PLACES = "tracks_2d", "tracks_3d"
"""Folders of the two kinds."""

MOST_FRAMES = 10**6
_COLUMNS = names("frame id type truncated occluded alpha left top width height x y z l h w rot score")
_LAYOUT = Layout(columns=_COLUMNS, wanted=tuple(name for name in _COLUMNS if name != "type"))


def are_results(path: Path) -> bool:
    """Whether a file is text of 18 columns with blanks between."""
    return path.is_file() and len(first_cells(read_content(path, "boxes in the panorama"), _LAYOUT)) == len(_COLUMNS)


def read_boxes(path: Path) -> FoundBoxes:
    """The boxes of ``tracks_2d/NAME.txt``.

    Raises
    ------
    FileError
        At the first row that is no box of a person.
    """
    rows, frames, people = _read(path, "a tracker's boxes")
    boxes, scores = rows.numbers("left", "top", "width", "height"), rows.columns["score"]
    far = np.abs(boxes).max(axis=1)
    rows.refuse(far > MOST_PIXELS, "the box reaches {0:g} px; boxes are in px of the panorama", far)
    bad = (boxes[:, 2] <= 0.0) | (boxes[:, 3] <= 0.0)
    rows.refuse(bad, "its box is {0:g} px wide and {1:g} px high", *boxes[:, 2:].T)
    return found_boxes(path, frames, people, boxes, scores, rows.lines)


def pictures_of(found: FoundBoxes) -> PictureLabels:
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
    rows, frames, people = _read(path, "a tracker's places")
    places, heights = np.stack([rows.columns["z"], -rows.columns["x"]], axis=-1), rows.columns["h"]
    far = np.abs(places).max(axis=1)
    rows.refuse(far > MOST_METRES, "the place is {0:g} m away; x, y and z are in m", far)
    rows.refuse((heights <= 0.0) | (heights > TALLEST), "h is {0:g}; people are up to 4 m tall", heights)
    return PlaceLabels(path=path, frames=frames, people=people, places=places, heights=heights)


def _read(path: Path, wanted: str) -> tuple[Rows, IntArray, IntArray]:
    """Rows, their frames [N] and ids [N]."""
    rows = parse_rows(path, read_content(path, wanted), _LAYOUT)
    frames = rows.whole("frame", 0, MOST_FRAMES, "no frame: those are whole numbers from 0 on")
    people = rows.whole("id", UNLINKED, LONGEST_ID, "no id: those are whole numbers from 0 on, or -1 for none")
    linked = np.flatnonzero(people != UNLINKED)
    found = first_repetition(frames[linked], people[linked])
    if found is not None:
        again = linked[found[1]]
        raise FileError(path, f"id {people[again]} stands in frame {frames[again]} twice", int(rows.lines[again]))
    return rows, frames, people
