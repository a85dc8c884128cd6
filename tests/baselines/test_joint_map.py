"""The estimator in C++: gradients, elimination, marginal priors, what it answers, and what its binding refuses."""

import pickle
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from tests.lib.solver_runs import CAMERAS, problem_of, see
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench.protocol import get_protocol
from vbbench.sequence import Truth
from vbbench.solver import CARRIERS, Carrier
from vbbench.solving.runner import run_sequence
from vbbench_baselines._core import Estimator
from vbbench_baselines.joint_map import MapBatch, MapCausal

DT, MOUNT, FOCAL = 0.4, 1.6, 600.0
NOWHERE = np.full((3, 3), np.nan)


@dataclass(frozen=True)
class Crowd:
    """A camera that walks along x, and people who walk as straight: poses [T, 3], places [T, K, 2], boxes [T, K, 5]."""

    poses: FloatArray
    places: FloatArray
    boxes: FloatArray


def crowd(
    frames: int, people: int, *, noise: float = 0.5, edge: float = 0.0, seed: int = 0, stray: float = 0.01
) -> Crowd:
    rng = np.random.default_rng(seed)
    time = DT * np.arange(frames)
    yaw = np.arctan2(0.06 * np.cos(0.2 * time), 1.2)  # the camera looks along its path
    poses = np.stack([1.2 * time, 0.3 * np.sin(0.2 * time), yaw], axis=-1)
    start = np.stack([rng.uniform(4.0, 10.0, people), rng.uniform(-3.0, 3.0, people)], axis=-1)
    velocity = np.stack([rng.uniform(0.6, 1.5, people), rng.normal(0.0, 0.2, people)], axis=-1)
    steps = rng.normal(0.0, stray, (frames, people, 2)).cumsum(axis=0)
    places = start + velocity * time[:, None, None] + steps
    heights = rng.normal(1.7, 0.07, people)
    return Crowd(poses, places, boxes_of(poses, places, heights, edge=edge, noise=noise, rng=rng))


def boxes_of(
    poses: FloatArray,
    places: FloatArray,
    heights: FloatArray,
    *,
    edge: float = 0.0,
    noise: float = 0.0,
    mount: float = MOUNT,
    rng: np.random.Generator | None = None,
) -> FloatArray:
    """Boxes [T, K, 5] of people of these heights [K] in m, with white noise in px."""
    offset = places - poses[:, None, :2]
    distance = np.hypot(offset[..., 0], offset[..., 1]) - edge
    angle = np.arctan2(offset[..., 1], offset[..., 0]) - poses[:, None, 2]
    pixels = noise / FOCAL * (rng or np.random.default_rng(0)).normal(size=(3, *distance.shape))
    length = heights / distance + pixels[0] - pixels[1]
    return np.stack([pixels[2] - angle, mount / distance + pixels[0], length, FOCAL * length, length], axis=-1)


def facts(people: int, *, known: bool = True, covariances: bool = False) -> dict[str, Any]:
    std = 0.0 if known else 0.03
    return {
        "dt": DT,
        "height_mean": 1.7,
        "height_std": 0.07,
        "pixel_std": 0.5,
        "box_std": std,
        "tilt_std": std,
        "mount_height_std": 4.0 * std,
        "mount_height": MOUNT,
        "box_edge": np.nan,
        "columns": people,
        "known_calibration": known,
        "covariances": covariances,
        "carrier": 0,
    }


class Run:
    """An estimator that steps through a crowd, and what it answered."""

    def __init__(
        self,
        people: int,
        *,
        known: bool = True,
        covariances: bool = False,
        changes: dict[str, Any] | None = None,
        **constants: float,
    ) -> None:
        self.core = Estimator()
        for name, value in constants.items():
            self.core.set(name, value)
        self.core.start(facts(people, known=known, covariances=covariances) | (changes or {}))
        self.people = people

    def arrays(self) -> dict[str, Any]:
        k = self.people
        return {
            "boxes": np.full((k, 5), np.nan),
            "cut": np.zeros(k, np.int32),
            "poses": NOWHERE.copy(),
            "positions": np.full((3, k, 2), np.nan),
            "motion": np.full(3, np.nan),
            "motion_covariance": np.zeros((3, 3)),
            "pose": np.full(3, np.nan),
            "pose_covariance": np.full((3, 3), np.nan),
            "places": np.full((k, 2), np.nan),
            "place_covariances": np.full((k, 2, 2), np.nan),
            "heights": np.full(k, np.nan),
        }

    def step(self, **given: Any) -> dict[str, Any]:
        arrays = self.arrays() | given
        arrays["converged"] = self.core.step(**arrays)
        return arrays

    def through(self, scene: Crowd, *, given: int = 2, poses_given: int = 2) -> list[dict[str, Any]]:
        """Steps of all frames; places of the first ``given`` ones are given, and poses of ``poses_given``."""
        answers = []
        for t, boxes in enumerate(scene.boxes):
            poses, positions = NOWHERE.copy(), np.full((3, self.people, 2), np.nan)
            if t < poses_given:
                poses[2] = scene.poses[t]
            if t < given:
                positions[2] = scene.places[t]
            answers.append(self.step(boxes=np.ascontiguousarray(boxes), poses=poses, positions=positions))
        return answers


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize(("size", "dt"), [(6, DT), (20, DT), (4, 0.1), (20, 0.07)])
def test_gradients_of_all_rows_are_those_of_the_cost(known: bool, size: int, dt: float) -> None:
    """Boxes and given values between key frames, every .2 s, depend on two of them."""
    run = Run(5, known=known, size=size, changes={"dt": dt})
    run.through(crowd(12, 5, edge=0.0 if known else 0.2), given=4, poses_given=4)
    system, core, width = run.core.linear_system(), run.core, 1e-6
    gradient = system["jacobian"].T @ (system["weights"] * system["residuals"]) + system["gradient"]
    for column in np.flatnonzero(system["free"]):
        step = np.zeros(len(gradient))
        step[column] = width
        found = (core.cost(step) - core.cost(-step)) / (2.0 * width)
        assert found == pytest.approx(gradient[column], rel=1e-3, abs=1e-3)


