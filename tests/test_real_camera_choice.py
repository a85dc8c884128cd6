"""Which cameras are solved as rough ones: those that the problem calls so, and those whose feet say it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.rough_crowd import DT, LEVEL, TILTED, Drive, drive, made_drive, photograph
from vbbench.camera import Camera, PerspectiveCamera
from vbbench.geometry import BoolArray
from vbbench.sequence import Truth
from vbbench.solving.runner import given_at
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.real_camera.choice import FEWEST, LOOKS, PATIENT, RoughCamera, is_rough, is_told
from vbbench_baselines.joint_map.real_camera.settings import Settings
from vbbench_baselines.joint_map.real_camera.tracking import Tracking

SETTINGS = Settings(window=4)


def rough(made: Drive) -> bool:
    """Whether the camera is taken for a rough one; by the whole sequence as frame by frame."""
    sequence = made.sequence
    whole = is_rough(made.problem, sequence.observations, sequence.given)
    choice = RoughCamera(SETTINGS, made.problem)
    answers = [choice.step(sequence.observations[t], given_at(sequence.given, t)) is not None for t in range(4)]
    assert answers == [is_told(made.problem), whole, whole, whole]
    return whole


def exact(truth: Truth, camera: Camera, pixel_std: float, seed: int = 0) -> Drive:
    """As the generator draws it: people as thin as poles, and noise in px alone, which the problem tells."""
    boxes = photograph(truth, camera, 0.0, pixel_std=pixel_std, edge=0.0, seed=seed)
    return made_drive(truth, boxes, box_std=0.0, pixel_std=pixel_std)


@pytest.mark.parametrize("fact", ["tilt_std", "mount_height_std", "box_std"])
def test_a_problem_can_tell(fact: str) -> None:
    """Then it is a rough one from the first frame on, however exact its boxes."""
    made = exact(drive(0), LEVEL, 0.0)
    assert not is_told(made.problem)
    assert rough(replace(made, problem=replace(made.problem, **{fact: 0.01})))


@pytest.mark.parametrize(
    "tilt", [{"pitch": 0.04}, {"pitch": -0.04}, {"pitch": 0.02, "roll": 0.01}, {"mount_height": 1.8}]
)
@pytest.mark.parametrize("pixel_std", [0.0, 1.0, 4.0])
def test_feet_of_given_people_tell(tilt: dict[str, float], pixel_std: float) -> None:
    for seed in range(5):
        assert rough(exact(drive(seed, frames=5), PerspectiveCamera(**tilt), pixel_std, seed))


@pytest.mark.parametrize("pixel_std", [0.0, 1.0, 4.0])
def test_noise_alone_does_not(pixel_std: float) -> None:
    """Nor does the same crowd seen by a camera that is tilted as its calibration says."""
    for seed in range(20):
        assert not rough(exact(drive(seed, frames=5), LEVEL, pixel_std, seed))
    made = exact(drive(0, frames=5), TILTED, pixel_std)
    assert not rough(replace(made, problem=replace(made.problem, camera=TILTED)))


@pytest.mark.parametrize("share", [0.15, 0.3])
def test_hidden_feet_do_not(share: float) -> None:
    """A box whose lower part is hidden ends too high; such are few."""
    for seed in range(10):
        truth, rng = drive(seed, frames=5), np.random.default_rng(seed)
        boxes = photograph(truth, LEVEL, 0.0, pixel_std=2.0, edge=0.0, seed=seed)
        hidden = rng.uniform(0.2, 0.6, boxes.shape[:2]) * (rng.random(boxes.shape[:2]) < share) * boxes[..., 2]
        boxes -= np.stack((np.zeros_like(hidden), 0.5 * hidden, hidden), axis=-1)
        assert not rough(made_drive(truth, boxes, box_std=0.0, pixel_std=2.0))


def test_boxes_that_are_wrong_do_not() -> None:
    """A third of them anywhere."""
    for seed in range(10):
        truth, rng = drive(seed, frames=5), np.random.default_rng(seed)
        boxes = photograph(truth, LEVEL, 0.0, pixel_std=1.0, edge=0.0, seed=seed)
        boxes[..., 1] += rng.uniform(-80.0, 80.0, boxes.shape[:2]) * (rng.random(boxes.shape[:2]) < 0.33)
        assert not rough(made_drive(truth, boxes, box_std=0.0))


def test_boxes_at_the_border_and_too_few_do_not() -> None:
    truth = drive(0, frames=5)
    boxes = photograph(truth, LEVEL, 0.0, edge=0.0)
    boxes[..., 2] = 2.0 * (LEVEL.height - 1.0 - boxes[..., 1])  # all end at the last row
    assert not rough(made_drive(truth, boxes, box_std=0.0))
    alone = drive(0, frames=5, people=1)
    few = exact(alone, PerspectiveCamera(pitch=0.05), 0.0)
    assert np.count_nonzero(few.sequence.observed[:LOOKS]) < FEWEST
    assert not rough(few)


def cold(made: Drive, seen: BoolArray | None = None) -> Drive:
    """With nothing given but the first pose; ``seen`` [T, K]: whose boxes are left."""
    given = replace(made.sequence.given, positions=np.full_like(made.sequence.given.positions, np.nan))
    given = given.keeping(np.arange(len(given.poses)) == 0, np.zeros(given.positions.shape[:2], np.bool_))
    boxes = made.sequence.observations
    boxes = boxes if seen is None else np.where(seen[..., None], boxes, np.nan)
    return replace(made, sequence=replace(made.sequence, given=given, observations=boxes))


def test_after_a_cold_start_the_heights_tell_that_feet_imply() -> None:
    for pitch in (0.06, 0.0):
        assert rough(cold(exact(drive(1, frames=5), PerspectiveCamera(pitch=pitch), 1.0))) == (pitch > 0.0)


def found_at(made: Drive) -> int | None:
    """The first frame from which on the camera is taken for a rough one; by the whole sequence likewise, if ever."""
    sequence, choice = made.sequence, RoughCamera(SETTINGS, made.problem)
    steps = [choice.step(boxes, given_at(sequence.given, t)) for t, boxes in enumerate(sequence.observations)]
    rough = [step is not None for step in steps]
    assert rough == sorted(rough), "once found, it stays"
    assert any(rough) == is_rough(made.problem, sequence.observations, sequence.given)
    return rough.index(True) if any(rough) else None


@pytest.mark.parametrize("others", [0, 1])
def test_after_a_cold_start_it_is_found_once_somebody_is_in_sight(others: int) -> None:
    """Robots are switched on where nobody, or one person, is in sight."""
    frames, alone = 20, 12
    for pitch in (0.06, 0.0):
        made = exact(drive(2, frames=frames), PerspectiveCamera(pitch=pitch), 1.0)
        seen = (np.arange(frames)[:, None] >= alone) | (np.arange(len(made.sequence.tracks)) < others)
        found = found_at(cold(made, seen))
        assert found is None if pitch == 0.0 else found is not None and found <= alone + 1


def test_where_nobody_ever_told_it_is_a_rough_one() -> None:
    made = exact(drive(2, frames=PATIENT + 3), LEVEL, 1.0)
    seen = np.zeros(made.sequence.observations.shape[:2], np.bool_)
    assert found_at(cold(made, seen)) == PATIENT - 1
    assert found_at(cold(made, ~seen)) is None


def test_frames_before_it_was_found_are_gone_through_again() -> None:
    """The answers are then those of a camera that is told to be a rough one, columns that stood for others included."""
    made = exact(drive(2, frames=20), PerspectiveCamera(pitch=0.06), 1.0)
    frames, people = made.sequence.observations.shape[:2]
    late = cold(made, np.broadcast_to(np.arange(frames)[:, None] >= 8, (frames, people)))
    choice, tracking = RoughCamera(SETTINGS, made.problem), Tracking(SETTINGS, made.problem)
    for t, boxes in enumerate(late.sequence.observations):
        given = given_at(late.sequence.given, t)
        if t in (5, 6, 8):
            for solver in (choice, tracking):
                solver.forget(np.arange(t - 5, t - 3))
        expected, found = tracking.step(boxes, given), choice.step(boxes, given)
        assert found is None or np.array_equal(found.pose, expected.pose)
    assert found is not None


def test_without_settings_every_camera_is_exact() -> None:
    """So it is for the variants that take feet or the bearer's walk out."""
    made = made_drive(drive(0, frames=5))
    assert RoughCamera(None, made.problem).step(made.sequence.observations[0], given_at(made.sequence.given, 0)) is None
    for options in ({"feet": False}, {"ego_prior": False}, {"real": None}):
        assert MapCausal(**options).settings is None  # type: ignore[arg-type]


def test_the_solvers_answer_as_the_choice_says() -> None:
    """They differ from those that take every camera for exact where it is a rough one, and only there."""
    for camera, differs in ((TILTED, True), (LEVEL, False)):
        made = exact(drive(3, frames=8, people=8), camera, 1.0)
        for make in (MapCausal, MapBatch):
            answer, plain = made.solved(make), made.solved(lambda make=make: make(real=None))
            assert (not np.array_equal(answer.poses, plain.poses)) == differs


def test_one_frame_and_none_are_no_contradiction() -> None:
    made = exact(drive(0, frames=5), TILTED, 1.0)
    for frames in (0, 1):
        given = made.sequence.given.frames(slice(frames))
        assert not is_rough(made.problem, made.sequence.observations[:frames], given)
    assert made.problem.dt == DT
