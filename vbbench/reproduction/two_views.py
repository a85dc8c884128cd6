"""Static points seen by two cameras, and the pose of the second: drawn at random, found by OpenCV and by least squares.

Coordinates are those of the first camera, (right, down, forward) in m. The second stands at the centre c and is turned
by R: a point x of the first is R(x − c) for the second. The length of c is not observable from pixels.

OpenCV's answer is the five-point method of Nistér (2004) within RANSAC: the essential matrix of the best sample of five
points, which no other point corrects. The best that the same pixels allow is least squares over all points. With
E = R[c]ₓ, F = K⁻ᵀEK⁻¹ and pixels p, q of a point in both pictures, Sampson's distance
qᵀFp / √((Fp)₁² + (Fp)₂² + (Fᵀq)₁² + (Fᵀq)₂²) is, to first order, how far the four coordinates of the pair must be moved
to meet: minimising its squares is bundle adjustment with the points eliminated.
"""

from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple, cast

import numpy as np
from scipy.spatial.transform import Rotation

from vbbench.camera import PerspectiveCamera, make_camera
from vbbench.errors import VbbenchError, needs_extra
from vbbench.geometry import BoolArray, FloatArray
from vbbench.paper import the_paper

Counted = Literal["redrawn", "seen", "in front", "all"]
"""Which points count: until so many are seen by both cameras; those of so many that are; those in front of both, inside
their pictures or not; all, mirrored where they are behind a camera."""
MOST_ROUNDS = 2000
"""After so many draws for a point without one that is seen, there is none."""
FEWEST = 5
STEPS = 60
"""Of Levenberg and Marquardt; most trials have converged after ten."""
_UNKNOWN, _DIFFERENCE = 5, 1e-7
"""Three numbers of R and two of the direction of c."""