def dense_step(core: Estimator) -> FloatArray:
    """The Gauss–Newton step of the dense system, by NumPy."""
    system = core.linear_system()
    free = system["free"] > 0.0
    jacobian, weights = system["jacobian"], system["weights"]
    hessian = jacobian.T @ (weights[:, None] * jacobian) + system["information"] + 1e-9 * np.eye(len(free))
    gradient = jacobian.T @ (weights * system["residuals"]) + system["gradient"]
    step = np.zeros(len(free))
    step[free] = np.linalg.solve(hessian[np.ix_(free, free)], -gradient[free])
    return step


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize(("people", "frames", "size", "dt"), [(3, 5, 20, DT), (3, 12, 6, DT), (3, 12, 4, 0.07)])
def test_elimination_takes_the_step_of_the_dense_system(
    people: int, frames: int, size: int, dt: float, known: bool
) -> None:
    run = Run(people, known=known, size=size, rounds=1.0, changes={"dt": dt})
    run.through(crowd(frames, people, edge=0.0 if known else 0.2, noise=3.0))
    step = run.core.eliminated_step()
    assert len(step) > 0
    assert np.abs(step).max() > 1e-6
    np.testing.assert_allclose(step, dense_step(run.core), rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("known", [True, False])
def test_marginal_priors_hold_what_left_the_window(known: bool) -> None:
    """With given poses the problem is next to linear: six frames and their priors answer as all frames do."""
    scene = crowd(18, 6, noise=0.2, edge=0.0 if known else 0.2)
    short, whole = (Run(6, known=known, size=size).through(scene, poses_given=18) for size in (6, 20))
    for one, other in zip(short, whole, strict=True):
        np.testing.assert_allclose(one["places"], other["places"], atol=0.02)
        np.testing.assert_allclose(one["heights"], other["heights"], atol=0.02)
    np.testing.assert_allclose(whole[-1]["places"], scene.places[-1], atol=0.1)


def test_a_short_window_finds_about_the_poses_of_one_that_holds_all_frames() -> None:
    """Four seconds, of which the first two frames are held; a camera that looks along its path, as modes expect."""
    for seed in range(3):
        scene = crowd(18, 6, seed=seed)
        short, whole = (Run(6, size=size).through(scene) for size in (10, 20))
        for one, other in zip(short, whole, strict=True):
            np.testing.assert_allclose(one["pose"], other["pose"], atol=0.1)
            np.testing.assert_allclose(one["places"], other["places"], atol=0.15)  # 5 to 13 m away
        np.testing.assert_allclose(short[-1]["pose"], scene.poses[-1], atol=0.5)
        np.testing.assert_allclose(short[-1]["places"], scene.places[-1], atol=0.5)


def test_errors_are_as_large_as_the_covariances_state() -> None:
    squares = []
    for seed in range(8):
        scene = crowd(18, 6, seed=seed, stray=0.05)
        answer = Run(6, covariances=True).through(scene)[-1]
        off = answer["pose"] - scene.poses[-1]
        squares.append(off @ np.linalg.solve(answer["pose_covariance"], off) / 3.0)
    assert 0.2 < np.mean(squares) < 2.0


def robot(frames: int, people: int, seed: int) -> Crowd:
    """A camera that drives along its axis at 1.1 m/s, and turns at up to .5 rad/s, among walkers."""
    scene, rng = crowd(frames, people, seed=seed, stray=0.02), np.random.default_rng(seed)
    rate = 0.5 * np.sin(0.5 * DT * np.arange(frames))
    yaw = DT * np.cumsum(rate)
    along = yaw - 0.5 * DT * rate
    x, y = 1.1 * DT * np.cumsum(np.cos(along)), 1.1 * DT * np.cumsum(np.sin(along))
    poses = np.stack([x, y, yaw], axis=-1)
    places = scene.places + rng.uniform(-6.0, 6.0, (people, 2)) - np.array([0.5 * DT * frames, 0.0])
    return Crowd(poses, places, boxes_of(poses, places, rng.normal(1.7, 0.07, people), noise=0.5, rng=rng))


def test_a_robot_that_turns_among_people_drives() -> None:
    for seed in range(3):
        scene, run = robot(50, 12, seed), Run(12)
        answer = run.through(scene)[-1]
        assert sum(run.core.modes()[1:3]) > 0.9  # straight on, or in curves
        assert np.hypot(*(answer["pose"] - scene.poses[-1])[:2]) < 0.6


def test_exact_boxes_of_people_far_away_show_how_a_car_brakes() -> None:
    """Projections of labels: two people 45 m away are 20 px tall, and half a pixel would be 1 m of distance."""
    errors = []
    for seed in range(6):
        scene = crowd(20, 2, seed=seed)
        speed = np.clip(4.5 - 0.45 * np.arange(20), 0.0, None)
        poses = np.stack([DT * np.cumsum(speed), np.zeros(20), np.zeros(20)], axis=-1)
        places = scene.places + np.array([40.0, 0.0])
        far = Crowd(poses, places, boxes_of(poses, places, np.array([1.64, 1.78]), edge=0.2))
        errors.append(np.hypot(*(Run(2, known=False).through(far)[-1]["pose"] - poses[-1])[:2]))
    assert np.mean(errors) < 0.2


def test_exact_boxes_of_people_whom_the_camera_passes_keep_the_estimate_finite() -> None:
    for seed in range(4):
        run = Run(4, known=False)
        assert np.isfinite(run.through(crowd(30, 4, seed=seed, noise=0.0, edge=0.2))[-1]["pose"]).all()


@pytest.mark.parametrize("known", [True, False])
def test_covariances_are_symmetric_and_positive(known: bool) -> None:
    scene = crowd(10, 4, edge=0.0 if known else 0.2)
    scene.boxes[3:, 1] = np.nan
    for answer in Run(4, known=known, covariances=True, size=6).through(scene)[2:]:
        spreads = [answer["pose_covariance"], *answer["place_covariances"]]
        for spread in spreads:
            if np.isfinite(spread).all():
                np.testing.assert_allclose(spread, spread.T)
                assert np.linalg.eigvalsh(spread).min() > 0.0
        assert np.isfinite(spreads[0]).all()


def test_without_covariances_none_are_written() -> None:
    answer = Run(3).through(crowd(4, 3))[-1]
    assert np.isnan(answer["pose_covariance"]).all()
    assert np.isnan(answer["place_covariances"]).all()


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("people", [0, 1, 3])
def test_nobody_one_person_and_gaps_give_finite_poses(people: int, known: bool) -> None:
    scene = crowd(30, people)
    scene.boxes[5:25] = np.nan
    run = Run(people, known=known, covariances=True, size=6)
    for answer in run.through(scene, given=1, poses_given=1):
        assert np.isfinite(answer["pose"]).all()
    assert np.isfinite(run.core.cost())


def test_nobody_ever_seen_gives_a_pose_and_no_places() -> None:
    run = Run(3)
    for _ in range(8):
        answer = run.step()
        assert np.isfinite(answer["pose"]).all()
        assert np.isnan(answer["places"]).all()


def test_a_forgotten_column_is_a_new_person() -> None:
    scene = crowd(12, 4)
    run = Run(4)
    run.through(scene)
    run.core.forget(np.array([1], np.int32))
    answer = run.step()
    assert np.isnan(answer["places"][1]).all()
    box = scene.boxes[-1].copy()
    box[1, 1:4] *= 0.5  # far from where the earlier person went
    answer = run.step(boxes=box)
    offset = answer["places"][1] - answer["pose"][:2]
    assert np.hypot(*offset) == pytest.approx(1.7 / box[1, 2], rel=0.2)


def error_with_edge(box_edge: float) -> float:
    """Median error in m of the places of people whose boxes agree with a plane .45 m nearer."""
    scene, run = crowd(12, 6, edge=0.45), Run(6)
    run.core.start(facts(6) | {"box_edge": box_edge})
    off = run.through(scene, poses_given=len(scene.boxes))[-1]["places"] - scene.places[-1]
    return float(np.median(np.hypot(off[:, 0], off[:, 1])))


def test_a_near_edge_that_is_given_moves_people_away_by_as_much() -> None:
    assert error_with_edge(0.45) < 0.05
    assert error_with_edge(np.nan) > 0.3


@pytest.mark.parametrize("edge", [0.0, 0.45])
def test_a_near_edge_that_is_given_holds_where_the_calibration_is_uncertain(edge: float) -> None:
    run = Run(6, known=False)
    run.core.start(facts(6, known=False) | {"box_edge": edge})
    run.through(crowd(12, 6, edge=edge))
    assert run.core.calibration()[4] == pytest.approx(edge, abs=0.1)


def test_a_start_begins_again() -> None:
    scene = crowd(6, 3)
    run = Run(3)
    first = run.through(scene)
    run.core.start(facts(3) | {"height_std": 0.3})  # children among them
    run.through(scene)
    run.core.start(facts(3))
    again = run.through(scene)
    np.testing.assert_array_equal(first[-1]["places"], again[-1]["places"])


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("boxes", np.zeros((2, 5)), r"boxes must have the shape \[3, 5\], not \[2, 5\]"),
        ("boxes", np.zeros((3, 5), np.float32), "boxes must be an array of float64 in C order"),
        ("boxes", np.zeros((5, 3)).T, "boxes must be an array of float64 in C order"),
        ("boxes", [1.0], "boxes must be an array of float64"),
        ("cut", np.zeros(3), "cut must be an array of int32"),
        ("cut", np.zeros(4, np.int32), r"cut must have the shape \[3\], not \[4\]"),
        ("poses", np.zeros(9), r"poses must have the shape \[3, 3\], not \[9\]"),
        ("positions", np.zeros((3, 2, 2)), r"positions must have the shape \[3, 3, 2\]"),
        ("motion", None, "motion must be an array of float64"),
        ("heights", np.zeros(3, np.float32), "heights must be an array of float64 in C order that can be written to"),
        ("places", np.zeros((3, 3)), r"places must have the shape \[3, 2\], not \[3, 3\]"),
    ],
)
def test_arrays_of_the_wrong_size_or_type_are_refused(name: str, value: Any, problem: str) -> None:
    with pytest.raises(VbbenchError, match=problem):
        Run(3).step(**{name: value})


