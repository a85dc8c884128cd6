"""What the observer sees: boxes, and the rendered picture, depth and ids if requested."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from vbbench.boxes import rectangles, with_seam_copies
from vbbench.geometry import IntArray
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.rendering import Picture
from vbbench.pictures.replay import Replay
from vbbench.pictures.viewer import marks
from vbbench.pictures.viewer.marks import Tape
from vbbench.pictures.viewer.world import CAMERA
from vbbench.sequence import NOBODY

QUALITY = 90
"""Of the JPEG pictures, in percent."""
CENTIMETRES = 100.0
"""Units of the depth pictures in a metre; 16 bits reach 655 m."""
_HORIZON_POINTS = 181


def ego_root(replay: Replay) -> str:
    """The parent of the picture: a pinhole camera whose pose is known, else its own plane."""
    return CAMERA if replay.camera.intrinsics is not None and replay.poses_known else "ego"


def record_boxes(tape: Tape, replay: Replay) -> None:
    """Record everybody's box in their colour, false alarms in red, and at both ends if it crosses a panorama's seam."""
    root, sequence = ego_root(replay), replay.sequence
    frame, track = np.nonzero(sequence.observed)
    colours = marks.people_colours(replay)[track]
    colours[replay.false_alarms[frame, track]] = marks.ALARM
    boxes, row = with_seam_copies(rectangles(sequence.observations[frame, track]), replay.camera.period)
    tape.many(
        f"{root}/boxes",
        tape.rr.Boxes2D,
        np.bincount(frame[row], minlength=sequence.frames),
        centers=boxes[:, :2] + 0.5 * boxes[:, 2:],
        half_sizes=0.5 * boxes[:, 2:],
        colors=colours[row],
        labels=sequence.tracks[track[row]].astype(str),
    )
    _record_frame(tape, replay, root)


def record_pictures(tape: Tape, replay: Replay, people: IntArray, pictures: Iterable[Picture]) -> None:
    """Record rendered pictures, one per frame; the pixels of the ``people`` [N] have the colours of their boxes."""
    rr, root, tracks = tape.rr, ego_root(replay), replay.sequence.tracks
    looks = zip(tracks.astype(str), marks.people_colours(replay).tolist(), strict=True)
    classes = [("nobody", (0, 0, 0, 0)), *looks, ("no box", marks.UNSEEN)]
    tape.always(root, rr.AnnotationContext([(number, *look) for number, look in enumerate(classes)]))
    class_of = _classes(replay, people)
    for frame, picture in enumerate(pictures):
        centimetres = np.where(np.isfinite(picture.depth), picture.depth * CENTIMETRES, 0.0).clip(0, 65535)
        ids = np.where(picture.ids == NOBODY, 0, class_of[frame, np.searchsorted(people, picture.ids)])
        tape.now(frame, f"{root}/picture", rr.Image(picture.rgb).compress(jpeg_quality=QUALITY))
        tape.now(frame, f"{root}/depth", rr.DepthImage(centimetres.astype(np.uint16), meter=CENTIMETRES))
        tape.now(frame, f"{root}/ids", rr.SegmentationImage(ids.astype(np.uint16)))


def _classes(replay: Replay, people: IntArray) -> IntArray:
    """[T, N] the class of a person's pixels: the number, from 1, of the track whose box shows them, else a last one."""
    sequence, persons = replay.sequence, replay.dataset.track_persons(replay.sequence)
    classes = np.full((sequence.frames, len(people)), len(sequence.tracks) + 1)
    frame, track = np.nonzero(sequence.observed & (persons != NOBODY))
    classes[frame, np.searchsorted(people, persons[frame, track])] = track + 1
    return classes


def record_footage(tape: Tape, replay: Replay, backdrop: Backdrop, done: Callable[[], object]) -> None:
    """Record the pictures that the camera itself took, in the frames that have one; ``done`` is called after each."""
    rr, root = tape.rr, ego_root(replay)
    for frame in range(replay.sequence.frames):
        picture = backdrop.recorded(frame)
        if picture is None:
            tape.now(frame, f"{root}/picture", rr.Clear(recursive=False))
        else:
            tape.now(frame, f"{root}/picture", rr.Image(picture).compress(jpeg_quality=QUALITY))
        done()


def _record_frame(tape: Tape, replay: Replay, root: str) -> None:
    """The picture's border and horizon, and in a panorama the directions of its columns; lines of one pixel."""
    rr, camera = tape.rr, replay.camera
    width, height = camera.picture_size
    look: dict[str, Any] = {"colors": [marks.BORDER], "radii": rr.Radius.ui_points(0.5)}
    tape.always(f"{root}/border", rr.Boxes2D(mins=[(0, 0)], sizes=[(width, height)], **look))
    columns = np.linspace(0.0, width, _HORIZON_POINTS)
    rows = camera.horizon(columns)
    inside = (rows >= 0.0) & (rows <= height)
    points = np.stack([columns, rows], axis=-1)
    pieces = np.stack([points[:-1], points[1:]], axis=1)[inside[:-1] & inside[1:]]
    tape.always(f"{root}/horizon", rr.LineStrips2D(pieces, **look))
    ahead = {text: column for text, column in replay.bearings.items() if text != "behind"}
    if ahead:
        places = [(column, 0.04 * height) for column in ahead.values()]
        colours = [marks.TRUTH] * len(ahead)
        tape.always(f"{root}/directions", rr.Points2D(places, labels=list(ahead), colors=colours, radii=2.0))
