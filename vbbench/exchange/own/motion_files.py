"""Where the camera was, and how its bearer moved by its own measurement: TUM files, a line a second or more.

Lines of ``timestamp tx ty tz qx qy qz qw``, the clock that of the boxes; the body's x axis points forward, z up. Lines
of ``odometry.txt`` may go on with the covariance of the motion since the line before, ff fl f_turn ll l_turn turn_turn
(forward, left, turn), in m², m·rad and rad².
"""

from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.own.camera_file import OdometryNoise
from vbbench.exchange.own.timing import Timeline
from vbbench.exchange.tum import planar_poses, read_tum_rows
from vbbench.files.tables import MOTION_COVARIANCE
from vbbench.geometry import FloatArray, IntArray, motion_between, motion_levers, wrap_angle
from vbbench.sequence import Odometry

LONGEST_HOLE = 1.0
"""Poses farther apart, in s, are not interpolated between."""
SAME_TIME = 1e-3
"""In s: clocks that differ by less agree."""
FASTEST, LEAP = 60.0, 5.0
"""In m/s and m: no camera is faster, but for the noise of a place."""
BEYOND = 0.5
"""In frames: how far before the first pose and after the last the camera is taken to move on as it did."""


def read_poses(path: Path, timeline: Timeline) -> FloatArray:
    """Poses [T, 3] (x, y, yaw) of the frames.

    Raises
    ------
    FileError
        If the file cannot be read, nobody moves as fast, or some frame has no pose: truth is whole, or it is none.
    """
    lines, values = _in_order(path, *read_tum_rows(path))
    times, poses = values[:, 0], planar_poses(path, lines, values)
    _refuse_leaps(path, lines, times, poses, timeline)
    found = _at(times, poses, timeline.times, beyond=BEYOND * timeline.dt)
    missing = np.isnan(found[:, 0])
    if missing.any():
        frame = int(missing.argmax())
        problem = (
            f"{int(missing.sum())} of {len(missing)} frames have no pose: frame {frame} is at "
            f"{timeline.times[frame]:.10g} s, the poses reach from {times[0]:.10g} to {times[-1]:.10g} s"
        )
        raise FileError(path, f"{problem}; both need one clock, and no hole over {LONGEST_HOLE:g} s")
    return found


def read_odometry(path: Path, timeline: Timeline, noise: OdometryNoise) -> tuple[Odometry, tuple[str, ...]]:
    """The motion from frame to frame with its covariance, NaN where it was not measured, and notes.

    Poses are interpolated at the times of the frames, and not known before the first and after the last. Stated
    covariances are added up over the time of a frame, parts of intervals in proportion to time; otherwise they follow
    from ``noise``.

    Raises
    ------
    FileError
        If the file cannot be read, nobody moves as fast, a covariance is not positive, or hardly any frame has a
        motion.
    """
    lines, values = _in_order(path, *read_tum_rows(path, MOTION_COVARIANCE))
    times, poses = values[:, 0], planar_poses(path, lines, values[:, :8])
    _refuse_leaps(path, lines, times, poses, timeline)
    at = _at(times, poses, timeline.times, beyond=SAME_TIME)
    motions = np.full((timeline.frames, 3), np.nan)
    motions[1:] = motion_between(at[:-1], at[1:])
    motions[1:, 2] = wrap_angle(motions[1:, 2])
    seconds = np.diff(timeline.times, prepend=np.nan)
    covariances = noise.covariances(motions, seconds)
    if values.shape[1] > 8:
        covariances = _stated(path, lines, times, poses, values[:, 8:], timeline.times)
    measured = np.isfinite(motions[1:, 0]) & np.isfinite(covariances[1:]).all(axis=(1, 2))
    motions[1:][~measured], covariances[1:][~measured] = np.nan, np.nan
    notes: tuple[str, ...] = ()
    if not measured.any():
        boxes = f"the boxes from {timeline.times[0]:.10g} to {timeline.times[-1]:.10g} s"
        problem = f"reaches from {times[0]:.10g} to {times[-1]:.10g} s, {boxes}: no frame has a motion"
        raise FileError(path, f"{problem}; both need one clock, and no hole over {LONGEST_HOLE:g} s")
    if not measured.all():
        notes = (f"{int((~measured).sum())} of {len(measured)} motions are not in {path.name}",)
    return Odometry(motions=motions, covariances=covariances), notes


def _refuse_leaps(path: Path, lines: IntArray, times: FloatArray, poses: FloatArray, timeline: Timeline) -> None:
    """Raise FileError at the first of the ``poses`` [N, 3], of those about the frames, to which nobody gets in time.

    It is looked from line to line, which a broken line does not pass, and over a second, which places in mm do not.
    """
    first, last = timeline.times[0] - LONGEST_HOLE, timeline.times[-1] + LONGEST_HOLE
    rows = np.arange(len(times))
    for later in (rows + 1, np.searchsorted(times, times + 1.0)):
        later = later.clip(max=len(times) - 1)
        passed = times[later] - times
        moved = np.hypot(*(poses[later, :2] - poses[:, :2]).T)
        leaps = (moved > LEAP + FASTEST * passed) & (times[later] >= first) & (times <= last)
        if leaps.any():
            row = int(leaps.argmax())
            problem = f"the place is {moved[row]:,.4g} m from the one {passed[row]:.3g} s before"
            raise FileError(path, f"{problem}; are places in m, and is the line whole?", int(lines[later[row]]))


