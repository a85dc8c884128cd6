"""A generated sequence as rows of the dataset's tables."""

from typing import Any

import numpy as np

from vbbench.files.sequence_rows import OBSERVER
from vbbench.files.tables import CAMERA, FRAME_TABLE, MOTION, MOTION_COVARIANCE, ODOMETRY_TABLE, TRACK_TABLE, Columns
from vbbench.geometry import IntArray
from vbbench.scene import Scene
from vbbench.sequence import NOBODY, Odometry, SequenceData
from vbbench.world import World


def scene_rows(scene: Scene, number: int) -> dict[str, Columns]:
    """The scene in the tables of truth: one row per person and frame, by frame, and one row per person."""
    frame, column = np.nonzero(scene.present)
    x, y = scene.positions[frame, column].T
    people = {"scene": np.full(len(scene.people), number), "person": scene.people, "height": scene.heights}
    where = {"scene": np.full(len(frame), number), "frame": frame, "person": scene.people[column]}
    return {"truth/scenes": {**where, "x": x, "y": y}, "truth/people": people}


def sequence_row(data: SequenceData, split: str) -> dict[str, Any]:
    """The row of a sequence in ``sequences.parquet``."""
    s = data.sequence
    return {
        "sequence": s.index,
        "scene": s.scene,
        "observer": s.observer,
        "first_frame": s.first_frame,
        "frames": s.frames,
        "people": len(s.tracks),
        "split": split,
        CAMERA: s.camera,
    }


def observation_rows(data: SequenceData) -> Columns:
    """One row per box, by frame and track."""
    s = data.sequence
    boxes = np.flatnonzero(s.observed)
    frame, column = np.divmod(boxes.astype(np.int32), np.int32(max(len(s.tracks), 1)))
    u, v, length = s.observations.reshape(-1, 3).take(boxes, axis=0).T
    return {
        "sequence": np.full(len(frame), s.index, np.int32),
        "frame": frame,
        "track": s.tracks.astype(np.int32)[column],
        "u": u,
        "v": v,
        "l": length,
        "visible": s.visible.reshape(-1).take(boxes).astype(np.float32),
    }


def given_rows(data: SequenceData) -> Columns:
    """One row per given position, by frame; the observer, with its yaw, comes first."""
    s = data.sequence
    own = np.flatnonzero(~np.isnan(s.given.poses[:, 0]))
    frame, column = np.nonzero(~np.isnan(s.given.positions[..., 0]))
    order = np.argsort(np.concatenate([own, frame]), kind="stable")
    poses, positions = s.given.poses[own], s.given.positions[frame, column]
    return {
        "sequence": np.full(len(order), s.index, np.int32),
        "frame": np.concatenate([own, frame])[order],
        "track": np.concatenate([np.full(len(own), OBSERVER), s.tracks[column]])[order],
        "x": np.concatenate([poses[:, 0], positions[:, 0]])[order],
        "y": np.concatenate([poses[:, 1], positions[:, 1]])[order],
        "yaw": np.concatenate([poses[:, 2], np.full(len(frame), np.nan)])[order],
    }


def odometry_rows(sequence: int, odometry: Odometry) -> Columns:
    """One row per measured motion, by frame."""
    frame = np.flatnonzero(np.isfinite(odometry.motions).all(axis=1))
    i, j = np.triu_indices(3)
    columns = dict(zip(MOTION, odometry.motions[frame].T, strict=True))
    columns |= dict(zip(MOTION_COVARIANCE, odometry.covariances[frame][:, i, j].T, strict=True))
    return {"sequence": np.full(len(frame), sequence), "frame": frame, **columns}


def pose_rows(data: SequenceData) -> Columns:
    """One row per frame: the true pose."""
    x, y, yaw = data.truth.poses.T
    where = {"sequence": np.full(len(x), data.sequence.index, np.int32), "frame": np.arange(len(x), dtype=np.int32)}
    return {**where, "x": x, "y": y, "yaw": yaw}


def track_rows(data: SequenceData, persons: IntArray) -> Columns:
    """One row where a track begins to stand for a person, or for nobody after one, by frame and track.

    Parameters
    ----------
    persons : [T, K] the person behind each track, `NOBODY` before its first box.
    """
    begins = np.empty(persons.shape, bool)
    begins[:1] = persons[:1] != NOBODY
    np.not_equal(persons[1:], persons[:-1], out=begins[1:])
    frame, column = np.nonzero(begins)
    return {
        "sequence": np.full(len(frame), data.sequence.index, np.int32),
        "frame": frame,
        "track": data.sequence.tracks[column],
        "person": persons[frame, column],
    }


def frame_rows(sequence: int, world: World) -> Columns:
    """One row: where the scene lies in the sequence's own world."""
    return {"sequence": np.array([sequence]), **{name: np.array([value]) for name, value in vars(world).items()}}


def sequence_rows(data: SequenceData) -> dict[str, Columns]:
    """Everything that is written of a sequence, by table."""
    tables = {"observations": observation_rows(data), "given": given_rows(data), "truth/poses": pose_rows(data)}
    if data.sequence.given.odometry is not None:
        tables[ODOMETRY_TABLE] = odometry_rows(data.sequence.index, data.sequence.given.odometry)
    if data.persons is not None:
        tables[TRACK_TABLE] = track_rows(data, data.persons)
    if data.world is not None:
        tables[FRAME_TABLE] = frame_rows(data.sequence.index, data.world)
    return tables if data.scene is None else tables | scene_rows(data.scene, data.sequence.scene)
