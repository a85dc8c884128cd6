"""The crowd engine as a whole: symmetries, goals, walls, and what it says to wrong input."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.lib.library_crowd import walk_by_library
from vbbench.geometry import FloatArray
from vbbench_generators.social_force import Crowd, Model, Moussaid, WallForce, simulate

MODEL = Model()
STEP: dict[str, Any] = {"dt": 0.1, "substeps": 1}


def crowd(people: int, seed: int = 0, goals: int = 2) -> Crowd:
    """People as dense as in Sim, 50 on 16 m x 16 m, on their way."""
    rng, half = np.random.default_rng(seed), 8.0 * np.sqrt(people / 50)
    positions, places = rng.uniform(-half, half, (people, 2)), rng.uniform(-half, half, (people, goals, 2))
    way = places[:, 0] - positions
    velocities = way / np.linalg.norm(way, axis=1, keepdims=True) * rng.uniform(0.5, 1.5, (people, 1))
    speeds = rng.uniform(0.8, 1.6, people)
    return Crowd(positions=positions, velocities=velocities, speeds=speeds, goals=places)


def lone(goal: list[list[float]], speed: float = 1.3) -> Crowd:
    still = np.zeros((1, 2))
    return Crowd(positions=still, velocities=still, speeds=np.array([speed]), goals=np.array([goal]))


def turned(one: Crowd, angle: float, shift: FloatArray) -> Crowd:
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    move = {name: getattr(one, name) @ turn.T + shift for name in ("positions", "goals")}
    return replace(one, velocities=one.velocities @ turn.T, **move)


@settings(max_examples=20, deadline=None)
@given(angle=st.floats(-7, 7), x=st.floats(-50, 50), y=st.floats(-50, 50), seed=st.integers(0, 99))
def test_crowds_walk_the_same_way_wherever_the_world_points(angle: float, x: float, y: float, seed: int) -> None:
    one, shift = crowd(12, seed), np.array([x, y])
    paths = simulate(one, MODEL, frames=6, **STEP)
    again = simulate(turned(one, angle, shift), MODEL, frames=6, **STEP)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    np.testing.assert_allclose(again, paths @ turn.T + shift, atol=1e-8)


def test_a_crowd_in_blocks_walks_as_one_without_up_to_rounding() -> None:
    """From 256 people on forces are summed in blocks; two crowds of 150 too far apart to meet are one of 300."""
    near, far = crowd(150, 1), crowd(150, 2)
    far = replace(far, positions=far.positions + 1e4, goals=far.goals + 1e4)
    both = Crowd(**{name: np.concatenate([getattr(near, name), values]) for name, values in vars(far).items()})
    paths = [simulate(one, MODEL, frames=5, **STEP) for one in (near, far, both)]
    np.testing.assert_allclose(paths[2], np.concatenate(paths[:2], axis=1), atol=1e-8)


def test_one_person_alone_reaches_the_desired_speed_and_stops_at_the_goal() -> None:
    paths = simulate(lone([[20.0, 0.0]]), MODEL, frames=301, **STEP)[:, 0]
    assert np.linalg.norm(paths[100] - paths[99]) == pytest.approx(0.13, rel=1e-6)
    assert np.linalg.norm(paths[-1] - [20.0, 0.0]) < 0.5
    np.testing.assert_array_equal(paths[-1], paths[-20])


def test_goals_are_headed_for_one_after_the_other_without_a_stop() -> None:
    goals = [[6.0, 0.0], [6.0, 6.0], [0.0, 6.0]]
    paths = simulate(lone(goals), MODEL, frames=301, **STEP)[:, 0]
    near = [np.flatnonzero(np.linalg.norm(paths - goal, axis=1) <= 1.0)[0] for goal in goals]
    assert near == sorted(near)
    assert np.linalg.norm(np.diff(paths[5 : near[-1]], axis=0), axis=1).min() > 0.05
    assert np.linalg.norm(paths[-1] - goals[-1]) < 0.5


def test_nobody_walks_faster_than_the_cap() -> None:
    one = crowd(50, 3)
    speeds = np.linalg.norm(np.diff(simulate(one, MODEL, frames=60, dt=0.05, substeps=1), axis=0), axis=2) / 0.05
    assert np.all(speeds <= 1.3 * one.speeds + 1e-9)


def test_walls_keep_people_out() -> None:
    wall = [[3.0, -20.0, 3.0, 20.0]]
    assert simulate(lone([[6.0, 0.1]]), MODEL, frames=200, **STEP)[-1, 0, 0] > 5.0
    assert simulate(lone([[6.0, 0.1]]), MODEL, frames=200, **STEP, walls=wall)[:, 0, 0].max() < 3.0


def test_degenerate_crowds_stay_finite() -> None:
    zeros, walls = np.zeros((5, 2)), [[0, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0.05, 0]]
    one = Crowd(positions=zeros, velocities=zeros, speeds=np.zeros(5), goals=zeros[:, None])
    moving = replace(one, velocities=np.arange(10).reshape(5, 2), speeds=np.ones(5))
    for start in (one, moving):
        assert np.all(np.isfinite(simulate(start, MODEL, frames=9, **STEP, walls=walls)))


def test_nobody_at_all_is_a_crowd_too() -> None:
    none = Crowd(positions=np.empty((0, 2)), velocities=np.empty((0, 2)), speeds=[], goals=np.empty((0, 1, 2)))
    assert simulate(none, Model(), frames=3, **STEP).shape == (3, 0, 2)


def test_substeps_are_frames_in_between() -> None:
    one = crowd(7)
    fine = simulate(one, Model(), frames=9, dt=0.1, substeps=1)
    np.testing.assert_allclose(simulate(one, Model(), frames=3, dt=0.4, substeps=4), fine[::4], atol=1e-12)


def changed(**change: Any) -> Crowd:
    return replace(crowd(3), **change)


def stepped(**change: Any) -> FloatArray:
    return simulate(crowd(3), Model(), **({"frames": 2, **STEP} | change))


@pytest.mark.parametrize(
    ("make", "change", "message"),
    [
        (changed, {"velocities": np.zeros((2, 2))}, "velocities must have shape"),
        (changed, {"positions": np.full((3, 2), np.nan)}, "positions must be finite"),
        (changed, {"speeds": [1.0, 1.0, -1.0]}, "negative"),
        (changed, {"goals": np.empty((3, 0, 2))}, "goals"),
        (stepped, {"frames": 0}, "frames"),
        (stepped, {"dt": 0.0}, "dt"),
        (stepped, {"dt": float("nan")}, "dt"),
        (stepped, {"substeps": 0}, "substeps"),
        (stepped, {"walls": [[0, 1, 2]]}, "walls"),
        (stepped, {"walls": [[0, 1, 2, np.nan]]}, "walls"),
        (Model, {"relaxation_time": 0.0}, "relaxation_time must be "),
        (Model, {"top_speed": 0.9}, "top_speed must be "),
        (Model, {"arrival_radius": 0.1}, "arrival_radius must be "),
        (Moussaid, {"reach": -1.0}, "reach must be "),
        (Moussaid, {"factor": float("nan")}, "factor must be "),
    ],
)
def test_what_makes_no_sense_is_refused(make: Any, change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make(**change)


FAR, FAST, DT = 1e6, 1e6, 0.1
"""Goals, in m, and speeds, in m/s, that nobody reaches; seconds of the step that shows a force."""


def forces_on(
    places: FloatArray, velocities: FloatArray, model: Model | None = None, **walls: FloatArray
) -> FloatArray:
    """Forces [S, K, 2] in m/s² on people of S scenes: what a step changes of their velocities, as goals do not pull."""
    model = model or Model()
    speeds, goals = np.full(places.shape[1], FAST), np.full((places.shape[1], 1, 2), FAR)
    without_pull = Model(relaxation_time=1e200, repulsion=model.repulsion, walls=model.walls)
    crowds = (
        Crowd(positions=here, velocities=velocity, speeds=speeds, goals=goals)
        for here, velocity in zip(places, velocities, strict=True)
    )
    paths = np.array([simulate(one, without_pull, frames=2, dt=DT, substeps=1, **walls) for one in crowds])
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


SIDE_BY_SIDE = Crowd(
    positions=np.array([[0.3, 0.0], [-0.2, 1.5]]),
    velocities=np.array([[0.0, 1.0], [0.0, 1.1]]),
    speeds=np.array([1.0, 1.2]),
    goals=np.array([[[0.3, 50.0]], [[-0.2, 50.0]]]),
)
"""No angle between directions passes half a turn, which the library does not wrap."""


@pytest.mark.extra("pysocialforce")
def test_the_library_takes_the_steps_and_the_speeds_that_it_is_given() -> None:
    still = np.zeros((1, 2))
    one = Crowd(positions=still, velocities=still, speeds=np.array([1.2]), goals=np.array([[[90.0, 0.0]]]))
    for walk in (simulate, walk_by_library):
        paths = walk(one, Model(), frames=101, dt=0.2, substeps=4)
        assert paths[-1, 0, 0] - paths[-2, 0, 0] == pytest.approx(0.24, rel=1e-9)


@pytest.mark.parametrize(
    "model",
    [
        Model(),
        replace(
            Model(relaxation_time=0.7, top_speed=1.1),
            repulsion=Moussaid(factor=4.0, velocity_weight=1.5, reach=0.4, side_sharpness=1.8, brake_sharpness=2.5),
        ),
    ],
    ids=["usual", "other"],
)
@pytest.mark.extra("pysocialforce")
def test_both_walk_alike_where_no_angle_passes_half_a_turn(model: Model) -> None:
    ours, theirs = (walk(SIDE_BY_SIDE, model, frames=21, dt=0.1, substeps=1) for walk in (simulate, walk_by_library))
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-8)