def _in_order(path: Path, lines: IntArray, values: FloatArray) -> tuple[IntArray, FloatArray]:
    """The lines' numbers [N] and values [N, ...] by ascending time, the first of the values."""
    order = np.argsort(values[:, 0], kind="stable")
    lines, values = lines[order], values[order]
    again = np.flatnonzero(np.diff(values[:, 0]) == 0.0)
    if len(again):
        problem = f"time {values[again[0], 0]:.10g} s stands twice; leave one of them out"
        raise FileError(path, problem, int(lines[again[0] + 1]))
    return lines, values


def _at(times: FloatArray, poses: FloatArray, wanted: FloatArray, *, beyond: float) -> FloatArray:
    """Poses [T, 3] at the times ``wanted`` [T] in s, interpolated; NaN ``beyond`` the first and last, and in holes."""
    if len(times) < 2:
        return np.full((len(wanted), 3), np.nan)
    after = np.searchsorted(times, wanted).clip(1, len(times) - 1)
    before = after - 1
    # Beyond the ends the motion of half a frame or so goes on, not the noise between two lines.
    early, late = wanted < times[0], wanted > times[-1]
    after[early] = np.searchsorted(times, times[0] + beyond).clip(1, len(times) - 1)
    before[early], after[late] = 0, len(times) - 1
    before[late] = (np.searchsorted(times, times[-1] - beyond, side="right") - 1).clip(0, len(times) - 2)
    turned = np.column_stack([poses[:, :2], np.unwrap(poses[:, 2])])
    share = (wanted - times[before]) / (times[after] - times[before])
    found: FloatArray = turned[before] + share[:, None] * (turned[after] - turned[before])
    found[:, 2] = wrap_angle(found[:, 2])
    outside = (wanted < times[0] - beyond) | (wanted > times[-1] + beyond)
    alone = (wanted > times[before] + beyond) & (wanted < times[after] - beyond)
    found[outside | (alone & (times[after] - times[before] > LONGEST_HOLE))] = np.nan
    return found


def _stated(
    path: Path, lines: IntArray, times: FloatArray, poses: FloatArray, triangles: FloatArray, wanted: FloatArray
) -> FloatArray:
    """[T, 3, 3] covariances of the motions since the frame before, from those [N, 6] since the line before."""
    matrices = np.empty((len(triangles), 3, 3))
    i, j = np.triu_indices(3)
    matrices[:, i, j] = matrices[:, j, i] = triangles
    smallest = np.linalg.eigvalsh(matrices)[:, 0]
    wrong = smallest[1:] <= 0.0
    if wrong.any():
        row = 1 + int(wrong.argmax())
        raise FileError(path, f"the covariance {' '.join(MOTION_COVARIANCE)} is not positive definite", int(lines[row]))
    return _composed(times, poses, matrices, wanted)


def _composed(times: FloatArray, poses: FloatArray, matrices: FloatArray, wanted: FloatArray) -> FloatArray:
    """The covariances [T, 3, 3] of motions of which each line states its part; where no line is, nothing is added.

    A part that moves by m with covariance C, in the axes where it begins, adds A C Aᵀ in those of the frame before:
    A turns it there, and an error of its turn moves the place that is reached in the end, as far as that is off.
    """
    inside = wanted[(wanted >= times[0]) & (wanted <= times[-1])]
    knots = np.union1d(times, inside)
    line = np.searchsorted(times, knots[1:])
    frame = np.searchsorted(wanted, knots[1:])
    parts = np.flatnonzero((frame > 0) & (frame < len(wanted)))
    line, frame, ends = line[parts], frame[parts], parts + 1
    at = _at(times, poses, np.concatenate([knots, wanted]), beyond=SAME_TIME)
    here, there = at[: len(knots)], at[len(knots) :]
    begun, left_to_go = there[frame - 1, 2], there[frame, :2] - here[ends, :2]
    rest = (left_to_go[:, 0] + 1j * left_to_go[:, 1]) * np.exp(-1j * begun)
    moves = motion_levers(np.exp(1j * (here[ends - 1, 2] - begun)), rest)
    shares = (knots[ends] - knots[ends - 1]) / (times[line] - times[line - 1])
    covariances = np.zeros((len(wanted), 3, 3))
    covariances[0] = np.nan
    np.add.at(covariances, frame, moves @ (shares[:, None, None] * matrices[line]) @ moves.transpose(0, 2, 1))
    return covariances
