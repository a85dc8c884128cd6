"""Arrays, and ground-plane geometry: the pose (x, y, yaw) and the camera's ground frame (right, forward).

World frame: z up, metres, radians; yaw counter-clockwise from world +x, the direction the camera looks.
world = pose.xy + forward·(cos yaw, sin yaw) + right·(sin yaw, −cos yaw)   (DESIGN section 2);
the paper's θ_z (arXiv 2111.05060, eq. 2) is π/2 − yaw.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def frozen_array(
    name: str, values: ArrayLike, shape: tuple[int | None, ...], dtype: type[Any] = np.float64
) -> NDArray[Any]:
    """``values`` as a read-only array; ValueError unless it has this ``shape``, in which ``None`` is any length."""
    array = np.asarray(values, dtype=dtype).view()
    fits = array.ndim == len(shape)
    for want, got in zip(shape, array.shape, strict=False):
        fits = fits and want in (None, got)
    if not fits:
        wanted = ", ".join("*" if n is None else str(n) for n in shape)
        raise ValueError(f"{name} must have shape [{wanted}], not {list(array.shape)}")
    array.flags.writeable = False
    return array


def freeze(owner: Any, dtype: type[Any] = np.float64, **shapes: tuple[int | None, ...]) -> None:
    """Make the named fields of a frozen dataclass read-only arrays of these shapes, as `frozen_array` does."""
    for name, shape in shapes.items():
        object.__setattr__(owner, name, frozen_array(name, getattr(owner, name), shape, dtype))


def runs_of_true(mask: BoolArray) -> IntArray:
    """[R, 2] the runs first ≤ t < last of consecutive frames in which ``mask`` [T] is set."""
    edges = np.diff(np.concatenate([[False], mask, [False]]))
    return np.flatnonzero(edges).reshape(-1, 2)


def wrap_angle(angle: FloatArray | float) -> FloatArray:
    """Angle in rad, any shape, wrapped to [−π, π); what is below −π by less than rounding comes out as π."""
    return np.mod(np.asarray(angle) + np.pi, 2.0 * np.pi) - np.pi


def shorter_way(apart: FloatArray, period: float | None) -> FloatArray:
    """Differences of columns [...] in px, the shorter way round in a picture ``period`` px around; ``None``: as is."""
    return apart if period is None else apart - period * np.round(apart / period)


def relative_to_world(relative: FloatArray, poses: FloatArray) -> FloatArray:
    """Ground-frame offsets to world positions.

    Parameters
    ----------
    relative : [..., K, 2] (right, forward) in m.
    poses : [..., 3] (x, y, yaw) in m and rad, one for each row of K people.

    Returns
    -------
    [..., K, 2] world positions in m.
    """
    right, forward = relative[..., 0], relative[..., 1]
    sin, cos = np.sin(poses[..., 2, None]), np.cos(poses[..., 2, None])
    x = poses[..., 0, None] + forward * cos + right * sin
    y = poses[..., 1, None] + forward * sin - right * cos
    return np.stack([x, y], axis=-1)


def world_to_relative(positions: FloatArray, poses: FloatArray) -> FloatArray:
    """World positions [..., K, 2] in m to ground-frame offsets (right, forward), the inverse of the above."""
    dx = positions[..., 0] - poses[..., 0, None]
    dy = positions[..., 1] - poses[..., 1, None]
    sin, cos = np.sin(poses[..., 2, None]), np.cos(poses[..., 2, None])
    relative = np.empty((*dx.shape, 2))
    np.subtract(dx * sin, dy * cos, out=relative[..., 0])
    np.add(dx * cos, dy * sin, out=relative[..., 1])
    return relative


def motion_between(before: FloatArray, after: FloatArray) -> FloatArray:
    """[..., 3] (forward, left, turn) from poses [..., 3] to later ones, in the former's axes; turns are not wrapped."""
    place = world_to_relative(after[..., None, :2], before)[..., 0, :]
    return np.stack([place[..., 1], -place[..., 0], after[..., 2] - before[..., 2]], axis=-1)


def motion_levers(axes: NDArray[np.complex128], rest: NDArray[np.complex128]) -> FloatArray:
    """[N, 3, 3] by which errors (forward, left, turn) of motions count where a way of several of them ends.

    Parameters
    ----------
    axes : [N] direction of the axes in which each motion is given, as exp(i · angle).
    rest : [N] the way that is left after each, in m, forward + i · left.
    """
    levers = np.zeros((len(axes), 3, 3))
    levers[:, 0, 0], levers[:, 0, 1], levers[:, 0, 2] = axes.real, -axes.imag, -rest.imag
    levers[:, 1, 0], levers[:, 1, 1], levers[:, 1, 2] = axes.imag, axes.real, rest.real
    levers[:, 2, 2] = 1.0
    return levers


def moved_as_one(poses: FloatArray, old: FloatArray, new: FloatArray) -> FloatArray:
    """[..., T, 3] a way of ``poses`` [T, 3] moved as a whole, so that a pose ``old`` [..., 3] becomes ``new``."""
    turn, apart = new[..., 2:] - old[..., 2:], poses[:, :2] - old[..., None, :2]
    cos, sin, dx, dy = np.cos(turn), np.sin(turn), apart[..., 0], apart[..., 1]
    x = new[..., 0:1] + cos * dx - sin * dy
    y = new[..., 1:2] + sin * dx + cos * dy
    return np.stack([x, y, wrap_angle(poses[:, 2] + turn)], axis=-1)


def place_levers(places: FloatArray, start: FloatArray) -> FloatArray:
    """∂place/∂pose [..., 2, 3] of places [..., 2] that are carried along by the pose ``start`` [≥ 2]."""
    levers = np.zeros((*places.shape[:-1], 2, 3))
    levers[..., 0, 0] = levers[..., 1, 1] = 1.0
    levers[..., 0, 2], levers[..., 1, 2] = start[1] - places[..., 1], places[..., 0] - start[0]
    return levers


def pose_levers(poses: FloatArray, start: FloatArray) -> FloatArray:
    """∂pose/∂pose [..., 3, 3] of poses [..., ≥ 2] that are carried along by the pose ``start`` [≥ 2]."""
    levers = np.zeros((*poses.shape[:-1], 3, 3))
    levers[..., :2, :] = place_levers(poses[..., :2], start)
    levers[..., 2, 2] = 1.0
    return levers


def covariance_along(levers: FloatArray, covariance: FloatArray) -> FloatArray:
    """[..., m, m] of what moves by the ``levers`` [..., m, n] with something of this ``covariance`` [n, n]."""
    return np.asarray(levers @ covariance @ np.swapaxes(levers, -1, -2))
