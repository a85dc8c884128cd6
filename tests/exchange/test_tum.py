"""TUM trajectory files: round trip, what evo reads in them, and every way a file can be bad."""

from pathlib import Path

import numpy as np
import pytest
from evo.tools import file_interface
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.tum import export_dataset_tum, export_tum, import_tum, import_tum_folder
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo, SubmissionWriter
from vbbench.files.submission_tables import SubmittedEstimates
from vbbench.geometry import wrap_angle

DT, HEIGHT = 0.4, 1.6
GOOD = "0.4 1 2 1.6 0 0 0 1"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "sequence-000000.txt"


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    folder = tmp_path_factory.mktemp("tum") / "dataset"
    write_dataset(folder, Crowd(scenes=1))
    return Dataset(folder)


@given(
    poses=arrays(np.float64, st.tuples(st.integers(1, 20), st.just(3)), elements=st.floats(-1e4, 1e4)),
    dt=st.sampled_from([0.04, 0.1, 0.4, 1 / 3, 1.0]),
)
def test_a_trajectory_comes_back(tmp_path_factory, poses, dt):
    file = tmp_path_factory.mktemp("trip") / "poses.txt"
    export_tum(poses, dt, HEIGHT, file)
    frames, back = import_tum(file, dt)
    np.testing.assert_array_equal(frames, np.arange(len(poses)))
    np.testing.assert_allclose(back[:, :2], poses[:, :2], rtol=0, atol=1e-9)
    np.testing.assert_allclose(wrap_angle(back[:, 2] - poses[:, 2]), 0.0, rtol=0, atol=1e-9)
    assert np.all((back[:, 2] >= -np.pi) & (back[:, 2] < np.pi))


def test_evo_reads_the_same_trajectory(file):
    poses = np.column_stack([np.linspace(0, 9, 25), np.linspace(3, -2, 25), np.linspace(-3.1, 3.1, 25)])
    export_tum(poses, DT, HEIGHT, file)
    read = file_interface.read_tum_trajectory_file(file)
    np.testing.assert_allclose(read.timestamps, np.arange(25) * DT)
    np.testing.assert_allclose(read.positions_xyz, np.column_stack([poses[:, :2], np.full(25, HEIGHT)]))
    turn = Rotation.from_quat(np.roll(read.orientations_quat_wxyz, -1, axis=1))
    np.testing.assert_allclose(turn.as_euler("ZYX")[:, 0], poses[:, 2], atol=1e-12)
    forward = turn.apply([1.0, 0.0, 0.0])
    np.testing.assert_allclose(forward[:, :2], np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])]), atol=1e-12)


def test_frames_without_a_pose_are_left_out_and_any_order_is_read(file):
    poses = np.array([[0, 0, 0], [np.nan] * 3, [2, 0, 0.5], [3, 0, 1.0]])
    export_tum(poses, DT, HEIGHT, file)
    lines = file.read_text().splitlines()
    file.write_text("\n".join([lines[0], "", *reversed(lines[1:])]) + "\n")
    frames, back = import_tum(file, DT)
    assert frames.tolist() == [0, 2, 3]
    np.testing.assert_allclose(back, poses[frames], atol=1e-12)


def test_either_sign_of_a_quaternion_and_few_digits_are_read(file):
    file.write_text("0.0 0 0 1.6 0 0 -0.4794 -0.8776\n0.4001 0 0 1.6 0.0001 0 0.4794 0.8776\n")
    frames, poses = import_tum(file, DT)
    assert frames.tolist() == [0, 1]
    np.testing.assert_allclose(poses[:, 2], 1.0, atol=1e-3)


