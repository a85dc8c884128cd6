"""Forces within groups, as pysocialforce has them (coherence and gaze in its "alternative" form)."""

import math

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_generators.crowds.social_force.basics import PYSOCIALFORCE, TARGET_DISTANCE, TARGET_X, TARGET_Y, X, Y


@kernel
def add_group_forces(
    people: FloatArray, members: IntArray, groups: IntArray, numbers: FloatArray, forces: FloatArray
) -> None:
    """Add the forces (m/s²) within groups; ``groups`` holds where each one starts in ``members``, and the last ends."""
    settings = numbers[0]
    strict = settings.kind == PYSOCIALFORCE
    for g in range(len(groups) - 1):
        group, size, x, y = members[groups[g] : groups[g + 1]], groups[g + 1] - groups[g], 0.0, 0.0
        if size < 2:
            continue
        for i in group:
            x += people[X, i]
            y += people[Y, i]
        for i in group:
            _cohere(people, i, x / size, y / size, (size - 1) / 2.0, settings.cohesion, strict, forces)
            _gaze(people, i, x, y, size, settings.gaze, strict, forces)
            for j in group:  # pushed away by as much as the two are apart
                dx, dy = people[X, i] - people[X, j], people[Y, i] - people[Y, j]
                if math.sqrt(dx * dx + dy * dy) <= settings.personal_space:
                    forces[0, i] += settings.separation * dx
                    forces[1, i] += settings.separation * dy


@kernel
def _cohere(
    people: FloatArray, i: int, x: float, y: float, radius: float, factor: float, strict: bool, forces: FloatArray
) -> None:
    """Pull towards the centre x, y, softly switched on where it is further off than ``radius``.

    ``strict``: the library reads this distance from columns that are not there, and gets 0.
    """
    dx, dy = x - people[X, i], y - people[Y, i]
    distance = 0.0 if strict else math.sqrt(dx * dx + dy * dy)
    pull = factor * 0.5 * (math.tanh(distance - radius) + 1.0)
    forces[0, i] += pull * dx
    forces[1, i] += pull * dy


@kernel
def _gaze(
    people: FloatArray, i: int, x: float, y: float, size: int, factor: float, strict: bool, forces: FloatArray
) -> None:
    """Push along the way to the goal as far as the others' centre lies ahead, relative to the goal's distance.

    x, y are sums over the group. The goal counts as 0.5 m away where it is nearer, unless ``strict``.
    """
    dx = (x - people[X, i]) / (size - 1) - people[X, i]
    dy = (y - people[Y, i]) / (size - 1) - people[Y, i]
    distance = people[TARGET_DISTANCE, i]
    distance = distance if strict else max(distance, 0.5)
    if distance > 0.0:
        push = factor * (dx * people[TARGET_X, i] + dy * people[TARGET_Y, i]) / distance
        forces[0, i] += push * people[TARGET_X, i]
        forces[1, i] += push * people[TARGET_Y, i]
