"""Files of camera poses and of odometry: trajectories with a line a second or more.

Their formats are those of `vbbench.exchange.trajectory`; the clock is that of the boxes. Lines of TUM odometry may end
with the covariance of the motion since the line before, ff fl f_turn ll l_turn turn_turn (forward, left, turn), in m²,
m·rad and rad².
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import FileError
from vbbench.exchange.box_rows import MOST_BACK, Timeline
from vbbench.exchange.own.camera_file import OdometryFacts
from vbbench.exchange.trajectory import Grounded, Trajectory, ground_poses, off_course, read_trajectory
from vbbench.files.tables import MOTION_COVARIANCE
from vbbench.geometry import FloatArray, IntArray, wrap_angle
from vbbench.parsing.column_names import UNITS
from vbbench.sequence import Odometry

LONGEST_HOLE = 1.0
"""Poses farther apart, in s, are not interpolated between."""
OFF_COURSE = 0.8
"""Share of the way that may lead elsewhere than where the camera looks, without a note."""
PATH_TURN = 0.05
"""Rad after one second that the yaw of a camera is off the direction of its path."""
FINEST, MUCH_LESS = 5e-4, 0.5
"""Seconds between poses that nothing measures faster than, and a share of time in common that is much less."""
LEAST_TURN, ENOUGH_TURN, ENOUGH_BOXES, ENOUGH_PEOPLE = 0.003, 0.15, 30, 4
"""Rad in a frame that boxes can show, rad in all, boxes and people, from which on turns are compared with boxes."""
MOST_LATE, MOST_TURN = 30, 0.3
"""Frames by which a clock is tried to be off, and rad that boxes show in a frame."""
USUAL_HEIGHT = 1.72
"""M, of people whose distance matters little."""
SAME_TIME = 1e-3
"""In s: clocks that differ by less agree."""
FASTEST, LEAP = 60.0, 5.0
"""In m/s and m: no camera is faster, but for the noise of a place."""
LEAST_LEAP, FREE, USUALLY = np.array([0.5, 0.35]), np.array([3.0, 2.0]), 0.9
"""In m and rad, and per second: a reset shows beyond these and four times the speed of this share of lines."""
BEYOND = 0.5
"""In frames: how far before the first pose and after the last the camera is taken to move on as it did."""


def read_poses(path: Path, timeline: Timeline) -> tuple[FloatArray, tuple[str, ...]]:
    """Poses [T, 3] (x, y, yaw) of the frames, and notes."""
    _, times, grounded = _read(path, timeline, OdometryFacts())
    found = _at(times, grounded.poses, timeline.times, beyond=BEYOND * timeline.dt)
    missing = np.isnan(found[:, 0])
    if missing.any():
        frame = int(missing.argmax())
        problem = f"{int(missing.sum())} of {len(missing)} frames have no pose: frame {frame} is at"
        raise FileError(path, f"{problem} {timeline.times[frame]:.10g} s, {_reach(times, timeline)}")
    return found, grounded.notes


def read_odometry(path: Path, timeline: Timeline, facts: OdometryFacts) -> tuple[Odometry, tuple[str, ...]]:
    """The camera's motion from frame to frame with its covariance, NaN where it was not measured, and notes.

    Poses are interpolated at the times of the frames, and not known before the first and after the last. Stated
    covariances are added up over the time of a frame; otherwise they follow from ``facts``.
    """
    trajectory, times, grounded = _read(path, timeline, facts)
    if grounded.from_path:
        facts = replace(facts, turn_floor=float(np.hypot(facts.turn_floor, PATH_TURN)))
    at = _at(times, grounded.poses, timeline.times, beyond=SAME_TIME)
    stated = _stated(trajectory, times, timeline.times)
    motions, covariances = np.full((len(at), 3), np.nan), np.full((len(at), 3, 3), np.nan)
    motions[1:], covariances[1:] = facts.motions(at, np.diff(timeline.times), stated)
    for row in _leaps(times, grounded.poses):
        before, after = timeline.times[:-1] + SAME_TIME, timeline.times[1:] - SAME_TIME
        motions[1:][(after > times[row - 1]) & (before < times[row])] = np.nan
    measured = np.isfinite(motions[1:, 0]) & np.isfinite(covariances[1:]).all(axis=(1, 2))
    motions[1:][~measured], covariances[1:][~measured] = np.nan, np.nan
    if not measured.any():
        frames = f"the boxes are from {timeline.times[0]:.10g} to {timeline.times[-1]:.10g} s"
        raise FileError(path, f"no frame has a motion: {frames}, {_reach(times, timeline)}")
    missing = f"{int((~measured).sum())} of {len(measured)} motions are not in {path.name}"
    off = times - timeline.times if len(times) == timeline.frames else np.zeros(1)
    if np.ptp(off) <= 0.1 * timeline.dt and abs(off[0]) >= 0.5 * timeline.dt:
        when = f"{abs(off[0]):.4g} s {'later' if off[0] > 0.0 else 'earlier'}"
        missing += f": it has as many poses as there are frames, each {when}: do both count from one number, 0 or 1?"
    return Odometry(motions=motions, covariances=covariances), (*grounded.notes, *([] if measured.all() else [missing]))


def _reach(times: FloatArray, timeline: Timeline) -> str:
    """Text about the time that poses cover, and the remedy if that of the frames is another."""
    reach = f"the poses reach from {times[0]:.10g} to {times[-1]:.10g} s"
    if timeline.numbered and (times[-1] < timeline.times[0] or times[0] > timeline.times[-1]):
        return (
            f"{reach}; boxes have numbers of frames: write the time of each frame by the clock of the poses into their "
            "file (a column 'time'), or subtract the time of frame 0 from the times here"
        )
    return f"{reach}; both need one clock, and no hole over {LONGEST_HOLE:g} s"


def _read(path: Path, timeline: Timeline, facts: OdometryFacts) -> tuple[Trajectory, FloatArray, Grounded]:
    """The rows of a file by ascending time, their times [N] in s by the clock of the boxes, and poses on the ground."""
    trajectory = read_trajectory(path)
    times, notes = _by_the_clock_of_boxes(trajectory, timeline)
    trajectory, times = _in_order(trajectory, times)
    grounded = ground_poses(trajectory, facts.axes)
    poses = grounded.poses
    _refuse_leaps(trajectory, times, poses, timeline)
    leaps = _leaps(times, poses)
    if len(leaps):
        moved = float(np.hypot(*(poses[leaps[0]] - poses[leaps[0] - 1])[:2]))
        where = f"{path.name}, {trajectory.place(leaps[0])}: the pose leaps by {moved:.3g} m from the line before"
        notes += (f"{where}, one of {len(leaps)} leaps: was odometry reset? Motions over them do not count",)
    if not np.ptp(poses, axis=0).any():
        notes += (f"{path.name}: its pose never changes: the camera is taken to stand",)
    share, angle = off_course(facts.of_camera(poses))
    if share > OFF_COURSE:
        side = "left" if angle > 0.0 else "right"
        way = f"{share:.0%} of the way leads {abs(np.degrees(angle)):.0f}° to the {side} of where the camera looks"
        advice = "if the camera does not drive backwards or sideways, write axes or mount in [odometry]"
        notes += (f"{path.name}: {way}; {advice}",)
    return trajectory, times, grounded._replace(notes=(*grounded.notes, *notes))


def _by_the_clock_of_boxes(trajectory: Trajectory, timeline: Timeline) -> tuple[FloatArray, tuple[str, ...]]:
    """Times [N] in s, and a note if their unit was inferred from the boxes.

    Rows without timestamps are the frames of the film from the first on.
    """
    path, times, count = trajectory.path, trajectory.times, len(trajectory)
    if times is None:
        if count == timeline.frames:
            return timeline.times, ()
        if timeline.numbered and count > timeline.times[-1] / timeline.frame_time - 0.5:
            return timeline.frame_time * np.arange(count, dtype=np.float64), ()
        problem = f"has {count} lines without timestamps, and the boxes {timeline.frames} frames"
        raise FileError(path, f"{problem}: a line is a frame; write the timestamp in s first")
    frames = timeline.times[0] + (times - timeline.first_number) * timeline.frame_time
    if trajectory.unit is not None:
        return (times * trajectory.unit if trajectory.unit else frames), ()
    first, last, step = timeline.times[0], timeline.times[-1], float(np.median(np.diff(np.sort(times))))
    clocks = {"s": times, **{unit: times * UNITS[unit] for unit in ("ms", "us", "ns") if step * UNITS[unit] > FINEST}}
    if step == 1.0 and timeline.numbered:
        clocks["numbers of frames"] = frames
    shared = {}
    for name, clock in clocks.items():
        both = min(last, clock.max()) - max(first, clock.min())
        shared[name] = both / (max(last, clock.max()) - min(first, clock.min()))
    best = max(shared, key=lambda name: shared[name])
    if shared["s"] > MUCH_LESS * shared[best] or shared[best] < MUCH_LESS:
        return times, ()
    return clocks[best], (f"{path.name}: timestamps are {best}: so they reach over the time of the boxes",)


def _refuse_leaps(trajectory: Trajectory, times: FloatArray, poses: FloatArray, timeline: Timeline) -> None:
    """Raise FileError at the first of the ``poses`` [N, 3], near the frames, that needs an impossible speed.

    Speeds are checked from line to line, which finds broken lines, and over a second, which finds places in mm.
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
            advice = "are places in m, of the body in the world, and the line whole?"
            raise trajectory.fault(int(later[row]), f"{problem}; {advice}")


