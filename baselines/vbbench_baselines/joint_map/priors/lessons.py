"""How firmly a fitted prior is to be believed of another recording: s_b and s_σ of `motion.learning`.

They are chosen by what they are for: as in one-step, the walks of a crowd are revealed frame by frame, and each next
place is predicted by what was learned so far. The density of the true places, in nats, is greatest with the right s_b
and s_σ. What is predicted is never what the prior was fitted on: another recording, or the other half of the only one.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench.scene import Scene
from vbbench_baselines.joint_map.motion.learning import Lessons, known_before, learn, nothing_learned, taught
from vbbench_baselines.joint_map.motion.walks import Walk, walk_of
from vbbench_baselines.joint_map.one_step import PAST, foresee
from vbbench_baselines.joint_map.prior import Prior

WINDOW = 16
"""Frames of a crowd that are revealed one by one; about those of a sequence."""
B_STDS = (0.03, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0)
SIGMA_PEOPLES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
"""The values that are tried, about half a decade apart: the densities are flat near the best."""


class Fold(NamedTuple):
    """A prior, and the scenes that it never saw."""

    prior: Prior
    scenes: Sequence[Scene]


def fit_lessons(folds: Sequence[Fold], prior: Prior) -> Prior:
    """``prior`` with the s_b and s_σ under which the folds are predicted best; each fold counts the same."""
    best = max(product(B_STDS, SIGMA_PEOPLES), key=lambda pair: sum(_score(fold, *pair) for fold in folds))
    return replace(prior, b_std=best[0], sigma_people=best[1])


def halves(scenes: Sequence[Scene]) -> tuple[list[Scene], list[Scene]]:
    """The first and the second half of the scenes, or of the frames of the only one."""
    if len(scenes) > 1:
        middle = len(scenes) // 2
        return [*scenes[:middle]], [*scenes[middle:]]
    middle = scenes[0].frames // 2
    return [_cut(scenes[0], slice(None, middle))], [_cut(scenes[0], slice(middle, None))]


def _cut(scene: Scene, frames: slice) -> Scene:
    positions = scene.positions[frames]
    here = ~np.isnan(positions[..., 0]).all(axis=0)
    return replace(scene, people=scene.people[here], positions=positions[:, here], heights=scene.heights[here])


def _score(fold: Fold, b_std: float, sigma_people: float) -> float:
    """Mean log density of a place, in nats."""
    prior = replace(fold.prior, b_std=b_std, sigma_people=sigma_people)
    told = np.zeros(2)
    for scene in fold.scenes:
        walk = walk_of(prior, scene.dt)
        for first in range(0, scene.frames, WINDOW):
            places = scene.positions[first : first + WINDOW]
            places = np.ascontiguousarray(places[:, ~np.isnan(places[..., 0]).all(axis=0)])
            told += _predict(places, walk, nothing_learned(places.shape[1], walk, prior))
    return float(told[0] / told[1])


@kernel
def _predict(places: FloatArray, fitted: Walk, lessons: Lessons) -> FloatArray:
    """[2] the sum of the log densities of places [T, K, 2] given those before, and their number."""
    told, nobody = np.zeros(2), np.full((PAST, 3), np.nan)
    for t in range(2, len(places)):
        before = places[max(t - PAST, 0) : t]
        learn(before, nobody[: len(before)], fitted, lessons)
        walk = taught(fitted, lessons)
        for k in range(places.shape[1]):
            known = known_before(before[:, k])
            if known >= 2 and not np.isnan(places[t, k, 0]):
                x, y, std = foresee(before[:, k], walk, lessons.variances[k])
                squared = ((places[t, k, 0] - x) ** 2 + (places[t, k, 1] - y) ** 2) / (walk.nu * std**2)
                told[0] -= (0.5 * walk.nu + 1.0) * np.log(1.0 + squared) + 2.0 * np.log(std) + np.log(2.0 * np.pi)
                told[1] += 1.0
    return told
