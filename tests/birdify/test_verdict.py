"""The verdict that a report of `birdify` begins with: each of its sentences, of made-up estimates."""

from typing import Any

import numpy as np
import pytest

from vbbench.birdify.verdict import Verdict, judge
from vbbench.estimate import Estimate
from vbbench.geometry import FloatArray, relative_to_world
from vbbench.solver import Carrier

DT, PEOPLE = 0.1, 6
RELATIVE = np.stack([np.linspace(-3.0, 3.0, PEOPLE), np.linspace(4.0, 9.0, PEOPLE)], axis=-1)


def estimate(seconds: float, *, drift: float = 0.01, own: float = 0.2, **changes: Any) -> Estimate:
    """A camera that walks at 1 m/s, and people around it in its pace.

    Along its way it is off by ``drift`` m after a second and by so much more each second; people around it by ``own`` m
    in each direction.
    """
    time = DT * np.arange(round(seconds / DT))
    poses = np.stack([time, np.zeros_like(time), np.zeros_like(time)], axis=-1)
    spread = np.zeros((len(time), 3, 3))
    spread[:, 0, 0] = (drift * time) ** 2
    around = np.broadcast_to(own**2 * np.eye(2), (len(time), PEOPLE, 2, 2))
    values: dict[str, Any] = {
        "poses": poses,
        "positions": relative_to_world(RELATIVE, poses),
        "converged": np.ones(len(time), bool),
        "pose_covariances": spread,
        "position_covariances": spread[:, None, :2, :2] + around,
    }
    return Estimate(**values | changes)


def verdict(answer: Estimate, carried_by: Carrier = "unknown", seen: Any = True) -> Verdict:
    observed = np.broadcast_to(seen, answer.positions.shape[:2])
    return judge(answer, observed, DT, [f"p{k}" for k in range(PEOPLE)], carried_by)


def leaping(answer: Estimate, metres: float, second: float) -> FloatArray:
    """Its poses, which leap forward by so many m at this time."""
    return answer.poses + np.where(DT * np.arange(len(answer.poses)) >= second, metres, 0.0)[:, None] * [1.0, 0.0, 0.0]


def test_a_good_map_is_described_by_its_radii() -> None:
    made = verdict(estimate(60.0, drift=0.02))
    people, path = made.sentences()
    assert people == "Places of people around the camera: within 0.6 m (95 %)."
    assert path == "The path drifts: within 0.4 m after 10 s, within 2.3 m at the end (60 s)."
    assert (made.usable, made.parts, made.fast) == (60.0, (), ())
    assert not made.lost(600).any()


def test_the_radius_of_people_holds_their_places_around_the_camera_and_not_the_drift() -> None:
    """By draws from the same covariances: along one direction 95 %, and more where errors go both ways."""
    one_way = np.zeros((100, PEOPLE, 2, 2))
    one_way[..., 1, 1] = 0.3**2
    sure = estimate(10.0, drift=5.0)
    made = verdict(estimate(10.0, drift=5.0, position_covariances=sure.pose_covariances[:, None, :2, :2] + one_way))  # type: ignore[index]
    drawn = np.abs(np.random.default_rng(0).normal(0.0, 0.3, 100_000))
    assert made.people == pytest.approx(np.quantile(drawn, 0.95), rel=0.01)


def test_an_uncertain_yaw_moves_people_with_the_camera() -> None:
    turned = estimate(10.0)
    spread = np.zeros((100, 3, 3))
    spread[:, 2, 2] = 0.1**2
    lever = turned.positions - turned.poses[:, None, :2]
    across = np.stack([-lever[..., 1], lever[..., 0]], axis=-1)
    places = 0.1**2 * across[..., :, None] * across[..., None, :] + 0.2**2 * np.eye(2)
    made = verdict(estimate(10.0, pose_covariances=spread, position_covariances=places))
    assert made.people == pytest.approx(verdict(turned).people)


@pytest.mark.parametrize(
    ("drift", "usable", "words"),
    [
        (0.12, 3.0 / (1.96 * 0.12), "The path drifts: within 2.4 m after 10 s, not usable beyond 13 s."),
        (0.2, 3.0 / (1.96 * 0.2), "The path of the camera is not usable beyond 7.7 s."),
        (20.0, 0.1, "The path of the camera is not usable."),
        (0.09, 60.0, "The path drifts: within 1.8 m after 10 s, within 11 m at the end (60 s)."),  # 18 % of its length
    ],
)
def test_a_path_that_drifts_is_usable_for_a_time(drift: float, usable: float, words: str) -> None:
    made = verdict(estimate(60.0, drift=drift))
    assert made.sentences()[1] == words
    assert made.usable == pytest.approx(usable, abs=0.15)
    assert made.lost(600).sum() == pytest.approx(10.0 * (60.0 - made.usable), abs=1.0)