def test_an_array_that_cannot_be_written_to_is_refused() -> None:
    pose = np.zeros(3)
    pose.flags.writeable = False
    with pytest.raises(VbbenchError, match="pose must be an array of float64 in C order that can be written to"):
        Run(3).step(pose=pose)


def test_a_step_before_the_start_is_refused() -> None:
    run = Run(0)
    for call in (lambda core: core.cost(), lambda core: core.step(**run.arrays())):
        with pytest.raises(VbbenchError, match="start comes before"):
            call(Estimator())


@pytest.mark.parametrize(
    ("wrong", "problem"),
    [
        ({"dt": 0.0}, "dt must be a number above 0"),
        ({"dt": float("nan")}, "dt must be a number above 0"),
        ({"dt": "fast"}, "dt has the wrong type"),
        ({"pixel_std": -1.0}, "pixel_std must be a number of at least 0"),
        ({"columns": -1}, "columns must be at least 0"),
        ({"carrier": 4}, "carrier must be from 0 to 3"),
        ({"box_edge": float("inf")}, "box_edge must be finite, or NaN or negative where it is not known"),
    ],
)
def test_facts_that_cannot_be_are_refused(wrong: dict[str, Any], problem: str) -> None:
    with pytest.raises(VbbenchError, match=problem):
        Estimator().start(facts(3) | wrong)
    with pytest.raises(VbbenchError, match=f"{next(iter(wrong))} is missing"):
        Estimator().start({name: value for name, value in facts(3).items() if name not in wrong})


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("luck", 1.0, "no constant is called luck"),
        ("edge", float("inf"), "edge must be a finite number"),
        ("size", 3.0, "size must be from 4 to 400 frames"),
        ("rounds", 0.0, "rounds must be from 1 to 1000"),
    ],
)
def test_constants_that_cannot_be_are_refused(name: str, value: float, problem: str) -> None:
    with pytest.raises(VbbenchError, match=problem):
        Estimator().set(name, value)


