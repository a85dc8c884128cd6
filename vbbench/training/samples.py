"""A sequence, or a window of its frames, as arrays of fixed shape: what a network reads, and what it is to answer."""

from collections.abc import Callable
from collections.abc import Sequence as Several
from dataclasses import dataclass, fields
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from vbbench.camera import Camera
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.protocol import Protocol, arrivals_given, scored_frames, scored_positions
from vbbench.scene import World
from vbbench.sequence import NOBODY, Given, Odometry, Sequence, Truth
from vbbench.solver import Problem

Array = TypeVar("Array")
Other = TypeVar("Other")

CAMERA_VALUES = ("width", "height", "focal", "ahead_u", "ahead_v", "mount_height", "pitch", "roll", "closed")
"""What `Sample.camera` holds: size and focal length in px, the pixel straight ahead, m, rad, rad, 1 for all around."""
TOLD_VALUES = ("dt", "height_mean", "height_std", "pixel_std", "box_std", "tilt_std", "mount_height_std")
"""What `Sample.told` holds: see `vbbench.solver.Problem`."""


@dataclass(frozen=True, kw_only=True)
class Sample(Generic[Array]):
    """One sequence or window, of T frames and K people; a batch has an axis B before all others.

    Numbers are float32, 0 where there is nothing to say; the mask next to them marks where. Frames after the end and
    people beyond the last are padding. A person keeps one column, the *slot*, in all frames.

    Parameters
    ----------
    index, start : [] number of the sequence, and its frame with which the sample begins.
    frames : [T] whether the frame is one, and no padding.
    tracks : [K] ids of the people in the sequence, −1 for padding.
    boxes : [T, K, 3] (u, v, l) in px; ``seen`` [T, K] marks where.
    visible : [T, K] how much shows of whoever is seen, or a detector's score.
    sights : [T, K, 2] (right, forward) in m from the camera to whoever is seen, if of the given mean height.
    arrives, leaves : [T, K] whether it is the person's first, or last, box in the sequence.
    camera, told : [9] and [7], see `CAMERA_VALUES` and `TOLD_VALUES`.
    given_poses : [T, 3] (x, y, yaw) in m and rad that the protocol gives; ``pose_given`` [T] marks where.
    given_positions : [T, K, 2] in m that it gives; ``position_given`` [T, K] marks where.
    odometry : [T, 3] (forward, left, turn) in m and rad since the frame before as the observer measured it, and
        ``odometry_covariances`` [T, 3, 3]; ``odometry_measured`` [T] marks where.
    poses : [T, 3] the true poses; ``pose_known`` [T] marks where truth was measured.
    positions : [T, K, 2] the true positions in m; ``position_known`` [T, K].
    relative : [T, K, 2] the same from the camera, (right, forward) in m; ``relative_known`` [T, K].
    heights : [K] true heights in m; ``height_known`` [K].
    persons : [T, K] number of the person behind the track, `NOBODY` where there is none: a track may change hands.
    scored_poses, scored_positions : [T] and [T, K] what counts for a score under the protocol.
    """

    index: Array
    start: Array
    frames: Array
    tracks: Array
    boxes: Array
    seen: Array
    visible: Array
    sights: Array
    arrives: Array
    leaves: Array
    camera: Array
    told: Array
    given_poses: Array
    pose_given: Array
    given_positions: Array
    position_given: Array
    odometry: Array
    odometry_covariances: Array
    odometry_measured: Array
    poses: Array
    pose_known: Array
    positions: Array
    position_known: Array
    relative: Array
    relative_known: Array
    heights: Array
    height_known: Array
    persons: Array
    scored_poses: Array
    scored_positions: Array

    def map(self, change: Callable[[Array], Other]) -> "Sample[Other]":
        """The same with every array changed."""
        return Sample(**{name: change(values) for name, values in vars(self).items()})

    def to(self, *where: Any, **how: Any) -> "Sample[Any]":
        """The same on another device, as `torch.Tensor.to` has it."""
        return self.map(lambda values: values.to(*where, **how))  # type: ignore[attr-defined]

    def pin_memory(self) -> "Sample[Any]":
        """The same in page-locked memory; a `DataLoader` with ``pin_memory=True`` asks for it."""
        return self.map(lambda values: values.pin_memory())  # type: ignore[attr-defined]


_BEGINNINGS = {
    "": ("index", "start", "camera", "told"),
    "K": ("tracks", "heights", "height_known"),
    "TK": (
        *("boxes", "seen", "visible", "sights", "arrives", "leaves", "given_positions", "position_given"),
        *("positions", "position_known", "relative", "relative_known", "persons", "scored_positions"),
    ),
}
AXES = {
    field.name: next((axes for axes, names in _BEGINNINGS.items() if field.name in names), "T")
    for field in fields(Sample)
}
"""The axes of frames (T) and people (K) that each array begins with."""
PADDING = {"tracks": -1, "persons": NOBODY}
"""What stands in padding, where it is not 0 or False."""


@dataclass(frozen=True, kw_only=True)
class Known:
    """A sequence with all that is known of it; NaN where nothing is.

    Parameters
    ----------
    sequence, problem : what a solver sees, and is given.
    truth : poses, positions and heights.
    relative : [T, K, 2] true (right, forward) from the camera in m.
    persons : [T, K] the person behind each track, `NOBODY` where there is none.
    """

    sequence: Sequence
    problem: Problem
    truth: Truth
    relative: FloatArray
    persons: IntArray


