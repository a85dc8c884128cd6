"""Footage: recordings of real cameras as datasets, whatever is known of their truth."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vbbench.camera import PerspectiveCamera
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import Pictures
from vbbench.files.verification import verify
from vbbench.generation.datasets import write_dataset
from vbbench.generation.footage import Footage, FootageOptions, joined_odometry
from vbbench.generation.generator import Card, Options
from vbbench.geometry import relative_to_world, world_to_relative
from vbbench.scene import Scene
from vbbench.scoring import score
from vbbench.sequence import NOBODY, Odometry
from vbbench.solving import solve
from vbbench_generators.footage.argoverse2 import argoverse2
from vbbench_generators.footage.jrdb.split import jrdb
from vbbench_generators.footage.kitti.split import kitti
from vbbench_generators.footage.motsynth import motsynth
from vbbench_generators.footage.nuscenes import nuscenes
from vbbench_generators.footage.own import own
from vbbench_generators.footage.split import FootageSplit, Recordings

CARD = Card(name="walk", title="A walk", licence="CC0", citation="-", sources=())
FRAMES, PEOPLE = 30, 5


def recording(name: str = "one", mount_height: float = 1.5, **changes: Any) -> Footage:
    """Somebody walks forward among people who cross, and one track without a person."""
    rng, time = np.random.default_rng(len(name)), 0.4 * np.arange(FRAMES)
    camera = PerspectiveCamera(mount_height=mount_height)
    poses = np.stack([0.5 * time, 0.1 * time, 0.02 * time], axis=-1)
    start = rng.uniform([8.0, -4.0], [14.0, 4.0], (PEOPLE, 2))
    people = start + time[:, None, None] * rng.normal(0.0, 0.3, (PEOPLE, 2))
    heights = rng.normal(1.72, 0.05, PEOPLE)
    boxes = camera.project(world_to_relative(people, poses), np.broadcast_to(heights, people.shape[:2]))
    boxes[:4, 0] = np.nan
    boxes = np.concatenate([boxes, boxes[:, -1:] + 30.0], axis=1)
    persons = np.where(np.isnan(boxes[..., 2]), NOBODY, np.append(np.arange(PEOPLE), NOBODY) * 10)
    persons[:, -1] = NOBODY
    facts: dict[str, Any] = {
        "poses": poses,
        "scene": Scene(name=name, dt=0.4, people=10 * np.arange(PEOPLE), positions=people, heights=heights),
        "persons": persons,
    }
    return Footage(
        name=name,
        camera=camera,
        dt=0.4,
        tracks=np.arange(PEOPLE + 1),
        boxes=boxes,
        visible=np.where(np.isnan(boxes[..., 2]), np.nan, 1.0),
        **{**facts, **changes},
    )


def relative(one: Footage) -> Footage:
    """The same where only the places from the camera are known."""
    assert one.scene is not None
    assert one.poses is not None
    scene = replace(one.scene, positions=world_to_relative(one.scene.positions, one.poses))
    return replace(one, poses=None, scene=scene)


@dataclass(frozen=True, kw_only=True)
class Walk(FootageSplit):
    """Recordings of the tests."""

    card: Card = CARD
    found: tuple[Footage, ...] = ()

    def recordings(self, options: Options) -> Recordings:
        """They are made here."""
        return Recordings(footage=self.found, definition={})


def made(folder: Any, *found: Footage, **options: Any) -> Dataset:
    return write_dataset(Walk(found=found).plan(Options(**options)), folder)


def test_cameras_may_differ_from_sequence_to_sequence(tmp_path):
    dataset = made(tmp_path / "d", recording("one", 1.5), recording("two", 1.2))
    assert [camera.mount_height for camera in dataset.info.cameras] == [1.5, 1.2]
    assert [dataset.camera(sequence).mount_height for sequence in dataset.sequences()] == [1.5, 1.2]
    assert [dataset.problem(sequence).camera.mount_height for sequence in dataset.sequences()] == [1.5, 1.2]
    assert "are as written" in verify(tmp_path / "d")
    for sequence in dataset.sequences():
        truth = dataset.truth(sequence)
        nobody = (dataset.track_persons(sequence) == NOBODY).all(axis=0)
        assert nobody.sum() == 1
        assert np.isnan(truth.positions[:, nobody]).all()
        assert sequence.observed[:, nobody].any()
        heights = truth.heights[~nobody]
        again = dataset.camera(sequence).project(
            world_to_relative(truth.positions[:, ~nobody], truth.poses),
            np.broadcast_to(heights, truth.positions.shape[:1] + heights.shape),
        )
        seen = sequence.observed[:, ~nobody]
        np.testing.assert_allclose(again[seen], sequence.observations[:, ~nobody][seen])


def test_whole_footage_is_solved_and_scored_like_any_dataset(tmp_path):
    dataset = made(tmp_path / "d", recording())
    for protocol in ("one-step", "sequential", "rollout"):
        figures = score(solve(dataset, "cv", protocol, tmp_path / protocol), tmp_path / "d").values()["metrics"]
        assert figures["dx"]["mean"] < 1.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("known", "changes", "missing"),
    [
        ("poses", {"scene": None, "persons": None}, {"dx", "dx_rel"}),
        ("none", {"scene": None, "persons": None, "poses": None}, {"dx", "dx_rel", "dr", "dt"}),
        ("relative", None, {"dx", "dr", "dt"}),
    ],
)
def test_what_is_not_known_is_not_scored_and_said(tmp_path, known, changes, missing):
    one = relative(recording()) if changes is None else recording(**changes)
    dataset = made(tmp_path / "d", one)
    assert (dataset.info.truth, Dataset(tmp_path / "d").info.id) == (known, dataset.info.id)
    verify(tmp_path / "d")
    with pytest.raises(VbbenchError, match="use cold-start"):
        solve(dataset, "cv", "sequential", tmp_path / "no")
    answer = solve(dataset, f"{__name__}:Still", "cold-start", tmp_path / "a")
    if known == "none":
        with pytest.raises(VbbenchError, match="has no true poses"):
            score(answer, tmp_path / "d")
        return
    result = score(answer, tmp_path / "d")
    assert {name for name, figure in result.values()["metrics"].items() if figure["mean"] is None} == missing
    assert "not known" in result.table()
    assert result.values()["truth"] == known
    assert (
        "not known"
        not in score(solve(made(tmp_path / "w", recording()), "cv", "rollout", tmp_path / "b"), tmp_path / "w").table()
    )


def test_relative_errors_without_poses_are_those_with_them_up_to_the_turn(tmp_path):
    whole = recording(poses=np.zeros((FRAMES, 3)))
    answers = []
    for name, one in (("whole", whole), ("relative", relative(whole))):
        dataset = made(tmp_path / name, one)
        answers.append(
            score(solve(dataset, f"{__name__}:Still", "cold-start", tmp_path / f"{name}-a"), tmp_path / name)
        )
    np.testing.assert_allclose(answers[0].summaries["dx_rel"].mean, answers[1].summaries["dx_rel"].mean)
    assert answers[0].summaries["dx_rel"].mean > 0.01


class Still:
    """Stands where it was first and places people where their boxes are at the mean height."""

    def start(self, problem: Any) -> None:
        self.problem = problem

    def step(self, frame: Any) -> Any:
        from vbbench.estimate import FrameEstimate

        self.start_pose = frame.given.poses[2] if frame.index == 0 else self.start_pose
        pose = np.array(self.start_pose)
        heights = np.full(len(frame.observations), self.problem.height_mean)
        places = relative_to_world(self.problem.camera.unproject(frame.observations, heights), pose)
        return FrameEstimate(pose=pose, positions=places)


@pytest.mark.slow
def test_odometry_reaches_solvers_frame_by_frame(tmp_path):
    motions = np.full((FRAMES, 3), np.nan)
    motions[1:] = np.arange(3 * (FRAMES - 1)).reshape(-1, 3)
    covariances = np.einsum("t,ij->tij", np.arange(FRAMES), np.array([[3.0, 1, 0.5], [1, 2, 0.25], [0.5, 0.25, 1]]))
    dataset = made(tmp_path / "d", recording(odometry=Odometry(motions=motions, covariances=covariances)))
    (sequence,) = dataset.sequences()
    odometry = sequence.given.odometry
    assert odometry is not None
    first = int(FRAMES - sequence.frames)
    np.testing.assert_array_equal(odometry.motions, motions[first:])
    np.testing.assert_array_equal(odometry.covariances[1:], covariances[first + 1 :])
    for isolate in (False, True):
        solve(dataset, f"{__name__}:Watcher", "cold-start", tmp_path / f"a{isolate}", isolate=isolate)


class Watcher(Still):
    """Checks that odometry of frame t is shown at t, and never before."""

    def step(self, frame: Any) -> Any:
        forward = frame.given.odometry.motions[:, 0]
        expected = np.array([3.0 * (t - 1) if t > 0 else np.nan for t in range(frame.index - 2, frame.index + 1)])
        np.testing.assert_array_equal(forward, expected)
        return super().step(frame)


def test_thinned_odometry_is_the_motion_between_the_kept_frames():
    rng = np.random.default_rng(0)
    motions = rng.normal(0.0, 0.3, (9, 3))
    poses = np.zeros((9, 3))
    for t in range(1, 9):
        poses[t, :2] = relative_to_world(np.array([[-motions[t, 1], motions[t, 0]]]), poses[t - 1])[0]
        poses[t, 2] = poses[t - 1, 2] + motions[t, 2]
    joined = joined_odometry(Odometry(motions=motions, covariances=np.tile(np.diag([0.01, 0.02, 1e-3]), (9, 1, 1))), 4)
    assert np.isnan(joined.motions[0]).all()
    for row in (1, 2):
        ((right, forward),) = world_to_relative(poses[4 * row, :2][None], poses[4 * (row - 1)])
        np.testing.assert_allclose(joined.motions[row], [forward, -right, poses[4 * row, 2] - poses[4 * row - 4, 2]])
    drawn = np.array(
        [_chain(motions[1:5] + rng.normal(0.0, 1.0, (4, 3)) * np.sqrt([0.01, 0.02, 1e-3])) for _ in range(20000)]
    )
    np.testing.assert_allclose(np.cov(drawn.T), joined.covariances[1], rtol=0.1, atol=0.002)


def _chain(motions: Any) -> Any:
    total = np.zeros(3)
    for forward, left, turn in motions:
        cos, sin = np.cos(total[2]), np.sin(total[2])
        total = total + np.array([cos * forward - sin * left, sin * forward + cos * left, turn])
    return total


def test_every_nth_frame_keeps_pictures_and_people_in_step(tmp_path):
    one = recording(pictures=Pictures(pattern="/films/{:04d}.png", first=7, step=1))
    dataset = made(tmp_path / "d", one, footage=FootageOptions(every=3))
    assert (dataset.info.dt, len(dataset.sequence(0).observations)) == (pytest.approx(1.2), FRAMES // 3)
    pictures = Dataset(tmp_path / "d").info.pictures[0]
    assert pictures is not None
    assert str(pictures.path(2)) == "/films/0013.png"
    assert one.poses is not None
    poses = dataset.world(dataset.sequence(0)).poses(one.poses[::3])
    np.testing.assert_array_equal(dataset.truth(dataset.sequence(0)).poses, poses)


SPLITS = {
    "own": own,
    "kitti": kitti,
    "jrdb": jrdb,
    "motsynth": motsynth,
    "argoverse2": argoverse2,
    "nuscenes": nuscenes,
}


@pytest.mark.parametrize(
    ("split", "name", "value"),
    [
        ("own", "cyclists", True),
        ("kitti", "cameras", ("panorama",)),
        ("jrdb", "poses", Path("p")),
        ("motsynth", "bags", Path("g")),
        ("argoverse2", "interpolated", False),
        ("nuscenes", "cyclists", True),
    ],
)
def test_an_option_that_a_split_does_not_read_is_refused(tmp_path, split, name, value):
    asked = Options(source=tmp_path, footage=FootageOptions(**{name: value}))
    with pytest.raises(
        VbbenchError, match=f"^{split} is footage and does not read `{name}`; it reads `seed`, .* and `"
    ):
        SPLITS[split].plan(asked)


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (["--tier", "noisy"], "--tier"),
        (["--sigma-h", "0.2"], "--sigma-h"),
        (["--no-interpolated"], "--interpolated"),
        (["--options", "detector=false"], "--detector"),
        (["--scenario", "plaza"], "--scenario or --people"),
    ],
)
def test_the_command_says_so_in_one_line(tmp_path, capsys, option, said):
    command = ["generate", "own", "--source", str(tmp_path), *option, "--out", str(tmp_path / "d")]
    assert main(command) == 2
    read = "--seed, --limit, --source, --dt, --sequences, --every, --longest, --poses, --boxes and --person-class"
    assert capsys.readouterr().err == f"vbbench: own is footage and does not read {said}; it reads {read}\n"


def test_footage_without_enough_people_in_a_row_is_refused(tmp_path):
    empty = replace(
        recording(), boxes=np.full((FRAMES, PEOPLE + 1, 3), np.nan), visible=np.full((FRAMES, PEOPLE + 1), np.nan)
    )
    with pytest.raises(VbbenchError, match="walk: nowhere are there 5 frames in a row, 1 apart, with 3 people"):
        made(tmp_path / "d", empty)
