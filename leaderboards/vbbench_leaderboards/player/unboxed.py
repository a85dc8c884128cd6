"""People of a sequence who are there but have no box, and why: what a viewer of rendered pictures asks first."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from vbbench.boxes import BOX_ASPECT, cut_to_picture, rectangles
from vbbench.camera import Camera
from vbbench.files.dataset import Dataset
from vbbench.generation.footage import FOOTAGE
from vbbench.geometry import BoolArray, FloatArray, IntArray, relative_to_world, shorter_way, world_to_relative
from vbbench.sequence import Sequence, Truth

CUT, HIDDEN = 0.6, 0.6
"""Who shows less than this share inside the picture is cut off; whose width is covered by more of it is hidden."""

_SAMPLES = np.linspace(-0.5, 0.5, 9)  # of a box's width, at which it may be covered
_FINDERS = ("detector", "tracking")
"""In a dataset's definition, what says that boxes were found, and not drawn around everybody."""


class Reason(IntEnum):
    """Why somebody has no box; 0 is nobody, or somebody who has one. The player's ``scripts/others.js`` has words."""

    OUTSIDE = 1
    CUT = 2
    HIDDEN = 3
    SMALL = 4
    MISSED = 5
    LEFT_OUT = 6


@dataclass(frozen=True, kw_only=True)
class Unboxed:
    """Who has no box: columns are the K tracks of the sequence, then M people while they have none of these.

    Parameters
    ----------
    reasons : [T, K + M] of `Reason`.
    boxes : [T, K + M, 3] (u, v, l) in px where a box would be; NaN outside the picture, and where there is a box.
    positions : [T, M, 2] in m of the M people while they have no box, as the player shows the truth.
    """

    reasons: IntArray
    boxes: FloatArray
    positions: FloatArray


def find_unboxed(dataset: Dataset, sequence: Sequence, truth: Truth) -> Unboxed | None:
    """Everybody of the scene without a box, with the first reason that holds; ``None`` where places are not known.

    Parameters
    ----------
    truth : the sequence's, as the player shows it.
    """
    if dataset.info.truth == "poses":
        return None
    people, places, heights = dataset.surroundings(sequence)
    if dataset.info.truth == "relative":
        places = relative_to_world(places, truth.poses)
    places[:, people == sequence.observer] = np.nan
    camera = dataset.camera(sequence)
    relative = world_to_relative(places, truth.poses)
    boxes = camera.project(relative, np.where(np.isfinite(heights), heights, dataset.info.height_mean))
    persons = dataset.track_persons(sequence)
    smallest = float(sequence.observations[sequence.observed, 2].min(initial=np.inf))
    without = np.isfinite(places[..., 0]) & ~_holds(persons, sequence.observed, people)
    found = any(name in dataset.info.definition for name in _FINDERS) or dataset.info.tier == FOOTAGE
    hides = found or bool(np.any(sequence.visible < 1.0))
    hidden = _hidden(boxes, camera.depth(relative), camera.period) if hides else np.zeros(without.shape)
    reasons = np.where(without, _reasons(boxes, hidden, camera, smallest, found), 0)
    return _by_track(people, persons, reasons, boxes, places)


def _holds(persons: IntArray, observed: BoolArray, people: IntArray) -> BoolArray:
    """[T, P] which of the ``people`` [P] a box shows, ``persons`` [T, K] being those behind the tracks."""
    return np.stack([np.isin(people, row[seen]) for row, seen in zip(persons, observed, strict=True)])


def _reasons(boxes: FloatArray, hidden: FloatArray, camera: Camera, smallest: float, found: bool) -> IntArray:
    """[T, P] why each of the boxes [T, P, 3] might be missing, were it not there, by the share of it that is hidden."""
    whole = rectangles(boxes)
    inside = cut_to_picture(whole, camera)
    share = np.prod(np.clip(inside[..., 2:], 0.0, None), axis=-1) / np.prod(whole[..., 2:], axis=-1)
    if camera.period is not None:  # a cylinder has no upper and lower border
        share = np.ones(share.shape)
    cases = [
        (np.isnan(boxes[..., 0]), Reason.OUTSIDE),
        (share < CUT, Reason.CUT),
        (hidden > HIDDEN, Reason.HIDDEN),
        ((boxes[..., 2] < smallest) & found, Reason.SMALL),
    ]
    other = Reason.MISSED if found else Reason.LEFT_OUT
    return np.select([case for case, _ in cases], [int(reason) for _, reason in cases], int(other))


def _hidden(boxes: FloatArray, depths: FloatArray, period: float | None) -> FloatArray:
    """[T, P] share of each box's width that nearer people stand before."""
    return np.stack([_covered(*moment, period) for moment in zip(boxes, depths, strict=True)])


def _covered(boxes: FloatArray, depths: FloatArray, period: float | None) -> FloatArray:
    """The same [P] of a frame."""
    half = 0.5 * BOX_ASPECT * boxes[:, 2]
    columns = boxes[:, :1] + 2.0 * half[:, None] * _SAMPLES
    across = np.abs(shorter_way(columns[:, :, None] - boxes[:, 0], period)) < half
    covered: FloatArray = (across & (depths < depths[:, None])[:, None]).any(axis=-1).mean(axis=-1)
    return covered


def _by_track(people: IntArray, persons: IntArray, reasons: IntArray, boxes: FloatArray, places: FloatArray) -> Unboxed:
    """Move everybody who is behind a track, of several the last, from the column of the person to that of the track."""
    frames, tracks = persons.shape
    boxes = np.where((reasons > 0)[..., None], boxes, np.nan)
    of_tracks, boxes_of_tracks = np.zeros((frames, tracks), np.int64), np.full((frames, tracks, 3), np.nan)
    frame = np.arange(frames)
    for track in reversed(range(tracks)):
        column = np.searchsorted(people, persons[:, track]).clip(max=len(people) - 1)
        moved = (people[column] == persons[:, track]) & (reasons[frame, column] > 0)
        of_tracks[moved, track] = reasons[frame, column][moved]
        boxes_of_tracks[moved, track] = boxes[frame, column][moved]
        reasons[frame[moved], column[moved]] = 0
    left = (reasons > 0).any(axis=0)
    kept = reasons[:, left]
    return Unboxed(
        reasons=np.hstack([of_tracks, kept]),
        boxes=np.hstack([boxes_of_tracks, np.where((kept > 0)[..., None], boxes[:, left], np.nan)]),
        positions=np.where((kept > 0)[..., None], places[:, left], np.nan),
    )
