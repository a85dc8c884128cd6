"""Folders of TUM trajectory files, ``sequence-000012.txt`` for sequence 12: out of a dataset, and into a submission."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.arrays import FloatArray, IntArray
from vbbench.dataset import Dataset
from vbbench.errors import FileError
from vbbench.sequence import Sequence
from vbbench.submission import SubmissionInfo, SubmissionWriter
from vbbench.submitted import SubmittedEstimates
from vbbench.tables import loose_files
from vbbench.tum.file import export_tum, import_tum

_NAME = re.compile(r"sequence-(\d+)\.txt")


def export_dataset_tum(dataset: Dataset, out: Path | str, submission: Path | str | None = None) -> Path:
    """Write the poses of every sequence, true ones or a submission's, as TUM trajectory files.

    Parameters
    ----------
    dataset : where the sequences lie.
    out : folder to write into; made if needed.
    submission : folder of a submission; its poses stand where there are any, those given to it elsewhere.

    Returns
    -------
    The folder ``out``.

    Raises
    ------
    VbbenchError
        If the truth is withheld, or the submission cannot be read or answers another dataset.
    """
    out = Path(out)
    estimates = None if submission is None else SubmittedEstimates(dataset, submission)
    with loose_files(out):
        for sequence in dataset.sequences():
            poses = dataset.truth(sequence).poses if estimates is None else estimates.of(sequence).poses
            export_tum(poses, dataset.info.dt, dataset.info.camera.mount_height, out / file_name(sequence.index))
    return out


def import_tum_folder(
    folder: Path | str, dataset: Dataset, out: Path | str, solver: str, protocol: str = "sequential"
) -> Path:
    """Make a submission of a folder of TUM trajectory files.

    The files know nothing of people: the submission holds poses only, and declares the failure policy ``hold``, under
    which everybody stays where last given. Sequences without a file are missing from it.

    Parameters
    ----------
    folder : files named as `export_dataset_tum` does.
    dataset : the dataset that they answer.
    out : submission folder to make.
    solver, protocol : names for the submission; the protocol must be what the solver was given.

    Returns
    -------
    The folder ``out``.

    Raises
    ------
    FileError
        For the first file that cannot be used, with its line (`import_tum`), or has a frame or a name that the dataset
        has not; or if there is no such file at all.
    """
    paths = _files(Path(folder), len(dataset))
    poses = {
        number: _poses_of(path, dataset.sequence(number), dataset.info.dt) for number, path in sorted(paths.items())
    }
    info = SubmissionInfo(solver=solver, dataset=dataset.info.id, protocol=protocol, failure_policy="hold")
    with SubmissionWriter(out, info) as writer:
        for number, (frames, values) in poses.items():
            writer.add(number, _pose_columns(frames, values), _no_positions())
    return Path(out)


def file_name(sequence: int) -> str:
    """Name of the trajectory file of a sequence."""
    return f"sequence-{sequence:06d}.txt"


def _files(folder: Path, sequences: int) -> dict[int, Path]:
    found = {}
    for path in sorted(folder.glob("*.txt")):
        name = _NAME.fullmatch(path.name)
        if name is None or int(name[1]) >= sequences or int(name[1]) in found:
            known = f"sequences 0 to {sequences - 1}, one file each, are called {file_name(0)} and so on"
            raise FileError(path, f"belongs to no sequence of the dataset; {known}")
        found[int(name[1])] = path
    if not found:
        raise FileError(folder, f"holds no trajectory; files are called {file_name(0)} and so on")
    return found


def _poses_of(path: Path, sequence: Sequence, dt: float) -> tuple[IntArray, FloatArray]:
    frames, poses = import_tum(path, dt)
    if frames[-1] >= sequence.frames:
        last = sequence.frames - 1
        raise FileError(
            path, f"has frame {frames[-1]}; sequence {sequence.index} ends with frame {last} ({last * dt:g} s)"
        )
    return frames, poses


def _pose_columns(frames: IntArray, poses: FloatArray) -> dict[str, Any]:
    return {"frame": frames, "x": poses[:, 0], "y": poses[:, 1], "yaw": poses[:, 2]}


def _no_positions() -> dict[str, Any]:
    return {"frame": np.empty(0, int), "track": np.empty(0, int), "x": np.empty(0), "y": np.empty(0)}
