"""Crowds step by step: goals, forces, and the semi-implicit integration v += F·Δt, x += v·Δt.

Scenes are walked side by side, or one large crowd at a time with the work of each step shared out.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel, parallel_kernel
from vbbench_generators.crowds.social_force.basics import (
    HELBING_MOLNAR,
    PAIRS,
    PEOPLE_ROWS,
    PYSOCIALFORCE,
    TARGET_DISTANCE,
    TARGET_X,
    TARGET_Y,
    VX,
    VY,
    X,
    Y,
)
from vbbench_generators.crowds.social_force.groups import add_group_forces
from vbbench_generators.crowds.social_force.helbing_molnar import helbing_molnar_rows
from vbbench_generators.crowds.social_force.model import STOP_RADIUS
from vbbench_generators.crowds.social_force.moussaid import moussaid_rows, strict_rows
from vbbench_generators.crowds.social_force.walls import sampled_wall, wall_potential

BRAKE_RADIUS = 0.2
"""Distance in m from the goal at which a person brakes, as in pysocialforce."""
BLOCKS = 16
"""Parts into which the people of a large crowd fall; fixed, so that sums do not depend on the number of threads."""


class Crowds(NamedTuple):
    """Crowds laid end to end, and all that moves them.

    Parameters
    ----------
    scenes : [S, 6] for each scene where its people, goals and groups start and end in the arrays below.
    states : [4, N] x, y, vx, vy of everybody in m and m/s.
    speeds : [N] desired speeds in m/s.
    goals : [P, 2] in m, of one person after the other.
    members, groups : indices, within their scene, of people in groups, and where each group starts among them.
    walls : [M, 4] segments x0, y0, x1, y1 in m.
    numbers : [1] record of `SETTINGS`.
    dt : seconds per frame, in ``substeps`` steps.
    """

    scenes: IntArray
    states: FloatArray
    speeds: FloatArray
    goals: FloatArray
    members: IntArray
    groups: IntArray
    walls: FloatArray
    numbers: NDArray[Any]
    dt: float
    substeps: int


@kernel
def aim(people: FloatArray, goals: FloatArray, current: IntArray, arrival_radius: float) -> None:
    """Turn people who have arrived to their next goal and write the way to it into ``people``.

    ``goals`` [K, G, 2] in m; ``current`` [K] which goal each person heads for, changed in place.
    """
    last = goals.shape[1] - 1
    for k in range(people.shape[1]):
        while True:
            dx = goals[k, current[k], 0] - people[X, k]
            dy = goals[k, current[k], 1] - people[Y, k]
            distance = math.sqrt(dx * dx + dy * dy)
            if distance > arrival_radius or current[k] == last:
                break
            current[k] += 1
        people[TARGET_DISTANCE, k] = distance
        people[TARGET_X, k] = dx / distance if distance > 0.0 else 0.0
        people[TARGET_Y, k] = dy / distance if distance > 0.0 else 0.0


@kernel
def add_row_forces(
    people: FloatArray,
    first: int,
    stride: int,
    walls: FloatArray,
    numbers: FloatArray,
    pairs: FloatArray,
    partners: IntArray,
    forces: FloatArray,
) -> None:
    """Add repulsion and walls for the people first, first + stride, ... to ``forces`` [2, K] in m/s²."""
    settings = numbers[0]
    if settings.kind == HELBING_MOLNAR:
        helbing_molnar_rows(people, first, stride, numbers, pairs, partners, forces)
    elif settings.kind == PYSOCIALFORCE:
        strict_rows(people, first, stride, numbers, forces)
    else:
        moussaid_rows(people, first, stride, numbers, pairs, forces)
    for k in range(first, people.shape[1], stride):
        for wall in range(len(walls)):
            x, y = people[X, k], people[Y, k]
            if settings.kind == HELBING_MOLNAR:
                fx, fy = wall_potential(x, y, walls[wall], settings.wall_factor, settings.wall_fall_off)
            else:
                fx, fy = sampled_wall(x, y, walls[wall], numbers, settings.kind == PYSOCIALFORCE, pairs)
            forces[0, k] += fx
            forces[1, k] += fy


@kernel
def move(people: FloatArray, speeds: FloatArray, numbers: FloatArray, forces: FloatArray, step: float) -> None:
    """Add the wish to walk to the goal to ``forces`` and take a step of ``step`` s.

    The desired force is (speed · e − v)/τ, −v/τ at the goal; the speed is capped; people who have arrived stand still.
    """
    settings = numbers[0]
    for k in range(people.shape[1]):
        distance = people[TARGET_DISTANCE, k]
        wish = speeds[k] * settings.desired_factor if distance > BRAKE_RADIUS else 0.0
        ax = (wish * people[TARGET_X, k] - people[VX, k]) / settings.relaxation_time + forces[0, k]
        ay = (wish * people[TARGET_Y, k] - people[VY, k]) / settings.relaxation_time + forces[1, k]
        vx, vy = people[VX, k] + step * ax, people[VY, k] + step * ay
        speed, top = math.sqrt(vx * vx + vy * vy), speeds[k] * settings.top_speed
        share = min(1.0, top / speed) if speed > 0.0 else 0.0
        share = 0.0 if distance < STOP_RADIUS else share
        people[VX, k], people[VY, k] = share * vx, share * vy
        people[X, k] += people[VX, k] * step
        people[Y, k] += people[VY, k] * step


@kernel
def march_scene(scene: IntArray, crowds: Crowds, paths: FloatArray) -> None:
    """Walk one scene and write ``paths`` [T, K, 2] in m."""
    walls, numbers, count = crowds.walls, crowds.numbers, scene[1] - scene[0]
    people, own_goals, current = _start(scene, crowds)
    pairs, partners = np.empty((4, max(PAIRS, count))), np.empty((2, max(PAIRS, count)), np.int64)
    forces = np.empty((2, count))
    first, stride = int(np.int64(0)), int(np.int64(1))  # for constants numba would compile everything anew
    speeds, groups = crowds.speeds[scene[0] : scene[1]], crowds.groups[scene[4] : scene[5] + 1]
    _record(people, paths[0])
    for frame in range(1, len(paths)):
        for _ in range(crowds.substeps):
            aim(people, own_goals, current, numbers[0].arrival_radius)
            forces[:] = 0.0
            add_row_forces(people, first, stride, walls, numbers, pairs, partners, forces)
            add_group_forces(people, crowds.members, groups, numbers, forces)
            move(people, speeds, numbers, forces, crowds.dt / crowds.substeps)
        _record(people, paths[frame])


@kernel
def _start(scene: IntArray, crowds: Crowds) -> tuple[FloatArray, FloatArray, IntArray]:
    """Rows of the people of a scene, their goals [K, G, 2] in m, and which of these each person heads for."""
    count = scene[1] - scene[0]
    people = np.zeros((PEOPLE_ROWS, count))
    people[: len(crowds.states)] = crowds.states[:, scene[0] : scene[1]]
    goals = crowds.goals[scene[2] : scene[3]].reshape((count, (scene[3] - scene[2]) // count, 2))
    return people, goals, np.zeros(count, np.int64)


@kernel
def _record(people: FloatArray, places: FloatArray) -> None:
    """Write everybody's place into ``places`` [K, 2]."""
    places[:, 0], places[:, 1] = people[X], people[Y]


