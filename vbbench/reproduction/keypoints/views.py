"""Static points in a voxel, seen by two cameras: what is drawn at random, and what pixels it gives.

Coordinates are those of the first camera, (right, down, forward) in m. The second stands at the centre c and is turned
by R: a point x of the first is R(x − c) for the second.
"""

from dataclasses import dataclass, field, replace
from typing import Literal, cast

import numpy as np
from scipy.spatial.transform import Rotation

from vbbench.camera import PerspectiveCamera, make_camera
from vbbench.errors import VbbenchError
from vbbench.geometry import BoolArray, FloatArray
from vbbench.paper import the_paper

Counted = Literal["redrawn", "seen", "in front", "all"]
"""Which points count: until so many are seen by both cameras; those of so many that are; those in front of both, inside
their pictures or not; all, mirrored where they are behind a camera."""
MOST_ROUNDS = 2000
"""After so many draws for a point without one that is seen, there is none."""


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
    """What is drawn. The numbers are the paper's; what else a reading of its text must say comes first.

    Parameters
    ----------
    camera : both cameras.
    voxel : sides in m to the right, down and forward; the paper does not say which of its lengths is which.
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

    @property
    def without_noise(self) -> "Setting":
        """The same points and motions, exactly seen."""
        return replace(self, noise=0.0)


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
        """[N] how far apart the cameras are, in m."""
        return np.asarray(np.linalg.norm(self.centre, axis=-1))

    @property
    def directions(self) -> FloatArray:
        """[N, 3] from the first camera to the second."""
        return self.centre / np.maximum(self.lengths, 1e-12)[:, None]


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
    for _ in range(1 if setting.counted == "seen" else MOST_ROUNDS):
        trial, point = np.nonzero(missing)
        places = _places(setting, distance, len(trial), random)
        turned = np.einsum("nij,nj->ni", rotation[trial], places - centre[trial])
        projected = _projected(setting.camera, np.stack([places, turned]))
        counts = _counts(setting, np.stack([places, turned]), projected)
        kept = trial[counts], point[counts]
        first[kept], second[kept] = projected[:, counts]
        missing[kept] = False
        if not missing.any():
            break
    if missing.any() and setting.counted != "seen":
        raise VbbenchError(f"the camera does not see the voxel at {distance:g} m; give one with a wider field of view")
    noise = setting.noise * random.uniform(-1.0, 1.0, (2, *first.shape))
    return Views(
        camera=setting.camera, rotation=rotation, centre=centre, first=first + noise[0], second=second + noise[1]
    )


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


def _places(setting: Setting, distance: float, count: int, random: np.random.Generator) -> FloatArray:
    """[M, 3] points in the voxel."""
    forward = distance + (0.0 if setting.from_centre else 0.5 * setting.voxel[2])
    return np.array([0.0, 0.0, forward]) + random.uniform(-0.5, 0.5, (count, 3)) * setting.voxel


def _projected(camera: PerspectiveCamera, points: FloatArray) -> FloatArray:
    """[..., 2] pixels of points [..., 3] of a camera, mirrored where they are behind it."""
    seen = points @ camera.intrinsics.T
    return np.asarray(seen[..., :2] / seen[..., 2:])


def _counts(setting: Setting, points: FloatArray, projected: FloatArray) -> BoolArray:
    """[M] which points count, from what [2, M, 3] they are for both cameras, and their pixels [2, M, 2]."""
    in_front = points[..., 2] > 0.0
    if setting.counted == "all":
        in_front = np.ones_like(in_front)
    elif setting.counted != "in front":
        in_front &= np.all((projected >= 0.0) & (projected < setting.camera.picture_size), axis=-1)
    return np.asarray(in_front.all(axis=0))