def sample_of(
    known: Known, protocol: Protocol, window: slice | None = None, *, local: bool = False
) -> Sample[NDArray[Any]]:
    """What a network reads of a sequence, or of a window of its frames, as its own sequence.

    Parameters
    ----------
    protocol : what is given, and what counts for a score.
    window : the frames; ``None`` for all. People without a box in a window are removed.
    local : whether the world is turned and shifted so that the first pose given is (0, 0, 0).
    """
    whole = known.sequence
    part = slice(0, whole.frames) if window is None else window
    kept: BoolArray = np.asarray(whole.observed[part].any(axis=0) | (window is None))
    poses, positions = known.truth.poses[part], known.truth.positions[part][:, kept]
    heights = known.truth.heights[kept]
    given = _given(known, protocol, part, kept)
    seen = whole.observed[part][:, kept]
    scored = {"scored_poses": scored_frames(seen), "scored_positions": scored_positions(seen, given)}
    if local:
        poses, positions, given = _from_first_pose(poses, positions, given)
    odometry = given.odometry or Odometry.unmeasured(len(poses))
    camera, boxes = known.problem.camera, whole.observations[part][:, kept]
    sights = camera.unproject(boxes, np.full(seen.shape, known.problem.height_mean))
    return Sample(
        index=np.array(whole.index),
        start=np.array(part.start),
        frames=np.ones(len(poses), np.bool_),
        tracks=whole.tracks[kept],
        boxes=_filled(boxes),
        seen=seen,
        visible=_filled(whole.visible[part][:, kept]),
        sights=_filled(sights),
        **_comings_and_goings(whole.observed, part, kept),
        camera=camera_values(camera),
        told=np.array([getattr(known.problem, name) for name in TOLD_VALUES], np.float32),
        **_masked(("given_poses", "pose_given"), given.poses),
        **_masked(("given_positions", "position_given"), given.positions),
        **_masked(("odometry", "odometry_measured"), odometry.motions),
        odometry_covariances=_filled(odometry.covariances),
        **_masked(("poses", "pose_known"), poses),
        **_masked(("positions", "position_known"), positions),
        **_masked(("relative", "relative_known"), known.relative[part][:, kept]),
        heights=_filled(heights),
        height_known=~np.isnan(heights),
        persons=known.persons[part][:, kept],
        **scored,
    )


def camera_values(camera: Camera) -> NDArray[np.float32]:
    """[9] a camera in numbers: see `CAMERA_VALUES`."""
    ahead = camera.pixels(np.array([0.0, 0.0, 1.0]))
    tilt = getattr(camera, "pitch", 0.0), getattr(camera, "roll", 0.0)
    closed = camera.period is not None
    return np.array([*camera.picture_size, camera.focal, *ahead, camera.mount_height, *tilt, closed], np.float32)


def collate(samples: Several[Sample[NDArray[Any]]]) -> Sample[NDArray[Any]]:
    """A batch: frames and people are padded to the longest and fullest sample."""
    frames = max(len(sample.frames) for sample in samples)
    people = max(1, *(len(sample.tracks) for sample in samples))
    size, made = {"T": frames, "K": people}, dict[str, NDArray[Any]]()
    for name, axes in AXES.items():
        values = [getattr(sample, name) for sample in samples]
        shape = len(values), *(size[axis] for axis in axes), *values[0].shape[len(axes) :]
        made[name] = np.full(shape, PADDING.get(name, 0), values[0].dtype)
        for row, one in enumerate(values):
            filled: tuple[Any, ...] = (row, *map(slice, one.shape[: len(axes)]))
            made[name][filled] = one
    return Sample(**made)


def _given(known: Known, protocol: Protocol, part: slice, kept: BoolArray) -> Given:
    """What the protocol gives in these frames; a window that begins later is given what a separate sequence is."""
    stored = known.sequence.given.frames(part)
    if part.start:
        seen = known.sequence.observed[part]
        truth = Truth(poses=known.truth.poses[part], positions=known.truth.positions[part], heights=known.truth.heights)
        fresh = arrivals_given(truth, seen & ~np.isnan(truth.positions[..., 0]))
        stored = Given(poses=fresh.poses, positions=fresh.positions, odometry=stored.odometry)
    given = protocol.select_given(stored)
    return Given(poses=given.poses, positions=given.positions[:, kept], odometry=given.odometry)


def _from_first_pose(poses: FloatArray, positions: FloatArray, given: Given) -> tuple[FloatArray, FloatArray, Given]:
    """The same in a world that begins at the first pose given; as they are where none is."""
    first = given.poses[0]
    if np.isnan(first).any():
        return poses, positions, given
    x, y, yaw = World(x=first[0], y=first[1], yaw=first[2]).poses_in_scene(np.zeros(3))
    back = World(x=x, y=y, yaw=yaw)
    moved = Given(poses=back.poses(given.poses), positions=back.positions(given.positions), odometry=given.odometry)
    return back.poses(poses), back.positions(positions), moved


def _comings_and_goings(observed: BoolArray, part: slice, kept: BoolArray) -> dict[str, BoolArray]:
    """``arrives`` and ``leaves`` of the kept people, as seen in the whole sequence."""
    frame = np.arange(len(observed))[part, None]
    seen = observed[:, kept]
    first, last = seen.argmax(axis=0), len(seen) - 1 - seen[::-1].argmax(axis=0)
    there = seen.any(axis=0)
    return {"arrives": (frame == first) & there, "leaves": (frame == last) & there}


def _masked(names: tuple[str, str], values: FloatArray) -> dict[str, NDArray[Any]]:
    """Values [..., N] with 0 where any of the N is NaN, and where they are known [...], under these names."""
    known: BoolArray = np.asarray(~np.isnan(values).any(axis=-1))
    return {names[0]: np.where(known[..., None], values, 0.0).astype(np.float32), names[1]: known}


def _filled(values: FloatArray) -> NDArray[np.float32]:
    return np.nan_to_num(values, nan=0.0).astype(np.float32)
