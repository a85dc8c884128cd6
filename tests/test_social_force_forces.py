"""Forces of the crowd engine against the formulas as one would write them down, in NumPy."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from vbbench.geometry import FloatArray
from vbbench_generators.crowds.social_force.basics import atan_unit, exp_negative
from vbbench_generators.crowds.social_force.engine import model_numbers
from vbbench_generators.crowds.social_force.helbing_molnar import helbing_molnar_pairs, helbing_molnar_rows
from vbbench_generators.crowds.social_force.moussaid import moussaid_pairs, moussaid_rows
from vbbench_generators.crowds.social_force.walls import sampled_wall, wall_potential
from vbbench_generators.social_force import HelbingMolnar, Model, Moussaid, WallForce


def people(count: int, seed: int, half: float | None = None) -> FloatArray:
    """[7, K] rows as kernels see them: place, velocity, direction to the goal and distance from it."""
    rng = np.random.default_rng(seed)
    half = 8.0 * np.sqrt(count / 50) if half is None else half
    angle = rng.uniform(-np.pi, np.pi, count)
    ahead = np.stack((np.cos(angle), np.sin(angle)))
    places, velocities = rng.uniform(-half, half, (2, count)), ahead * rng.uniform(0.0, 1.7, count)
    return np.concatenate((places, velocities, ahead, np.full((1, count), 9.0)))


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


def test_the_exponential_and_the_arc_tangent_are_as_near_as_they_say() -> None:
    x, r = np.linspace(-60.0, 0.0, 200_001), np.linspace(0.0, 1.0, 200_001)
    assert max(abs(exp_negative(v) - w) for v, w in zip(x, np.exp(x), strict=True)) < 5e-13
    assert max(abs(atan_unit(v) - w) for v, w in zip(r, np.arctan(r), strict=True)) < 6e-12
    assert exp_negative(0.0) == 1.0


@pytest.mark.parametrize("size", [0.1, 1.0, 10.0])
def test_pairs_of_moussaid_are_the_formula(size: float) -> None:
    rng = np.random.default_rng(1)
    r, u = rng.normal(0.0, size, (5000, 2)), rng.normal(0.0, 1.0, (5000, 2))
    columns = [np.ascontiguousarray(values) for values in (*r.T, *u.T)]
    moussaid_pairs(len(r), 5.1, 2.0, 0.35, 2.0, 3.0, *columns)
    np.testing.assert_allclose(np.stack(columns[:2], axis=1), moussaid_exactly(r, u), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("count", [1, 2, 5, 50, 130])
def test_everybody_feels_the_sum_of_all_pairs(count: int) -> None:
    rows, forces = people(count, count), np.zeros((2, count))
    moussaid_rows(rows, 0, 1, model_numbers(Model()), np.empty((4, max(200, count))), forces)
    i, j = np.nonzero(~np.eye(count, dtype=bool))
    exact = np.zeros((count, 2))
    np.add.at(exact, i, moussaid_exactly((rows[:2, i] - rows[:2, j]).T, (rows[2:4, j] - rows[2:4, i]).T))
    np.testing.assert_allclose(forces.T, exact, rtol=0.0, atol=1e-8)


@settings(max_examples=200, deadline=None)
@given(values=st.tuples(*[st.floats(-20, 20)] * 4))
def test_action_is_reaction_to_the_bit(values: tuple[float, float, float, float]) -> None:
    columns = [np.array([value, -value]) for value in values]
    moussaid_pairs(2, 5.1, 2.0, 0.35, 2.0, 3.0, *columns)
    assert columns[0][0] == -columns[0][1]
    assert columns[1][0] == -columns[1][1]
    assert np.all(np.isfinite(columns[:2]))


def test_people_who_stand_in_one_place_feel_nothing_and_no_nan() -> None:
    for pairs in (
        lambda *c: moussaid_pairs(1, 5.1, 2.0, 0.35, 2.0, 3.0, *c),
        lambda *c: helbing_molnar_pairs(1, 2.1, 0.3, *c),
    ):
        columns = [np.zeros(1) for _ in range(4)]
        pairs(*columns)
        assert columns[0][0] == columns[1][0] == 0.0


def potential(r: FloatArray, s: FloatArray) -> FloatArray:
    """V0 exp(−b/σ) of r, s e [N, 2]; Helbing & Molnár (1995)."""
    both = np.linalg.norm(r, axis=1) + np.linalg.norm(r - s, axis=1)
    return 2.1 * np.exp(-np.sqrt(both**2 - np.sum(s * s, axis=1)) / 2.0 / 0.3)


def helbing_molnar_exactly(r: FloatArray, s: FloatArray) -> FloatArray:
    """−∇V [N, 2] by central differences."""
    h = 1e-6
    slopes = [(potential(r + a, s) - potential(r - a, s)) / (2 * h) for a in (np.array([h, 0.0]), np.array([0.0, h]))]
    return -np.stack(slopes, axis=1)


def test_pairs_of_helbing_and_molnar_are_the_slope_of_the_potential() -> None:
    rng = np.random.default_rng(2)
    r, s = rng.normal(0.0, 1.5, (5000, 2)), rng.normal(0.0, 1.0, (5000, 2))
    columns = [np.ascontiguousarray(values) for values in (*r.T, *s.T)]
    helbing_molnar_pairs(len(r), 2.1, 0.3, *columns)
    exact = helbing_molnar_exactly(r, s)
    clear = np.sum((r + 0) * (r - s), axis=1) > 1e-3
    np.testing.assert_allclose(np.stack(columns[:2], axis=1)[clear], exact[clear], rtol=1e-5, atol=1e-8)


@pytest.mark.parametrize("count", [1, 2, 50, 300])
def test_people_behind_count_less(count: int) -> None:
    rows, forces = people(count, count), np.zeros((2, count))
    size = max(500, count)
    scratch = np.empty((4, size)), np.empty((2, size), dtype=np.int64)
    helbing_molnar_rows(rows, 0, 1, model_numbers(Model(repulsion=HelbingMolnar())), *scratch, forces)
    i, j = np.nonzero(~np.eye(count, dtype=bool))
    s = 2.0 * np.linalg.norm(rows[2:4], axis=0) * rows[4:6]
    columns = [np.ascontiguousarray(values) for values in (*(rows[:2, i] - rows[:2, j]), *s[:, j])]
    helbing_molnar_pairs(len(i), 2.1, 0.3, *columns)
    force = np.stack(columns[:2], axis=1)
    seen = -np.sum(rows[4:6, i].T * force, axis=1) >= np.linalg.norm(force, axis=1) * np.cos(np.radians(100.0))
    exact = np.zeros((count, 2))
    np.add.at(exact, i, np.where(seen, 1.0, 0.5)[:, None] * force)
    np.testing.assert_allclose(forces.T, exact, rtol=0.0, atol=1e-8)


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
    got = sampled_wall(*place, np.array(wall), model_numbers(Model(walls=WallForce())), False, np.empty((4, 30)))
    np.testing.assert_allclose(got, exact, rtol=1e-9, atol=1e-5)


def test_the_wall_of_helbing_and_molnar_repels_from_its_nearest_point() -> None:
    wall = np.array([0.0, 0.0, 4.0, 0.0])
    assert wall_potential(1.0, 0.3, wall, 10.0, 0.2) == pytest.approx((0.0, 50.0 * np.exp(-1.5)))
    assert wall_potential(-0.3, 0.0, wall, 10.0, 0.2) == pytest.approx((-50.0 * np.exp(-1.5), 0.0))
    assert wall_potential(1.0, 0.0, wall, 10.0, 0.2) == (0.0, 0.0)


def test_parameters_reach_the_kernels() -> None:
    rows, forces = people(2, 0, 1.0), np.zeros((2, 2, 2))
    for n, factor in enumerate((1.0, 3.0)):
        numbers = model_numbers(Model(repulsion=Moussaid(factor=factor)))
        moussaid_rows(rows, 0, 1, numbers, np.empty((4, 8)), forces[n])
    np.testing.assert_allclose(forces[1], 3.0 * forces[0], rtol=1e-12)
