"""The table that readers make of a file, and the dense scene made of it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.scene import Scene
from vbbench_generators.readers.gates import (
    check_integers,
    check_on_ground,
    check_phase,
    check_size,
    check_speed,
    check_tracks,
)


@dataclass(frozen=True, kw_only=True)
class TrackTable:
    """One row for each person in each frame, with the line where it stands.

    Parameters
    ----------
    path : the file.
    frame, person : [N] numbers as they stand in the file.
    positions : [N, 2] in m.
    lines : [N] 1-based.
    """

    path: Path
    frame: FloatArray
    person: FloatArray
    positions: FloatArray
    lines: IntArray

    def to_scene(self, dt: float, frame_step: int | None = None) -> Scene:
        """The scene with a row every ``frame_step`` frames (``None``: the commonest step), ``dt`` seconds a row.

        Row 0 is the first frame with anybody in it. Where nobody is, rows are empty.

        Raises
        ------
        FileError
            If a gate of ``gates.py`` is shut; an implausible walking speed is a warning only.
        """
        frame = check_integers(self.path, "frame", self.frame, self.lines)
        person = check_integers(self.path, "id", self.person, self.lines)
        check_on_ground(self.path, self.positions, self.lines)
        order = np.lexsort((self.lines, frame, person))
        frame, person, lines = frame[order], person[order], self.lines[order]
        step = frame_step or commonest_step(frame, person)
        check_tracks(self.path, frame, person, lines, step)
        check_phase(self.path, frame, lines, step)
        scene = self._dense(frame, person, self.positions[order], step, dt)
        check_speed(self.path, scene)
        return scene

    def _dense(self, frame: IntArray, person: IntArray, positions: FloatArray, step: int, dt: float) -> Scene:
        people, column = np.unique(person, return_inverse=True)
        row = _row_of_frame(frame, step)
        frames = int(row.max()) + 1
        check_size(self.path, frames, len(people), len(frame))
        dense = np.full((frames, len(people), 2), np.nan)
        dense[row, column] = positions
        unknown = np.full(len(people), np.nan)
        return Scene(name=self.path.stem, dt=dt, people=people, positions=dense, heights=unknown)


def commonest_step(frame: IntArray, person: IntArray) -> int:
    """The commonest step within tracks, of rows [N] sorted by person, then frame; 1 where there is none."""
    delta = np.diff(frame)[np.diff(person) == 0]
    steps, counts = np.unique(delta[delta > 0], return_counts=True)
    return int(steps[counts.argmax()]) if len(steps) else 1


def _row_of_frame(frame: IntArray, step: int) -> IntArray:
    """Row [N] of each frame. Recordings may go on at another phase after nobody was there, so gaps round up."""
    unique, inverse = np.unique(frame, return_inverse=True)
    rows = np.concatenate([[0], np.cumsum(-(-np.diff(unique) // step))])
    return rows[inverse].astype(np.int64)
