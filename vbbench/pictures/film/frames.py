"""Frames of a film, one after the other: the ego view and the map, a title above and a legend below."""

from collections.abc import Iterable, Iterator

import numpy as np

from vbbench.camera import PerspectiveCamera
from vbbench.pictures.film import paint
from vbbench.pictures.film.captions import TITLE_HEIGHT, Legend, draw_title
from vbbench.pictures.film.chart import Chart, distance_colours_of
from vbbench.pictures.film.ego import draw_ego
from vbbench.pictures.film.paint import Canvas
from vbbench.pictures.film.reel import Reel
from vbbench.pictures.renderer import Renderer

_CHART = 560  # px, least height of a map
_LEAST_WIDTH = 960  # px, for the words


class Film:
    """The frames of a sequence as pictures of one size; nothing is kept of those that were made.

    A perspective picture has the map beside it, a panorama below it.

    Parameters
    ----------
    reel : what to show.
    """

    def __init__(self, reel: Reel) -> None:
        self.reel = reel
        camera = reel.dataset.info.camera
        width, height = camera.picture_size
        self._beside = isinstance(camera, PerspectiveCamera)
        if self._beside:
            tall = max(height, _CHART)
            self.chart = Chart(reel, max(tall, _LEAST_WIDTH - width), tall)
            self.width, middle = width + self.chart.width, tall
        else:
            self.width = max(width, _LEAST_WIDTH)
            self.chart = Chart(reel, self.width, _CHART)
            middle = height + _CHART
        self.width += self.width % 2  # codecs take pairs of columns and rows
        self._legend = Legend.of(reel, self.width).canvas
        self.height = TITLE_HEIGHT + middle + len(self._legend)
        self.height += self.height % 2

    def frames(self, renderer: Renderer, wanted: Iterable[int]) -> Iterator[Canvas]:
        """Pictures [height, width, 3] of the wanted frames of the sequence, each made when it is asked for."""
        sequence, camera = self.reel.sequence, self.reel.dataset.info.camera
        for frame in wanted:
            pose = self.reel.truth.poses[frame]
            seen = renderer.render(sequence.first_frame + frame, camera, pose, observer=sequence.observer)
            yield self._compose(seen.rgb, frame)

    def _compose(self, picture: Canvas, frame: int) -> Canvas:
        moment = self.reel.moment(frame)
        ego = draw_ego(picture, moment, distance_colours_of(moment, self.reel))
        chart = self.chart.draw(moment)
        canvas = paint.blank(self.width, self.height)
        canvas[:TITLE_HEIGHT] = draw_title(self.width, moment)
        rows, columns = ego.shape[:2]
        canvas[TITLE_HEIGHT : TITLE_HEIGHT + rows, :columns] = ego
        top, left = (TITLE_HEIGHT, columns) if self._beside else (TITLE_HEIGHT + rows, 0)
        canvas[top : top + self.chart.height, left : left + self.chart.width] = chart
        bottom = top + self.chart.height
        canvas[bottom : bottom + len(self._legend)] = self._legend
        return np.ascontiguousarray(canvas)
