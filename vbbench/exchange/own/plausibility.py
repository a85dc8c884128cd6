"""Whether boxes can be of the camera's picture: what does not fit is said with numbers, or refused."""

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from vbbench.box_checks import find_misfit, outside_picture
from vbbench.errors import FileError
from vbbench.exchange.own.box_files import OwnBoxes
from vbbench.exchange.own.camera_file import OwnCamera
from vbbench.exchange.sequence_files import SEQUENCE_INFO, picture_facts
from vbbench.geometry import BoolArray, FloatArray, runs_of_true

LONGEST_GAP, MOST_EMPTY = 1.0, 0.1
"""Seconds without a box, and the share of frames without one, from which a note says so."""

LEAST_DEGREES = 0.1
"""A pitch that is larger, in rad, may be one in degrees."""


def fitting(rows: OwnBoxes, own: OwnCamera) -> tuple[OwnBoxes, tuple[str, ...]]:
    """The boxes whose middle lies in the picture, and notes.

    Raises
    ------
    FileError
        If they cannot be people in this picture (`find_misfit`).
    """
    picture = own.facts.picture
    misfit = find_misfit(rows.boxes, own.camera, picture, own.facts.height_mean)
    if misfit is not None and misfit.certain:
        raise FileError(rows.path, misfit.text)
    if misfit is not None and abs(own.facts.pitch) > LEAST_DEGREES and "pitch" in vars(own.camera):
        pitch = float(np.radians(own.facts.pitch))
        level = replace(cast(Any, own.camera), pitch=pitch)
        if find_misfit(rows.boxes, level, picture, own.facts.height_mean) is None:
            text = f"pitch = {own.facts.pitch:g} is in rad, and boxes fit so many degrees: write pitch = {pitch:.4g}"
            misfit = misfit._replace(text=text)
    outside = outside_picture(rows.boxes, own.camera, picture)
    lost, shown = int(outside.sum()), f"{picture[0]:g} x {picture[1]:g} px"
    note = f"{lost} of {len(outside)} boxes are left out: their middle is outside the picture of {shown}"
    notes = [*([note] if lost else []), *([misfit.text] if misfit else [])]
    return rows.select(~outside), tuple(notes)


def frame_seconds(boxes: Path, own: OwnCamera, dt: float | None) -> float | None:
    """Seconds per frame by the camera file, by ``dt``, or by MOTChallenge's ``seqinfo.ini`` of a file of boxes.

    Raises
    ------
    FileError
        If there is a ``seqinfo.ini`` that names another size or frame rate.
    """
    beside = (folder / SEQUENCE_INFO for folder in (boxes.parent, boxes.parent.parent))
    found = next((path for path in beside if path.is_file()), boxes.parent / SEQUENCE_INFO)
    stated = picture_facts(found)
    size, rate = stated.size, stated.rate
    facts, seconds = own.facts, own.facts.seconds or dt
    if any(size) and (facts.width, facts.height or size[1]) != size:
        raise FileError(
            own.path,
            f"says {facts.width} x {facts.height} px, {found} says {size[0]} x {size[1]}; write the "
            "size of the picture that the boxes are of, with the focal length that belongs to it",
        )
    if seconds is not None and not stated.has_dt(seconds):
        problem = f"{1.0 / seconds:.4g} frames a second are given, {found} says frameRate={rate:g}"
        raise FileError(own.path, f"{problem}; write the rate of the frames that the boxes are of in both")
    return 1.0 / rate if seconds is None and rate else seconds


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