def test_a_camera_that_leans_looks_where_its_axis_points_on_the_ground(file):
    turns = Rotation.from_euler("ZYX", [[1.1, 0.2, -0.1], [-2.5, -0.3, 0.4]])
    rows = [f"{0.4 * t} 1 2 1.6 {' '.join(map(repr, turn))}\n" for t, turn in enumerate(turns.as_quat().tolist())]
    file.write_text("".join(rows))
    np.testing.assert_allclose(import_tum(file, DT)[1], [[1, 2, 1.1], [1, 2, -2.5]], atol=1e-12)


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("0.8 1 2 1.6 0 0 1", "7 columns with blanks between, wanted 8"),
        ("0.8,1,2,1.6,0,0,0,1", "1 columns with blanks between, wanted 8"),
        ("0.8 1 nan 1.6 0 0 0 1", "ty is nan"),
        ("inf 1 2 1.6 0 0 0 1", "timestamp is inf"),
        ("0.8 1 2 1.6 0 0 0 0", "length 0"),
        ("0.8 1 2 1.6 0 0 0.5 0.5", "length 0.7071"),
        ("0.8 1 2 1.6 0.7071068 0 0 0.7071068", "leans by 90°"),
        ("0.6 1 2 1.6 0 0 0 1", "timestamp 0.6 s is not a frame's"),
        ("-0.4 1 2 1.6 0 0 0 1", "timestamp -0.4 s is not a frame's"),
        ("1e300 1 2 1.6 0 0 0 1", "is not a frame's"),
        ("0.4 5 5 1.6 0 0 0 1", "frame 1 was already given in line 2"),
    ],
)
def test_a_bad_line_is_named(file, line, problem):
    file.write_text(f"# a comment\n{GOOD}\n{line}\n")
    with pytest.raises(FileError, match=problem) as caught:
        import_tum(file, DT)
    assert caught.value.line == 3
    assert caught.value.path == file


@pytest.mark.parametrize("text", ["", "# nothing but a comment\n\n", None])
def test_a_file_that_is_empty_or_missing_is_refused(file, text):
    if text is not None:
        file.write_text(text)
    with pytest.raises(FileError, match="missing" if text is None else "holds no pose"):
        import_tum(file, DT)


def test_true_poses_of_a_dataset_become_a_submission(dataset, tmp_path):
    files = export_dataset_tum(dataset, tmp_path / "files")
    assert len(list(files.iterdir())) == len(dataset)
    submission = import_tum_folder(files, dataset, tmp_path / "submission", "mine", "rollout")
    info = SubmissionInfo.read(submission)
    assert (info.solver, info.protocol, info.failure_policy) == ("mine", "rollout", "hold")
    submitted = SubmittedEstimates(dataset, submission)
    for sequence in dataset.sequences():
        estimate, truth = submitted.of(sequence), dataset.truth(sequence)
        np.testing.assert_allclose(estimate.poses[:, :2], truth.poses[:, :2], atol=1e-9)
        np.testing.assert_allclose(wrap_angle(estimate.poses[:, 2] - truth.poses[:, 2]), 0.0, atol=1e-9)
        given = sequence.given.first_frames(2).positions
        np.testing.assert_array_equal(estimate.positions, given)


def test_poses_of_a_submission_are_exported_with_those_given_to_it(dataset, tmp_path):
    sequence = dataset.sequence(0)
    frames = np.arange(2, sequence.frames)
    info = SubmissionInfo(solver="mine", dataset=dataset.info.id, protocol="sequential")
    with SubmissionWriter(tmp_path / "submission", info) as writer:
        poses = {"frame": frames, "x": frames + 0.5, "y": -frames, "yaw": np.full(len(frames), 3.0)}
        writer.add(0, poses, {"frame": [], "track": [], "x": [], "y": []})
    files = export_dataset_tum(dataset, tmp_path / "files", tmp_path / "submission")
    read_frames, read = import_tum(files / "sequence-000000.txt", dataset.info.dt)
    assert read_frames.tolist() == list(range(sequence.frames))
    np.testing.assert_allclose(read[:2], sequence.given.poses[:2], atol=1e-9)
    np.testing.assert_allclose(read[2:], np.column_stack([frames + 0.5, -frames, np.full(len(frames), 3.0)]))


def test_files_of_another_dataset_or_none_are_refused(dataset, tmp_path):
    with pytest.raises(FileError, match="holds no trajectory"):
        import_tum_folder(tmp_path, dataset, tmp_path / "out", "mine")
    path = tmp_path / "sequence-000000.txt"
    export_tum(np.zeros((500, 3)), dataset.info.dt, HEIGHT, path)
    with pytest.raises(FileError, match="has frame 499; sequence 0 ends with frame"):
        import_tum_folder(tmp_path, dataset, tmp_path / "out", "mine")
    path.rename(tmp_path / "sequence-000999.txt")
    with pytest.raises(FileError, match="belongs to no sequence"):
        import_tum_folder(tmp_path, dataset, tmp_path / "out", "mine")
    assert not (tmp_path / "out").exists()


def test_a_submission_to_another_dataset_is_not_exported(dataset, tmp_path):
    info = SubmissionInfo(solver="mine", dataset="0" * 16, protocol="sequential")
    with SubmissionWriter(tmp_path, info):
        pass
    with pytest.raises(VbbenchError, match="answers dataset 0000000000000000"):
        export_dataset_tum(dataset, tmp_path / "files", tmp_path)