def hidden_scene() -> Crowd:
    """A crowd before a camera that stands, 2.2 m high.

    Person 0 comes, stands for a while before persons 1 and 2, and goes. Meanwhile their boxes end at its shoulders.
    """
    frames, mount, comes, goes = 30, 2.2, 10, 22
    poses = np.zeros((frames, 3))
    places = np.tile([[3.0, 0.0], [6.0, 0.0], [8.0, 0.03], [7.0, -2.0], [8.0, 2.5], [5.0, 1.8]], (frames, 1, 1))
    way = np.clip(np.arange(frames) - comes, None, 0) + np.clip(np.arange(frames) - goes, 0, None)
    places[:, 0, 1] = -0.12 + 0.2 * way
    whole = boxes_of(poses, places, np.full(6, 1.7), mount=mount)
    boxes, shoulders = whole.copy(), (whole[:, 0, 1] - 0.8 * whole[:, 0, 2])
    hides = (np.arange(frames) >= comes) & (np.arange(frames) <= goes)
    for k in (1, 2):
        boxes[hides, k, 2] -= whole[hides, k, 1] - shoulders[hides]
        boxes[hides, k, 1] = shoulders[hides]
        boxes[hides, k, 3] = FOCAL * boxes[hides, k, 2]
        boxes[hides, k, 4] = boxes[hides, k, 2]
    return Crowd(poses, places, boxes)


@pytest.mark.parametrize("dt", [DT, 0.1])
@pytest.mark.parametrize("known", [True, False])
def test_boxes_that_end_at_a_nearer_person_do_not_move_those_behind(known: bool, dt: float) -> None:
    """Where such a box ends, somebody of 1.7 m would stand 1.9 m farther. At 10 Hz half of all frames count, too."""
    scene = hidden_scene()
    run = Run(6, known=known, changes={"mount_height": 2.2, "dt": dt})
    for answer, places in zip(run.through(scene, poses_given=len(scene.poses)), scene.places, strict=True):
        off = answer["places"] - places
        assert np.hypot(off[:, 0], off[:, 1]).max() < 0.3


@pytest.mark.parametrize("frames", [13, 14])
def test_who_returns_between_key_frames_is_where_the_box_is(frames: int) -> None:
    """A person turns round while nobody sees it, for .7 s at 10 Hz; its last velocity leads 1.4 m astray."""
    time = 0.1 * np.arange(frames + 8)
    places = np.tile([[6.0, -3.0], [8.0, 1.0], [9.0, -1.0], [7.0, 3.0]], (len(time), 1, 1))
    places[:, 0, 1] += np.interp(time, (0.0, 0.1 * (frames - 3), time[-1]), (0.0, 0.13 * (frames - 3), 0.0))
    poses = np.zeros((len(time), 3))
    scene = Crowd(poses, places, boxes_of(poses, places, np.full(4, 1.7), noise=0.5))
    scene.boxes[frames - 6 : frames + 1, 0] = np.nan
    answers = Run(4, covariances=True, changes={"dt": 0.1}).through(scene, poses_given=len(time))
    off = answers[frames + 1]["places"][0] - places[frames + 1, 0]
    assert np.hypot(*off) < 0.4
    assert off @ np.linalg.solve(answers[frames + 1]["place_covariances"][0], off) < 9.0


TALL = np.array([1.55, 1.62, 1.66, 1.78, 1.88, 1.70])
SWITCH = 15
"""Frame from which boxes are of another person, or the camera looks elsewhere."""


def walkers(switched: bool = False, turn: float = 0.0, dt: float = DT) -> Crowd:
    """Six people of the heights `TALL` before a camera that follows them; column 2 may go over to one .2 m taller."""
    rng, frames = np.random.default_rng(1), 24
    time = dt * np.arange(frames)
    poses = np.stack([time, 0.0 * time, turn * (np.arange(frames) >= SWITCH)], axis=-1)
    start = np.stack([rng.uniform(5.0, 10.0, 6), np.linspace(-3.0, 3.0, 6)], axis=-1)
    velocity = np.stack([rng.uniform(0.7, 1.3, 6), rng.normal(0.0, 0.2, 6)], axis=-1)
    places = start + velocity * time[:, None, None]
    boxes = boxes_of(poses, places, TALL, noise=0.3)
    if switched:
        places[SWITCH:, 2] = poses[SWITCH:, :2] + (4.5, 3.5)
        boxes[SWITCH:, 2] = boxes_of(poses, places, TALL + 0.2, noise=0.3)[SWITCH:, 2]
    return Crowd(poses, places, boxes)


@pytest.mark.parametrize("dt", [DT, 0.1])
@pytest.mark.parametrize("known", [True, False])
def test_an_identity_switch_starts_a_new_person_and_does_not_move_the_camera(known: bool, dt: float) -> None:
    """At 10 Hz the switch is between two key frames, of which the second finds it."""
    scene, first = walkers(switched=True, dt=dt), SWITCH + (dt < DT)
    same, other = (Run(6, known=known, changes={"dt": dt}).through(one) for one in (walkers(dt=dt), scene))
    for t in range(first, len(scene.poses)):
        np.testing.assert_allclose(other[t]["pose"], same[t]["pose"], atol=0.03)
        np.testing.assert_allclose(other[t]["places"][2] - other[t]["pose"][:2], (4.5, 3.5), atol=0.4)
    before, after = (other[t]["heights"] for t in (SWITCH - 1, first + 1))
    assert after[2] > before[2] + 0.05
    np.testing.assert_allclose(np.delete(after, 2), np.delete(before, 2), atol=0.01)


