"""The files of a sequence of KITTI tracking: calibration, labels, poses of the camera, and boxes of a detector.

``calib/NNNN.txt``: projection of camera 2, and extrinsics of the GPS/IMU. ``label_02/NNNN.txt``: boxes and places of
people in each picture, in 17 columns. Poses of the camera, from GPS/IMU (``oxts/NNNN.txt``) or from other poses of
camera 0, become motions [T, 4, 4] from rectified coordinates of camera 0 to a world with z up. GPS/IMU gives the world
of its Mercator map, x to the east, as in KITTI's devkit: s = cos(latitude of the first line), R the earth's radius,

    x = s R λ,   y = s R ln tan(π/4 + φ/2),   rotation = Rz(yaw) Ry(pitch) Rx(roll);

poses of other programs have the world of their first line, x forward and y left.
"""

import warnings
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.camera import PerspectiveCamera
from vbbench.errors import FileError, VbbenchWarning
from vbbench.exchange.box_rows import BoxRows, rows_of
from vbbench.exchange.box_tables import UNLINKED
from vbbench.exchange.text_tables import NamedColumns, Rows, first_cells, read_content, read_fixed
from vbbench.exchange.trajectory import MATRIX, read_trajectory
from vbbench.files.tables import LARGEST_ID
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.parsing.numbers import finite_number
from vbbench_generators.footage.tracks import frames_of, read_found, sure_boxes

MOUNT_HEIGHT = 1.65
"""Height of the cameras above the ground in m (Geiger et al. 2013, figure 3)."""

SIZES = {
    721.5377: (1242, 375),
    707.0493: (1224, 370),
    718.3351: (1238, 374),
    707.0912: (1226, 370),
    718.8560: (1241, 376),
}
"""Focal length of the rectified pictures in px → their width and height, of the five days of recording: 2011-09-26,
-28, -29, -30, and 2011-10-03."""

_SAME_FOCAL = 1e-3
_KEYS = {
    "P2": ("P2",),
    "R_rect": ("R_rect", "R0_rect"),
    "Tr_velo_cam": ("Tr_velo_cam", "Tr_velo_to_cam"),
    "Tr_imu_velo": ("Tr_imu_velo", "Tr_imu_to_velo"),
}
"""What is read, and what versions of the download call it."""
_TOLERANCE = 1e-2
"""How far a rotation's rows may be from orthonormal."""
_FOCAL_RANGE = (0.3, 5.0)
"""Focal lengths of cameras on cars, in widths of their pictures: 120° to 11° across."""


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """Calibration of the sensors.

    Parameters
    ----------
    projection : [3, 4] P2, from rectified coordinates of camera 0 (right, down, forward) to pixels of camera 2.
    imu_to_camera : [4, 4] from the GPS/IMU (forward, left, up) to rectified coordinates of camera 0.
    """

    path: Path
    projection: FloatArray
    imu_to_camera: FloatArray

    @property
    def offset(self) -> FloatArray:
        """Translation [3] in m from coordinates of camera 0 to those of camera 2: t = K⁻¹ p₄."""
        return np.asarray(np.linalg.solve(self.projection[:, :3], self.projection[:, 3]), np.float64)

    @property
    def known_size(self) -> tuple[int, int] | None:
        """Width and height of the pictures by their focal length; ``None`` if it is none of KITTI's."""
        focal = self.projection[0, 0]
        return next((size for known, size in SIZES.items() if abs(focal - known) < _SAME_FOCAL), None)

    def camera(self, size: tuple[int, int]) -> PerspectiveCamera:
        """Camera 2, assumed level; ``size`` is that of its pictures in px."""
        (focal, _, cx, _), (_, vertical, cy, _), _ = self.projection.tolist()
        least, most = (width * size[0] for width in _FOCAL_RANGE)
        if not (least <= focal <= most and least <= vertical <= most):
            problem = f"P2 has focal lengths {focal:g} and {vertical:g} px, for pictures {size[0]} px wide"
            raise FileError(self.path, f"{problem}; a camera's is {least:.0f} to {most:.0f} px")
        return PerspectiveCamera(
            width=size[0],
            height=size[1],
            focal=focal,
            cx=cx,
            cy=cy,
            mount_height=MOUNT_HEIGHT,
            vertical_focal=None if vertical == focal else vertical,
        )

    def project(self, places: FloatArray) -> FloatArray:
        """Pixels [N, 2] of places [N, 3] in coordinates of camera 0; NaN behind the camera."""
        seen = places @ self.projection[:, :3].T + self.projection[:, 3]
        depth = np.where(seen[:, 2:] > 0.0, seen[:, 2:], np.nan)
        pixels: FloatArray = seen[:, :2] / depth
        return pixels


def read_calibration(path: Path) -> Calibration:
    """Read a calibration file."""
    text = read_content(path, "the calibration: P2, R_rect, Tr_velo_cam, Tr_imu_velo").decode(errors="replace")
    found = {}
    for line, words in enumerate((line.replace(":", " ").split() for line in text.splitlines()), 1):
        name = next((name for name, keys in _KEYS.items() if words and words[0] in keys), None)
        if name is not None:
            found[name] = _matrix(path, line, name, words[1:])
    missing = [name for name in _KEYS if name not in found]
    if missing:
        raise FileError(path, f"lacks {', '.join(missing)}; download the calibration of the tracking benchmark again")
    return Calibration(
        path=path,
        projection=found["P2"],
        imu_to_camera=_rigid(found["R_rect"]) @ _rigid(found["Tr_velo_cam"]) @ _rigid(found["Tr_imu_velo"]),
    )


