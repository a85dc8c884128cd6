"""``label_02/NNNN.txt``: boxes and places of people in each picture, in KITTI's 17 columns."""

import warnings
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchWarning
from vbbench.exchange.box_rows import BoxRows, rows_of
from vbbench.exchange.box_tables import UNLINKED
from vbbench.exchange.text_tables import NamedColumns, Rows, first_cells, read_fixed
from vbbench.files.tables import LARGEST_ID
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_generators.footage.kitti.calibration import Calibration
from vbbench_generators.footage.tracks import read_found, sure_boxes

WALKERS = ("Pedestrian", "Person", "Person_sitting")
"""Classes of people on their feet, and of people who sit; versions of the download call these in two ways."""
CYCLISTS = ("Cyclist",)
CARS = ("Car", "Van", "Truck")
CLASSES = (*WALKERS, *CYCLISTS, *CARS, "Tram", "Misc", "DontCare")

LABELS = (
    "frame track class truncated occluded (alpha) left top right bottom height (width) (length) x y z (rotation) "
    "[score]"
)
"""Columns; trackers write the last one for KITTI's evaluation."""
_COUNTS = 17, 18

FARTHEST = 250.0
"""In m: no label is of anything farther off; a lidar reaches half as far."""

UNKNOWN = -1000.0
"""What stands in x, y and z where nobody knows."""
MOST_FRAMES = 10**6
SPARE = 2.0
"""px that a box may reach beyond the picture: those of KITTI end up to a pixel outside."""

SHOWS = np.array([1.0, 0.7, 0.3, 0.5])
"""Visible share by the column ``occluded``: fully visible, partly, largely occluded, unknown. KITTI says no more than
these words."""
INSIDE = np.array([1.0, 0.75, 0.5])
"""Share inside the picture by the column ``truncated``: all, cut, largely cut."""

MANY = 0.005
"""Share of the places outside their boxes that is worth a warning: one in a thousand in KITTI's labels."""

_REACH = 0.5
"""Widths and heights of a box that its projected place may lie beyond its borders."""


@dataclass(frozen=True, kw_only=True)
class Labels(Rows):
    """Labelled boxes, one a row.

    Parameters
    ----------
    frame, track : [N] from 0; track −1 for regions without a particular person.
    kind : [N] index of the class in `CLASSES`.
    truncated, occluded : [N] KITTI's levels.
    boxes : [N, 4] (left, top, right, bottom) in px.
    height : [N] height of the labelled body in m, NaN if unknown.
    places : [N, 3] its foot (right, down, forward) in coordinates of camera 0, in m; NaN if unknown.
    scores : [N] a detector's scores; 1 where there are none.
    """

    frame: IntArray
    track: IntArray
    kind: IntArray
    truncated: IntArray
    occluded: IntArray
    boxes: FloatArray
    height: FloatArray
    places: FloatArray
    scores: FloatArray

    @property
    def last_frame(self) -> int:
        """The last frame with a row, −1 if there is none."""
        return int(self.frame.max(initial=-1))

    @property
    def rectangles(self) -> FloatArray:
        """[N, 4] the boxes as (left, top, width, height) in px."""
        return np.concatenate([self.boxes[:, :2], self.boxes[:, 2:] - self.boxes[:, :2]], axis=-1)

    @property
    def visible(self) -> FloatArray:
        """[N] about the visible share of each body, in (0, 1]: `SHOWS` × `INSIDE`."""
        shown: FloatArray = SHOWS[self.occluded] * INSIDE[self.truncated]
        return shown

    def of(self, classes: Collection[str]) -> "Labels":
        """The rows of some classes."""
        return self.select(np.isin(self.kind, [CLASSES.index(name) for name in classes]))

    def tracked(self) -> tuple["Labels", IntArray, IntArray]:
        """The rows with a track, the tracks [K], and the index [N] of each row's track among these."""
        rows = self.select(self.track >= 0)
        tracks, column = np.unique(rows.track, return_inverse=True)
        return rows, tracks, column


