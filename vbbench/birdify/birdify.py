"""The function behind ``vbbench birdify``: reads a recording, solves it, and writes map and report.

OUT/report.md, report.json            verdict and uncertainty: see `vbbench.birdify.report`
OUT/poses.parquet, poses.csv          frame, time, x, y, yaw, and standard deviations
OUT/poses.txt                         the same as a TUM trajectory
OUT/positions.parquet, positions.csv  frame, time, id, x, y, and standard deviation
OUT/map.png                           the whole map
OUT/film.mp4                          the map next to the boxes, frame by frame, on request
OUT/recording                         copies of the input files, a folder for 'vbbench generate own'
OUT/dataset, OUT/submission           the same as a dataset and its submission, for plot, render, view, export
"""

import shutil
import warnings
from codecs import BOM_UTF8
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from vbbench.birdify.measuring import make_report
from vbbench.birdify.report import REPORT, Report, write_tables
from vbbench.errors import FileError, VbbenchError, VbbenchWarning, suggestion, user_mistakes
from vbbench.estimate import Estimate
from vbbench.exchange.box_rows import write_boxes
from vbbench.exchange.box_tables import holds_pictures, label_folder
from vbbench.exchange.own.camera_file import find_camera
from vbbench.exchange.own.recording import (
    CAMERA,
    ODOMETRY,
    OwnRecording,
    RecordingFiles,
    as_recordings,
    boxes_in,
    read_recording,
)
from vbbench.exchange.trajectory import AXES, Axes
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import Pictures
from vbbench.files.submission import SubmissionInfo, SubmissionWriter
from vbbench.files.submission_tables import answer_rows
from vbbench.folders.replacing import write_text_atomically
from vbbench.folders.work_folder import WorkFolder, check_free
from vbbench.generation import write_dataset
from vbbench.generation.generator import FootageGenerator, FootagePlan, Options
from vbbench.parsing.numbers import FRAME_TIME
from vbbench.pictures.rendering import silent
from vbbench.protocol import get_protocol
from vbbench.registry import load, make_solver
from vbbench.sequence import Sequence
from vbbench.solving.provenance import hardware, solver_version
from vbbench.solving.runner import run_sequence

PROTOCOL = "cold-start"
DATASET, SUBMISSION, RECORDING = "dataset", "submission", "recording"
VIDEOS = (".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v", ".mpg", ".mpeg", ".mjpeg", ".ts", ".ogv", ".wmv")
"""Endings of the names of videos."""


@dataclass(frozen=True, kw_only=True)
class Birdified:
    """The result of `birdify`.

    Parameters
    ----------
    folder : folder of the map.
    report : its report.
    """

    folder: Path
    report: Report


def is_film(path: Path) -> bool:
    """Whether a path is a film: a video by its name, or a folder of pictures; otherwise it holds boxes."""
    if path.is_dir():
        return holds_pictures(path) or not (label_folder(path) or boxes_in(path))
    return path.suffix.lower() in VIDEOS


def birdify(
    boxes: Path | str,
    camera: Path | str,
    out: Path | str,
    *,
    odometry: Path | str | None = None,
    odometry_axes: Axes | None = None,
    solver: str = "map-causal",
    film: bool = False,
    dt: float | None = None,
    name: str = "",
    pictures: Pictures | None = None,
    mount: Mapping[str, float | str] | None = None,
    person_class: int | str | None = None,
    overwrite: bool = False,
    announce: Callable[[str], object] = silent,
) -> Birdified:
    """Make a map of a camera and the people around it, from boxes of these people alone.

    The first pose of the camera is the map's origin, with its viewing direction as the x axis.

    Raises VbbenchError if a file cannot be used, ``dt`` lies outside its range, the solver is unknown or fails, or
    ``out`` exists.

    Parameters
    ----------
    boxes : a file of boxes, a folder of MOTChallenge, or one of YOLO's labels (`vbbench.exchange.box_rows`).
    camera : camera file (`vbbench.exchange.own.camera_file`), a folder that holds one, or a calibration of another
        program (`vbbench.exchange.own.calibration_files`).
    out : folder to make; it appears when it is complete.
    odometry : trajectory of the observer by odometry (`vbbench.exchange.trajectory`).
    odometry_axes : axes of its body, a key of `vbbench.exchange.trajectory.AXES`; by default those of the camera file,
        or those that fit the motion.
    solver : a registered name, or ``module:attribute``.
    film : whether to make a film, which takes longer than all other steps.
    dt : seconds per frame, if neither camera file nor boxes state it.
    name : name of the recording; by default that of the file of boxes.
    pictures : pictures of the frames, for drawing.
    mount : keys that the camera file lacks: ``mount_height`` in m, ``pitch`` in rad, ``carried_by``.
    person_class : class of people in the boxes, by number or name, if the file does not show it.
    overwrite : whether to replace a folder that birdify made.
    announce : called with a line for each stage.
    """
    out, camera, solving = Path(out), find_camera(Path(camera)), make_solver(solver)
    if dt is not None:
        with user_mistakes():
            FRAME_TIME.check("dt", dt)
        dt = float(dt)
    with WorkFolder(out, partial(check_free, out, REPORT, "folder that birdify made", overwrite)) as work:
        files = with_axes(named_files(boxes, camera, odometry), odometry_axes)
        files = replace(files, name=name or files.name)
        recording = read_recording(files, dt=dt, pictures=pictures, mount=mount, person_class=person_class)
        work.begin()
        _keep_files(recording, dt, work.new / RECORDING)
        announce(_described(recording))
        dataset = write_dataset(plan_of(recording), work.new / DATASET)
        sequence = dataset.sequence(0)
        announce(f"solving with {solver} ({PROTOCOL})")
        answer = _solve(dataset, sequence, solver, solving, work.new / SUBMISSION)
        ids = recording.rows.ids.of(sequence.tracks)
        write_tables(work.new, sequence, recording.rows.timeline, answer, dataset.camera(sequence).mount_height, ids)
        report = make_report(dataset, recording, answer, solver)
        _draw_map(work.new / "map.png", sequence, answer, report)
        if film:
            from vbbench.pictures.rendering import render_to_file

            submission = work.new / SUBMISSION
            render_to_file(dataset, 0, work.new / "film.mp4", footage=True, submission=submission, announce=announce)
        write_text_atomically(work.new / "report.md", report.markdown())
        write_text_atomically(work.new / REPORT, report.to_json())
        work.publish()
    for warning in report.warnings:
        warnings.warn(VbbenchWarning(warning), stacklevel=2)
    return Birdified(folder=out, report=report)


