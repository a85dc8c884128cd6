"""A sequence from its rows in the tables of a dataset."""

from typing import Any

import numpy as np

from vbbench.files.dataset_checks import PathOf, Rows, check_frame, check_sequence, check_tracks
from vbbench.files.tables import CAMERA, MOTION, MOTION_COVARIANCE
from vbbench.geometry import IntArray
from vbbench.sequence import NOBODY, Given, Odometry, Sequence, held_persons
from vbbench.world import World

OBSERVER = -1
"""The track number that stands for the observer in ``given.parquet``."""


def sequence_of(path_of: PathOf, facts: dict[str, Any], boxes: Rows, given: Rows, moved: Rows | None) -> Sequence:
    """The sequence, checked.

    Parameters
    ----------
    path_of : the path of a table, by name, for messages.
    facts : its row of ``sequences``.
    boxes, given, moved : its rows of ``observations``, ``given`` and ``odometry``, if there is that table.

    Raises
    ------
    FileError
        If the rows contradict one another.
    """
    tracks, column = np.unique(boxes["track"], return_inverse=True)
    shape = (int(facts["frames"]), len(tracks))
    check_sequence(path_of, int(facts["sequence"]), shape[0], boxes, given, tracks)
    observations = np.full((*shape, 3), np.nan)
    observations[boxes["frame"], column] = np.stack([boxes["u"], boxes["v"], boxes["l"]], axis=-1)
    visible = np.full(shape, np.nan)
    visible[boxes["frame"], column] = boxes["visible"]
    return Sequence(
        index=int(facts["sequence"]),
        scene=int(facts["scene"]),
        observer=int(facts["observer"]),
        first_frame=int(facts["first_frame"]),
        tracks=tracks,
        observations=observations,
        visible=visible,
        given=_dense_given(given, tracks, shape, moved),
        camera=int(facts[CAMERA]),
    )


def persons_of(path_of: PathOf, index: int, frames: int, tracks: IntArray, rows: Rows) -> IntArray:
    """[T, K] the person behind each of the ``tracks`` of a sequence, from its ``rows`` of ``truth/tracks``.

    Raises FileError if they name other tracks or frames.
    """
    check_tracks(path_of, index, frames, tracks, rows)
    column = np.searchsorted(tracks, rows["track"])
    persons, begun = np.full((frames, len(tracks)), NOBODY), np.zeros((frames, len(tracks)), np.bool_)
    persons[rows["frame"], column] = rows["person"]
    begun[rows["frame"], column] = True
    return held_persons(persons, begun)


def world_of(path_of: PathOf, index: int, rows: Rows) -> World:
    """The world of a sequence, from its ``rows`` of ``truth/frames``; raises FileError unless there is one."""
    check_frame(path_of, index, rows)
    return World(**{name: float(rows[name][0]) for name in ("x", "y", "yaw")})


def _dense_given(rows: Rows, tracks: IntArray, shape: tuple[int, int], moved: Rows | None) -> Given:
    poses, positions = np.full((shape[0], 3), np.nan), np.full((*shape, 2), np.nan)
    own = rows["track"] == OBSERVER
    poses[rows["frame"][own]] = np.stack([rows["x"][own], rows["y"][own], rows["yaw"][own]], axis=-1)
    column = np.searchsorted(tracks, rows["track"][~own])
    positions[rows["frame"][~own], column] = np.stack([rows["x"][~own], rows["y"][~own]], axis=-1)
    odometry = None if moved is None else _dense_odometry(moved, shape[0])
    return Given(poses=poses, positions=positions, odometry=odometry)


def _dense_odometry(rows: Rows, frames: int) -> Odometry:
    motions, covariances = np.full((frames, 3), np.nan), np.full((frames, 3, 3), np.nan)
    motions[rows["frame"]] = np.stack([rows[name] for name in MOTION], axis=-1)
    i, j = np.triu_indices(3)
    triangle = np.stack([rows[name] for name in MOTION_COVARIANCE], axis=-1)
    for where in ((i, j), (j, i)):
        covariances[rows["frame"][:, None], where[0], where[1]] = triangle
    return Odometry(motions=motions, covariances=covariances)
