"""What the paper leaves open about its figure: each other reading, changed alone, and those that come nearest."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from vbbench.reproduction.keypoints.five_point import ANY_DISTANCE, OPENCVS, Method
from vbbench.reproduction.keypoints.views import Setting, pinhole

DEEP, UPRIGHT = (10.0, 5.0, 20.0), (20.0, 10.0, 5.0)
"""Voxels with other sides to the right, down and forward, in m."""


@dataclass(frozen=True, kw_only=True)
class Reading:
    """One way to read the text.

    Parameters
    ----------
    name : what is otherwise than measured in the main.
    setting, method : what is drawn, and how it is solved.
    unit_length : whether every translation is said to be as long as its bound; otherwise as long as it truly is.
    """

    name: str
    setting: Setting
    method: Method = OPENCVS
    unit_length: bool = False


def all_readings(main: Setting) -> tuple[Reading, ...]:
    """The main reading, every other one with one thing changed, and three with several."""
    small = pinhole(320, 240, 160.0)
    settings: Mapping[str, Mapping[str, Any]] = {
        "camera 1920 × 1080, f 960 px (90°)": {"camera": pinhole(1920, 1080, 960.0)},
        "camera 640 × 480, f 500 px (65°)": {"camera": pinhole(640, 480, 500.0)},
        "camera 640 × 480, f 320 px (90°)": {"camera": pinhole(640, 480, 320.0)},
        "camera 320 × 240, f 160 px (90°)": {"camera": small},
        "voxel 20 m deep, 10 m wide, 5 m high": {"voxel": DEEP},
        "voxel 5 m deep, 20 m wide, 10 m high": {"voxel": UPRIGHT},
        "distance to the voxel's centre": {"from_centre": True},
        "only those of 100 points that both see": {"counted": "seen"},
        "points outside the picture count": {"counted": "in front"},
        "to the centre, points behind a camera count": {"from_centre": True, "counted": "all"},
        "turned by .20 rad, moved by 1.0 m": {"at_bound": True},
        "turned and moved in any direction": {"in_space": True},
    }
    methods = {
        "threshold 0.5 px": Method(threshold=0.5),
        "threshold 2 px": Method(threshold=2.0),
        "threshold 10⁶ px: the first sample": Method(threshold=1e6),
        "least median of squares": Method(sampling="LMEDS"),
        "MAGSAC++, refined": Method(sampling="USAC_MAGSAC"),
        "points count however far away": Method(reach=ANY_DISTANCE),
    }
    deep = replace(main, voxel=DEEP, at_bound=True)
    return (
        Reading(name="as in the figure", setting=main),
        *(Reading(name=name, setting=replace(main, **changes)) for name, changes in settings.items()),
        *(Reading(name=name, setting=main, method=method) for name, method in methods.items()),
        Reading(name="translation taken as 1.0 m long", setting=main, unit_length=True),
        Reading(name="20 m deep, moved by 1.0 m", setting=deep),
        Reading(name="that, 640 × 480, f 320 px", setting=replace(deep, camera=pinhole(640, 480, 320.0))),
        Reading(name="that, 320 × 240, f 160 px, any direction", setting=replace(deep, camera=small, in_space=True)),
    )
