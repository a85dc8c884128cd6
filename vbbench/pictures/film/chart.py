"""The bird's-eye view of a film: the whole sequence in one window that stands still."""

import numpy as np

from vbbench.camera import PerspectiveCamera
from vbbench.geometry import FloatArray
from vbbench.pictures.film import hues, paint
from vbbench.pictures.film.paint import Canvas
from vbbench.pictures.film.reel import Reel
from vbbench.pictures.plotting import labels, style
from vbbench.pictures.plotting.moment import Moment

_MARGIN = 1.0  # m around everything drawn
_OUTLIER = 2.0  # m beyond the truth that an estimate may widen the view
_REACH = 20.0  # m from the observer's path; who is farther away may be outside the map
_TAIL_SECONDS = 3.0
_ARROW = 44.0  # px
_LABEL = 12  # px
_FIELD = 12.0  # m that the field of view is drawn deep, at most
_STEPS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
"""Lengths in m that the grid and the scale bar may have."""


class Chart:
    """Draws one frame after the other on a map of ``width`` x ``height`` px.

    Parameters
    ----------
    reel : the sequence.
    width, height : size in px.
    """

    def __init__(self, reel: Reel, width: int, height: int) -> None:
        self._reel, self.width, self.height = reel, width, height
        low, high = _extent(reel)
        self.scale = float(min((width, height) / (high - low)))
        """Pixels a metre."""
        self._middle = (low + high) / 2.0
        self._step = next((s for s in _STEPS if s * self.scale >= 60.0), _STEPS[-1])
        self._tail = max(style.TAIL_FRAMES, round(_TAIL_SECONDS / reel.scene.dt))
        self._ground = self._draw_ground()

    def place(self, points: FloatArray) -> FloatArray:
        """Column and row [..., 2] in px of world positions in m; north is up."""
        offset = (points - self._middle) * self.scale
        return np.stack([0.5 * self.width + offset[..., 0], 0.5 * self.height - offset[..., 1]], axis=-1)

    def draw(self, moment: Moment) -> Canvas:
        """The map of one frame."""
        canvas = self._ground.copy()
        people = distance_colours_of(moment, self._reel)
        self._draw_field_of_view(canvas, moment)
        self._draw_paths(canvas, moment, people)
        self._draw_people(canvas, moment, people)
        self._draw_observers(canvas, moment)
        self._draw_labels(canvas, moment)
        self._draw_scale_bar(canvas)
        return canvas

    def _draw_ground(self) -> Canvas:
        """What never changes: the grid, and everybody's track from beginning to end."""
        canvas = paint.blank(self.width, self.height)
        half = np.array([self.width, self.height]) / (2.0 * self.scale)
        low, high = self._middle - half, self._middle + half
        for axis in (0, 1):
            for value in np.arange(np.ceil(low[axis] / self._step), np.floor(high[axis] / self._step) + 1) * self._step:
                ends = np.stack([low, high])
                ends[:, axis] = value
                paint.draw_lines(canvas, self.place(ends)[None], hues.GRID)
        for track in range(len(self._reel.sequence.tracks)):
            paint.draw_path(canvas, self.place(self._reel.truth.positions[:, track]), hues.TRUTH_FAINT)
        return canvas

    def _draw_field_of_view(self, canvas: Canvas, moment: Moment) -> None:
        camera, pose = moment.info.camera, moment.known_pose
        if not isinstance(camera, PerspectiveCamera):
            return
        right, left = np.arctan([(camera.width - camera.cx) / camera.focal, camera.cx / camera.focal])
        angles = pose[2] + np.linspace(-right, left, 25)
        arc = pose[:2] + min(self._reel.farthest, _FIELD) * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        corners = self.place(np.vstack([pose[:2], arc]))
        tint = paint.blank(self.width, self.height)
        paint.draw_polygon(tint, corners, hues.FIELD)
        np.minimum(canvas, tint, out=canvas)
        paint.draw_path(canvas, np.vstack([corners, corners[:1]]), hues.FIELD_EDGE)

    def _draw_paths(self, canvas: Canvas, moment: Moment, people: list[paint.Colour]) -> None:
        now, truth, estimate = moment.frame + 1, self._reel.truth, self._reel.estimate
        recent = slice(max(0, now - self._tail), now)
        for track in np.flatnonzero(moment.observed):
            paint.draw_path(canvas, self.place(truth.positions[recent, track]), hues.TRUTH_TAIL, 2)
            if estimate is not None:
                shown = np.where(
                    self._reel.sequence.observed[recent, track, None], estimate.positions[recent, track], np.nan
                )
                paint.draw_path(canvas, self.place(shown), people[track], 2)
        paint.draw_path(canvas, self.place(truth.poses[:now, :2]), hues.TRUTH, 2)
        if estimate is not None:
            paint.draw_path(canvas, self.place(estimate.poses[:now, :2]), hues.ESTIMATE, 2)

    def _draw_people(self, canvas: Canvas, moment: Moment, people: list[paint.Colour]) -> None:
        for place in self.place(self._reel.unseen(moment.frame)):
            paint.draw_disc(canvas, place, 3.5, hues.WHITE, hues.UNSEEN)
        known, guessed = self.place(moment.known), self.place(moment.estimated)
        there = moment.observed & np.isfinite(known[:, 0])
        if moment.estimate is None:
            for track in np.flatnonzero(there):
                paint.draw_disc(canvas, known[track], 6.0, people[track], hues.TRUTH)
            return
        for track in np.flatnonzero(there):
            paint.draw_disc(canvas, known[track], 6.5, hues.WHITE, hues.TRUTH)
        paint.draw_lines(canvas, np.stack([known, guessed], axis=1), hues.INK, 2)
        for track in np.flatnonzero(np.isfinite(guessed[:, 0])):
            paint.draw_disc(canvas, guessed[track], 4.5, people[track])

    def _draw_observers(self, canvas: Canvas, moment: Moment) -> None:
        poses = [(moment.known_pose, hues.TRUTH)]
        if moment.estimate is not None:
            poses.append((moment.estimate.poses[moment.frame], hues.ESTIMATE))
            ends = self.place(np.stack([pose[:2] for pose, _ in poses]))
            paint.draw_lines(canvas, ends[None], hues.INK, 2)
        for pose, colour in poses:
            if np.isfinite(pose).all():
                paint.draw_arrow(canvas, *self._arrow(pose), colour)

    def _arrow(self, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
        tail = self.place(pose[:2])
        return tail, tail + _ARROW * np.array([np.cos(pose[2]), -np.sin(pose[2])])

    def _draw_labels(self, canvas: Canvas, moment: Moment) -> None:
        """Ids beside people, the nearest first; who has no free place goes without."""
        places = self.place(np.where(np.isnan(moment.estimated), moment.known, moment.estimated))
        size = np.array([self.width, self.height])
        inside = np.all((places > 0) & (places < size), axis=1)
        shown = np.flatnonzero(moment.observed & inside)
        order = shown[np.argsort(moment.distances[shown])]
        texts = [str(track) for track in moment.sequence.tracks[order]]
        pose = moment.known_pose if moment.estimate is None else moment.estimate.poses[moment.frame]
        tail, tip = self._arrow(pose)
        bar = np.array([40.0, self.height - 20.0]) + np.linspace(0.0, 1.0, 8)[:, None] * np.array([110.0, 0.0])
        arrow = tail + np.linspace(0.0, 1.0, 6)[:, None] * (tip - tail)
        taken = np.vstack([places[order], self.place(moment.known[order]), arrow, bar])
        offsets = labels.beside(places[order], labels.text_extent(texts, _LABEL), taken, clearance=5.0)
        for text, place, offset in zip(texts, places[order], offsets, strict=True):
            if np.isfinite(offset[0]):
                paint.draw_text(canvas, text, place + offset, _LABEL, hues.INK, halo=hues.WHITE, align="centre")

    def _draw_scale_bar(self, canvas: Canvas) -> None:
        length, right, row = self._step * self.scale, 16.0 + self._step * self.scale, self.height - 16.0
        ends = [[(x, row - 4.0), (x, row + 4.0)] for x in (16.0, right)]
        paint.draw_lines(canvas, np.array([[(16.0, row), (right, row)], *ends]), hues.INK, 2)
        where = (16.0 + length / 2.0, row - 13.0)
        paint.draw_text(canvas, f"{self._step:g} m", where, 13, hues.INK, halo=hues.WHITE, align="centre")


def distance_colours_of(moment: Moment, reel: Reel) -> list[paint.Colour]:
    """The colour of each track [K] in both views."""
    return hues.distance_hues(moment.distances, reel.farthest)


def _extent(reel: Reel) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest (x, y) in m that the map shows in every frame."""
    path = reel.truth.poses[:, :2]
    reach = path.min(axis=0) - _REACH, path.max(axis=0) + _REACH
    people = reel.truth.positions[reel.sequence.observed]
    real = np.vstack([path, people.clip(*reach)])
    points = [real]
    if reel.estimate is not None:
        limits = np.nanmin(real, axis=0) - _OUTLIER, np.nanmax(real, axis=0) + _OUTLIER
        shown = reel.estimate.positions[reel.sequence.observed]
        points += [shown.clip(*limits), reel.estimate.poses[:, :2].clip(*limits)]
    every = np.vstack(points)
    return np.nanmin(every, axis=0) - _MARGIN, np.nanmax(every, axis=0) + _MARGIN
