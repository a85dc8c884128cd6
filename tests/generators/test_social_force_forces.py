"""Forces of the crowd engine against the formulas as one would write them down, in NumPy."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from vbbench.geometry import FloatArray
from vbbench_generators.social_force import Crowd, Model, Moussaid, WallForce, simulate_many

FAR, FAST, DT = 1e6, 1e6, 0.1
"""Goals, in m, and speeds, in m/s, that nobody reaches; seconds of the step that shows a force."""


def forces_on(
    places: FloatArray, velocities: FloatArray, model: Model | None = None, **walls: FloatArray
) -> FloatArray:
    """Forces [S, K, 2] in m/s² on people of S scenes: what a step changes of their velocities, as goals do not pull."""
    model = model or Model()
    speeds, goals = np.full(places.shape[1], FAST), np.full((places.shape[1], 1, 2), FAR)
    crowds = [
        Crowd(positions=here, velocities=velocity, speeds=speeds, goals=goals)
        for here, velocity in zip(places, velocities, strict=True)
    ]
    without_pull = Model(relaxation_time=1e200, repulsion=model.repulsion, walls=model.walls)
    paths = np.array(simulate_many(crowds, without_pull, frames=2, dt=DT, substeps=1, **walls))
    return ((paths[:, 1] - paths[:, 0]) / DT - velocities) / DT


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
    forces = forces_on(np.stack([r, 0.0 * r], axis=1), np.stack([0.0 * u, u], axis=1))
    np.testing.assert_allclose(forces[:, 0], moussaid_exactly(r, u), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("count", [1, 2, 5, 50, 130])
def test_everybody_feels_the_sum_of_all_pairs(count: int) -> None:
    rng = np.random.default_rng(count)
    half = 8.0 * np.sqrt(count / 50)
    places, velocities = rng.uniform(-half, half, (count, 2)), rng.normal(0.0, 1.0, (count, 2))
    i, j = np.nonzero(~np.eye(count, dtype=bool))
    exact = np.zeros((count, 2))
    np.add.at(exact, i, moussaid_exactly(places[i] - places[j], velocities[j] - velocities[i]))
    np.testing.assert_allclose(forces_on(places[None], velocities[None])[0], exact, rtol=0.0, atol=1e-8)


def test_people_who_stand_in_one_place_feel_nothing() -> None:
    assert np.all(forces_on(np.zeros((1, 7, 2)), np.zeros((1, 7, 2))) == 0.0)


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
    got = forces_on(np.array([[place]]), np.zeros((1, 1, 2)), Model(walls=WallForce()), walls=np.array([wall]))
    np.testing.assert_allclose(got[0, 0], exact, rtol=1e-9, atol=1e-5)


def test_parameters_reach_the_forces() -> None:
    places, still = np.array([[[0.0, 0.0], [0.6, 0.3]]]), np.zeros((1, 2, 2))
    one, three = (forces_on(places, still, Model(repulsion=Moussaid(factor=factor))) for factor in (1.0, 3.0))
    np.testing.assert_allclose(three, 3.0 * one, rtol=1e-9)