def _matrix(path: Path, line: int, name: str, words: list[str]) -> FloatArray:
    columns = 3 if name == "R_rect" else 4
    if len(words) != 3 * columns:
        raise FileError(path, f"{name} has {len(words)} numbers, not {3 * columns} (3 rows of {columns})", line)
    matrix = np.array([finite_number(path, line, name, word) for word in words]).reshape(3, columns)
    if name == "P2" and not (matrix[0, 0] > 0.0 and matrix[1, 1] > 0.0):
        raise FileError(path, f"P2 has focal lengths {matrix[0, 0]:g} and {matrix[1, 1]:g} px; they are above 0", line)
    if name != "P2":
        skew = np.abs(matrix[:, :3] @ matrix[:, :3].T - np.eye(3)).max()
        if skew > _TOLERANCE or np.linalg.det(matrix[:, :3]) < 0.0:
            raise FileError(path, f"{name} is no rotation: its rows deviate from orthonormal ones by {skew:.2g}", line)
    return matrix


def _rigid(matrix: FloatArray) -> FloatArray:
    """A rotation [3, 3], or rotation and translation [3, 4], as a homogeneous matrix [4, 4]."""
    whole = np.eye(4)
    whole[:3, : matrix.shape[1]] = matrix
    return whole


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
    def smallest_picture(self) -> tuple[int, int]:
        """Width and height in px of the smallest picture that holds all boxes."""
        columns, rows = np.ceil(self.boxes[:, 2:].max(axis=0, initial=1.0)).astype(int).tolist()
        return columns, rows

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
        frame=frames_of(rows),
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


EARTH_RADIUS = 6378137.0

PLACE = "lat lon alt roll pitch yaw"
_REST = (
    "vn ve vf vl vu ax ay az af al au wx wy wz wf wl wu pos_accuracy vel_accuracy navstat numsats posmode velmode "
    "orimode"
)
OXTS_ROW = " ".join([PLACE, *(f"({name})" for name in _REST.split())])
"""The 30 columns of the devkit."""

LONGEST_STEP = 15.0
"""In m from a line to the next, a tenth of a second: no car is as fast as that."""

_Z_UP = np.array([[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""From right, down, forward to forward, left, up."""


def read_oxts(path: Path, calibration: Calibration) -> FloatArray:
    """Motions [T, 4, 4] of camera 0, from the first camera's place on the map."""
    from scipy.spatial.transform import Rotation  # slow to import

    rows = read_fixed(path, OXTS_ROW, "GPS/IMU, a line a frame")
    latitude, longitude, altitude, roll, pitch, yaw = (rows[name] for name in PLACE.split())
    rows.refuse(np.abs(latitude) > 85.0, "lat is {0:g}°; the map ends at 85°", latitude)
    rows.refuse(np.abs(longitude) > 180.0, "lon is {0:g}°; it is -180° to 180°", longitude)
    for name, angle in (("roll", roll), ("pitch", pitch), ("yaw", yaw)):
        rows.refuse(
            np.abs(angle) > 2.0 * np.pi, f"{name} is {{0:g}} rad, more than a full turn; is it in degrees?", angle
        )
    scale = np.cos(np.radians(latitude[0])) * EARTH_RADIUS
    east = scale * np.radians(longitude)
    north = scale * np.log(np.tan(np.pi / 4.0 + np.radians(latitude) / 2.0))
    motions = np.tile(np.eye(4), (len(rows), 1, 1))
    motions[:, :3, :3] = Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=-1)).as_matrix()
    motions[:, :3, 3] = np.stack([east - east[0], north - north[0], altitude - altitude[0]], axis=-1)
    _refuse_leaps(rows, motions[:, :3, 3])
    cameras = motions @ np.linalg.inv(calibration.imu_to_camera)
    cameras[:, :3, 3] -= cameras[0, :3, 3].copy()
    return cameras


def read_poses(path: Path) -> FloatArray:
    """Motions [T, 4, 4] of camera 0 in the axes of the first picture; a line is a matrix [3, 4]."""
    rows = read_trajectory(path)
    if MATRIX not in rows.rotations:
        raise FileError(path, "needs 12 numbers in each line: a matrix [3, 4], row after row")
    motions = np.tile(np.eye(4), (len(rows), 1, 1))
    motions[:, :3, :3], motions[:, :3, 3] = rows.rotations[MATRIX], rows.places
    _refuse_leaps(rows, rows.places)
    return _Z_UP @ np.linalg.inv(motions[0]) @ motions


def _refuse_leaps(rows: Rows, places: FloatArray) -> None:
    """Raise FileError at the first of the ``places`` [T, 3] in m that is too far from the one before."""
    moved = np.linalg.norm(np.diff(places, axis=0, prepend=places[:1]), axis=1)
    rows.refuse(
        moved > LONGEST_STEP, "the camera is {0:,.0f} m from where the line before has it; are places in m?", moved
    )


def on_the_ground(motions: FloatArray, calibration: Calibration) -> FloatArray:
    """Poses [T, 3] (x, y, yaw) of camera 2 on the ground plane, from motions [T, 4, 4] of camera 0."""
    centre = np.append(-calibration.offset, 1.0)
    x, y = (motions @ centre)[:, :2].T
    ahead_x, ahead_y = motions[:, :2, 2].T
    return np.stack([x, y, np.arctan2(ahead_y, ahead_x)], axis=-1)


def in_the_world(places: FloatArray, motions: FloatArray) -> FloatArray:
    """World positions [N, 2] of places [N, 3] in coordinates of camera 0, with its motion [N, 4, 4] in each frame."""
    world: FloatArray = np.einsum("nij,nj->ni", motions[:, :2, :3], places) + motions[:, :2, 3]
    return world


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
    frame = frames_of(rows)
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
