"""Static points seen by two cameras, and the pose of the second: drawn at random, found by the five-point method.

Coordinates are those of the first camera, (right, down, forward) in m. The second stands at the centre c and is turned
by R: a point x of the first is R(x − c) for the second. The length of c is not observable from pixels.

OpenCV's answer is the five-point method of Nistér (2004) within RANSAC: the essential matrix of the best sample of five
points, which no other point corrects.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from vbbench.camera import PerspectiveCamera
from vbbench.errors import VbbenchError, needs_extra
from vbbench.geometry import BoolArray, FloatArray
from vbbench.paper import the_paper

MOST_ROUNDS = 2000
"""After so many draws for a point without one that is seen, there is none."""
FEWEST = 5


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What is drawn. The numbers are the paper's; what else a reading of its text must fix comes first.

    Parameters
    ----------
    camera : both cameras.
    voxel : sides in m to the right, down and forward; the paper does not state which of its lengths is which.
    points : of a trial.
    rotation, translation : bounds in rad and m.
    noise : on every coordinate of a projection, uniform up to ± so many px.
    """

    camera: PerspectiveCamera = field(default_factory=PerspectiveCamera)
    voxel: tuple[float, float, float] = (20.0, 5.0, 10.0)
    points: int = the_paper().keypoints.points
    rotation: float = the_paper().keypoints.rotation
    translation: float = the_paper().keypoints.translation
    noise: float = the_paper().keypoints.noise


class Poses(NamedTuple):
    """Poses of the second cameras of N trials: R [N, 3, 3], and directions of c [N, 3], 0 without an answer."""

    rotation: FloatArray
    direction: FloatArray


@dataclass(frozen=True, kw_only=True)
class Views:
    """N trials at one distance.

    Parameters
    ----------
    camera : both cameras.
    rotation : [N, 3, 3] R of the second camera.
    centre : [N, 3] c of the second camera, in m.
    first, second : [N, P, 2] projections in px.
    """

    camera: PerspectiveCamera
    rotation: FloatArray
    centre: FloatArray
    first: FloatArray
    second: FloatArray

    @property
    def lengths(self) -> FloatArray:
        """[N] distance between the cameras, in m."""
        return np.asarray(np.linalg.norm(self.centre, axis=-1))

    def translation_errors(self, poses: Poses) -> FloatArray:
        """[N] in m, where translations are as long as they truly are."""
        return np.asarray(np.linalg.norm(self.lengths[:, None] * poses.direction - self.centre, axis=-1))

    def rotation_errors(self, poses: Poses) -> FloatArray:
        """[N] angles in rad between estimated and true rotations."""
        between = poses.rotation @ self.rotation.transpose(0, 2, 1)
        twist = np.stack([between[:, i, j] - between[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=-1)
        return np.asarray(np.arctan2(np.linalg.norm(twist, axis=-1), np.trace(between, axis1=1, axis2=2) - 1.0))


def draw_views(setting: Setting, distance: float, trials: int, seed: int) -> Views:
    """Draw trials whose voxel begins at a distance in m: points until so many are seen by both cameras.

    Points and motions do not depend on the noise.

    Raises
    ------
    VbbenchError
        If the cameras do not see the voxel.
    """
    random = np.random.default_rng([seed, round(1000.0 * distance)])
    rotation, centre = _motions(setting, trials, random)
    first, second = np.full((2, trials, setting.points, 2), np.nan)
    missing = np.ones((trials, setting.points), bool)
    middle = np.array([0.0, 0.0, distance + 0.5 * setting.voxel[2]])
    for _ in range(MOST_ROUNDS):
        trial, point = np.nonzero(missing)
        places = middle + random.uniform(-0.5, 0.5, (len(trial), 3)) * setting.voxel
        turned = np.einsum("nij,nj->ni", rotation[trial], places - centre[trial])
        both = np.stack([places, turned])
        seen = both @ setting.camera.intrinsics.T
        projected = seen[..., :2] / seen[..., 2:]
        counts = _both_see(setting.camera, both, projected)
        kept = trial[counts], point[counts]
        first[kept], second[kept] = projected[:, counts]
        missing[kept] = False
        if not missing.any():
            break
    else:
        raise VbbenchError(f"the camera does not see the voxel at {distance:g} m; give one with a wider field of view")
    noise = setting.noise * random.uniform(-1.0, 1.0, (2, *first.shape))
    first, second = first + noise[0], second + noise[1]
    return Views(camera=setting.camera, rotation=rotation, centre=centre, first=first, second=second)


def _motions(setting: Setting, trials: int, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Rotations [N, 3, 3] and centres [N, 3] of the second camera, which moves on the ground plane, as people do."""
    share = random.uniform(0.0, 1.0, (2, trials))
    axis, direction = random.normal(size=(2, trials, 3))
    axis[:, ::2] = 0.0
    direction[:, 1] = 0.0
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    rotation = Rotation.from_rotvec(axis * (setting.rotation * share[0])[:, None]).as_matrix()
    return rotation, direction * (setting.translation * share[1])[:, None]


def _both_see(camera: PerspectiveCamera, points: FloatArray, projected: FloatArray) -> BoolArray:
    """[M] which points both cameras see, by coordinates [2, M, 3] for both cameras, and pixels [2, M, 2]."""
    inside = np.all((projected >= 0.0) & (projected < camera.picture_size), axis=-1)
    return np.asarray((inside & (points[..., 2] > 0.0)).all(axis=0))


def check_opencv() -> None:
    """Raise MissingExtraError if OpenCV is not installed."""
    with needs_extra("render", "the five-point method"):
        import cv2  # noqa: F401


def five_point(views: Views, seed: int) -> Poses:
    """The pose of every trial; without an answer, one that has not moved.

    Raises
    ------
    MissingExtraError
        If OpenCV is not installed.
    """
    with needs_extra("render", "the five-point method"):
        import cv2
    cv2.setRNGSeed(seed % 2**31)
    trials = len(views.centre)
    rotation, direction = np.tile(np.eye(3), (trials, 1, 1)), np.zeros((trials, 3))
    camera = views.camera.intrinsics
    for trial, pair in enumerate(zip(views.first, views.second, strict=True)):
        if len(pair[0]) < FEWEST:
            continue
        matrix, agree = cv2.findEssentialMat(*pair, camera)
        if matrix is None:
            continue
        # A sample may have several matrices, one below the other.
        found = cv2.recoverPose(matrix[:3], *pair, camera, mask=agree)
        rotation[trial], direction[trial] = found[1], -(found[1].T @ found[2])[:, 0]
    return Poses(rotation, direction)