def test_a_path_that_is_unsure_at_first_alone_is_usable() -> None:
    spread = np.zeros((200, 3, 3))
    spread[1:10, 0, 0] = 4.0
    made = verdict(estimate(20.0, pose_covariances=spread))
    assert made.usable == 20.0


def test_a_short_path_is_judged_at_its_end() -> None:
    assert verdict(estimate(5.0)).sentences()[1] == "The path of the camera: within 0.1 m at the end (5.0 s)."


def test_a_solver_without_covariances_leaves_it_open() -> None:
    made = verdict(estimate(20.0, pose_covariances=None, position_covariances=None))
    assert made.sentences() == ("The solver reports no uncertainty: how far places and path are off is not known.",)
    leaping_one = estimate(20.0, pose_covariances=None, position_covariances=None)
    poses = leaping(leaping_one, 100.0, 12.0)
    words = verdict(estimate(20.0, pose_covariances=None, position_covariances=None, poses=poses)).sentences()
    assert words[1] == "The path of the camera is not usable beyond 11 s."


def test_covariances_of_people_that_do_not_hold_those_of_the_pose_give_no_radius() -> None:
    small = np.broadcast_to(1e-4 * np.eye(2), (200, PEOPLE, 2, 2))
    made = verdict(estimate(20.0, drift=0.05, position_covariances=small))
    assert made.people is None
    people, path = made.sentences()
    assert people == "Places of people around the camera: how far they are off does not follow from the covariances."
    assert path == "The path drifts: within 1.0 m after 10 s, within 2.0 m at the end (20 s)."


def test_frames_that_did_not_converge_are_named_by_their_times() -> None:
    marks = np.ones(600, bool)
    marks[100:150] = marks[155:200] = marks[400:410] = False
    made = verdict(estimate(60.0, converged=marks))
    assert made.sentences()[-1] == (
        "Not usable from 10.0 to 20.0 s and from 40.0 to 41.0 s: the estimate did not converge."
    )
    for begin in (450, 480, 510):
        marks[begin : begin + 5] = False
    marks[590:] = False
    words = verdict(estimate(60.0, converged=marks)).sentences()[-1]
    assert words == (
        "Not usable from 10.0 to 20.0 s, from 40.0 to 41.0 s, from 59.0 s to the end and in 3 shorter parts: "
        "the estimate did not converge."
    )


def test_where_hardly_anything_converged_nothing_is_usable() -> None:
    marks = np.zeros(200, bool)
    marks[:10] = True
    made = verdict(estimate(20.0, converged=marks))
    assert made.sentences() == ("Nothing of this map is usable: the estimate did not converge.",)


@pytest.mark.parametrize(
    ("carried_by", "metres", "impossible"),
    [
        ("person", 3.5, True),
        ("robot", 3.5, False),
        ("robot", 4.5, True),
        ("vehicle", 28.0, False),
        ("unknown", 28.0, False),
        ("vehicle", 40.0, True),
        ("unknown", 40.0, True),
    ],
)
def test_a_camera_is_not_faster_than_what_carries_it(carried_by: Carrier, metres: float, impossible: bool) -> None:
    """A leap within a frame, on top of 1 m/s."""
    answer = estimate(40.0)
    poses = leaping(answer, metres, 20.0)
    made = verdict(estimate(40.0, poses=poses, positions=answer.positions), carried_by)
    assert bool(made.parts) is impossible
    assert (made.usable < 40.0) is impossible
    if impossible:
        assert made.usable == pytest.approx(19.0, abs=0.11)
        words = " ".join(made.sentences())
        assert "not usable beyond 19 s." in words
        assert f"Not usable from 19.0 to 21.0 s: the camera would move at {metres + 1:.0f} m/s." in words


def test_people_are_not_faster_than_people() -> None:
    answer = estimate(40.0)
    places = answer.positions.copy()
    time = DT * np.arange(400)
    places[:, 2, 1] += 6.0 * time
    words = verdict(estimate(40.0, positions=places)).sentences()
    assert words[-1] == "1 of 6 people (p2) would move faster than 4 m/s: their places are not usable."
    places[200:300, :, 1] += 5.0 * time[:100, None]
    places[300:, :, 1] += 50.0
    words = verdict(estimate(40.0, positions=places)).sentences()
    assert words[-2] == "Not usable from 19.8 to 30.3 s: people would move at 5 m/s."


def test_people_who_are_not_seen_have_no_speed() -> None:
    answer = estimate(40.0)
    seen = np.zeros((400, PEOPLE), bool)
    seen[:5] = True
    made = verdict(answer, seen=seen)
    assert (made.walkers, made.fast) == (0, ())
    assert made.people == pytest.approx(verdict(answer).people)
    assert verdict(answer, seen=False).people is None
