"""Poses to and from TUM trajectory files: lines of ``timestamp tx ty tz qx qy qz qw``, one file per sequence.

Convention: timestamp = frame·dt in s; (tx, ty) is the observer's position in m and tz the camera's mount height; the
quaternion turns the body frame (x forward, z up) into the world frame (z up), so that a yaw alone is
(0, 0, sin yaw/2, cos yaw/2).
"""

from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.sequence_files import files_by_sequence, sequence_name
from vbbench.exchange.trajectory import ground_poses, read_trajectory
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo, SubmissionWriter
from vbbench.files.submission_tables import SubmittedEstimates
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import FloatArray, IntArray

_HEADER = "# timestamp tx ty tz qx qy qz qw (body: x forward, z up; timestamp {})\n"
_GRID_TOLERANCE = 0.05
"""How far a timestamp may be from its frame, in frames."""
_LAST_FRAME = 2**31 - 1
"""The largest frame that the tables hold."""


def export_tum(poses: FloatArray, dt: float | FloatArray, mount_height: float, path: Path | str) -> None:
    """Write poses [T, 3] (x, y, yaw) in m and rad as a TUM trajectory; frames whose pose is NaN are skipped.

    Parameters
    ----------
    poses : pose of frame t in row t.
    dt : seconds per frame; or the times [T] of the frames in s.
    mount_height : the camera's height in m, written as tz.
    """
    frames = np.flatnonzero(np.isfinite(poses).all(axis=-1))
    x, y, yaw = poses[frames].T
    zero, even = np.zeros(len(frames)), np.ndim(dt) == 0
    times = frames * dt if even else np.asarray(dt)[frames]
    header = _HEADER.format("= frame * dt" if even else "in s, of the clock of the boxes")
    rows = np.stack([times, x, y, zero + mount_height, zero, zero, np.sin(yaw / 2.0), np.cos(yaw / 2.0)], axis=-1)
    lines = [" ".join(map(repr, row)) + "\n" for row in rows.tolist()]
    write_text_atomically(Path(path), header + "".join(lines))


def import_tum(path: Path | str, dt: float) -> tuple[IntArray, FloatArray]:
    """Read a TUM trajectory, or another (`vbbench.exchange.trajectory`); the body's axes are inferred from the motion.

    Returns frames [N], ascending, and poses [N, 3] (x, y, yaw) in m and rad, yaw in [−π, π).

    Parameters
    ----------
    path : the file; empty lines and lines that start with ``#`` are skipped.
    dt : seconds per frame; timestamp / dt is the frame. Lines without timestamps are a frame each.
    """
    trajectory = read_trajectory(Path(path))
    poses = ground_poses(trajectory).poses
    times = dt * np.arange(len(poses), dtype=np.float64)
    if trajectory.times is not None:
        times = trajectory.times * (dt if trajectory.unit == 0.0 else trajectory.unit or 1.0)
    with np.errstate(over="ignore"):
        exact = times / dt
    nearest = np.round(exact)
    wrong = (np.abs(exact - nearest) > _GRID_TOLERANCE) | (nearest < 0) | (nearest > _LAST_FRAME)
    trajectory.refuse(wrong, f"timestamp {{0:.10g}} s is not a frame's; frame n is at n × {dt:g} s, from 0", times)
    frames = nearest.astype(np.int64)
    trajectory.refuse_twice("frame {0} was already given in {at}; remove one of them", frames)
    order = np.argsort(frames)
    return frames[order], poses[order]


def export_dataset_tum(dataset: Dataset, out: Path | str, submission: Path | str | None = None) -> Path:
    """Write the poses of every sequence, true ones or a submission's, as TUM files into the folder ``out``; return it.

    Poses that a ``submission``, a folder, lacks are those given to it.
    """
    out = Path(out)
    estimates = None if submission is None else SubmittedEstimates(dataset, submission)
    with loose_files(out):
        for sequence in dataset.sequences():
            poses = dataset.truth(sequence).poses if estimates is None else estimates.of(sequence).poses
            path = out / f"{sequence_name(sequence.index)}.txt"
            export_tum(poses, dataset.info.dt, dataset.camera(sequence).mount_height, path)
    return out


def import_tum_folder(
    folder: Path | str, dataset: Dataset, out: Path | str, solver: str, protocol: str = "sequential"
) -> Path:
    """Make a submission, the folder ``out``, from a folder of TUM trajectory files, and return it.

    The submission holds poses only, and declares the failure policy ``hold``, under which people stay where last given.
    Sequences without a file are missing from it.

    Parameters
    ----------
    folder : files named as `export_dataset_tum` does.
    solver, protocol : names for the submission; the protocol must be the one that the solver ran under.
    """
    named = {path: path.stem for path in sorted(Path(folder).glob("*.txt"))}
    if not named:
        raise FileError(folder, f"holds no trajectory; files are called {sequence_name(0)}.txt and so on")
    paths, dt = files_by_sequence(named, len(dataset)), dataset.info.dt
    poses = {number: import_tum(path, dt) for number, path in paths.items()}
    for number, (frames, _) in poses.items():
        if frames[-1] > (last := dataset.sequence(number).frames - 1):
            problem = f"has frame {frames[-1]}; sequence {number} ends with frame {last} ({last * dt:g} s)"
            raise FileError(paths[number], problem)
    info = SubmissionInfo(solver=solver, dataset=dataset.info.id, protocol=protocol, failure_policy="hold")
    nobody: dict[str, Any] = {**dict.fromkeys(("frame", "track"), np.empty(0, int)), "x": np.empty(0), "y": np.empty(0)}
    with SubmissionWriter(out, info) as writer:
        for number, (frames, found) in poses.items():
            x, y, yaw = found.T
            writer.add(number, {"frame": frames, "x": x, "y": y, "yaw": yaw}, nobody)
    return Path(out)