def _leaps(times: FloatArray, poses: FloatArray) -> IntArray:
    """Rows whose step from the pose before is far longer than most steps of the poses [N, 3]."""
    moves = np.diff(poses, axis=0)
    moved = np.column_stack([np.hypot(moves[:, 0], moves[:, 1]), np.abs(wrap_angle(moves[:, 2]))])
    passed = np.diff(times)[:, None]
    usual = np.quantile(moved / passed, USUALLY, axis=0) if len(moved) else 0.0
    return 1 + np.flatnonzero((moved > LEAST_LEAP + (FREE + 4.0 * usual) * passed).any(axis=1))


def compare_turns(path: Path, motions: FloatArray, boxes: FloatArray, camera: Camera) -> tuple[str, ...]:
    """A note if boxes [T, K, 3] do not show the turns of the camera's ``motions`` [T, 3] since the frame before.

    People are taken to stand, at distances by their heights: a turn to the left moves them to the right by as much.
    Turns the other way, as of a left-handed world, are refused.
    """
    frame, track = np.nonzero(np.isfinite(boxes[1:, :, 2]) & np.isfinite(boxes[:-1, :, 2]))
    before, after = (camera.unproject(boxes[frame + n, track], np.full(len(frame), USUAL_HEIGHT)) for n in (0, 1))
    forward, left, turn = motions[frame + 1].T
    stands = np.arctan2(before[:, 0] + np.nan_to_num(left), before[:, 1] - np.nan_to_num(forward))
    seen = wrap_angle(np.arctan2(after[:, 0], after[:, 1]) - stands)
    turns = np.abs(turn) > LEAST_TURN
    whole = float(np.abs(motions[np.abs(motions[:, 2]) > LEAST_TURN, 2]).sum())
    if whole < ENOUGH_TURN or turns.sum() < ENOUGH_BOXES or len(np.unique(track[turns])) < ENOUGH_PEOPLE:
        return ()
    late = _turns_late(motions[1:, 2], frame, seen)
    if late:
        when = "later" if late > 0 else "earlier"
        problem = f"boxes show its turns {abs(late)} frames {when}: is its clock theirs?"
        return (f"{path.name}: {problem} Write its timestamps so much {when}",)
    shown = seen[turns] / turn[turns]
    order = np.argsort(shown)
    weight = np.cumsum(np.abs(turn[turns])[order])
    share = float(shown[order][np.searchsorted(weight, 0.5 * weight[-1])])
    if share > 0.5:
        return ()
    problem = f"of {np.degrees(whole):.0f}° that the camera turns by it, boxes show {share:.0%}"
    if share < -0.5:
        advice = "does its y point right, or z down? Write axes = 'ned' (or 'unreal', left-handed) in [odometry]"
        advice = f"{advice}; of a compass's heading write 90° - heading, of poses from world to camera their inverses"
        raise FileError(path, f"{problem}, the other way: {advice}")
    degrees = "; if its yaw is in degrees, name the column 'yaw [deg]'" if 0.5 < np.degrees(share) < 2.0 else ""
    return (f"{path.name}: {problem}: are its axes, clock and mount those of the camera?{degrees}",)


