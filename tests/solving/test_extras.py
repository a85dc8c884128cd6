"""What a solver may report besides its estimate: fallback, covariances, heights; from its answer to files and score."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.lib.answers import submit, submit_csv, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.errors import VbbenchError
from vbbench.estimate import Estimate, FrameEstimate
from vbbench.files.dataset import Dataset
from vbbench.scoring import score
from vbbench.sequence import Given
from vbbench.solver import Frame, Problem
from vbbench.solving import solve

PLAIN: dict[str, Any] = {"pose": np.zeros(3), "positions": np.zeros((4, 2))}
EXTRAS: dict[str, Any] = {
    "fallback": True,
    "pose_covariance": np.diag([1.0, 2.0, 3.0]),
    "position_covariances": np.tile(np.eye(2), (4, 1, 1)),
    "heights": np.full(4, 1.7),
    "height_variances": np.full(4, 0.01),
}


class Plain:
    """Answers zeros and reports nothing else."""

    def start(self, problem: Problem) -> None:
        self.people = len(problem.tracks)

    def step(self, frame: Frame) -> FrameEstimate:
        return FrameEstimate(pose=np.zeros(3), positions=np.zeros((len(frame.observations), 2)))


class Reporting(Plain):
    """Falls back at frame 3 of every sequence, and says nothing of other frames; its heights grow with time."""

    def step(self, frame: Frame) -> FrameEstimate:
        people = len(frame.observations)
        return FrameEstimate(
            pose=np.zeros(3),
            positions=np.zeros((people, 2)),
            fallback=True if frame.index == 3 else None,
            pose_covariance=np.arange(9.0).reshape(3, 3) + frame.index,
            position_covariances=np.tile([[1.0, 0.5], [0.5, 2.0]], (people, 1, 1)),
            heights=np.full(people, 1.5 + 0.01 * frame.index),
            height_variances=np.full(people, 0.01),
        )


class Moody(Plain):
    """Reports a fallback in later parts only: a new object solves each part."""

    made = 0

    def __init__(self) -> None:
        Moody.made += 1
        self.falls_back = True if Moody.made > 1 else None

    def step(self, frame: Frame) -> FrameEstimate:
        plain = super().step(frame)
        return FrameEstimate(pose=plain.pose, positions=plain.positions, fallback=self.falls_back)


class Whole:
    """A solver of whole sequences that falls back in its last frame, and knows heights."""

    def solve(self, problem: Problem, observations: np.ndarray, given: Given) -> Estimate:
        frames, people = observations.shape[:2]
        return Estimate(
            poses=np.zeros((frames, 3)),
            positions=np.zeros((frames, people, 2)),
            fallback=np.arange(frames) == frames - 1,
            heights=np.full(people, frames),
        )


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    folder = tmp_path_factory.mktemp("extras") / "dataset"
    write_dataset(folder, Crowd(scenes=6, people=9, frames=20))
    return Dataset(folder)


@pytest.mark.parametrize("name", [name for name in EXTRAS if name != "fallback"])
def test_extras_of_a_wrong_shape_are_named(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} must have shape"):
        FrameEstimate(**PLAIN, **{name: np.zeros(7)})
    several = {"pose_covariance": "pose_covariances"}.get(name, name)
    with pytest.raises(ValueError, match=f"{several} must have shape"):
        Estimate(poses=np.zeros((2, 3)), positions=np.zeros((2, 4, 2)), **{several: np.zeros((7, 7))})


def test_frames_stack_to_an_estimate_and_come_out_of_it_again() -> None:
    whole = Estimate.of_frames([FrameEstimate(**PLAIN), FrameEstimate(**PLAIN, **EXTRAS), FrameEstimate(**PLAIN)])
    assert whole.fallback.tolist() == [False, True, False]
    assert np.isnan(whole.pose_covariances[0]).all()
    assert whole.position_covariances.shape == (3, 4, 2, 2)
    np.testing.assert_array_equal(whole.heights, EXTRAS["heights"])
    again = whole.frame(1)
    for name, value in EXTRAS.items():
        np.testing.assert_array_equal(getattr(again, name), value)


def test_a_simple_solver_writes_the_tables_of_the_contract_alone(dataset: Dataset, tmp_path: Path) -> None:
    out = solve(dataset, f"{__name__}:Plain", "sequential", tmp_path / "out")
    assert sorted(path.name for path in out.iterdir()) == ["poses.parquet", "positions.parquet", "submission.json"]
    assert list(pd.read_parquet(out / "poses.parquet")) == ["sequence", "frame", "x", "y", "yaw"]
    result = score(out, dataset.folder)
    assert result.values()["fallback_frames"] is None
    assert "fallback" not in result.table()


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_what_is_reported_is_written_and_counted(dataset: Dataset, tmp_path: Path, jobs: int) -> None:
    out = solve(dataset, f"{__name__}:Reporting", "sequential", tmp_path / "out", jobs=jobs)
    poses = pd.read_parquet(out / "poses.parquet")
    assert list(poses) == ["sequence", "frame", "x", "y", "yaw", "fallback"]
    assert (poses.fallback == (poses.frame == 3)).all()
    heights = pd.read_parquet(out / "heights.parquet")
    assert len(heights) == sum(len(sequence.tracks) for sequence in dataset.sequences())
    frames = np.array([sequence.frames for sequence in dataset.sequences()])
    np.testing.assert_allclose(heights.height, 1.49 + 0.01 * frames[heights.sequence])
    result = score(out, dataset.folder)
    assert result.fallback_frames == (poses.frame == 3).sum()
    assert f"({result.fallback_frames} by fallback)" in result.table()


def test_covariances_are_written_when_asked_for(dataset: Dataset, tmp_path: Path) -> None:
    out = solve(dataset, f"{__name__}:Reporting", "one-step", tmp_path / "out", covariance=True)
    row = pd.read_parquet(out / "poses.parquet").iloc[0]
    assert row[["xx", "xy", "x_yaw", "yy", "y_yaw", "yaw_yaw"]].tolist() == [n + row.frame for n in (0, 1, 2, 4, 5, 8)]
    assert pd.read_parquet(out / "positions.parquet")[["xx", "xy", "yy"]].drop_duplicates().values.tolist() == [
        [1.0, 0.5, 2.0]
    ]
    assert score(out, dataset.folder).fallback_frames is not None


def test_covariances_that_nobody_reports_are_refused(dataset: Dataset, tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match=r"reports no covariances; remove .covariance."):
        solve(dataset, f"{__name__}:Plain", "sequential", tmp_path / "out", covariance=True)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("protocol", ["one-step", "sequential"])
def test_solvers_of_whole_sequences_report_too(dataset: Dataset, tmp_path: Path, protocol: str) -> None:
    out = solve(dataset, f"{__name__}:Whole", protocol, tmp_path / "out")
    poses = pd.read_parquet(out / "poses.parquet")
    last = np.array([sequence.frames for sequence in dataset.sequences()])[poses.sequence] - 1
    assert (poses.fallback == ((poses.frame == last) | (protocol == "one-step"))).all()
    heights = pd.read_parquet(out / "heights.parquet")
    assert heights.variance.isna().all()


def test_strangers_may_declare_fallback_in_parquet_and_csv(dataset: Dataset, tmp_path: Path) -> None:
    poses, positions = true_answers(dataset.folder, 0.1)
    marked = poses.assign(fallback=(poses.frame % 2 == 0).astype("int8"))
    by_hand = score(submit_csv(tmp_path / "csv", dataset.folder, (marked, positions)), dataset.folder)
    parquet = score(submit(tmp_path / "parquet", dataset.folder, (marked, positions)), dataset.folder)
    assert by_hand.fallback_frames == parquet.fallback_frames
    assert 0 < by_hand.fallback_frames < by_hand.frames
    marked.to_parquet(tmp_path / "parquet/poses.parquet", index=False)
    assert json.loads(score(tmp_path / "parquet", dataset.folder).to_json())["fallback_frames"] == (
        by_hand.fallback_frames
    )
