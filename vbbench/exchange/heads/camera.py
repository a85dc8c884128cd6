"""The surveillance camera: a pinhole camera that looks down on a crowd from far above."""

import re
from dataclasses import dataclass

import numpy as np

from vbbench.errors import VbbenchError, quoted, user_mistakes
from vbbench.exchange.heads.settings import HeadOptions
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import check_ranges

HEAD_HEIGHT = 1.58
"""Height in m over the ground of the head's centre of somebody 1.70 m tall."""
FARTHEST = 10.0
"""Where a picture reaches the horizon, the ground counts as visible up to so many camera heights away."""


@dataclass(frozen=True, kw_only=True)
class SurveillanceCamera:
    """A pinhole with square pixels and the principal point in the middle of the picture.

    A point (right, forward, up) m as seen from the ground below the camera has Z = forward·cos θ + (H − up)·sin θ along
    the optical axis and Y = (H − up)·cos θ − forward·sin θ below it; its column is cx + f·right/Z, its row cy + f·Y/Z,
    both turned about the middle by the roll ρ: u − cx = f (right·cos ρ + Y·sin ρ)/Z and
    v − cy = f (Y·cos ρ − right·sin ρ)/Z.

    Parameters
    ----------
    width, height : of the picture in px.
    focal : f in px.
    mount_height : H in m.
    tilt : θ in rad, down from the horizon.
    roll : ρ in rad; the right of the picture goes up.
    """

    width: int
    height: int
    focal: float
    mount_height: float
    tilt: float
    roll: float = 0.0

    @property
    def middle(self) -> tuple[float, float]:
        """The principal point (cx, cy) in px."""
        return self.width / 2.0, self.height / 2.0

    @property
    def horizon(self) -> float:
        """Row in px of the horizon in the middle column: cy − f·tan θ/cos ρ."""
        return self.middle[1] - self.focal * float(np.tan(self.tilt) / np.cos(self.roll))

    def project(self, points: FloatArray) -> FloatArray:
        """Points [..., 3] (right, forward, up) m → [..., 3] (u px, v px, Z m); NaN behind the camera."""
        right, forward, drop = points[..., 0], points[..., 1], self.mount_height - points[..., 2]
        sin, cos = np.sin(self.tilt), np.cos(self.tilt)
        depth = forward * cos + drop * sin
        depth = np.where(depth > 0.0, depth, np.nan)
        across, down = self.focal * right / depth, self.focal * (drop * cos - forward * sin) / depth
        sin, cos = np.sin(self.roll), np.cos(self.roll)
        cx, cy = self.middle
        return np.stack([cx + cos * across + sin * down, cy + cos * down - sin * across, depth], axis=-1)

    def inside(self, places: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """[...] whether places [..., ≥ 2] (u, v) px lie in the picture."""
        u, v = places[..., 0], places[..., 1]
        return (u >= 0.0) & (u < self.width) & (v >= 0.0) & (v < self.height)

    def footprint(self, up: float = HEAD_HEIGHT) -> FloatArray:
        """Corners [4, 2] (right, forward) m of the picture, roll aside, on the plane ``up`` m over the ground.

        In the order near left, near right, far right, far left; the far end is cut at `FARTHEST` camera heights.
        """
        half, drop = np.arctan(self.height / 2.0 / self.focal), self.mount_height - up
        reach = FARTHEST * self.mount_height
        near, far = (
            drop / np.tan(angle) if np.tan(angle) > drop / reach else reach
            for angle in (self.tilt + half, self.tilt - half)
        )
        ends = np.array([near, near, far, far])
        depth = ends * np.cos(self.tilt) + drop * np.sin(self.tilt)
        side = np.array([-1.0, 1.0, 1.0, -1.0]) * depth * self.width / 2.0 / self.focal
        return np.stack([side, ends], axis=-1)

    def middle_of_view(self) -> float:
        """Distance in m from the camera forward to the centre of `footprint`."""
        (_, near), (wide_near, _), (wide_far, far), _ = self.footprint()
        return float(near + (far - near) * (wide_near + 2.0 * wide_far) / (3.0 * (wide_near + wide_far)))


def camera_of(options: HeadOptions) -> SurveillanceCamera:
    """The camera that the options describe.

    Raises
    ------
    VbbenchError
        If an option is out of range, or the camera would not see heads from above.
    """
    with user_mistakes():
        check_ranges(options)
    size = re.fullmatch(r"([0-9]{1,5})x([0-9]{1,5})", options.size)
    if size is None or min(int(size[1]), int(size[2])) < 1:
        raise VbbenchError(f"size must be width x height in px such as 1920x1080, not {quoted(options.size)}")
    if not options.camera_height > HEAD_HEIGHT + 1.0:
        problem = f"camera_height must be more than a metre above people's heads, not {options.camera_height:g}"
        raise VbbenchError(problem)
    for name, low, high in (("tilt", 0.0, 90.0), ("roll", -45.0, 45.0), ("fov", 0.0, 150.0)):
        if not low < (value := getattr(options, name)) < high:
            raise VbbenchError(f"{name} must be between {low:g} and {high:g} degrees, not {value:g}")
    width, height = int(size[1]), int(size[2])
    return SurveillanceCamera(
        width=width,
        height=height,
        focal=width / 2.0 / float(np.tan(np.radians(options.fov) / 2.0)),
        mount_height=options.camera_height,
        tilt=float(np.radians(options.tilt)),
        roll=float(np.radians(options.roll)),
    )