@pytest.mark.parametrize("dt", [DT, 0.1])
def test_people_keep_their_heights_when_columns_change(dt: float) -> None:
    """Columns 2 and 3 exchange their people; the person of column 4 is lost for two key frames, then has column 6.

    Feet are so uncertain that boxes of a new person could be of any person from 1.6 to 1.8 m.
    """
    scene = walkers(dt=dt)
    scene.boxes[..., 1] += 0.1 * scene.boxes[..., 2] * np.random.default_rng(3).normal(size=scene.boxes.shape[:2])
    order, lost, joined = np.array([0, 1, 3, 2, 6, 5, 4]), SWITCH + round(2 * max(dt, 0.2) / dt), SWITCH + 6
    places, boxes = (np.insert(array, 6, np.nan, axis=1) for array in (scene.places, scene.boxes))
    boxes[SWITCH:lost, 4] = np.nan
    for array in (places, boxes):
        array[SWITCH:] = array[SWITCH:, order]
    other = Run(7, known=False, changes={"dt": dt}).through(Crowd(scene.poses, places, boxes))
    same = Run(6, known=False, changes={"dt": dt}).through(scene)
    for t in range(joined, len(boxes)):
        expected = np.insert(same[t]["heights"], 6, np.nan)[order]
        np.testing.assert_allclose(other[t]["heights"][[2, 3, 6]], expected[[2, 3, 6]], atol=0.02)


@pytest.mark.parametrize("known", [True, False])
def test_boxes_that_all_jump_at_once_are_of_the_same_people(known: bool) -> None:
    """The camera has turned by 29 degrees."""
    scene = walkers(turn=0.5)
    still, turned = (Run(6, known=known).through(one) for one in (walkers(), scene))
    for one, other in zip(still[SWITCH:], turned[SWITCH:], strict=True):
        np.testing.assert_allclose(other["heights"], one["heights"], atol=0.01)
        relative = [answer["places"] - answer["pose"][:2] for answer in (one, other)]
        np.testing.assert_allclose(*(np.hypot(off[:, 0], off[:, 1]) for off in relative), atol=0.15)


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("dt", [0.1, 0.4])
def test_two_people_with_given_places_find_a_camera_that_saw_nobody_for_half_a_minute(known: bool, dt: float) -> None:
    run, tall, ahead = Run(4, known=known, changes={"dt": dt}), np.full(4, 1.7), np.array([0.5 * dt, 0.0, 0.0])
    stand = np.array([[6.0, 0.0], [7.0, 2.0], [5.0, -2.0], [8.0, 1.0]])
    poses = ahead * np.arange(10)[:, None]
    places = np.broadcast_to(stand, (10, 4, 2))
    run.through(Crowd(poses, places, boxes_of(poses, places, tall, noise=0.5)))
    blind = [run.step()["converged"] for _ in range(round(30.0 / dt))]
    assert not any(blind[round(3.0 / dt) :])
    turn = np.array([[np.cos(2.0), np.sin(2.0)], [-np.sin(2.0), np.cos(2.0)]])
    poses = np.array([[25.0, -12.0, 2.0]]) + np.arange(2)[:, None] * np.append(ahead[:2] @ turn, 0.0)
    places = np.broadcast_to(poses[0, :2] + stand @ turn, (2, 4, 2))
    for boxes, pose, given in zip(boxes_of(poses, places, tall, noise=0.5), poses, (places[0], None), strict=True):
        boxes[1::2] = np.nan
        positions = np.full((3, 4, 2), np.nan)
        if given is not None:
            positions[2, ::2] = given[::2]
        answer = run.step(boxes=boxes, positions=positions)
        assert np.hypot(*(answer["pose"] - pose)[:2]) < 0.5
        assert answer["converged"]


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("dt", [0.1, 0.4])
def test_given_places_correct_a_camera_that_turned_while_it_saw_nobody_for_a_second(known: bool, dt: float) -> None:
    """The yaw is too far off for a descent; bearings of people with given places show it."""
    run, stand = Run(8, known=known, changes={"dt": dt}), np.array([[6.0, 0.0], [7.0, 2.0], [5.0, -2.0], [8.0, 1.0]])
    ahead = np.array([0.5 * dt, 0.0, 0.0])
    poses = ahead * np.arange(20)[:, None]
    places = np.concatenate([stand, np.full((4, 2), np.nan)])
    boxes = boxes_of(poses, np.broadcast_to(places, (20, 8, 2)), np.full(8, 1.7), noise=0.5)
    run.through(Crowd(poses, np.broadcast_to(places, (20, 8, 2)), boxes))
    for _ in range(round(1.2 / dt)):
        run.step()
    turn = np.array([[np.cos(2.4), np.sin(2.4)], [-np.sin(2.4), np.cos(2.4)]])
    poses = poses[-1] + np.array([0.5, 0.0, 2.4]) + np.zeros((round(1.0 / dt), 3))
    places = np.concatenate([np.full((4, 2), np.nan), poses[0, :2] + stand @ turn])
    places = np.broadcast_to(places, (len(poses), 8, 2))
    for t, shown in enumerate(boxes_of(poses, places, np.full(8, 1.7), noise=0.5)):
        positions = np.full((3, 8, 2), np.nan)
        if t == 0:
            positions[2, 4:7] = places[0, 4:7]
        answer = run.step(boxes=np.ascontiguousarray(shown), positions=positions)
    assert np.hypot(*(answer["pose"] - poses[-1])[:2]) < 0.3
    assert abs(answer["pose"][2] - 2.4) < 0.1


