"""The crowd engine as a whole: symmetries, goals, walls, groups, threads, and what it says to wrong input."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vbbench.geometry import FloatArray
from vbbench_generators.social_force import Crowd, Model, Moussaid, simulate, simulate_many

MODEL = Model()
STEP: dict[str, Any] = {"dt": 0.1, "substeps": 1}


def crowd(people: int, seed: int = 0, grouped: bool = False, goals: int = 2) -> Crowd:
    """People as dense as in Sim, 50 on 16 m x 16 m, on their way."""
    rng, half = np.random.default_rng(seed), 8.0 * np.sqrt(people / 50)
    positions, places = rng.uniform(-half, half, (people, 2)), rng.uniform(-half, half, (people, goals, 2))
    way = places[:, 0] - positions
    velocities = way / np.linalg.norm(way, axis=1, keepdims=True) * rng.uniform(0.5, 1.5, (people, 1))
    groups = np.where(np.arange(people) < people // 2, np.arange(people) // 3, -1) if grouped else np.full(people, -1)
    speeds = rng.uniform(0.8, 1.6, people)
    return Crowd(positions=positions, velocities=velocities, speeds=speeds, goals=places, groups=groups)


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
    one, shift = crowd(12, seed, grouped=True), np.array([x, y])
    paths = simulate(one, MODEL, frames=6, **STEP)
    again = simulate(turned(one, angle, shift), MODEL, frames=6, **STEP)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    np.testing.assert_allclose(again, paths @ turn.T + shift, atol=1e-8)


@pytest.mark.parametrize("walls", [(), [[-8, -8, 8, -8], [-8, 8, 8, 8]]], ids=["open", "walls"])
def test_bytes_do_not_depend_on_company_or_threads(walls: Any) -> None:
    crowds = [crowd(people, people, grouped=True) for people in (10, 300, 1, 50, 2, 257)]
    alone = [simulate(one, MODEL, frames=4, dt=0.2, substeps=2, walls=walls, threads=1).tobytes() for one in crowds]
    for threads in (None, 1, 2):
        paths = simulate_many(crowds, MODEL, frames=4, dt=0.2, substeps=2, walls=walls, threads=threads)
        assert [path.tobytes() for path in paths] == alone


def test_a_large_crowd_walks_as_a_small_one_up_to_rounding(monkeypatch: pytest.MonkeyPatch) -> None:
    one = crowd(60)
    small = simulate(one, MODEL, frames=5, **STEP)
    monkeypatch.setattr("vbbench_generators.social_force.LARGE", 2)
    np.testing.assert_allclose(simulate(one, MODEL, frames=5, **STEP), small, atol=1e-10)


def test_momentum_is_kept_by_moussaid() -> None:
    one = replace(crowd(40), velocities=np.zeros((40, 2)), speeds=np.full(40, 100.0))
    goals = 1e9 * np.where(np.arange(40)[:, None, None] % 2, 1.0, -1.0) * np.ones((1, 1, 2))
    paths = simulate(replace(one, goals=goals), Model(), frames=2, dt=1e-3, substeps=1)
    assert np.abs((paths[1] - paths[0]).sum(axis=0)).max() < 1e-11


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


def test_a_group_stays_closer_together_than_strangers() -> None:
    positions = np.array([[0.0, 0.0], [0.0, 3.0], [0.0, -3.0]])
    goals = positions[:, None] + (30.0, 0.0)
    strangers = Crowd(positions=positions, velocities=np.tile([1.0, 0.0], (3, 1)), speeds=np.full(3, 1.0), goals=goals)
    friends = replace(strangers, groups=np.zeros(3, dtype=np.int64))
    spread = [np.ptp(simulate(one, Model(), frames=100, **STEP)[-1, :, 1]) for one in (strangers, friends)]
    assert spread[1] < 0.7 * spread[0]


def test_degenerate_crowds_stay_finite() -> None:
    zeros, walls = np.zeros((5, 2)), [[0, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0.05, 0]]
    one = Crowd(positions=zeros, velocities=zeros, speeds=np.zeros(5), goals=zeros[:, None], groups=[0, 0, 1, 1, -1])
    moving = replace(one, velocities=np.arange(10).reshape(5, 2), speeds=np.ones(5))
    for start in (one, moving):
        assert np.all(np.isfinite(simulate(start, MODEL, frames=9, **STEP, walls=walls)))


def test_nobody_at_all_is_a_crowd_too() -> None:
    none = Crowd(positions=np.empty((0, 2)), velocities=np.empty((0, 2)), speeds=[], goals=np.empty((0, 1, 2)))
    assert simulate(none, Model(), frames=3, **STEP).shape == (3, 0, 2)
    assert simulate_many([], Model(), frames=3, **STEP) == []


def test_substeps_are_frames_in_between() -> None:
    one = crowd(7)
    fine = simulate(one, Model(), frames=9, dt=0.1, substeps=1)
    np.testing.assert_allclose(simulate(one, Model(), frames=3, dt=0.4, substeps=4), fine[::4], atol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"velocities": np.zeros((2, 2))}, "velocities must have shape"),
        ({"positions": np.full((3, 2), np.nan)}, "positions must be finite"),
        ({"speeds": [1.0, 1.0, -1.0]}, "negative"),
        ({"goals": np.empty((3, 0, 2))}, "goals"),
        ({"groups": [0, 0, -2]}, "groups"),
    ],
)
def test_crowds_that_make_no_sense(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(crowd(3), **change)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"frames": 0}, "frames"),
        ({"dt": 0.0}, "dt"),
        ({"dt": float("nan")}, "dt"),
        ({"substeps": 0}, "substeps"),
        ({"walls": [[0, 1, 2]]}, "walls"),
        ({"walls": [[0, 1, 2, np.nan]]}, "walls"),
        ({"threads": 0}, "threads"),
    ],
)
def test_steps_that_make_no_sense(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        simulate(crowd(3), Model(), **({"frames": 2, **STEP} | change))


@pytest.mark.parametrize(
    "make",
    [
        lambda: Model(relaxation_time=0.0),
        lambda: Model(top_speed=0.9),
        lambda: Model(arrival_radius=0.1),
        lambda: Moussaid(reach=-1.0),
        lambda: Moussaid(factor=float("nan")),
    ],
)
def test_models_that_make_no_sense(make: Any) -> None:
    with pytest.raises(ValueError, match=r"Model|Moussaid"):
        make()
