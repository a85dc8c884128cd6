"""The estimator in C++: its gradients, its elimination, its marginal priors, and what its binding refuses."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench_baselines._core import Estimator

DT, MOUNT, FOCAL = 0.4, 1.6, 600.0
NOWHERE = np.full((3, 3), np.nan)


@dataclass(frozen=True)
class Crowd:
    """A camera that walks along x, and people who walk as straight: poses [T, 3], places [T, K, 2], boxes [T, K, 5]."""

    poses: FloatArray
    places: FloatArray
    boxes: FloatArray


def crowd(frames: int, people: int, *, noise: float = 0.5, edge: float = 0.0, seed: int = 0) -> Crowd:
    rng = np.random.default_rng(seed)
    time = DT * np.arange(frames)
    poses = np.stack([1.2 * time, 0.3 * np.sin(0.2 * time), 0.1 * np.sin(0.3 * time)], axis=-1)
    start = np.stack([rng.uniform(4.0, 10.0, people), rng.uniform(-3.0, 3.0, people)], axis=-1)
    velocity = np.stack([rng.uniform(0.6, 1.5, people), rng.normal(0.0, 0.2, people)], axis=-1)
    steps = rng.normal(0.0, 0.01, (frames, people, 2)).cumsum(axis=0)
    places = start + velocity * time[:, None, None] + steps
    heights = rng.normal(1.7, 0.07, people)
    offset = places - poses[:, None, :2]
    distance = np.hypot(offset[..., 0], offset[..., 1])
    angle = np.arctan2(offset[..., 1], offset[..., 0]) - poses[:, None, 2]
    pixels = noise / FOCAL * rng.normal(size=(3, frames, people))
    length = heights / (distance - edge) + pixels[0] - pixels[1]
    boxes = np.stack(
        [-angle + pixels[2], MOUNT / (distance - edge) + pixels[0], length, FOCAL * length, length], axis=-1
    )
    return Crowd(poses, places, boxes)


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

    def __init__(self, people: int, *, known: bool = True, covariances: bool = False, **constants: float) -> None:
        self.core = Estimator()
        for name, value in constants.items():
            self.core.set(name, value)
        self.core.start(facts(people, known=known, covariances=covariances))
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
@pytest.mark.parametrize("size", [6, 20])
def test_gradients_of_all_rows_are_those_of_the_cost(known: bool, size: int) -> None:
    run = Run(5, known=known, size=size)
    run.through(crowd(12, 5, edge=0.0 if known else 0.2))
    names = ("path", "height", "own edge", "calibration", "camera")
    errors = dict(zip(names, run.core.gradient_errors(), strict=True))
    assert all(error < 1e-3 for error in errors.values()), errors


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
@pytest.mark.parametrize(("people", "frames", "size"), [(3, 5, 20), (3, 12, 6)])
def test_elimination_takes_the_step_of_the_dense_system(people: int, frames: int, size: int, known: bool) -> None:
    run = Run(people, known=known, size=size, rounds=1.0)
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
    scene = crowd(18, 6)
    short, whole = (Run(6, size=size).through(scene) for size in (6, 20))
    for one, other in zip(short, whole, strict=True):
        np.testing.assert_allclose(one["pose"], other["pose"], atol=0.15)
        np.testing.assert_allclose(one["places"], other["places"], atol=0.4)  # 5 to 13 m away
    np.testing.assert_allclose(short[-1]["pose"], scene.poses[-1], atol=0.5)
    np.testing.assert_allclose(short[-1]["places"], scene.places[-1], atol=0.5)


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


@pytest.mark.parametrize("columns", [[3], [-1]])
def test_columns_that_are_not_there_cannot_be_forgotten(columns: list[int]) -> None:
    with pytest.raises(VbbenchError, match="columns must be from 0 to 2"):
        Run(3).core.forget(np.array(columns, np.int32))
