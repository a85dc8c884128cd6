"""The camera above the heads, and the homography between its picture and the ground."""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, freeze
from vbbench_generators.lifting.heads import SizePlane


@dataclass(frozen=True, kw_only=True)
class GroundCamera:
    """A static camera with square pixels and its principal point in the picture's centre.

    Parameters
    ----------
    focal : focal length in px.
    tilt, roll : in rad; tilt downwards from level, roll as `heads.SizePlane.roll`.
    height : height of the camera above the ground, in m.
    heads_to_ground : homography [3, 3] from px about the picture's centre to m on the ground, of points at head height.
    """

    focal: float
    tilt: float
    roll: float
    height: float
    heads_to_ground: FloatArray

    def __post_init__(self) -> None:
        freeze(self, heads_to_ground=(3, 3))

    @property
    def horizon(self) -> float:
        """Where the horizon crosses the middle column: ν in px from the picture's centre, negative above it."""
        row: FloatArray = self.heads_to_ground[2]
        return float(-row[2] / row[1])

    def depth(self, x: FloatArray, nu: FloatArray) -> FloatArray:
        """[N] third homogeneous coordinate of points in px; its sign changes on the horizon."""
        row = self.heads_to_ground[2]
        depth: FloatArray = row[0] * x + row[1] * nu + row[2]
        return depth

    def to_ground(self, x: FloatArray, nu: FloatArray) -> FloatArray:
        """Head centres [N] in px from the picture's centre to positions [N, 2] in m."""
        ground: FloatArray = np.stack([x, nu, np.ones_like(x)], axis=1) @ self.heads_to_ground.T
        return ground[:, :2] / ground[:, 2:]

    def jacobian(self, x: FloatArray, nu: FloatArray) -> FloatArray:
        """Jacobian [N, 2, 2] of the ground position (X, Y) in m by the picture (u, v) in px."""
        matrix, depth, ground = self.heads_to_ground, self.depth(x, nu), self.to_ground(x, nu)
        return (matrix[:2, :2] - ground[:, :, None] * matrix[2, :2]) / depth[:, None, None]


def camera_of_plane(plane: SizePlane, focal: float, head_size: float, head_height: float) -> GroundCamera:
    """The camera in which heads of ``head_size`` m at ``head_height`` m have the sizes of ``plane``.

    X = D·x/ŝ and Y = g·D/ŝ − (H − h)·tan θ, seen from the camera's foot: X to the right, Y forward.
    """
    g = plane.stretch(focal)
    above = head_size * focal / (g * plane.slope)
    foot = head_size * plane.depth / (g * plane.slope)
    cos, sin = np.cos(plane.roll), np.sin(plane.roll)
    size = np.array([plane.c, plane.b, plane.a])
    across = head_size * np.array([cos, -sin, 0.0])
    forward = g * head_size * np.array([0.0, 0.0, 1.0]) - foot * size
    return GroundCamera(
        focal=focal,
        tilt=float(np.arctan2(plane.depth, focal)),
        roll=plane.roll,
        height=above + head_height,
        heads_to_ground=np.stack([across, forward, size]),
    )


def camera_of_homography(
    homography: FloatArray, centre: FloatArray, seen: FloatArray, head_height: float
) -> GroundCamera:
    """The camera whose picture ``homography`` [3, 3] maps to the ground, in m and in the frame of that homography.

    Its inverse is K·[r1 r2 t]: r1 and r2 are perpendicular and of one length, which gives the focal length (R. Hartley,
    A. Zisserman, Multiple View Geometry, 2004, sections 8.1 and 8.8). The heads' plane is ``head_height`` higher.

    Raises ValueError if no camera with square pixels and a centred principal point has this homography.

    Parameters
    ----------
    centre : [2] of the picture, in px.
    seen : [2] a point in px that shows some of the ground.
    """
    shift = np.array([[1.0, 0.0, -centre[0]], [0.0, 1.0, -centre[1]], [0.0, 0.0, 1.0]])
    columns = shift @ np.linalg.inv(homography)
    place = homography @ np.r_[seen, 1.0]
    columns *= np.sign(columns[2] @ place) * np.sign(place[2])
    focal = _focal(columns)
    view = np.diag([1.0 / focal, 1.0 / focal, 1.0]) @ columns
    view /= np.sqrt(np.linalg.norm(view[:, 0]) * np.linalg.norm(view[:, 1]))
    up = np.cross(view[:, 0], view[:, 1])
    height = -float(up @ view[:, 2])
    # A frame with its axes the other way round has the camera at a negative height: up is then down.
    raised = view.copy()
    raised[:, 2] += np.copysign(head_height, height) * up
    down = -np.copysign(1.0, height) * up
    return GroundCamera(
        focal=focal,
        tilt=float(np.arcsin(np.clip(down[2] / np.linalg.norm(down), -1.0, 1.0))),
        roll=float(np.arctan2(down[0], down[1])),
        height=abs(height),
        heads_to_ground=np.linalg.inv(np.diag([focal, focal, 1.0]) @ raised),
    )


def _focal(columns: FloatArray) -> float:
    """Focal length in px that makes two of the ``columns`` [3, 3] perpendicular and equally long, by least squares."""
    first, second = columns[:, 0], columns[:, 1]
    flat = np.array([first[:2] @ second[:2], first[:2] @ first[:2] - second[:2] @ second[:2]])
    deep = np.array([first[2] * second[2], first[2] ** 2 - second[2] ** 2])
    inverse = -float(flat @ deep) / max(float(flat @ flat), 1e-300)  # both are 0 where the camera looks straight down
    if not (np.isfinite(inverse) and inverse > 0.0):
        raise ValueError("no camera with square pixels and its principal point in the picture's centre has it")
    return float(1.0 / np.sqrt(inverse))
