"""JRDB's labels: boxes in the stitched panorama, and boxes in metres around the robot.

``labels_2d_stitched/NAME.json``: ``labels`` → ``000000.jpg`` → boxes [left, top, width, height] in px.
``labels_3d/NAME.json``: ``labels`` → ``000000.pcd`` → boxes cx, cy, cz, l, w, h, rot_z in m, x forward, y left, z up.
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError, quoted
from vbbench.exchange.box_rows import BoxRows, rows_of
from vbbench.exchange.box_tables import UNLINKED
from vbbench.exchange.text_tables import NamedColumns, Rows, first_cells, read_fixed
from vbbench.files.tables import LARGEST_ID
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.json_text import read_object
from vbbench_generators.footage.tracks import frames_of, sure_boxes

VISIBLE = {"Fully_visible": 1.0, "Mostly_visible": 0.75, "Severely_occluded": 0.25, "Fully_occluded": 0.0}
"""JRDB's words of occlusion, as visible fractions; who is fully hidden is seen by no camera."""

MOST_METRES, TALLEST, MOST_PIXELS = 1000.0, 4.0, 1e5
"""How far away and how tall in m a person is at most, and where in px a box may be."""

_BOX = ("left", "top", "width", "height")
_PEDESTRIAN, _NO_SIZE = "pedestrian:", "its box is {0:g} px wide and {1:g} px high"
_ATTRIBUTES = {"occlusion": "Fully_visible", "interpolated": "false"}
"""Attributes of labels, and what they are where nothing is said."""
_LARGEST = 2**30


@dataclass(frozen=True, kw_only=True)
class PlaceLabels(Rows):
    """Labelled places of people.

    Parameters
    ----------
    frame, track : [N] number of the point cloud and of the person.
    places : [N, 2] metres forward and to the left of the robot.
    heights : [N] of the people in m.
    """

    frame: IntArray
    track: IntArray
    places: FloatArray
    heights: FloatArray


def read_pictures(path: Path, *, interpolated: bool = True) -> BoxRows:
    """The people of ``labels_2d_stitched/NAME.json`` by number of the picture; other labels are not read.

    Parameters
    ----------
    interpolated : whether boxes that were computed from others are kept.
    """
    rows = _people(path, ".jpg", _BOX)
    boxes, (frame, track) = rows.stacked(*_BOX), _of_whom(rows)
    rows.refuse(boxes[:, 2:].min(axis=1, initial=1.0) <= 0.0, _NO_SIZE, *boxes[:, 2:].T)
    visible = np.array(list(VISIBLE.values()))[rows.places("occlusion", tuple(VISIBLE))]
    found = rows_of(path, frame, track, boxes, visible, rows.lines)
    by_hand = np.char.lower(rows["interpolated"]) != "true"
    return replace(found, visible=visible).select(interpolated | by_hand)


def read_places(path: Path) -> PlaceLabels:
    """The people of ``labels_3d/NAME.json``."""
    rows = _people(path, ".pcd", ("cx", "cy", "h"))
    return _places(rows, rows.stacked("cx", "cy"))


def _people(path: Path, ending: str, names: tuple[str, ...]) -> NamedColumns:
    """The labels of people: frame, id, the ``names`` of their boxes, and the attributes that are read."""
    where, rows, words = list[str](), list[list[float]](), list[list[str]]()
    for picture, labels in sorted(read_frames(path, "labels", "labels").items()):
        frame = frame_of(path, picture, ending, "labels")
        if not isinstance(labels, list):
            raise FileError(path, f"{picture} is {quoted(labels)}, not a list of labels")
        for number, label in enumerate(labels, 1):
            here = f"{picture}, label {number}"
            name = label.get("label_id") if isinstance(label, dict) else None
            if not isinstance(name, str):
                raise FileError(path, f"{here}: has no text 'label_id' such as 'pedestrian:12'")
            if not name.startswith(_PEDESTRIAN):
                continue
            person, attributes = name.removeprefix(_PEDESTRIAN), label.get("attributes", {})
            if not (person.isascii() and person.isdigit() and len(person) <= 9):
                raise FileError(path, f"{here}: label_id is {quoted(name)}, not 'pedestrian:NUMBER'")
            if not isinstance(attributes, dict):
                raise FileError(path, f"{here}: key 'attributes' is {quoted(attributes)}, not an object")
            where.append(here)
            rows.append([frame, int(person), *_numbers_of_box(path, here, label.get("box"), names)])
            words.append([str(attributes.get(word, usual)) for word, usual in _ATTRIBUTES.items()])
    numbers = np.array(rows).reshape(-1, 2 + len(names))
    columns = dict(zip(("frame", "id", *names), numbers.T, strict=True))
    columns |= dict(zip(_ATTRIBUTES, np.array(words, np.str_).reshape(-1, len(_ATTRIBUTES)).T, strict=True))
    lines = np.zeros(len(rows), np.int64)
    table = NamedColumns(path=path, columns=columns, lines=lines, where=np.array(where, np.str_))
    table.refuse_twice(f"'{_PEDESTRIAN}{{1}}' stands there twice", *_of_whom(table))
    return table


