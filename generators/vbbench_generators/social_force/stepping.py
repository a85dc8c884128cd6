"""One step of a crowd: goals, forces, and the semi-implicit integration v += F·Δt, x += v·Δt."""

import math

from vbbench.geometry import FloatArray, IntArray
from vbbench.kernels import kernel
from vbbench_generators.social_force.groups import group_forces
from vbbench_generators.social_force.helbing_molnar import helbing_molnar_rows
from vbbench_generators.social_force.layout import (
    HELBING_MOLNAR,
    PYSOCIALFORCE,
    TARGET_DISTANCE,
    TARGET_X,
    TARGET_Y,
    VX,
    VY,
    X,
    Y,
)
from vbbench_generators.social_force.model import STOP_RADIUS
from vbbench_generators.social_force.moussaid import moussaid_rows
from vbbench_generators.social_force.strict import strict_rows
from vbbench_generators.social_force.walls import sampled_wall, wall_potential

BRAKE_RADIUS = 0.2
"""Within so many metres of the goal a person brakes, as in pysocialforce."""


@kernel
def aim(people: FloatArray, goals: FloatArray, current: IntArray, arrival_radius: float) -> None:
    """Turn those who have arrived to their next goal and write the way to it into ``people``.

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
def add_group_forces(
    people: FloatArray, members: IntArray, groups: IntArray, numbers: FloatArray, forces: FloatArray
) -> None:
    """Add the forces within groups; ``groups`` holds where each one starts in ``members``, and where the last ends."""
    strict = numbers[0].kind == PYSOCIALFORCE
    for g in range(len(groups) - 1):
        group_forces(people, members[groups[g] : groups[g + 1]], numbers, strict, forces)


@kernel
def move(people: FloatArray, speeds: FloatArray, numbers: FloatArray, forces: FloatArray, step: float) -> None:
    """Add the wish to walk to the goal to ``forces`` and take a step of ``step`` s.

    The desired force is (speed · e − v)/τ, −v/τ at the goal; the speed is capped; whoever has arrived stands still.
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
