"""The best that the same pixels allow: least squares over all points, and its bound, for all trials at once.

With E = R[c]ₓ, F = K⁻ᵀEK⁻¹ and pixels p, q of a point in both pictures, Sampson's distance
qᵀFp / √((Fp)₁² + (Fp)₂² + (Fᵀq)₁² + (Fᵀq)₂²) is, to first order, how far the four coordinates of the pair must be moved
to meet: minimising its squares is bundle adjustment with the points eliminated. Five numbers are unknown, three of R
and two of the direction of c; its length is not in the pixels.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from vbbench.geometry import BoolArray, FloatArray
from vbbench.reproduction.keypoints.five_point import Poses
from vbbench.reproduction.keypoints.views import Views

STEPS = 60
"""Of Levenberg and Marquardt; most trials have converged after ten."""
_UNKNOWN, _DIFFERENCE = 5, 1e-7


def truth(views: Views) -> Poses:
    """The true poses."""
    return Poses(rotation=views.rotation, direction=views.directions)


def refined(views: Views, start: Poses) -> Poses:
    """Poses of least squares, found from ``start`` by Levenberg and Marquardt's method."""
    best, damping = start, np.full(len(views.centre), 1e-3)
    residuals = sampson(views, best)
    for _ in range(STEPS):
        jacobian = _jacobian(views, best)
        normal = jacobian.transpose(0, 2, 1) @ jacobian
        diagonal = np.einsum("nii->ni", normal) * damping[:, None] + 1e-12
        gradient = np.einsum("npi,np->ni", jacobian, residuals)
        steps = -np.linalg.solve(normal + diagonal[:, :, None] * np.eye(_UNKNOWN), gradient[..., None])[..., 0]
        tried = _moved(best, steps)
        new = sampson(views, tried)
        better = np.sum(new**2, axis=-1) < np.sum(residuals**2, axis=-1)
        best = _chosen(better, tried, best)
        residuals = np.where(better[:, None], new, residuals)
        damping = np.where(better, 0.1 * damping, np.minimum(10.0 * damping, 1e6))
    return best


def better_fit(views: Views, one: Poses, other: Poses) -> Poses:
    """Whichever of two poses of every trial fits the points better: far away there are several minima."""
    lower = np.sum(sampson(views, one) ** 2, axis=-1) < np.sum(sampson(views, other) ** 2, axis=-1)
    return _chosen(lower, one, other)


def bound(clean: Views, noise: float) -> FloatArray:
    """[N] Cramér–Rao bound of the RMS error of translation in m, where its length is known.

    Parameters
    ----------
    clean : the trials seen without noise.
    noise : bound in px of the uniform noise, which counts as normal noise of the same variance.
    """
    jacobian = _jacobian(clean, truth(clean))
    covariance = noise**2 / 3.0 * np.linalg.inv(jacobian.transpose(0, 2, 1) @ jacobian)
    return np.asarray(clean.lengths * np.sqrt(np.einsum("nii->n", covariance[:, 3:, 3:])))


def sampson(views: Views, poses: Poses) -> FloatArray:
    """[N, P] Sampson's distances in px; 0 for points that do not count."""
    inverse = np.linalg.inv(views.camera.intrinsics)
    matrix = inverse.T @ poses.rotation @ _cross(poses.direction) @ inverse
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
        columns.append((sampson(views, _moved(poses, step)) - here) / _DIFFERENCE)
    return np.stack(columns, axis=-1)


def _moved(poses: Poses, steps: FloatArray) -> Poses:
    """Poses turned by steps [N, 5]: three of the rotation, two of the direction."""
    direction = poses.direction + np.einsum("nij,nj->ni", _tangents(poses.direction), steps[:, 3:])
    return Poses(
        rotation=poses.rotation @ Rotation.from_rotvec(steps[:, :3]).as_matrix(),
        direction=direction / np.maximum(np.linalg.norm(direction, axis=-1, keepdims=True), 1e-12),
    )


def _chosen(first: BoolArray, one: Poses, other: Poses) -> Poses:
    """The one pose where ``first`` [N] says so, and the other elsewhere."""
    return Poses(
        rotation=np.where(first[:, None, None], one.rotation, other.rotation),
        direction=np.where(first[:, None], one.direction, other.direction),
    )


def _tangents(direction: FloatArray) -> FloatArray:
    """[N, 3, 2] two directions of length 1 across each, at a right angle."""
    helper = np.eye(3)[np.argmin(np.abs(direction), axis=-1)]
    one = np.cross(direction, helper)
    one /= np.maximum(np.linalg.norm(one, axis=-1, keepdims=True), 1e-12)
    return np.stack([one, np.cross(direction, one)], axis=-1)


def _cross(vectors: FloatArray) -> FloatArray:
    """[N, 3, 3] matrices [v]ₓ with [v]ₓ x = v × x."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(-1, 3, 3)