def pinhole(width: int, height: int, focal: float) -> PerspectiveCamera:
    """A camera whose axis meets the middle of its picture, sizes and focal length in px.

    Raises
    ------
    VbbenchError
        If a value lies outside its range.
    """
    centred = {"cx": width / 2, "cy": height / 2}
    return cast(PerspectiveCamera, make_camera("perspective", width=width, height=height, focal=focal, **centred))


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What is drawn. The numbers are the paper's; what else a reading of its text must fix comes first.

    Parameters
    ----------
    camera : both cameras.
    voxel : sides in m to the right, down and forward; the paper does not state which of its lengths is which.
    from_centre : whether the distance is that of the voxel's centre instead of its near side.
    counted : which points count.
    at_bound : whether every motion is as large as its bounds; otherwise uniform up to them.
    in_space : whether the camera turns and moves in any direction; otherwise on the ground plane, as people do.
    points : of a trial.
    rotation, translation : bounds in rad and m.
    noise : on every coordinate of a projection, uniform up to ± so many px.
    """

    camera: PerspectiveCamera = field(default_factory=PerspectiveCamera)
    voxel: tuple[float, float, float] = (20.0, 5.0, 10.0)
    from_centre: bool = False
    counted: Counted = "redrawn"
    at_bound: bool = False
    in_space: bool = False
    points: int = the_paper().keypoints.points
    rotation: float = the_paper().keypoints.rotation
    translation: float = the_paper().keypoints.translation
    noise: float = the_paper().keypoints.noise


class Poses(NamedTuple):
    """Poses of the second cameras of N trials: R [N, 3, 3], and directions of c [N, 3], 0 without an answer."""

    rotation: FloatArray
    direction: FloatArray

    def where(self, chosen: BoolArray, other: "Poses") -> "Poses":
        """These poses where ``chosen`` [N], and the other ones elsewhere."""
        return Poses(
            np.where(chosen[:, None, None], self.rotation, other.rotation),
            np.where(chosen[:, None], self.direction, other.direction),
        )

    def moved(self, steps: FloatArray) -> "Poses":
        """Poses turned by steps [N, 5]: three of the rotation, two of the direction."""
        helper = np.eye(3)[np.argmin(np.abs(self.direction), axis=-1)]
        one = np.cross(self.direction, helper)
        one /= np.maximum(np.linalg.norm(one, axis=-1, keepdims=True), 1e-12)
        tangents = np.stack([one, np.cross(self.direction, one)], axis=-1)
        direction = self.direction + np.einsum("nij,nj->ni", tangents, steps[:, 3:])
        return Poses(
            self.rotation @ Rotation.from_rotvec(steps[:, :3]).as_matrix(),
            direction / np.maximum(np.linalg.norm(direction, axis=-1, keepdims=True), 1e-12),
        )


@dataclass(frozen=True, kw_only=True)
class Views:
    """N trials at one distance.

    Parameters
    ----------
    camera : both cameras.
    rotation : [N, 3, 3] R of the second camera.
    centre : [N, 3] c of the second camera, in m.
    first, second : [N, P, 2] projections in px; NaN = the point does not count.
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

    @property
    def truth(self) -> Poses:
        """The true poses."""
        return Poses(self.rotation, self.centre / np.maximum(self.lengths, 1e-12)[:, None])

    def translation_errors(self, poses: Poses, lengths: FloatArray) -> FloatArray:
        """[N] in m, where translations are taken to have these lengths [N]."""
        return np.asarray(np.linalg.norm(lengths[:, None] * poses.direction - self.centre, axis=-1))

    def rotation_errors(self, poses: Poses) -> FloatArray:
        """[N] angles in rad between estimated and true rotations."""
        between = poses.rotation @ self.rotation.transpose(0, 2, 1)
        twist = np.stack([between[:, i, j] - between[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=-1)
        return np.asarray(np.arctan2(np.linalg.norm(twist, axis=-1), np.trace(between, axis1=1, axis2=2) - 1.0))


def draw_views(setting: Setting, distance: float, trials: int, seed: int) -> Views:
    """Draw trials at a distance in m. Points and motions do not depend on the noise.

    Raises
    ------
    VbbenchError
        If the cameras do not see the voxel.
    """
    random = np.random.default_rng([seed, round(1000.0 * distance)])
    rotation, centre = _motions(setting, trials, random)
    first, second = np.full((2, trials, setting.points, 2), np.nan)
    missing = np.ones((trials, setting.points), bool)
    forward = distance + (0.0 if setting.from_centre else 0.5 * setting.voxel[2])
    for _ in range(1 if setting.counted == "seen" else MOST_ROUNDS):
        trial, point = np.nonzero(missing)
        places = np.array([0.0, 0.0, forward]) + random.uniform(-0.5, 0.5, (len(trial), 3)) * setting.voxel
        turned = np.einsum("nij,nj->ni", rotation[trial], places - centre[trial])
        both = np.stack([places, turned])
        seen = both @ setting.camera.intrinsics.T
        projected = seen[..., :2] / seen[..., 2:]  # mirrored for a point behind the camera
        counts = _counts(setting, both, projected)
        kept = trial[counts], point[counts]
        first[kept], second[kept] = projected[:, counts]
        missing[kept] = False
        if not missing.any():
            break
    if missing.any() and setting.counted != "seen":
        raise VbbenchError(f"the camera does not see the voxel at {distance:g} m; give one with a wider field of view")
    noise = setting.noise * random.uniform(-1.0, 1.0, (2, *first.shape))
    first, second = first + noise[0], second + noise[1]
    return Views(camera=setting.camera, rotation=rotation, centre=centre, first=first, second=second)


def _motions(setting: Setting, trials: int, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Rotations [N, 3, 3] and centres [N, 3] of the second camera."""
    share = np.ones((2, trials)) if setting.at_bound else random.uniform(0.0, 1.0, (2, trials))
    axis, direction = random.normal(size=(2, trials, 3))
    if not setting.in_space:
        axis[:, ::2] = 0.0
        direction[:, 1] = 0.0
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    rotation = Rotation.from_rotvec(axis * (setting.rotation * share[0])[:, None]).as_matrix()
    return rotation, direction * (setting.translation * share[1])[:, None]


def _counts(setting: Setting, points: FloatArray, projected: FloatArray) -> BoolArray:
    """[M] which points count, by coordinates [2, M, 3] for both cameras, and pixels [2, M, 2]."""
    in_front = points[..., 2] > 0.0
    if setting.counted == "all":
        in_front = np.ones_like(in_front)
    elif setting.counted != "in front":
        in_front &= np.all((projected >= 0.0) & (projected < setting.camera.picture_size), axis=-1)
    return np.asarray(in_front.all(axis=0))


class Method(NamedTuple):
    """How OpenCV is called; the defaults are its own.

    ``sampling`` is the flag of the consensus that chooses a sample, ``threshold`` the largest distance in px of a point
    that agrees from its epipolar line. Points count in the choice among the four poses of a matrix up to ``reach``
    lengths of the translation.
    """

    sampling: Literal["RANSAC", "LMEDS", "USAC_MAGSAC"] = "RANSAC"
    threshold: float = 1.0
    reach: float = 50.0


OPENCVS, ANY_DISTANCE = Method(), Method(reach=1e9)


def check_opencv() -> None:
    """Raise MissingExtraError if OpenCV is not installed."""
    with needs_extra("render", "the five-point method"):
        import cv2  # noqa: F401


def five_point(views: Views, method: Method, seed: int) -> Poses:
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
    camera, flag = views.camera.intrinsics, getattr(cv2, method.sampling)
    for trial, (first, second) in enumerate(zip(views.first, views.second, strict=True)):
        known = ~np.isnan(first[:, 0])
        if known.sum() < FEWEST:
            continue
        pair = first[known], second[known]
        matrix, agree = cv2.findEssentialMat(*pair, camera, flag, 0.999, method.threshold)
        if matrix is None:
            continue
        # A sample may have several matrices, one below the other.
        found = cv2.recoverPose(matrix[:3], *pair, camera, distanceThresh=method.reach, mask=agree)
        rotation[trial], direction[trial] = found[1], -(found[1].T @ found[2])[:, 0]
    return Poses(rotation, direction)


def refined(views: Views, start: Poses) -> Poses:
    """Poses of least squares for all trials at once, found from ``start`` by Levenberg and Marquardt's method."""
    best, damping = start, np.full(len(views.centre), 1e-3)
    residuals = sampson(views, best)
    for _ in range(STEPS):
        jacobian = _jacobian(views, best)
        normal = jacobian.transpose(0, 2, 1) @ jacobian
        diagonal = np.einsum("nii->ni", normal) * damping[:, None] + 1e-12
        gradient = np.einsum("npi,np->ni", jacobian, residuals)
        steps = -np.linalg.solve(normal + diagonal[:, :, None] * np.eye(_UNKNOWN), gradient[..., None])[..., 0]
        tried = best.moved(steps)
        new = sampson(views, tried)
        better = np.sum(new**2, axis=-1) < np.sum(residuals**2, axis=-1)
        best = tried.where(better, best)
        residuals = np.where(better[:, None], new, residuals)
        damping = np.where(better, 0.1 * damping, np.minimum(10.0 * damping, 1e6))
    return best


def better_fit(views: Views, one: Poses, other: Poses) -> Poses:
    """Whichever of two poses of every trial fits the points better: far away there are several minima."""
    return one.where(np.sum(sampson(views, one) ** 2, axis=-1) < np.sum(sampson(views, other) ** 2, axis=-1), other)


def bound(setting: Setting, distance: float, trials: int, seed: int) -> float:
    """RMS over trials of the Cramér–Rao bound of the error of translation in m, where its length is given.

    The uniform noise counts as normal noise of the same variance.
    """
    clean = draw_views(replace(setting, noise=0.0), distance, trials, seed)
    jacobian = _jacobian(clean, clean.truth)
    covariance = setting.noise**2 / 3.0 * np.linalg.inv(jacobian.transpose(0, 2, 1) @ jacobian)
    own = clean.lengths * np.sqrt(np.einsum("nii->n", covariance[:, 3:, 3:]))
    return float(np.sqrt(np.mean(own**2)))


def sampson(views: Views, poses: Poses) -> FloatArray:
    """[N, P] Sampson's distances in px; 0 for points that do not count."""
    inverse = np.linalg.inv(views.camera.intrinsics)
    x, y, z = poses.direction.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)
    matrix = inverse.T @ poses.rotation @ cross @ inverse
    first, second = (
        np.concatenate([seen, np.ones_like(seen[..., :1])], axis=-1) for seen in (views.first, views.second)
    )
    lines, back = first @ matrix.transpose(0, 2, 1), second @ matrix
    square = np.sum(lines[..., :2] ** 2 + back[..., :2] ** 2, axis=-1)
    return np.asarray(np.nan_to_num(np.sum(second * lines, axis=-1) / np.sqrt(np.maximum(square, 1e-30))))


def _jacobian(views: Views, poses: Poses) -> FloatArray:
    """[N, P, 5] derivatives of Sampson's distances, from differences."""
    columns, here = [], sampson(views, poses)
    for unknown in range(_UNKNOWN):
        step = np.zeros((len(poses.direction), _UNKNOWN))
        step[:, unknown] = _DIFFERENCE
        columns.append((sampson(views, poses.moved(step)) - here) / _DIFFERENCE)
    return np.stack(columns, axis=-1)
