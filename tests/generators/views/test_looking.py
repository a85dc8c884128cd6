"""``look = natural``: every law of heads is what its settings say, at any frame time, and follows from the seed."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from vbbench.generation.generator import Look, Options, Simulation
from vbbench.geometry import FloatArray, wrap_angle
from vbbench.registry import load
from vbbench_generators.views.looking import LAWS, Law, Way, causal_headings, limit_turns, natural_look, natural_yaws

LOOK = natural_look()
STEADY = replace(LOOK, walking=replace(LOOK.walking, offset_std=0.0, unsteady_std=0.0))
"""Without what strays from the law."""


def straight(dt: float = 0.1, seconds: float = 20.0, speed: float = 1.2, beside: float | None = None) -> Way:
    """A walk along x; a neighbour may keep up with it at an angle ``beside`` in rad, 5 m away."""
    times = np.arange(round(seconds / dt) + 1) * dt
    path = np.column_stack((speed * times, np.zeros_like(times)))
    around = path[:, None] + (np.nan if beside is None else 5.0 * np.array((np.cos(beside), np.sin(beside))))
    return Way(path=path, times=times, around=around, dt=dt)


def circle(rate: float = 0.5, dt: float = 0.1, seconds: float = 8.0) -> tuple[Way, FloatArray]:
    """A walk to the left on a circle at 1 m/s, and its direction [T] in rad."""
    times = np.arange(round(seconds / dt) + 1) * dt
    path = np.column_stack((np.sin(rate * times), -np.cos(rate * times))) / rate
    return Way(path=path, times=times, around=path[:, None], dt=dt), rate * times


def yaws(way: Way, law: Law | None, seed: int, look: Any = STEADY) -> FloatArray:
    return natural_yaws(way, look, np.random.default_rng(seed), law)


@pytest.mark.parametrize(("law", "lead"), [("follow", 0.1), ("ahead", 0.3), ("sway", 0.0)])
def test_heads_lead_the_path_by_what_the_settings_say(law: Law, lead: float) -> None:
    """On a circle a head that points to where one is in τ s leads the path by τ/2; its ends have no past or future."""
    way, direction = circle()
    inner = slice(15, -15)
    leads = [np.mean(wrap_angle(yaws(way, law, seed) - direction)[inner]) / 0.5 for seed in range(300)]
    assert np.mean(leads) == pytest.approx(lead, abs=0.03)
    if law == "follow":
        assert np.std(leads) == pytest.approx(LOOK.follow.lead_std, rel=0.25)


def test_glances_last_as_long_as_they_should_and_go_to_the_neighbour() -> None:
    turned = np.concatenate([yaws(straight(beside=1.0), "glance", seed) for seed in range(200)])
    assert np.mean(turned > 0.35) == pytest.approx(LOOK.glance.time_share, rel=0.2)
    assert turned.max() == pytest.approx(LOOK.glance.head_share, abs=0.02)
    assert np.mean(np.abs(turned) < 0.05) > 0.7
    assert np.abs(yaws(straight(), "glance", 0)).max() < 1e-9
    assert np.abs(yaws(straight(beside=2.5), "glance", 0)).max() < 1e-9


def test_heads_sway_at_half_the_step_rate() -> None:
    rates, widths = [], []
    for seed in range(100):
        swayed = yaws(straight(), "sway", seed)
        power = np.abs(np.fft.rfft(swayed - swayed.mean()))
        rates.append(np.fft.rfftfreq(len(swayed), 0.1)[power.argmax()])
        widths.append(np.sqrt(2.0) * swayed.std())
    assert np.mean(rates) == pytest.approx(0.5 * LOOK.sway.step_rate, rel=0.03)
    assert np.mean(widths) == pytest.approx(LOOK.sway.amplitude, rel=0.15)


@pytest.mark.parametrize("law", LAWS)
def test_who_stands_looks_around(law: Law) -> None:
    spreads, turns = [], []
    for seed in range(200):
        looked = np.unwrap(yaws(straight(speed=0.0), law, seed))
        spreads.append(looked.std())
        turns.append(np.count_nonzero(np.diff((np.abs(np.diff(looked)) > 1e-6).astype(int)) > 0) / 20.0)
    assert 0.8 * LOOK.standing.spread < np.mean(spreads) < LOOK.standing.spread
    assert np.mean(turns) == pytest.approx(1.0 / LOOK.standing.held_for, rel=0.25)


def test_heads_stray_by_what_the_settings_say_and_turn_no_faster_than_heads_do() -> None:
    strayed = np.array([yaws(straight(), "follow", seed, LOOK) for seed in range(200)])
    assert strayed.mean(axis=1).std() == pytest.approx(LOOK.walking.offset_std, rel=0.25)
    assert (strayed - strayed.mean(axis=1)[:, None]).std() == pytest.approx(LOOK.walking.unsteady_std, rel=0.15)
    back = straight()
    path = np.where(np.arange(len(back.path))[:, None] < 100, back.path, 2.0 * back.path[100] - back.path)
    turned = np.unwrap(yaws(replace(back, path=path), "follow", 3))
    assert np.abs(np.diff(turned)).max() <= LOOK.walking.turn_rate * 0.1 + 1e-9
    assert abs(turned[-1] - turned[0]) == pytest.approx(np.pi, abs=0.05)


@pytest.mark.parametrize("law", LAWS)
def test_a_law_does_not_depend_on_the_frame_time(law: Law) -> None:
    fine, coarse = yaws(straight(dt=0.1), law, 7, LOOK), yaws(straight(dt=0.4), law, 7, LOOK)
    np.testing.assert_allclose(fine[::4], coarse, atol=1e-9)


def test_natural_draws_the_laws_by_their_shares() -> None:
    way, drawn = circle()[0], dict.fromkeys(LAWS, 0)
    for seed in range(400):
        found = yaws(way, None, seed)
        (law,) = [law for law in LAWS if np.array_equal(found, yaws(way, law, seed))]
        drawn[law] += 1
    assert [drawn[law] / 400 for law in LAWS] == pytest.approx(LOOK.shares, abs=0.08)


def test_headings_follow_walks_and_are_held_by_who_stands() -> None:
    """East, north, and then a slow drift to the west."""
    velocity = np.repeat([[1.3, 0.0], [0.0, 1.3], [-0.1, 0.0]], 15, axis=0)
    headings = causal_headings(0.4 * np.cumsum(velocity, axis=0)[:, None], 0.4)[:, 0]
    np.testing.assert_allclose(headings[[0, 14, 29]], [0.0, 0.0, 0.5 * np.pi], atol=1e-3)
    assert headings[-1] == pytest.approx(0.5 * np.pi, abs=0.3)


def test_turns_are_limited_and_go_the_short_way_round() -> None:
    np.testing.assert_allclose(limit_turns(np.array([0.0, 0.1, 3.0]), 1.0, 5.0), [0.0, 0.1, 3.0])
    slow = limit_turns(np.array([3.0, 3.0, -3.0, -3.0]), 0.1, 2.0)
    np.testing.assert_allclose(slow, [3.0, 3.0, 3.2, 2 * np.pi - 3.0])


@pytest.mark.parametrize("split", ["demo", "sim", "street"])
@pytest.mark.parametrize("look", ["natural", "glance"])
def test_every_generator_of_trajectories_turns_heads(split: str, look: Look) -> None:
    simulation = None if split == "demo" else Simulation(sequences=2, people=(12,))
    options = Options(look=look, simulation=simulation)
    plan, again, moved = (
        load("generator", split).plan(one) for one in (options, options, replace(options, look="motion"))
    )
    assert plan.info.definition["look"] == look
    assert plan.info.definition["natural"]["follow"]["lead"] == 0.1
    poses, same, plain = (one.build(1).truth.poses for one in (plan, again, moved))
    assert np.isfinite(poses).all()
    np.testing.assert_array_equal(poses, same)
    np.testing.assert_array_equal(poses[:, :2], plain[:, :2])
    assert np.abs(wrap_angle(poses[:, 2] - plain[:, 2])).max() > 1e-3


def test_a_tier_says_how_heads_turn_unless_the_user_does() -> None:
    demo = load("generator", "demo")
    assert demo.plan(Options(tier="field")).info.definition["look"] == "natural"
    assert demo.plan(Options(tier="field", look="wander")).info.definition["look"] == "wander"
    plain = demo.plan(Options(tier="noisy"))
    assert plain.info.id == demo.plan(Options(tier="noisy", look="motion")).info.id
    assert "natural" not in plain.info.definition
