"""Heads in the pictures of one camera that stands still: their boxes, and their centres."""

from dataclasses import dataclass, replace

import numpy as np

from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze


@dataclass(frozen=True, kw_only=True)
class HeadBoxes:
    """Head boxes of one recording, one a row, by track, then by frame; a track has one box a frame at most.

    Parameters
    ----------
    name : what the recording is called, such as ``HT21-03``.
    dt : seconds per frame.
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
        freeze(self, np.int64, frame=(count,), track=(count,))
        freeze(self, boxes=(count, 4), visible=(count,))
        if np.any((np.diff(self.track) < 0) | ((np.diff(self.track) == 0) & (np.diff(self.frame) <= 0))):
            raise ValueError("head boxes must be ordered by track, then by frame, with one box per frame")

    def __len__(self) -> int:
        return len(self.frame)

    @property
    def centre(self) -> FloatArray:
        """[2] of the picture, in px."""
        return np.array(self.size) / 2.0

    @property
    def whole(self) -> BoolArray:
        """[N] which boxes the picture's edge does not cut."""
        left, top, width, height = self.boxes.T
        whole: BoolArray = (left > 0.0) & (top > 0.0) & (left + width < self.size[0]) & (top + height < self.size[1])
        return whole

    def heads(self) -> "Heads":
        """The boxes' centres."""
        x, nu = (self.boxes[:, n] + (self.boxes[:, n + 2] - self.size[n]) / 2.0 for n in range(2))
        return Heads(x=x, nu=nu, frame=self.frame, track=self.track, dt=self.dt)


@dataclass(frozen=True, kw_only=True)
class Heads:
    """Head centres in px from the picture's centre, by track, then by frame: [N] each; ``dt`` in s."""

    x: FloatArray
    nu: FloatArray
    frame: IntArray
    track: IntArray
    dt: float

    def take(self, chosen: BoolArray | IntArray) -> "Heads":
        """The heads ``chosen`` by index or mask."""
        x, nu = self.x[chosen], self.nu[chosen]
        return replace(self, x=x, nu=nu, frame=self.frame[chosen], track=self.track[chosen])


def split_at_gaps(heads: Heads, gap: float) -> Heads:
    """The same heads with tracks split at gaps of more than ``gap`` s.

    The first part keeps its id; the others get ids above the highest. Heads stay ordered by track, then by frame.
    """
    limit = max(1, int(np.floor(gap / heads.dt + 1e-9)))
    opening = np.r_[True, heads.track[1:] != heads.track[:-1]]
    broken = np.r_[False, np.diff(heads.frame) > limit] & ~opening
    if not broken.any():
        return heads
    piece = np.cumsum(broken)
    since = np.maximum.accumulate(np.where(opening | broken, np.arange(len(opening)), 0))
    track = np.where(broken[since], heads.track.max() + piece[since], heads.track)
    return replace(heads, track=track).take(np.argsort(track, kind="stable"))