@pytest.mark.parametrize("known", [True, False])
def test_places_given_between_key_frames_are_those_of_the_frame_and_the_next_key_frame_uses_them(known: bool) -> None:
    rate, still = 30, np.tile([3.0, 1.0, 2.0], (14, 1))
    places = np.broadcast_to(still[0, :2] + [[-1.0, 6.0], [-4.0, 5.0], [-3.0, 8.0]], (14, 3, 2))
    run = Run(3, known=known, changes={"dt": 1.0 / rate})
    for t, boxes in enumerate(boxes_of(still, places, np.full(3, 1.9))):
        poses, positions = np.full((3, 3), np.nan), np.full((3, 3, 2), np.nan)
        if t == 0:
            poses[2], positions[2, :2] = still[0], places[0, :2]
        if t == 10:  # key frames are 0, 6, 12; a tall person would seem to be nearer
            positions[2, 2] = places[t, 2]
        boxes[2 if t < 10 else 3 :] = np.nan
        answer = run.step(boxes=boxes, poses=poses, positions=positions)
        if t == 10:
            np.testing.assert_array_equal(answer["places"][2], places[t, 2])
    assert np.hypot(*(answer["places"][2] - places[-1, 2])) < 0.3


def drive(seed: int, rate: int, seconds: float, speed: float, people: int) -> Crowd:
    """A camera that drives along a street, and people who walk and stand on both sides of it.

    The errors of boxes, 2 % of their heights, are correlated in time. They are the same at all rates that divide 30 Hz.
    """
    rng, frames = np.random.default_rng(seed), round(30 * seconds) + 1
    time = np.arange(frames) / 30.0
    poses = np.stack([speed * time, 0.0 * time, 0.0 * time], axis=-1)
    aside = rng.uniform(2.0, 7.0, people) * rng.choice([-1, 1], people)
    start = np.stack([rng.uniform(4.0, speed * seconds + 25.0, people), aside], axis=-1)
    pace = rng.choice([-1.3, 0.0, 1.3], people) * rng.uniform(0.8, 1.1, people)
    velocity = np.stack([pace, rng.normal(0.0, 0.05, people)], axis=-1)
    places = start + velocity * time[:, None, None]
    boxes = boxes_of(poses, places, rng.normal(1.7, 0.07, people))
    memory = np.exp(-1.0 / 30.0 / np.array([0.4, 3.0, 3.0]))[:, None]
    errors = np.zeros((frames, 3, people))
    errors[0] = rng.normal(size=(3, people))
    for t in range(1, frames):
        errors[t] = memory * errors[t - 1] + np.sqrt(1.0 - memory**2) * rng.normal(size=(3, people))
    length = boxes[..., 2]
    boxes[..., :2] += 0.02 * length[..., None] * np.moveaxis(errors[:, ::2], 1, -1)
    boxes[..., 2] = boxes[..., 4] = length * np.exp(0.02 * errors[:, 1])
    boxes[..., 3] = FOCAL * boxes[..., 2]
    offset = places - poses[:, None, :2]
    unseen = (offset[..., 0] < 1.5) | (np.abs(boxes[..., 0]) > 0.9) | (np.hypot(offset[..., 0], offset[..., 1]) > 25.0)
    boxes[unseen] = np.nan
    every = 30 // rate
    return Crowd(poses[::every], places[::every], np.ascontiguousarray(boxes[::every]))


def driven(scene: Crowd, rate: int, carrier: Carrier) -> list[dict[str, Any]]:
    """Answers to a drive, whose first .4 s are given."""
    stated = {"dt": 1.0 / rate, "carrier": CARRIERS.index(carrier), "box_edge": 0.0, "box_std": 0.02}
    given = round(0.4 * rate) + 1
    return Run(scene.places.shape[1], known=False, changes=stated).through(scene, given=given, poses_given=given)


@pytest.mark.parametrize("carrier", ["unknown", "vehicle"])
@pytest.mark.parametrize("seed", [0, 1])
def test_a_vehicle_is_followed(carrier: Carrier, seed: int) -> None:
    scene = drive(seed, 10, 10.0, 8.0, 40)
    answers = driven(scene, 10, carrier)
    assert np.hypot(*(answers[-1]["pose"] - scene.poses[-1])[:2]) < 0.03 * 80.0
    assert all(answer["converged"] for answer in answers)


def test_nobody_who_walks_is_as_fast_as_a_vehicle() -> None:
    answers = driven(drive(0, 10, 3.0, 8.0, 40), 10, "person")
    assert not any(answer["converged"] for answer in answers[5:])


@pytest.mark.parametrize("known", [True, False])
def test_people_who_all_run_faster_than_they_can_are_not_converged(known: bool) -> None:
    frames = 12
    poses = np.zeros((frames, 3))
    away = 6.0 * DT * np.arange(frames)
    places = np.array([[5.0, -2.0], [7.0, 0.0], [6.0, 2.0]]) + np.stack([away, 0.0 * away], axis=-1)[:, None]
    scene = Crowd(poses, places, boxes_of(poses, places, np.full(3, 1.7)))
    answers = Run(3, known=known).through(scene, given=frames, poses_given=frames)
    assert not any(answer["converged"] for answer in answers[2:])


def test_a_runner_whose_place_jumps_leaves_the_cost_finite() -> None:
    frames = 16
    poses, ahead = np.zeros((frames, 3)), 3.5 * DT * np.arange(frames) + 20.0 * (np.arange(frames) >= 14)
    places = np.stack([5.0 + ahead, np.ones(frames)], axis=-1)[:, None]
    run = Run(1)
    run.through(Crowd(poses, places, boxes_of(poses, places, np.full(1, 1.7))), given=frames, poses_given=frames)
    assert np.isfinite(run.core.cost())


@pytest.mark.slow
def test_a_higher_frame_rate_does_not_increase_errors() -> None:
    errors = np.zeros((4, 2))
    for row, rate in enumerate((5, 10, 15, 30)):
        for seed in range(5):
            scene = drive(seed, rate, 6.0, 1.5, 16)
            answers = driven(scene, rate, "robot")
            poses, places = (np.stack([answer[name] for answer in answers]) for name in ("pose", "places"))
            off, away = (poses - scene.poses)[:, :2], (places - scene.places)[~np.isnan(scene.boxes[..., 0])]
            errors[row] += np.hypot(*off.T).mean(), np.hypot(*away.T).mean()
    assert np.all(errors[1:] < 1.1 * errors[0])