def _numbers_of_box(path: Path, here: str, box: Any, names: tuple[str, ...]) -> list[float]:
    """The numbers of a box by their ``names``: a list of px, or an object in m."""
    listed, most = names == _BOX, MOST_PIXELS if names == _BOX else MOST_METRES
    if not isinstance(box, list if listed else dict) or (listed and len(box) != len(names)):
        wanted = f"[{', '.join(names)}]" if listed else "an object with cx, cy, cz, l, w, h, rot_z"
        raise FileError(path, f"{here}: key 'box' is {quoted(box)}, not {wanted}")
    values = dict(zip(names, box, strict=True)) if isinstance(box, list) else dict(box)
    for name in names:
        if name not in values:
            raise FileError(path, f"{here}: key '{name}' is missing in its box of {', '.join(box) or 'nothing'}")
        value = values[name]
        if not isinstance(value, (int, float)) or isinstance(value, bool) or not abs(value) <= most:
            raise FileError(path, f"{here}: {name} is {quoted(value)}, not a number up to {most:,.0f}")
    return [float(values[name]) for name in names]


def read_frames(path: Path, key: str, wanted: str) -> dict[str, Any]:
    """The object ``key`` of a JSON file, from names of frames to what is ``wanted`` of each."""
    values = read_object(path, f"it holds {wanted} of JRDB", largest=_LARGEST)
    found = values.get(key)
    if not isinstance(found, dict):
        keys = ", ".join(sorted(values)[:5])
        raise FileError(path, f"has no object '{key}', from names of frames to {wanted}; its keys are {keys}")
    return found


def frame_of(path: Path, name: str, ending: str, key: str) -> int:
    """The number in the ``name`` of a frame, such as 000012.pcd."""
    stem = name.removesuffix(ending)
    if stem == name or not (stem.isascii() and stem.isdigit() and len(stem) <= 9):
        raise FileError(path, f"key {quoted(name)} of '{key}' is not the name of a frame, such as 000000{ending}")
    return int(stem)


BOXES, PLACES = "tracks_2d", "tracks_3d"
"""Folders of the two kinds of results."""

SAMPLE = "frame id x y h w l rot_z left top width height"
RESULTS = "frame id (type) truncated occluded alpha left top width height x y z l h w rot score"
"""Columns of both."""


def are_results(path: Path) -> bool:
    """Whether a file is text of 18 columns separated by blanks: results of a tracker."""
    return len(first_cells(path)) == len(RESULTS.split())


def read_sample(path: Path) -> tuple[BoxRows, PlaceLabels]:
    """Both kinds of labels: a row for each person in each frame; x forward, y left."""
    rows = _read(path, "JRDB-Traj's sample", SAMPLE)
    return pictures_of(_boxes(rows, np.ones(len(rows)))), _places(rows, rows.stacked("x", "y"))


def read_tracked_boxes(path: Path) -> BoxRows:
    """The boxes of ``tracks_2d/NAME.txt``."""
    rows = _read(path, "a tracker's boxes", RESULTS)
    return _boxes(rows, rows.numbers("score"))


def pictures_of(found: BoxRows) -> BoxRows:
    """Tracked boxes as labels, with scores as visible fractions; raises FileError at the first without an id."""
    found.refuse(found.track == UNLINKED, "id is -1: these are detections; link them first")
    return replace(found, visible=found.scores)


def read_tracked_places(path: Path) -> PlaceLabels:
    """The places of ``tracks_3d/NAME.txt``."""
    rows = _read(path, "a tracker's places", RESULTS)
    return _places(rows, rows.stacked("z", "x") * [1.0, -1.0])


def _read(path: Path, wanted: str, names: str) -> NamedColumns:
    """Rows with whole frames and ids, a person once in a frame."""
    rows = read_fixed(path, names, wanted)
    frames = frames_of(rows)
    people = rows.whole("id", UNLINKED, LARGEST_ID, "no id: those are whole numbers from 0 on, or -1 for none")
    rows.refuse_twice("id {1} stands in frame {0} twice", frames, people, among=people != UNLINKED)
    return rows


def _boxes(rows: NamedColumns, scores: FloatArray) -> BoxRows:
    boxes = rows.stacked("left", "top", "width", "height")
    far = np.abs(boxes).max(axis=1)
    rows.refuse(far > MOST_PIXELS, "the box reaches {0:g} px; boxes are in px of the panorama", far)
    rows.refuse(boxes[:, 2:].min(axis=1) <= 0.0, _NO_SIZE, *boxes[:, 2:].T)
    frame, track = _of_whom(rows)
    return sure_boxes(rows_of(rows.path, frame, track, boxes, scores, rows.lines))


def _places(rows: NamedColumns, places: FloatArray) -> PlaceLabels:
    """Places [N, 2] forward and left in m, of rows with a plausible height of a person."""
    far, heights = np.abs(places).max(axis=1, initial=0.0), rows.numbers("h")
    rows.refuse(far > MOST_METRES, "the place is {0:g} m away; x, y and z are in m", far)
    rows.refuse((heights <= 0.0) | (heights > TALLEST), "h is {0:g}; people are up to 4 m tall", heights)
    frame, track = _of_whom(rows)
    return PlaceLabels(path=rows.path, lines=rows.lines, frame=frame, track=track, places=places, heights=heights)


def _of_whom(rows: NamedColumns) -> IntArray:
    """Frames and ids [2, N] of rows."""
    return rows.stacked("frame", "id").astype(np.int64).T