def read_labels(path: Path) -> Labels:
    """Read a label file, with 17 columns, or 18 with a score."""
    rows = read_fixed(path, LABELS, "labelled boxes")
    track = rows.whole("track", -1, LARGEST_ID, "no track: those are whole numbers from 0 on, -1 for nobody")
    kind = rows.places("class", CLASSES)
    linked = (track >= 0) & (kind != CLASSES.index("DontCare"))
    boxes = rows.stacked("left", "top", "right", "bottom")
    wide, high = boxes[:, 2] - boxes[:, 0], boxes[:, 3] - boxes[:, 1]
    rows.refuse(linked & ~((wide > 0.0) & (high > 0.0)), "the box is {0:g} x {1:g} px; remove it", wide, high)
    height, places = rows.numbers("height").copy(), rows.stacked("x", "y", "z")
    unknown = places[:, 2] == UNKNOWN
    height[unknown], places[unknown] = np.nan, np.nan
    known = linked & ~np.isnan(places[:, 2])
    people = known & np.isin(kind, [CLASSES.index(name) for name in WALKERS])
    far = np.abs(places).max(axis=1)
    rows.refuse(known & ~(far < FARTHEST), "the place is {0:g} m away; x, y and z are in m", far)
    rows.refuse(people & ~((height >= 0.3) & (height <= 3.0)), "the height is {0:g} m, which no person's is", height)
    behind = people & (places[:, 2] < -1.0) & (rows.numbers("truncated") == 0.0)
    rows.refuse(behind, "z is {0:g} m, behind the camera that shows the box; z is forward", places[:, 2])
    labels = Labels(
        path=path,
        frame=rows.whole("frame", 0, MOST_FRAMES, "no frame: those are whole numbers from 0 on"),
        track=np.where(linked, track, -1),
        kind=kind,
        truncated=_level(rows, "truncated", linked, len(INSIDE)),
        occluded=_level(rows, "occluded", linked, len(SHOWS)),
        boxes=boxes,
        height=height,
        places=places,
        scores=rows.numbers("score", 1.0),
        lines=rows.lines,
    )
    twice = "track {1} has a box in frame {0} already, in {at}; remove one"
    labels.refuse_twice(twice, labels.frame, labels.track, among=labels.track >= 0)
    return labels


def size_of_pictures(labels: Labels) -> tuple[int, int]:
    """The smallest picture that holds all labelled boxes."""
    columns, rows = np.ceil(labels.boxes[:, 2:].max(axis=0, initial=1.0)).astype(int).tolist()
    return columns, rows


def refuse_boxes_outside(labels: Labels, size: tuple[int, int], known_by: str) -> None:
    """Raise FileError at the first box outside pictures of this size; ``known_by`` names the size's source."""
    left, top, right, bottom = labels.boxes.T
    outside = (left < -SPARE) | (top < -SPARE) | (right > size[0] + SPARE) | (bottom > size[1] + SPARE)
    if outside.any():
        row = int(outside.argmax())
        box = " ".join(f"{value:g}" for value in labels.boxes[row])
        problem = f"the box {box} reaches beyond pictures of {size[0]} x {size[1]} px, {known_by}"
        raise FileError(labels.path, f"{problem}; do labels and calibration belong together?", int(labels.lines[row]))