def named_files(boxes: Path | str, camera: Path | str, odometry: Path | str | None) -> RecordingFiles:
    """The files of a recording from the user's paths; a folder stands for the boxes or the camera in it.

    Raises FileError if boxes or odometry are missing.
    """
    found = boxes_in(Path(boxes)) or Path(boxes)
    moved = None if odometry is None else Path(odometry)
    for path in filter(None, (found, moved)):
        if not path.exists():
            raise FileError(path, "there is no such file")
    return RecordingFiles(name=Path(boxes).stem, camera=find_camera(Path(camera)), boxes=found, odometry=moved)


def with_axes(files: RecordingFiles, axes: Axes | None) -> RecordingFiles:
    """The files with odometry in ``axes``; ``None``: those of the camera file, or those that fit the motion.

    Raises VbbenchError if there are no such axes, or no odometry.
    """
    if axes is not None and (files.odometry is None or axes not in AXES):
        wanted = f"{axes} cannot be; {suggestion(axes, AXES)}" if files.odometry else "there is no odometry"
        raise VbbenchError(f"`odometry_axes`: {wanted}")
    return replace(files, odometry_axes=axes)


def _described(recording: OwnRecording) -> str:
    seen = recording.footage.observed
    return (
        f"{recording.footage.frames} frames of {recording.footage.dt:g} s, {len(recording.footage.tracks)} tracks, "
        f"{int(seen.sum())} boxes, {seen.sum() / len(seen):.1f} people a frame"
    )


def _keep_files(recording: OwnRecording, dt: float | None, folder: Path) -> None:
    """Copy the input files under the names of split ``own``; adds ``dt`` to a camera file without it.

    Boxes that are not plain text are written as CSV.
    """
    folder.mkdir(parents=True)
    files = recording.files
    named = files.boxes.suffix.lower() == ".csv"
    kept = {"boxes.csv" if named else "gt.txt": files.boxes, ODOMETRY: files.odometry}
    if not recording.rows.plain:
        write_boxes(folder / "boxes.csv", recording.rows)
        kept = {ODOMETRY: files.odometry}
    for name, path in kept.items():
        if path is not None:
            shutil.copyfile(path, folder / name)
    if files.odometry is not None and files.odometry_axes is not None:
        stated = f"# axes: {files.odometry_axes}\n"
        (folder / ODOMETRY).write_bytes(stated.encode() + files.odometry.read_bytes().removeprefix(BOM_UTF8))
    given = dt is not None and recording.own.facts.seconds is None
    line = f"dt = {dt!r}  # seconds per frame, given with this file\n" if given else ""
    (folder / CAMERA).write_text(line + recording.own.text, "utf-8")


def plan_of(recording: OwnRecording) -> FootagePlan:
    """The plan of split ``own`` with the recording as its only sequence."""
    generator = load("generator", "own")
    if not isinstance(generator, FootageGenerator):
        raise VbbenchError("split 'own' is not installed as it comes with vbbench; install vbbench again")
    return generator.lay_out(as_recordings([recording]), Options())


def _solve(dataset: Dataset, sequence: Sequence, solver: str, solving: Any, folder: Path) -> Estimate:
    """The solver's estimate of a sequence; writes the scored rows as a submission."""
    protocol, problem = get_protocol(PROTOCOL), dataset.problem(sequence, covariances=True)
    with threadpool_limits(1):
        answer, seconds = run_sequence(solving, problem, sequence, protocol, None)
    info = SubmissionInfo(
        solver=solver,
        version=solver_version(solver),
        dataset=dataset.info.id,
        protocol=PROTOCOL,
        seconds_per_frame=seconds / sequence.frames,
        hardware=hardware(),
    )
    rows = answer_rows(sequence, protocol, answer, covariance=False)
    with SubmissionWriter(folder, info, fallback=answer.fallback is not None) as writer:
        writer.add(0, rows["poses"], rows["positions"])
    return answer


def _draw_map(path: Path, sequence: Sequence, answer: Estimate, report: Report) -> None:
    from vbbench.pictures.plotting.style import save_picture
    from vbbench.pictures.plotting.whole_map import plot_map

    facts = [" ".join(report.verdict.sentences())]
    lost = report.verdict.lost(sequence.frames)
    save_picture(plot_map(answer, sequence.observed, report.dt, report.name, facts, lost), path)
