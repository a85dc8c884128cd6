"""``vbbench live``: a `Session` on a recording, shown frame by frame in the rerun viewer."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np

from vbbench.birdify.birdify import plan_of
from vbbench.boxes import rectangles
from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.own.recording import OwnRecording
from vbbench.files.dataset import problem_of
from vbbench.folders.replacing import replacing
from vbbench.geometry import FloatArray
from vbbench.pictures.viewer.marks import Opened, can_open, outlines, rerun, strictly
from vbbench.pictures.viewer.recording import SUFFIX
from vbbench.pictures.viewer.world import CONFIDENCE
from vbbench.solving.measured import far_outside
from vbbench.solving.session import Session, SessionAnswer


def show_live(recording: OwnRecording, solver: str, out: Path | None = None) -> int:
    """Step a session through a recording and show each answer: in the viewer at the recording's pace, or in a file.

    Raises VbbenchError if rerun is not installed, there is no display and no ``out``, or the solver fails.

    Parameters
    ----------
    recording : the recording.
    solver : a registered name or ``module:attribute`` of a frame-by-frame solver.
    out : an ``.rrd`` file, which is written at the solver's pace in place of opening the viewer.

    Returns
    -------
    The number of frames.
    """
    footage, begin, path = recording.footage, monotonic(), []
    with _stream(recording, out) as stream:
        for frame, (boxes, answer) in enumerate(answers(recording, solver)):
            path.append(answer.pose[:2])
            stream.set_time("frame", sequence=frame)
            stream.set_time("time", duration=frame * footage.dt)
            for entity, shown in _marks(boxes, answer, np.array(path)):
                stream.log(entity, shown)
            if out is None:
                sleep(max(0.0, begin + frame * footage.dt - monotonic()))
    return footage.frames


def answers(recording: OwnRecording, solver: str) -> Iterator[tuple[dict[Any, FloatArray], SessionAnswer]]:
    """Boxes {id: (u, v, l)} and answer of each frame."""
    plan = plan_of(recording)
    sequence = plan.build(0).sequence
    facts, camera, moved = vars(problem_of(plan.info, sequence)), recording.footage.camera, sequence.given.odometry
    given = {name: facts[name] for name in facts if name not in ("camera", "dt", "tracks", "covariances")}
    session = Session(solver, camera, plan.info.dt, people=max(1, int(sequence.observed.sum(axis=1).max())), **given)
    names = recording.rows.ids.of(sequence.tracks).tolist()
    for frame, seen in enumerate(sequence.observed):
        there = np.flatnonzero(seen)
        there = there[~far_outside(sequence.observations[frame, there], camera)]  # as a distorted lens may show them
        boxes = {names[k]: sequence.observations[frame, k] for k in there}
        known = frame > 0 and moved is not None and bool(np.isfinite(moved.motions[frame]).all())
        odometry = (moved.motions[frame], moved.covariances[frame]) if known and moved is not None else None
        yield boxes, session.step_observations(boxes, odometry)


def _marks(boxes: dict[Any, FloatArray], answer: SessionAnswer, path: FloatArray) -> Iterator[tuple[str, Any]]:
    """Entities of a frame: boxes; on the map, whose y axis points down, people, 95 % ellipses and the camera."""
    rr, flip = rerun(), np.array([1.0, -1.0])
    sides = rectangles(np.array(list(boxes.values())).reshape(-1, 3))
    yield "camera/boxes", rr.Boxes2D(array=sides, array_format=rr.Box2DFormat.XYWH, labels=list(map(str, boxes)))
    places = np.array(list(answer.positions.values())).reshape(-1, 2)
    yield "map/people", rr.Points2D(places * flip, radii=0.2, labels=list(map(str, answer.positions)))
    spread = [(answer.positions[name], matrix) for name, matrix in answer.position_covariances.items()]
    if answer.pose_covariance is not None:
        spread.append((answer.pose[:2], answer.pose_covariance[:2, :2]))
    if spread:
        centres, matrices = (np.array(values) for values in zip(*spread, strict=True))
        yield "map/95-percent", rr.LineStrips2D(outlines(centres, matrices, CONFIDENCE) * flip)
    ahead = np.array([np.cos(answer.pose[2]), np.sin(answer.pose[2])])
    yield "map/camera", rr.Arrows2D(origins=[path[-1] * flip], vectors=[ahead * flip])
    yield "map/path", rr.LineStrips2D([path * flip])


@contextmanager
def _stream(recording: OwnRecording, out: Path | None) -> Iterator[Any]:
    """A stream to the viewer, or to a file that appears when it is complete."""
    rr = rerun("vbbench live")
    stream = rr.RecordingStream(f"vbbench live {recording.footage.name}")
    if not rr.is_enabled(stream):
        raise VbbenchError("rerun is switched off; unset the environment variable RERUN")
    with strictly():
        if out is None:
            opened = can_open()
            if opened is not Opened.SHOWN:
                raise VbbenchError(f"{opened.value}; write a recording with --out map{SUFFIX}")
            stream.spawn()
            yield stream
            return
        if out.suffix != SUFFIX or out.is_dir():
            raise FileError(out, f"a recording is a file that ends in {SUFFIX}; give it such a name")
        with replacing(out) as temporary:
            stream.save(temporary)
            yield stream
            stream.disconnect()
