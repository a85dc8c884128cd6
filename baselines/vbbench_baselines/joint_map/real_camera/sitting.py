"""Newcomers who may sit: a descent that begins with all people standing hardly finds them.

Somebody short whose box is taken for one of a person who stands is put too far away, and feet that then end too low are
outliers, which pull little. So a descent is also begun with them short and near.
"""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench_baselines.joint_map.real_camera.cues import HEIGHT, PITCH, ROLL
from vbbench_baselines.joint_map.real_camera.gaps import fill
from vbbench_baselines.joint_map.real_camera.heights import SHORTER, is_short
from vbbench_baselines.joint_map.real_camera.joint import Point, Seen
from vbbench_baselines.joint_map.real_camera.newest import Start
from vbbench_baselines.joint_map.real_camera.past import known_before

TRIED = (1, 2, 4, 8)
"""After so many boxes of somebody it is tried."""


def seated(point: Point, seen: Seen, mean: float) -> list[Start]:
    """A start with those short whom the newest boxes show shorter than people of the ``mean`` ln height; or none."""
    boxes = (~np.isnan(seen.boxes.azimuth)).sum(axis=0)
    tried = np.flatnonzero(~known_before(seen.past) & np.isin(boxes, TRIED) & (seen.boxes.cut[-1] == 0))
    if len(tried) == 0 or seen.fixed[-1]:
        return []
    short = tried[is_short(_shown(point, seen, tried), mean) & ~is_short(point.people[tried, 0], mean)]
    if len(short) == 0:
        return []
    places, people = point.places.copy(), point.people.copy()
    people[short, 0] = mean + SHORTER
    places[:, short] = np.nan
    fill(places, point.frames, seen, people)
    return [Start(point._replace(places=places, people=people, variances=point.variances.copy()))]


def _shown(point: Point, seen: Seen, people: IntArray) -> FloatArray:
    """Heights, as ln, of ``people`` [M] by feet and size of their newest boxes; NaN where there is none."""
    boxes, frame = seen.boxes, point.frames[-1]
    azimuth = boxes.azimuth[-1, people]
    foot = boxes.foot[-1, people] - frame[PITCH] * np.cos(azimuth) - frame[ROLL] * np.sin(azimuth)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.log(boxes.length[-1, people] * frame[HEIGHT] / foot))