def square(seed: int, frames: int = 40, people: int = 10) -> Truth:
    """A camera that walks along x, and people who stand or walk along x either way."""
    rng, time = np.random.default_rng(seed), DT * np.arange(frames)
    poses = np.stack([1.2 * time, 0.0 * time, 0.0 * time], axis=-1)
    aside = rng.uniform(1.5, 7.0, people) * rng.choice([-1, 1], people)
    start = np.stack([rng.uniform(2.0, 20.0, people), aside], axis=-1)
    velocity = np.stack([rng.choice([-1.3, 0.0, 1.3], people), rng.normal(0.0, 0.1, people)], axis=-1)
    positions = start + velocity * time[:, None, None] + rng.normal(0.0, 0.01, (frames, people, 2))
    return Truth(poses=poses, positions=positions, heights=rng.normal(1.7, 0.07, people))


@pytest.mark.slow
def test_boxes_of_later_frames_help_and_come_with_covariances() -> None:
    protocol, errors, squares = get_protocol("rollout"), np.zeros((2, 2)), []
    for seed in range(6):
        truth = square(seed)
        sequence = see(truth, CAMERAS[0], 3.0, seed)
        problem = problem_of(sequence, CAMERAS[0], 3.0, covariances=True)
        for row, make in enumerate((MapCausal, MapBatch)):
            found = run_sequence(make(), problem, sequence, protocol, None)[0]
            off, moved = (found.positions - truth.positions)[2:], (found.poses - truth.poses)[2:, :2]
            errors[row] += np.hypot(*np.moveaxis(off, -1, 0)).mean(), np.hypot(*moved.T).mean()
        for spreads in (found.pose_covariances[2:], found.position_covariances[2:]):
            assert np.linalg.eigvalsh(spreads).min() > 0.0
        inverse = np.linalg.inv(found.position_covariances[2:])
        squares.append(0.5 * np.einsum("tki,tkij,tkj->tk", off, inverse, off).mean())
    assert np.all(errors[1] < 0.95 * errors[0])
    assert 0.2 < np.mean(squares) < 2.0


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("dt", [DT, 1.0 / 15.0])
def test_a_copy_of_an_estimator_goes_on_as_it_does(known: bool, dt: float) -> None:
    scene, runs = crowd(20, 5, noise=2.0), [Run(5, known=known, covariances=True, size=8, changes={"dt": dt})]
    runs[0].through(Crowd(scene.poses[:12], scene.places[:12], scene.boxes[:12]))
    runs += [deepcopy(runs[0]), pickle.loads(pickle.dumps(runs[0]))]  # noqa: S301
    for boxes in scene.boxes[12:]:
        first, *others = (run.step(boxes=boxes) for run in runs)
        for other in others:
            for name in ("pose", "pose_covariance", "places", "place_covariances", "heights"):
                np.testing.assert_array_equal(other[name], first[name])


def test_a_state_of_another_version_is_refused() -> None:
    state = Run(2).core.__getstate__()
    for wrong in (b"", state[:-8], state + bytes(8)):
        with pytest.raises(VbbenchError, match="the state is not that of an estimator of this version"):
            Estimator.__new__(Estimator).__setstate__(wrong)


@pytest.mark.parametrize("seed", range(3))
def test_a_head_that_turns_at_once_does_not_move_the_camera(seed: int) -> None:
    made = crowd(12, 2, seed=seed)
    poses = made.poses + np.array([0.0, 0.0, -0.35]) * (np.arange(12) >= 8)[:, None]
    scene = Crowd(poses, made.places, boxes_of(poses, made.places, np.full(2, 1.7)))
    answers = Run(2, known=False).through(scene)
    off = np.array([answer["pose"] for answer in answers])[8:] - poses[8:]
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.4
    assert np.abs(off[:, 2]).max() < 0.06


def test_given_places_that_contradict_a_box_do_not_send_the_camera_away() -> None:
    """A person appears, is seen ahead, and is given a place 40 m behind the camera."""
    scene, run = crowd(13, 2), Run(2, known=False)
    for t, boxes in enumerate(scene.boxes):
        poses, positions = NOWHERE.copy(), np.full((3, 2, 2), np.nan)
        poses[2] = scene.poses[t] if t < 2 else np.nan
        positions[2, 0] = scene.places[t, 0] if t < 2 else np.nan
        if t == 12:
            positions[2, 1] = scene.poses[t, :2] - (40.0, 0.0)
        seen = np.where(np.arange(2)[:, None] <= (t == 12), boxes, np.nan)
        answer = run.step(boxes=seen, poses=poses, positions=positions)
    assert np.hypot(*(answer["pose"] - scene.poses[-1])[:2]) < 50.0


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("dt", [0.1, 0.067])
def test_with_all_frames_before_given_each_frame_is_as_good_as_a_key_frame(dt: float, known: bool) -> None:
    """Key frames are .2 s apart; what is given up to the last frame holds in those between, too."""
    frames, rng = 16, np.random.default_rng(5)
    poses = np.stack([1.2 * dt * np.arange(frames), np.zeros(frames), 0.2 * dt * np.arange(frames)], axis=-1)
    places = (
        np.array([[6.0, -2.0], [8.0, 1.0], [7.0, 2.5]]) + np.array([0.9, 0.3]) * dt * np.arange(frames)[:, None, None]
    )
    boxes = boxes_of(poses, places, np.full(3, 1.7), noise=1.0, rng=rng)
    run = Run(3, known=known, changes={"dt": dt})
    for t in range(frames):
        given, positions = NOWHERE.copy(), np.full((3, 3, 2), np.nan)
        for back in (1, 2):
            if t >= back:
                given[2 - back], positions[2 - back] = poses[t - back], places[t - back]
        answer = run.step(boxes=np.ascontiguousarray(boxes[t]), poses=given, positions=positions)
        if t > 3:
            assert np.abs(answer["pose"] - poses[t]).max() < 0.03
            assert np.hypot(*(answer["places"] - places[t]).T).max() < 0.06


