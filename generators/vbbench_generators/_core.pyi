"""The extension module: sources in ``generators/cpp``, built by ``CMakeLists.txt``.

Arrays are in C order, of float64, int64 where they count, and bool where they mark. Anything else is a `VbbenchError`.
"""

from vbbench.geometry import FloatArray, IntArray

def available_threads() -> int:
    """How many threads this process may run at the same time."""

def march(
    *,
    scenes: IntArray,
    states: FloatArray,
    speeds: FloatArray,
    goals: FloatArray,
    members: IntArray,
    groups: IntArray,
    walls: FloatArray,
    numbers: dict[str, float],
    dt: float,
    substeps: int,
    paths: FloatArray,
    threads: int,
    large: bool,
) -> None:
    """Walk crowds by the social force, and write ``paths``.

    Parameters
    ----------
    scenes : [S, 6] for each scene where its people, goals and groups start and end in the arrays below.
    states : [4, N] x, y, vx, vy of everybody in m and m/s.
    speeds : [N] desired speeds in m/s.
    goals : [P, 2] in m, of one person after the other.
    members, groups : indices, within their scene, of people in groups, and where each group starts among them.
    walls : [M, 4] segments x0, y0, x1, y1 in m.
    numbers : of the model, see `vbbench_generators.crowds.social_force.engine.NUMBERS`.
    dt : seconds per frame, in ``substeps`` steps.
    paths : [T, N, 2] in m.
    threads : of which each walks a scene; where scenes are ``large``, they share the people of one.
    """

def row_forces(people: FloatArray, walls: FloatArray, numbers: dict[str, float]) -> FloatArray:
    """Forces [2, K] in m/s² of others and of walls.

    Parameters
    ----------
    people : [7, K] place (m), velocity (m/s), unit vector to the current goal, and distance (m) from it.
    walls, numbers : as of `march`.
    """
