"""Boxes of heads in the pictures of one camera that stands still."""

from dataclasses import dataclass

import numpy as np

from vbbench.arrays import FloatArray, IntArray, frozen_array


@dataclass(frozen=True, kw_only=True)
class HeadBoxes:
    """Head boxes of one recording, one a row, by track, then by frame; a track has one box a frame at most.

    Parameters
    ----------
    name : what the recording is called, such as ``HT21-03``.
    dt : seconds a frame.
    size : width and height of the pictures in px.
    frame : [N] from 0, the recording's first frame.
    track : [N] ids.
    boxes : [N, 4] (left, top, width, height) in px from 0, the corner of the picture.
    visible : [N] visible fraction in (0, 1].
    """

    name: str
    dt: float
    size: tuple[int, int]
    frame: IntArray
    track: IntArray
    boxes: FloatArray
    visible: FloatArray

    def __post_init__(self) -> None:
        count = len(self.frame)
        for name in ("frame", "track"):
            object.__setattr__(self, name, frozen_array(name, getattr(self, name), (count,), np.int64))
        object.__setattr__(self, "boxes", frozen_array("boxes", self.boxes, (count, 4)))
        object.__setattr__(self, "visible", frozen_array("visible", self.visible, (count,)))
        if np.any((np.diff(self.track) < 0) | ((np.diff(self.track) == 0) & (np.diff(self.frame) <= 0))):
            raise ValueError("head boxes stand by track, then by frame, one box a frame")

    def __len__(self) -> int:
        return len(self.frame)