@pytest.mark.parametrize(
    ("carrier", "rate", "speed", "most"),
    [
        ("person", 10, 0.0, 0.1),
        ("person", 10, 0.7, 0.4),
        *((carrier, rate, 1.3, 0.8) for carrier in ("person", "unknown") for rate in (5, 10)),
    ],
)
def test_a_camera_that_stands_strolls_or_moves_evenly_is_followed(
    carrier: Carrier, rate: int, speed: float, most: float
) -> None:
    """Where it moves evenly its yaw does not change, which heads hardly do; only people's speed speaks for motion."""
    off, stated = [], {"dt": 1.0 / rate, "carrier": CARRIERS.index(carrier), "box_edge": 0.0, "box_std": 0.02}
    for seed in range(5):
        scene = drive(seed, rate, 6.0, speed, 24)
        answers = Run(24, known=False, changes=stated).through(scene, given=0, poses_given=1)
        off.append(np.hypot(*(answers[-1]["pose"] - scene.poses[-1])[:2]))
    assert np.median(off) < most


def strollers(seed: int, speed: float) -> Crowd:
    """Thirty people who walk every way at about a speed in m/s, and a camera that passes them at .8 m/s."""
    rng, people, frames = np.random.default_rng(seed), 30, 20
    time = DT * np.arange(frames)
    poses = np.stack([0.8 * time, 0.1 * np.sin(time), 0.05 * np.sin(1.3 * time)], axis=-1)
    start = np.stack([rng.uniform(4.0, 22.0, people), rng.uniform(-6.0, 6.0, people)], axis=-1)
    way, fast = rng.uniform(0.0, 2.0 * np.pi, people), speed * rng.normal(1.0, 0.25, people)
    velocity = fast[:, None] * np.stack([np.cos(way), np.sin(way)], axis=-1)
    stray = rng.normal(0.0, 0.03, (frames, people, 2)).cumsum(axis=0)
    places = start + velocity * time[:, None, None] + stray
    boxes = boxes_of(poses, places, rng.normal(1.7, 0.07, people), noise=0.5, rng=rng)
    boxes[(places - poses[:, None, :2])[..., 0] < 1.5] = np.nan
    return Crowd(poses, places, boxes)


@pytest.mark.parametrize("speed", [0.8, 1.3])
def test_a_crowd_that_strolls_is_not_taken_for_one_that_flows(speed: float) -> None:
    """The prior of speed is that of walkers; the mean of a crowd is learned."""
    off = []
    for seed in range(5):
        scene = strollers(seed, speed)
        answers = Run(30).through(scene, given=0, poses_given=1)
        off.append(np.hypot(*(answers[-1]["pose"] - scene.poses[-1])[:2]))
    assert np.median(off) < 1.5


@pytest.mark.parametrize("rate", [15, 30])
def test_values_that_are_given_between_key_frames_count(rate: int) -> None:
    """Key frames are .2 s apart; the second pose and place of each follow the first one at once."""
    for seed in range(3):
        scene = drive(seed, rate, 2.0, 1.5, 16)
        stated = {"dt": 1.0 / rate, "box_edge": 0.0, "box_std": 0.02}
        answers = Run(16, known=False, changes=stated).through(scene)
        assert np.hypot(*(answers[rate // 2]["pose"] - scene.poses[rate // 2])[:2]) < 0.06


def street(seed: int) -> Crowd:
    """A camera walks along a street for 14 s; 24 people walk along it, both ways, each in sight for 3 s."""
    rng, people, frames, step = np.random.default_rng(seed), 24, 70, 0.2
    time = step * np.arange(frames)
    poses = np.stack([1.3 * time, 0.0 * time, 0.0 * time], axis=-1)
    first = rng.uniform(-2.0, 12.5, people)  # s
    speed = rng.choice([-1.0, 1.0], people) * rng.normal(1.3, 0.2, people)
    start = np.stack([1.3 * first + rng.uniform(5.0, 12.0, people), rng.uniform(-5.0, 5.0, people)], axis=-1)
    age, stray = time[:, None] - first, rng.normal(0.0, 0.1, (frames, people, 2)).cumsum(axis=0)
    places = start + np.stack([speed * age, np.zeros_like(age)], axis=-1) + step * stray.cumsum(axis=0)
    boxes = boxes_of(poses, places, rng.normal(1.7, 0.07, people), rng=rng)
    error = rng.normal(0.0, 0.08, (3, frames, people))
    for t in range(1, frames):
        error[:, t] = 0.6 * error[:, t - 1] + 0.8 * error[:, t]
    boxes[..., 0] += boxes[..., 4] * error[0]
    boxes[..., 1] += boxes[..., 2] * error[1]
    boxes[..., 2:] *= np.exp(error[2])[..., None]
    boxes[(age < 0.0) | (age > 3.0) | ((places - poses[:, None, :2])[..., 0] < 2.0)] = np.nan
    return Crowd(poses, places, boxes)


def test_directions_of_people_along_a_street_keep_the_heading() -> None:
    """Without an axis, which a weight of its share of 0 removes, the camera leaves the street by more."""
    stated = {"dt": 0.2, "carrier": CARRIERS.index("person"), "box_edge": 0.0}
    off = np.zeros((2, 32))
    for i, without in enumerate(({}, {"axis_share": 1e-9, "axis_weight": 1e9})):
        for seed in range(32):
            run = Run(24, known=False, changes=stated, **without)
            off[i, seed] = abs(run.through(street(seed), given=0, poses_given=1)[-1]["pose"][1])
    assert off[0].mean() < 0.95 * off[1].mean()
