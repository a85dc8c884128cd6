"""The extension module: sources in ``generators/cpp``, built by ``CMakeLists.txt``.

Arrays are in C order, of float64, int64 where they count, and bool where they mark. Anything else is a `VbbenchError`.
"""

from vbbench.geometry import BoolArray, FloatArray, IntArray

def elementary(name: str, x: FloatArray, y: FloatArray) -> FloatArray:
    """What the function of cpp/elementary.hpp called ``name`` is of x [N]; `atan2` of x and y."""

def march(
    *,
    states: FloatArray,
    speeds: FloatArray,
    goals: FloatArray,
    walls: FloatArray,
    numbers: dict[str, float],
    dt: float,
    substeps: int,
    paths: FloatArray,
) -> None:
    """Walk a crowd by the social force, and write ``paths``.

    Parameters
    ----------
    states : [4, K] x, y, vx, vy of everybody in m and m/s.
    speeds : [K] desired speeds in m/s.
    goals : [K, G, 2] in m.
    walls : [M, 4] segments x0, y0, x1, y1 in m.
    numbers : of a `vbbench_generators.social_force.Model` by name, those of walls behind ``wall_``.
    dt : seconds per frame, in ``substeps`` steps.
    paths : [T, K, 2] in m.
    """

def sweep(
    figures: FloatArray,
    distances: FloatArray,
    half: FloatArray,
    top: FloatArray,
    columns: int,
    bottom: float,
    wraps: bool,
) -> tuple[FloatArray, FloatArray]:
    """Occlusion: visible fractions [T, K] of people, and boxes [T, K, 4] (u, v, l, width) in px of their visible parts.

    ``figures`` [T, K, 3] are (u, row of the feet, l) in px, ``distances`` [T, K] in m, NaN = not there; ``half``,
    ``top`` [S] of the `vbbench_generators.tiers.noise.Outline`; ``columns``, ``bottom`` of the picture in px, infinity
    where it ``wraps``.
    """

def link_rows(numbers: FloatArray, kept: float, fresh: float) -> None:
    """Make each row of independent ``numbers`` [T, N] ``kept`` times the one before and ``fresh`` times itself."""

def sights(
    there: IntArray,
    relative: FloatArray,
    positions: FloatArray,
    poses: FloatArray,
    heights: FloatArray,
    mounts: FloatArray,
    tilt: FloatArray,
    amplitudes: FloatArray,
    phases: FloatArray,
    waves: FloatArray,
    near_edge: float,
) -> FloatArray:
    """Directions [N, 2, 3] (right, down, forward) of the tilted camera to feet and heads of some people.

    ``there`` [N] is who, counted through [T, K]; other numbers are those of `Carriage` in ``cpp/sights.hpp``.
    """

def project_cuboids(
    frame: IntArray,
    centres: FloatArray,
    rotations: FloatArray,
    sizes: FloatArray,
    turns: FloatArray,
    shifts: FloatArray,
    intrinsics: tuple[float, float, float, float],
    cylinder: bool,
    behind: float,
) -> FloatArray:
    """Boxes [N, 4] (left, top, right, bottom) in px around cuboids; NaN where a corner is behind a pinhole.

    Arrays are those of `Scene` in ``cpp/cuboids.hpp``, ``intrinsics`` (fx, fy, cx, cy) those of its `Projection`.
    """

def worths(tracks: FloatArray, detections: FloatArray, scores: FloatArray, least: float, period: float) -> FloatArray:
    """[N, M] excess over ``least`` of the IoU of boxes [N, 4] and [M, 4], times the score [M] of the latter.

    Boxes, here and below, are (centre column, centre row, width, height) in px; ``period`` is the width of a picture
    that closes on itself, 0 for one with borders.
    """

def merge_people(
    boxes: FloatArray,
    scores: FloatArray,
    true: FloatArray,
    chance: FloatArray,
    overlap: float,
    rate: float,
    period: float,
) -> BoolArray:
    """Merge some pairs of people into one box about both, in place; returns a mask of the detections that remain.

    Of two whose true boxes overlap by more than ``overlap`` that is so where the first's ``chance`` is below ``rate``.
    """

def remaining(boxes: FloatArray, order: IntArray, overlap: float, period: float) -> BoolArray:
    """Non-maximum suppression: mask of boxes [N, 4] whose IoU with better, kept ones is at most ``overlap``."""

def look_round(
    places: FloatArray, crowd: BoolArray, ways: FloatArray, wanted: int, limits: tuple[float, float, float, float]
) -> tuple[IntArray, FloatArray]:
    """Visibility of people along each of the paths ``ways`` [P, T, 3].

    Parameters
    ----------
    places, crowd : [T, K, 2] in m of everybody, and [T, K] who is to be seen.
    wanted : how many must be in view.
    limits : azimuths in rad of the view's left and right border, and the farthest and nearest distance in m.

    Returns
    -------
    [P, 2] the longest run of frames first ≤ t < last in which enough people are in view and nobody is in the way, the
    first of several, and [P, T] the distance in m of the nearest in view, or the farthest.
    """

def steer(
    goals: FloatArray,
    start: FloatArray,
    top_speed: float,
    acceleration: float,
    turn_rate: float,
    turn_time: float,
    lead: float,
    step: float,
) -> FloatArray:
    """[N, 5] place x, y in m, yaw in rad, speed and turning rate of a robot at each ``step`` s.

    ``goals`` [N, 2] and ``start`` [2] are in m; for the rest see `vbbench_generators.views.vehicle.RobotModel`.
    """

def turn_towards(course: FloatArray, most: float) -> FloatArray:
    """Yaws [N] that follow a ``course`` [N] by at most so many rad a step."""

def filter_readings(
    times: FloatArray, values: FloatArray, kinds: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Pose [T, 3], its covariance, and motion since the frame before with its covariance, at the T frames.

    ``times``, ``values``, ``kinds`` [N] are readings, ascending in time: `vbbench_generators.footage.odometry_filter`.
    """

def smooth(known: FloatArray, noise: FloatArray, starts: IntArray, q: float, dt: float) -> FloatArray:
    """Smoothed coordinate [M], gaps filled.

    Parameters
    ----------
    known, noise : [M] in m and m²; NaN = a gap, never at either end of a piece.
    starts : [K + 1] where each piece of a track begins; the last is M.
    q : density of acceleration in m²/s³.
    dt : seconds per frame.
    """

def whiten(
    value: FloatArray, phi: FloatArray, weight: FloatArray, person: IntArray, between: float
) -> tuple[FloatArray, FloatArray, float, float]:
    """Normal equations of harmonics, weighted square sum and log determinant; deviations of people are integrated out.

    Parameters
    ----------
    value, phi, weight : [S] log speeds, directions in rad, and weights.
    person : [S] ascending numbers.
    between : variance of people's paces.
    """
