"""Frames of a film: the ego view and the map, a title above and a legend below."""

from collections.abc import Iterable, Iterator

import numpy as np

from vbbench.pictures.film import paint
from vbbench.pictures.film.bird import BirdsEyeView
from vbbench.pictures.film.captions import TITLE_HEIGHT, draw_legend, draw_title
from vbbench.pictures.film.ego import draw_ego
from vbbench.pictures.film.paint import Canvas
from vbbench.pictures.rendering import Renderer
from vbbench.pictures.replay import Replay

_MAP = 560  # px, least height of a map
_LEAST_WIDTH = 960  # px, for the words
_FARTHEST = 30.0  # m up to which colours show distances


class Film:
    """The frames of a sequence as pictures of one size; none is kept in memory.

    A picture with borders has the map beside it, a panorama below it.

    Parameters
    ----------
    replay : what to show, with its truth.
    """

    def __init__(self, replay: Replay) -> None:
        self.replay = replay
        self.farthest = float(np.clip(np.ceil(np.nanmax(replay.distances, initial=1.0)), 1.0, _FARTHEST))
        """Distance in m at the light end of the colours."""
        width, height = replay.camera.picture_size
        self._beside = replay.camera.period is None
        if self._beside:
            middle = max(height, _MAP)
            self.bird = BirdsEyeView(replay, self.farthest, max(middle, _LEAST_WIDTH - width), middle)
            self.width = width + self.bird.width
        else:
            self.width = max(width, _LEAST_WIDTH)
            self.bird = BirdsEyeView(replay, self.farthest, self.width, _MAP)
            middle = height + _MAP
        self.width += self.width % 2  # codecs take pairs of columns and rows
        self._legend = draw_legend(self.width, replay, self.farthest)
        self.height = TITLE_HEIGHT + middle + len(self._legend)
        self.height += self.height % 2

    def frames(self, renderer: Renderer, wanted: Iterable[int]) -> Iterator[Canvas]:
        """Pictures [height, width, 3] of the wanted frames of the sequence, each made when it is needed."""
        sequence, replay = self.replay.sequence, self.replay
        for frame in wanted:
            pose = replay.known.poses[frame]
            seen = renderer.render(sequence.first_frame + frame, replay.camera, pose, observer=sequence.observer)
            yield self._compose(seen.rgb, frame)

    def _compose(self, picture: Canvas, frame: int) -> Canvas:
        colours = paint.distance_hues(self.replay.distances[frame], self.farthest)
        ego, bird = draw_ego(picture, self.replay, frame, colours), self.bird.draw(frame, colours)
        canvas = paint.blank(self.width, self.height)
        canvas[:TITLE_HEIGHT] = draw_title(self.width, self.replay, frame)
        rows, columns = ego.shape[:2]
        canvas[TITLE_HEIGHT : TITLE_HEIGHT + rows, :columns] = ego
        top, left = (TITLE_HEIGHT, columns) if self._beside else (TITLE_HEIGHT + rows, 0)
        bottom = top + self.bird.height
        canvas[top:bottom, left : left + self.bird.width] = bird
        canvas[bottom : bottom + len(self._legend)] = self._legend
        return canvas