def _turns_late(turns: FloatArray, frame: IntArray, seen: FloatArray) -> int:
    """Delay in frames of turns ``seen`` [N] in boxes after ``frame`` [N], against ``turns`` [T − 1]; 0 if unclear."""
    count, size, off = np.bincount(frame, minlength=len(turns)), len(turns), dict[int, float]()
    shown = np.bincount(frame, np.clip(seen, -MOST_TURN, MOST_TURN), size) / np.where(count, count, np.nan)
    most = min(MOST_LATE, size // 2)
    for late in range(-most, most + 1):
        pairs = np.abs(shown[max(late, 0) : size + min(late, 0)] - turns[max(-late, 0) : size - max(late, 0)])
        if np.isfinite(pairs).sum() >= 0.5 * np.isfinite(shown).sum():
            off[late] = float(np.nanmean(pairs))
    best, mirrored = min(off, key=lambda late: off[late], default=0), float(np.nanmean(np.abs(shown + turns)))
    # A left-handed world mirrors turns.
    return best if off.get(best, 0.0) < min(mirrored, MUCH_LESS * off.get(0, 0.0) - LEAST_TURN) else 0


def _in_order(trajectory: Trajectory, times: FloatArray) -> tuple[Trajectory, FloatArray]:
    """The rows, and their times [N], by ascending time."""
    back = times[:-1] - times[1:]
    if 0 < (back > LONGEST_HOLE).sum() <= MOST_BACK:
        problem = f"the clock goes back by {back.max():.4g} s; of two recordings keep one"
        raise trajectory.fault(int(back.argmax()) + 1, problem)
    order = np.argsort(times, kind="stable")
    trajectory, times = trajectory.select(order), times[order]
    again = np.append(False, np.diff(times) == 0.0)
    trajectory.refuse(again, "time {0:.10g} s stands twice; remove one of them", times)
    return trajectory, times


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


def _stated(trajectory: Trajectory, times: FloatArray, wanted: FloatArray) -> FloatArray | None:
    """[T − 1, 3, 3] covariances of the motions between the times ``wanted`` [T], if lines at ``times`` [N] state them.

    Those of lines, of the motion since the line before, are added up, parts of lines in proportion to time.
    """
    if trajectory.covariances is None:
        return None
    matrices = np.empty((len(times), 3, 3))
    i, j = np.triu_indices(3)
    matrices[:, i, j] = matrices[:, j, i] = trajectory.covariances
    wrong = np.append(False, np.linalg.eigvalsh(matrices)[1:, 0] <= 0.0)
    trajectory.refuse(wrong, f"the covariance {' '.join(MOTION_COVARIANCE)} is not positive definite")
    knots = np.union1d(times, wanted.clip(times[0], times[-1]))
    line, frame = np.searchsorted(times, knots[1:]), np.searchsorted(wanted, knots[1:])
    shares = np.diff(knots) / (times[line] - times[line - 1])
    sums = np.zeros((len(wanted) + 1, 3, 3))  # the first and last: before the first frame, and after the last
    np.add.at(sums, frame, shares[:, None, None] * matrices[line])
    return sums[1:-1]