def refuse_places_elsewhere(labels: Labels, calibration: Calibration) -> None:
    """Raise FileError if most places do not project into their boxes, as of another frame; warn if some do not."""
    whole = labels.select((labels.truncated == 0) & (labels.track >= 0) & ~np.isnan(labels.height))
    if not len(whole):
        return
    middle = whole.places - 0.5 * whole.height[:, None] * np.array([0.0, 1.0, 0.0])
    pixels = calibration.project(middle)
    corners = whole.boxes.reshape(-1, 2, 2)
    spare = _REACH * (corners[:, 1] - corners[:, 0])
    inside = ((pixels > corners[:, 0] - spare) & (pixels < corners[:, 1] + spare)).all(axis=1)
    outside = 1.0 - float(inside.mean())
    if outside <= MANY:
        return
    share = f"{outside:.0%}" if outside > 0.1 else f"{outside:.1%}"
    row = int(np.argmin(inside))
    seen = "behind the camera" if np.isnan(pixels[row, 0]) else f"at {pixels[row, 0]:.0f} {pixels[row, 1]:.0f} px"
    problem = f"the labelled place is {seen}, outside its box, as are {share} of {len(whole)}"
    wanted = "x, y, z are right, down and forward of camera 0, in m"
    fault = FileError(whole.path, f"{problem}: {wanted}", int(whole.lines[row]))
    if outside > 0.5:
        raise fault
    warnings.warn(VbbenchWarning(str(fault)), stacklevel=2)


def _level(rows: NamedColumns, name: str, linked: BoolArray, levels: int) -> IntArray:
    values = np.where(linked, rows.numbers(name), 0.0)
    bad = (values != np.round(values)) | (values < -1) | (values >= levels)
    rows.refuse(bad, f"{name} is {{0:g}}; levels are 0 to {levels - 1}, -1 if unknown", values)
    return np.maximum(values, 0.0).astype(np.int64)


DETECTIONS = "frame type left top right bottom score (height) (width) (length) (x) (y) (z) (rotation) (alpha)"
"""Columns of lidar detectors, with commas between."""
TYPES = {1: "Pedestrian", 2: "Car", 3: "Cyclist"}
"""Classes of these detections."""
LARGEST_LOG_ODDS = 20.0
"""Largest score that is log-odds, as lidar detectors write them; one in 500 million would be wrong."""


def read_boxes(
    path: Path,
    frames: int,
    classes: tuple[str, ...],
    *,
    dt: float,
    picture: tuple[float, float],
    person_class: str | None = None,
) -> BoxRows:
    """Read boxes of ``classes`` with sufficient scores, of a recording of ``frames`` frames.

    Parameters
    ----------
    dt, picture, person_class : as in `read_found`.
    """
    count = len(first_cells(path))
    if count in _COUNTS:
        return _from_labels(path, classes).within(frames)
    if count == len(DETECTIONS.split()):
        return _from_detections(path, classes).within(frames)
    return read_found(path, frames, dt, picture, person_class)


def _from_detections(path: Path, classes: tuple[str, ...]) -> BoxRows:
    rows = read_fixed(path, DETECTIONS, "boxes on the pictures")
    frame = rows.whole("frame", 0, MOST_FRAMES, "no frame: those are whole numbers from 0 on")
    corners = rows.stacked("left", "top", "right", "bottom")
    sizes = corners[:, 2:] - corners[:, :2]
    rows.refuse((sizes[:, 0] <= 0.0) | (sizes[:, 1] <= 0.0), "the box is {0:g} x {1:g} px; remove it", *sizes.T)
    wanted = np.isin(rows["type"], [number for number, name in TYPES.items() if name in classes])
    boxes, track = np.concatenate([corners[:, :2], sizes], axis=-1), np.full(len(rows), UNLINKED)
    scores = _log_odds(rows["score"][wanted])
    return sure_boxes(rows_of(path, frame[wanted], track[wanted], boxes[wanted], scores, rows.lines[wanted]))


def _from_labels(path: Path, classes: tuple[str, ...]) -> BoxRows:
    labels = read_labels(path).of(classes)
    scores = _log_odds(labels.scores)
    return sure_boxes(rows_of(path, labels.frame, labels.track, labels.rectangles, scores, labels.lines))


def _log_odds(scores: FloatArray) -> FloatArray:
    """Scores [N] in [0, 1]; log-odds are converted, which exceed 1 and are too small for per cent."""
    small = (scores > 0.0).all() and 1.0 < scores.max(initial=0.0) <= LARGEST_LOG_ODDS
    return 1.0 / (1.0 + np.exp(-scores)) if small else scores
