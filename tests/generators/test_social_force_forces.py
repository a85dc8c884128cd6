"""Forces of the crowd engine against the formulas as one would write them down, in NumPy."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench_generators._core import row_forces
from vbbench_generators.social_force import Model, Moussaid, WallForce, model_numbers

NO_WALLS = np.empty((0, 4))


def people(count: int, seed: int, half: float | None = None) -> FloatArray:
    """[7, K] rows: place, velocity, direction to the goal and distance from it."""
    rng = np.random.default_rng(seed)
    half = 8.0 * np.sqrt(count / 50) if half is None else half
    angle = rng.uniform(-np.pi, np.pi, count)
    ahead = np.stack((np.cos(angle), np.sin(angle)))
    places, velocities = rng.uniform(-half, half, (2, count)), ahead * rng.uniform(0.0, 1.7, count)
    return np.concatenate((places, velocities, ahead, np.full((1, count), 9.0)))


def two(r: FloatArray, u: FloatArray) -> FloatArray:
    """[7, 2] rows of two people of whom the first stands at r [2] from the second, who walks with u [2] relative to it.

    The first stands still, and the second's goal lies where it walks to.
    """
    rows = np.zeros((7, 2))
    rows[:2, 0], rows[2:4, 1], rows[4:6, 1] = r, u, u / max(float(np.linalg.norm(u)), 1e-300)
    return rows


def of_pairs(r: FloatArray, u: FloatArray, model: Model) -> FloatArray:
    """Force [N, 2] on the first of each of the pairs of `two`."""
    numbers = model_numbers(model)
    forces = [row_forces(two(*each), NO_WALLS, numbers)[:, 0] for each in zip(r, u, strict=True)]
    return np.reshape(forces, (-1, 2))


def of_wall(place: tuple[float, float], wall: FloatArray, model: Model) -> FloatArray:
    """Force [2] of a wall [4] on somebody who stands still."""
    rows = np.zeros((7, 1))
    rows[:2, 0] = place
    return row_forces(rows, wall[None], model_numbers(model))[:, 0]


def moussaid_exactly(r: FloatArray, u: FloatArray) -> FloatArray:
    """Force on i, [N, 2], of places r of i less j and velocities u of j less i, [N, 2]; Moussaïd et al., eqs. 4-6."""
    d = np.linalg.norm(r, axis=1)
    e = r / d[:, None]
    D = 2.0 * u + e
    B = 0.35 * np.linalg.norm(D, axis=1)
    t = D / np.linalg.norm(D, axis=1)[:, None]
    theta = np.arctan2(t[:, 1], t[:, 0]) - np.arctan2(e[:, 1], e[:, 0])
    theta -= 2 * np.pi * np.round(theta / (2 * np.pi))
    ahead, aside = np.exp(-d / B - (3 * B * theta) ** 2), -np.sign(theta) * np.exp(-d / B - (2 * B * theta) ** 2)
    left = np.stack((-t[:, 1], t[:, 0]), axis=1)
    return 5.1 * (ahead[:, None] * t + aside[:, None] * left)


@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
def test_pairs_of_moussaid_are_the_formula(size: float) -> None:
    rng = np.random.default_rng(1)
    r, u = rng.normal(0.0, size, (5000, 2)), rng.normal(0.0, 1.0, (5000, 2))
    np.testing.assert_allclose(of_pairs(r, u, Model()), moussaid_exactly(r, u), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("count", [1, 2, 5, 50, 130])
def test_everybody_feels_the_sum_of_all_pairs(count: int) -> None:
    rows = people(count, count)
    forces = row_forces(rows, NO_WALLS, model_numbers(Model()))
    i, j = np.nonzero(~np.eye(count, dtype=bool))
    exact = np.zeros((count, 2))
    np.add.at(exact, i, moussaid_exactly((rows[:2, i] - rows[:2, j]).T, (rows[2:4, j] - rows[2:4, i]).T))
    np.testing.assert_allclose(forces.T, exact, rtol=0.0, atol=1e-8)


@settings(max_examples=200, deadline=None)
@given(values=st.tuples(*[st.floats(-20, 20)] * 4))
def test_action_is_reaction_to_the_bit(values: tuple[float, float, float, float]) -> None:
    forces = row_forces(two(np.array(values[:2]), np.array(values[2:])), NO_WALLS, model_numbers(Model()))
    np.testing.assert_array_equal(forces[:, 0], -forces[:, 1])
    assert np.all(np.isfinite(forces))


def test_people_who_stand_in_one_place_feel_nothing_and_no_nan() -> None:
    assert np.all(row_forces(np.zeros((7, 2)), NO_WALLS, model_numbers(Model())) == 0.0)


@settings(max_examples=100, deadline=None)
@given(place=st.tuples(st.floats(-6, 6), st.floats(-6, 6)), wall=st.tuples(*[st.floats(-9, 9)] * 4))
def test_walls_are_the_sum_of_their_points(place: tuple[float, float], wall: tuple[float, ...]) -> None:
    start, end = np.array(wall).reshape(2, 2)
    points = np.linspace(start, end, max(int(np.linalg.norm(end - start) * 10), 2))
    away = np.array(place) - points
    distance = np.linalg.norm(away, axis=1)
    assume(distance.min() > 1e-6)
    felt = distance - 0.35 < 3.35
    exact = (away / distance[:, None] * np.exp(-(distance - 0.35) / 0.2)[:, None])[felt].sum(axis=0) * 10.0
    got = of_wall(place, np.array(wall), Model(walls=WallForce()))
    np.testing.assert_allclose(got, exact, rtol=1e-9, atol=1e-5)


def test_parameters_reach_the_forces() -> None:
    one, three = (
        row_forces(people(2, 0, 1.0), NO_WALLS, model_numbers(Model(repulsion=Moussaid(factor=factor))))
        for factor in (1.0, 3.0)
    )
    np.testing.assert_allclose(three, 3.0 * one, rtol=1e-12)


@pytest.mark.parametrize(
    ("people", "walls", "numbers", "problem"),
    [
        (np.zeros((7, 2), np.float32), NO_WALLS, {}, "people must be an array of float64 in C order"),
        (np.zeros((6, 2)), NO_WALLS, {}, r"people must have the shape \[7, any\], not \[6, 2\]"),
        (np.zeros((7, 2)), np.zeros((1, 3)), {}, r"walls must have the shape \[any, 4\]"),
        (None, NO_WALLS, {}, "people must be an array"),
        (np.zeros((7, 2)), NO_WALLS, {"reach": np.nan}, "reach must be a finite number"),
    ],
)
def test_what_is_no_crowd_is_refused(people: FloatArray, walls: FloatArray, numbers: object, problem: str) -> None:
    with pytest.raises(VbbenchError, match=problem):
        row_forces(people, walls, {**model_numbers(Model()), **numbers})  # type: ignore[dict-item]
