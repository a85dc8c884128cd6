"""Whether boxes can be of the camera's picture: what does not fit is said with numbers, or refused."""

from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.own.box_files import BoxRows
from vbbench.exchange.own.camera_file import OwnCamera
from vbbench.exchange.sequence_files import SEQUENCE_INFO, picture_size_of
from vbbench.geometry import BoolArray, FloatArray, runs_of_true

MOST_OUTSIDE = 0.2
"""A larger share of boxes whose middle is outside the picture means that they are of another picture."""
UNFILLED, ENOUGH = 0.6, 200
"""Boxes that reach no farther into the picture than this share of it, if there are so many, are worth a note."""
FEW = 20
"""Fewer boxes do not tell what is wrong with all."""
LONGEST_GAP, MOST_EMPTY = 1.0, 0.1
"""Seconds without a box, and the share of frames without one, from which a note says so."""


def fitting(rows: BoxRows, own: OwnCamera) -> tuple[BoxRows, tuple[str, ...]]:
    """The boxes whose middle lies in the picture, and notes.

    Raises
    ------
    FileError
        If they are shares of the picture in place of px, too many lie outside it, or a ``seqinfo.ini`` beside the file
        names another size.
    """
    _check_sequence_info(rows.path, own)
    across, down = rows.boxes[:, 0] + 0.5 * rows.boxes[:, 2], rows.boxes[:, 1] + 0.5 * rows.boxes[:, 3]
    width, height = own.facts.picture
    shown = f"{width:g} x {height:g} px"
    if (np.abs(rows.boxes) <= 1.5).all():
        problem = f"all boxes are within 1.5 px: they seem to be shares of the picture; write px of {shown}"
        raise FileError(rows.path, problem)
    if _are_corners(rows.boxes, own.facts.picture):
        problem = "width and height seem to be the right and lower borders of boxes; subtract left and top from them"
        raise FileError(rows.path, problem)
    beside = (across < 0.0) | (across >= width)
    outside = np.asarray((down < 0.0) | (down >= height) | (beside & (own.camera.period is None)))
    count, lost = len(outside), int(outside.sum())
    if lost > MOST_OUTSIDE * count:
        right, bottom = np.quantile(rows.boxes[:, 0] + rows.boxes[:, 2], 0.99), np.quantile(down, 0.99)
        raise FileError(
            rows.path,
            f"the middle of {lost} of {count} boxes is outside the picture of {shown} ({own.path.name}): they reach "
            f"column {right:.0f} and row {bottom:.0f}; write the size of the picture that the boxes are of",
        )
    notes = [f"{lost} of {count} boxes are left out: their middle is outside the picture of {shown}"] if lost else []
    inside = rows.select(~outside)
    reach = (inside.boxes[:, :2] + inside.boxes[:, 2:]).max(axis=0) / (width, height)
    if count >= ENOUGH and (reach < UNFILLED).all():
        share = " x ".join(f"{part:.0%}" for part in reach)
        notes.append(f"boxes fill only the upper left {share} of {shown}; is that the size of the picture they are of?")
    return inside, tuple(notes)


def _are_corners(boxes: FloatArray, picture: tuple[float, float]) -> bool:
    """Whether boxes [N, 4] (left, top, width, height), most of them beyond the picture, lie in it as two corners.

    One person near the upper left may look like that, several people do not.
    """
    near, far = boxes[:, :2], boxes[:, 2:]
    beyond, spread = (near + far > picture).any(axis=1), float(np.ptp(near[:, 0]))
    several = len(boxes) >= FEW and spread > np.median(far[:, 0] - near[:, 0])
    return bool(several and beyond.mean() > 0.5 and (far > near).all() and (far <= picture).all())


def _check_sequence_info(path: Path, own: OwnCamera) -> None:
    """Refuse another size than MOTChallenge's ``seqinfo.ini`` beside the boxes has."""
    found = next((one for one in (path.parent, path.parent.parent) if (one / SEQUENCE_INFO).is_file()), path.parent)
    size, facts = picture_size_of(found / SEQUENCE_INFO), own.facts
    if size is not None and (facts.width, facts.height or size[1]) != size:
        raise FileError(
            own.path,
            f"says {facts.width} x {facts.height} px, {found / SEQUENCE_INFO} says {size[0]} x {size[1]}; write the "
            "size of the picture that the boxes are of, with the focal length that belongs to it",
        )


def gaps(observed: BoolArray, dt: float) -> tuple[str, ...]:
    """A note on frames in which nobody is seen, [T, K], if there are many of them or many in a row."""
    empty = np.asarray(~observed.any(axis=1))
    runs = runs_of_true(empty)
    longest = runs[np.diff(runs, axis=1)[:, 0].argmax()] if len(runs) else np.zeros(2, np.int64)
    seconds = float(longest[1] - longest[0]) * dt
    if seconds < LONGEST_GAP and empty.mean() < MOST_EMPTY:
        return ()
    most = f"the longest gap is {seconds:.3g} s, from frame {longest[0]}"
    return (
        f"{int(empty.sum())} of {len(empty)} frames have no box ({most}): nothing but motion priors carries over it",
    )


def box_noise(boxes: FloatArray, width: float, period: float | None) -> float | None:
    """Standard deviation in px of the columns, tops and bottoms of boxes [T, K, 3], by their third differences.

    Noise that is white from frame to frame has third differences of variance 20 σ², and whoever walks hardly any. What
    changes slowly, as a limb that sticks out for a second, is not seen in them. ``None`` if there are too few.
    """
    u, v, length = np.moveaxis(boxes, -1, 0)
    edges = np.stack([u, v - 0.5 * length, v + 0.5 * length])
    thirds = np.diff(edges, n=3, axis=1)
    if period is not None:
        thirds[0][np.abs(thirds[0]) > 0.5 * width] = np.nan
    thirds = thirds[np.isfinite(thirds)]
    return float(1.4826 * np.median(np.abs(thirds)) / np.sqrt(20.0)) if len(thirds) >= 100 else None
