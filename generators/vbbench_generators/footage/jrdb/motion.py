"""Where JRDB's robot was when its pictures were taken, and what its wheels said of it.

Truth comes from wheels and gyro, odometry from the wheels alone: a robot's odometry is rarely better, and a solver that
repeats it does not thereby repeat the truth. Both share what the wheels get wrong of the distance.
"""

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchWarning
from vbbench.geometry import BoolArray, FloatArray, moved_as_one, wrap_angle
from vbbench.sequence import Odometry
from vbbench_generators.footage.jrdb.bags import BagReadings, speeds_of
from vbbench_generators.footage.odometry_filter import Readings, RobotMotion, clock_offset, filter_motion

OFFSET_STD = 0.02
"""s, by which the clocks of bag and pictures may differ still."""

MOST_LATE, WIDEST = 0.1, 2.0
"""s that people may turn around the robot before or after its poses do, and up to which this is tried."""

_SLACK = 0.5
_FEWEST = 3


@dataclass(frozen=True, kw_only=True)
class MeasuredMotion:
    """What is known of the robot's motion.

    Parameters
    ----------
    poses : [T, 3] (x, y, yaw) in m and rad, from (0, 0, 0) at frame 0.
    covariances : [T, 3, 3] of these.
    odometry : by the wheels alone.
    offsets : by how many seconds the clocks of gyro and pictures are ahead of the wheels'; ``None`` = not measurable.
    """

    poses: FloatArray
    covariances: FloatArray
    odometry: Odometry
    offsets: dict[str, float | None]

    @property
    def distance(self) -> float:
        """Metres driven."""
        return float(np.linalg.norm(np.diff(self.poses[:, :2], axis=0), axis=1).sum())

    @property
    def end_std(self) -> float:
        """Standard deviation in m of the last place, of the larger of its two directions."""
        return float(np.sqrt(np.linalg.eigvalsh(self.covariances[-1, :2, :2])[-1]))


def measure_motion(bag: BagReadings, times: FloatArray, places: FloatArray, every: int = 1) -> MeasuredMotion:
    """The robot's motion at the times of frames.

    Parameters
    ----------
    bag : what its sensors said.
    times : [T] of the frames in s.
    places : [T, P, 2] metres forward and to the left of the robot of people, NaN = not there: whether the clocks of bag
        and pictures differ follows from how people turn around the robot.
    every : of how many frames one will be kept. Slip lasts, so that the errors of motions in a row are correlated: the
        covariances are such that those of so many motions add up to that of the motion over all of them.

    Raises
    ------
    FileError
        If the bag does not cover the frames.
    """
    _check_covers(bag, times)
    gyro, offsets = bag.gyro, dict[str, float | None]()
    if gyro is not None:
        offsets["gyro"] = clock_offset(bag.turn, gyro)
        gyro = gyro.earlier(offsets["gyro"] or 0.0)
    seen = turning_by_people(times, places)
    offsets["pictures"] = None if seen is None else clock_offset(gyro or bag.turn, seen)
    times = times - (offsets["pictures"] or 0.0)
    truth = filter_motion(times, bag.speed, bag.turn, gyro)
    wheels = truth if gyro is None else filter_motion(times, bag.speed, bag.turn, None)
    kept = filter_motion(times[::every], bag.speed, bag.turn, None)
    return MeasuredMotion(
        poses=truth.poses,
        covariances=truth.covariances + _late(truth, times),
        odometry=shared_out(wheels.odometry, kept.odometry, every),
        offsets=offsets,
    )


def follow_poses(
    path: Path, way: tuple[FloatArray, FloatArray], times: FloatArray, places: FloatArray, every: int = 1
) -> MeasuredMotion:
    """The robot's motion by the poses that its wheels gave; ``times``, ``places``, ``every`` as in `measure_motion`.

    Parameters
    ----------
    path : the file of the poses, for messages.
    way : times [N] in s and poses [N, 3] (x, y, yaw).

    Raises
    ------
    FileError
        If they do not cover the frames.
    """
    when, twist = speeds_of(*way)
    speed, turn = (Readings(times=when, values=values) for values in twist.T)
    _check_covers(BagReadings(path=path, speed=speed, turn=turn, gyro=None), times)
    seen = turning_by_people(times, places)
    late = None if seen is None else clock_offset(turn, seen, WIDEST)
    if late is not None and abs(late) > MOST_LATE:
        problem = f"people turn around the robot {late:+.2f} s after its poses do; are poses those of the point clouds?"
        warnings.warn(VbbenchWarning(f"{path}: {problem}"), stacklevel=2)
    poses = np.stack([np.interp(times, way[0], column) for column in way[1].T], axis=-1)
    motion = filter_motion(times, speed, turn, None)
    kept = filter_motion(times[::every], speed, turn, None)
    return MeasuredMotion(
        poses=moved_as_one(poses, poses[0], np.zeros(3)),
        covariances=motion.covariances,
        odometry=shared_out(motion.odometry, kept.odometry, every),
        offsets={"places": late},
    )


def shared_out(odometry: Odometry, kept: Odometry, every: int) -> Odometry:
    """Motions from frame to frame, with shares of the covariances of the motions from kept frame to ``kept`` frame."""
    block = (np.arange(len(odometry.motions)) + every - 1) // every
    shares = kept.covariances[block.clip(max=len(kept.motions) - 1)] / every
    return Odometry(motions=odometry.motions, covariances=shares)


def turning_by_people(times: FloatArray, places: FloatArray) -> Readings | None:
    """The robot's turning rate in rad/s between frames: against how people turn around it, by their median.

    ``None`` where there are hardly frames with enough people.
    """
    directions = np.arctan2(places[..., 1], places[..., 0])
    turned = wrap_angle(np.diff(directions, axis=0))
    enough: BoolArray = (~np.isnan(turned)).sum(axis=1) >= _FEWEST
    if enough.sum() < 2:
        return None
    middles = times[:-1] + 0.5 * np.diff(times)
    return Readings(times=middles[enough], values=-np.nanmedian(turned[enough], axis=1) / np.diff(times)[enough])


def _late(motion: RobotMotion, times: FloatArray) -> FloatArray:
    """[T, 3, 3] what an error of the clock adds: the robot moves on in the meantime, more or less than at frame 0."""
    speeds: FloatArray = np.gradient(motion.poses, times, axis=0)
    ahead = OFFSET_STD * (speeds - speeds[0])
    added: FloatArray = ahead[:, :, None] * ahead[:, None, :]
    return added


def _check_covers(bag: BagReadings, times: FloatArray) -> None:
    first, last = bag.speed.times[[0, -1]]
    if times[0] < first - _SLACK or times[-1] > last + _SLACK:
        covered, wanted = f"{first:.3f} to {last:.3f} s", f"{times[0]:.3f} to {times[-1]:.3f} s"
        raise FileError(bag.path, f"covers {covered}, the pictures {wanted}: is it the bag of another recording?")