@kernel
def march(crowds: Crowds, paths: FloatArray) -> None:
    """Walk scenes one after the other, and fill ``paths`` [T, N, 2] in m."""
    for s in range(len(crowds.scenes)):
        scene = crowds.scenes[s]
        march_scene(scene, crowds, paths[:, scene[0] : scene[1]])


@parallel_kernel
def march_side_by_side(crowds: Crowds, paths: FloatArray) -> None:
    """`march` with scenes spread over threads."""
    for s in prange(len(crowds.scenes)):
        scene = crowds.scenes[s]
        march_scene(scene, crowds, paths[:, scene[0] : scene[1]])


@parallel_kernel
def march_large(crowds: Crowds, paths: FloatArray) -> None:
    """`march` for a large crowd: blocks of people are spread over threads and summed in the order of blocks."""
    scene, walls, numbers = crowds.scenes[0], crowds.walls, crowds.numbers
    people, own_goals, current = _start(scene, crowds)
    count, stride = people.shape[1], int(np.int64(BLOCKS))  # a constant would compile all forces again
    pairs = np.empty((BLOCKS, 4, max(PAIRS, count)))
    partners = np.empty((BLOCKS, 2, max(PAIRS, count)), np.int64)
    forces = np.empty((BLOCKS, 2, count))
    speeds, groups = crowds.speeds[scene[0] : scene[1]], crowds.groups[scene[4] : scene[5] + 1]
    _record(people, paths[0])
    for frame in range(1, len(paths)):
        for _ in range(crowds.substeps):
            aim(people, own_goals, current, numbers[0].arrival_radius)
            for block in prange(BLOCKS):
                first = int(np.int64(block))  # numba counts in uint64 here
                forces[block] = 0.0
                add_row_forces(people, first, stride, walls, numbers, pairs[block], partners[block], forces[block])
            _gather_blocks(forces)
            add_group_forces(people, crowds.members, groups, numbers, forces[0])
            move(people, speeds, numbers, forces[0], crowds.dt / crowds.substeps)
        _record(people, paths[frame])


@kernel
def _gather_blocks(forces: FloatArray) -> None:
    """Add the forces [B, 2, K] of all blocks to those of the first, in order."""
    for block in range(1, len(forces)):
        forces[0] += forces[block]
