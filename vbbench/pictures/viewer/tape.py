"""A rerun recording of one sequence: all its frames at once, an entity at a time."""

from typing import Any

import numpy as np

from vbbench.geometry import IntArray

FRAME, TIME = "frame", "time"
"""The two timelines: frame of the sequence from 0, and seconds from its start."""


class Tape:
    """Takes what there is to show of an entity in every frame, in columns: no loop over frames, and a small file.

    Parameters
    ----------
    stream : a ``rerun.RecordingStream``.
    frames : number of frames.
    dt : seconds a frame.
    """

    def __init__(self, stream: Any, frames: int, dt: float) -> None:
        from vbbench.pictures.viewer.sdk import rerun

        self.rr = rerun()
        self.stream, self.frames, self.dt = stream, frames, dt

    def always(self, path: str, shown: Any) -> None:
        """Something that is there in every frame."""
        self.stream.log(path, shown, static=True)

    def now(self, frame: int, path: str, shown: Any) -> None:
        """Something that is too large for columns, in one frame."""
        self.stream.set_time(FRAME, sequence=frame)
        self.stream.set_time(TIME, duration=frame * self.dt)
        self.stream.log(path, shown)

    def each(self, path: str, kind: Any, frames: IntArray | None = None, **values: Any) -> None:
        """One value of every component in each of the ``frames`` (``None``: in all)."""
        wanted = np.arange(self.frames) if frames is None else frames
        if len(wanted):
            self.stream.send_columns(path, self._times(wanted), kind.columns(**values))

    def many(self, path: str, kind: Any, counts: IntArray, **values: Any) -> None:
        """So many instances in each frame: counts [T], and components that hold those of all frames on end."""
        if counts.any():
            columns = kind.columns(**values).partition(counts)
            self.stream.send_columns(path, self._times(np.arange(self.frames)), columns)

    def _times(self, frames: IntArray) -> list[Any]:
        column = self.rr.TimeColumn
        return [column(FRAME, sequence=frames), column(TIME, duration=frames * self.dt)]
