"""The failure policy `hold`: a missing row is filled with the last known value of its track or observer."""

from dataclasses import replace

import numpy as np

from vbbench.files.dataset import OBSERVER
from vbbench.geometry import FloatArray, IntArray
from vbbench.scoring.matched_rows import Answers
from vbbench.scoring.scored_rows import ScoredRows


def hold(rows: ScoredRows, answers: Answers) -> Answers:
    """The answers with every gap filled.

    A missing pose is the observer's last one, a missing position the track's last one, given or estimated, at an
    earlier frame of the sequence; a track never known before stands where the observer does.
    """
    if answers.posed.all() and answers.placed.all():
        return answers
    poses = _fill_poses(rows, answers)
    return replace(answers, poses=poses, positions=_fill_positions(rows, answers, poses))


def _fill_poses(rows: ScoredRows, answers: Answers) -> FloatArray:
    own = rows.given["track"] == OBSERVER
    given = np.stack([rows.given[name][own] for name in ("x", "y", "yaw")], axis=-1)
    group = np.concatenate([rows.given["sequence"][own], rows.pose_sequence[answers.posed]])
    frame = np.concatenate([rows.given["frame"][own], rows.pose_frame[answers.posed]])
    known = np.concatenate([given, answers.poses[answers.posed]])
    gap = ~answers.posed
    poses = answers.poses.copy()
    poses[gap] = _last_known(group, frame, known, rows.pose_sequence[gap], rows.pose_frame[gap])
    return poses


def _fill_positions(rows: ScoredRows, answers: Answers, poses: FloatArray) -> FloatArray:
    grid, placed = rows.grid, answers.placed
    people = rows.given["track"] != OBSERVER
    given = {name: values[people] for name, values in rows.given.items()}
    own_group = grid.group(rows.sequence, rows.track)
    group = np.concatenate([grid.group(given["sequence"], given["track"]), own_group[placed]])
    frame = np.concatenate([given["frame"], rows.frame[placed]])
    known = np.concatenate([np.stack([given["x"], given["y"]], axis=-1), answers.positions[placed]])
    last = _last_known(group, frame, known, own_group[~placed], rows.frame[~placed])
    observer = poses[rows.pose_of_position[~placed], :2]
    positions = answers.positions.copy()
    positions[~placed] = np.where(np.isnan(last), observer, last)
    return positions


def _last_known(
    group: IntArray, frame: IntArray, values: FloatArray, wanted_group: IntArray, wanted_frame: IntArray
) -> FloatArray:
    """For each wanted group and frame [M] the value [M, C] of the group's latest earlier row; NaN if it has none."""
    stride = int(max(frame.max(initial=0), wanted_frame.max(initial=0))) + 1
    key = group.astype(np.int64) * stride + frame
    order = np.argsort(key)
    place = np.searchsorted(key[order], wanted_group.astype(np.int64) * stride + wanted_frame) - 1
    if not len(key):
        return np.full((len(place), values.shape[1]), np.nan)
    row = order[place]
    found = (place >= 0) & (group[row] == wanted_group)
    return np.where(found[:, None], values[row], np.nan)
