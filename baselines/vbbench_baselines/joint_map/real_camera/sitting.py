"""Newcomers who may sit: a descent that begins with all people standing hardly finds them.

Somebody short whose box is taken for one of a person who stands is put too far away, and feet that then end too low are
outliers, which pull little. So a descent is also begun with them short and near.
"""

import numpy as np

from vbbench.geometry import BoolArray
from vbbench_baselines.joint_map.real_camera.cues import HEIGHT, PITCH, ROLL
from vbbench_baselines.joint_map.real_camera.gaps import fill
from vbbench_baselines.joint_map.real_camera.heights import SHORTER, is_short
from vbbench_baselines.joint_map.real_camera.joint import Point, Seen
from vbbench_baselines.joint_map.real_camera.newest import Start

TRIED = (1, 2, 4, 8)
"""After so many boxes of somebody it is tried."""


def seated(point: Point, seen: Seen, mean: float) -> list[Start]:
    """A start with those short whom the newest boxes show shorter than people of the ``mean`` ln height; or none."""
    short = _may_sit(point, seen, mean)
    if not short.any() or seen.fixed[-1]:
        return []
    places, people = point.places.copy(), point.people.copy()
    people[short, 0] = mean + SHORTER
    places[:, short] = np.nan
    fill(places, point.frames, seen, people)
    return [Start(point._replace(places=places, people=people, variances=point.variances.copy()))]


def _may_sit(point: Point, seen: Seen, mean: float) -> BoolArray:
    """[K] who is taken to stand, though feet and height of the newest box are nearer to somebody short."""
    boxes, frame = seen.boxes, point.frames[-1]
    azimuth, whole = boxes.azimuth[-1], boxes.cut[-1] == 0
    level = boxes.foot[-1] - frame[PITCH] * np.cos(azimuth) - frame[ROLL] * np.sin(azimuth)
    with np.errstate(invalid="ignore", divide="ignore"):
        shown = np.log(boxes.length[-1] * frame[HEIGHT] / level)
    tried = np.isin((~np.isnan(boxes.azimuth)).sum(axis=0), TRIED)
    return np.asarray(tried & whole & is_short(shown, mean) & ~is_short(point.people[:, 0], mean))
