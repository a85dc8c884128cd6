"""Forces of walls, which are line segments."""

import math

from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench_generators.crowds.social_force.basics import TINY, exp_negative

SAMPLES_PER_METRE = 10.0


@kernel
def sampled_wall(
    x: float, y: float, wall: FloatArray, numbers: FloatArray, strict: bool, pushes: FloatArray
) -> tuple[float, float]:
    """Force (m/s²) on a person at x, y (m) of one wall (x0, y0, x1, y1) as pysocialforce has it.

    ``int(10 · length)`` points evenly spread from end to end repel with exp(−(d − body radius)/fall-off) each. Walls
    too short for two points have two, at their ends; ``strict``: what the library gives them, one or none, and the
    exponential of the C library. ``pushes`` [≥ 2, N] is scratch.
    """
    settings = numbers[0]
    ax, ay = wall[2] - wall[0], wall[3] - wall[1]
    length = math.sqrt(ax * ax + ay * ay)
    count = int(length * SAMPLES_PER_METRE)
    count = count if strict else max(count, 2)
    step = 1.0 / max(count - 1, 1)
    from_x, from_y, dx, dy = x - wall[0], y - wall[1], pushes[0], pushes[1]
    first, last = _within_reach(from_x, from_y, ax, ay, length, settings.wall_reach + settings.body_radius)
    step_x, step_y, fx, fy = ax * step, ay * step, 0.0, 0.0
    start, end = max(int(first / step) - 1, 0), min(int(last / step) + 2, count)
    for k in range(start, end, pushes.shape[1]):
        filled = min(end - k, pushes.shape[1])
        for n in range(filled):
            dx[n] = from_x - (k + n) * step_x
            dy[n] = from_y - (k + n) * step_y
        if strict:
            _exact_pushes(filled, settings.body_radius, settings.wall_fall_off, settings.wall_reach, dx, dy)
        else:
            _pushes(filled, settings.body_radius, settings.wall_fall_off, settings.wall_reach, dx, dy)
        for n in range(filled):
            fx += dx[n]
            fy += dy[n]
    return settings.wall_factor * fx, settings.wall_factor * fy


@kernel
def _pushes(filled: int, radius: float, fall_off: float, reach: float, dx: FloatArray, dy: FloatArray) -> None:
    """Replace places by pushes, without branches."""
    for n in range(filled):
        distance = math.sqrt(dx[n] * dx[n] + dy[n] * dy[n])
        gap = distance - radius
        decay = exp_negative(-abs(gap) / fall_off)
        decay = decay if gap >= 0.0 else 1.0 / decay
        push = decay / (distance if distance > TINY else TINY)
        push = push if gap < reach else 0.0
        dx[n] *= push
        dy[n] *= push


@kernel
def _exact_pushes(filled: int, radius: float, fall_off: float, reach: float, dx: FloatArray, dy: FloatArray) -> None:
    """`_pushes` with the exponential of the C library."""
    for n in range(filled):
        distance = math.sqrt(dx[n] * dx[n] + dy[n] * dy[n])
        felt = distance > 0.0 and distance - radius < reach
        push = math.exp(-(distance - radius) / fall_off) / distance if felt else 0.0
        dx[n] *= push
        dy[n] *= push


@kernel
def _within_reach(x: float, y: float, ax: float, ay: float, length: float, reach: float) -> tuple[float, float]:
    """The part of a segment, as fractions of it, within ``reach`` of x, y as seen from its start; (1, −1) if none."""
    if length == 0.0:
        return 0.0, 1.0
    along, across = (x * ax + y * ay) / length, (x * ay - y * ax) / length
    squared = reach * reach - across * across
    if squared < 0.0:
        return 1.0, -1.0
    half = math.sqrt(squared)
    first, last = (along - half) / length, (along + half) / length
    return (max(first, 0.0), min(last, 1.0)) if first <= 1.0 and last >= 0.0 else (1.0, -1.0)


@kernel
def wall_potential(x: float, y: float, wall: FloatArray, strength: float, fall_off: float) -> tuple[float, float]:
    """Force (m/s²) of the nearest point of one wall (x0, y0, x1, y1): −∇ U0 exp(−d/R), Helbing & Molnár (1995)."""
    ax, ay = wall[2] - wall[0], wall[3] - wall[1]
    squared = ax * ax + ay * ay
    along = ((x - wall[0]) * ax + (y - wall[1]) * ay) / squared if squared > 0.0 else 0.0
    along = min(max(along, 0.0), 1.0)
    dx, dy = x - (wall[0] + along * ax), y - (wall[1] + along * ay)
    distance = math.sqrt(dx * dx + dy * dy)
    if distance == 0.0:
        return 0.0, 0.0
    push = strength / fall_off * math.exp(-distance / fall_off) / distance
    return push * dx, push * dy
