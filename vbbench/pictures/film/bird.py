"""The bird's-eye view of a film: the whole sequence in one fixed window, or a window that goes with the observer."""

import numpy as np
from scipy.ndimage import uniform_filter1d

from vbbench.geometry import FloatArray
from vbbench.pictures.film import paint
from vbbench.pictures.film.paint import Canvas, Colour
from vbbench.pictures.plotting import style
from vbbench.pictures.replay import Replay

_MARGIN = 1.0  # m around everything drawn
_OUTLIER = 2.0  # m beyond the truth that an estimate may widen the view
_REACH = 20.0  # m from the observer's path; people farther away may be outside the map
_TAIL_SECONDS = 3.0
_ARROW = 44.0  # px
_LABEL = 12  # px
_FIELD = 12.0  # m that the field of view is drawn deep, at most
_LEAST_SCALE = 12.0  # px for a metre; where the whole sequence needs less, the window moves
_LEAST_SPAN = 8.0  # m that a map shows at least
_AHEAD = 8.0  # m before the observer lies the middle of a window that moves
_CALM_SECONDS = 2.0  # over which its way is averaged
_STEPS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
"""Lengths in m that the grid and the scale bar may have."""


class BirdsEyeView:
    """Draws frames on a map of ``width`` x ``height`` px.

    The window is the same in all frames, unless the sequence is so long that people could not be distinguished.

    Parameters
    ----------
    replay : the sequence.
    farthest : distance in m at the light end of the colours.
    width, height : size in px.
    """

    def __init__(self, replay: Replay, farthest: float, width: int, height: int) -> None:
        self._replay, self.width, self.height = replay, width, height
        self._field = min(farthest, _FIELD)
        low, high = _extent(replay)
        whole = float(min((width, height) / (high - low)))
        self.scale = max(whole, _LEAST_SCALE)
        """Pixels per metre."""
        self.moves = whole < _LEAST_SCALE
        """Whether the window goes with the observer."""
        half = np.array([width, height]) / (2.0 * self.scale)
        self._middles = _window_path(replay, low, high, half)
        self._middle = self._middles[0]
        self._step = next((s for s in _STEPS if s * self.scale >= 60.0), _STEPS[-1])
        self._tail = max(style.TAIL_FRAMES, round(_TAIL_SECONDS / replay.info.dt))
        self._ground = None if self.moves else self._draw_ground()

    def place(self, points: FloatArray) -> FloatArray:
        """Column and row [..., 2] in px of world positions in m, on the map drawn last; north is up."""
        offset = (points - self._middle) * self.scale
        return np.stack([0.5 * self.width + offset[..., 0], 0.5 * self.height - offset[..., 1]], axis=-1)

    def draw(self, frame: int, people: list[Colour]) -> Canvas:
        """The map of one frame, people in their colours [K]."""
        self._middle = self._middles[frame]
        canvas = self._draw_ground() if self._ground is None else self._ground.copy()
        self._draw_field_of_view(canvas, frame)
        self._draw_paths(canvas, frame, people)
        self._draw_people(canvas, frame, people)
        self._draw_observers(canvas, frame)
        self._draw_labels(canvas, frame)
        self._draw_scale_bar(canvas)
        return canvas

    def _draw_ground(self) -> Canvas:
        """What is the same in all frames, but for the window: the grid, and the whole track of everybody."""
        canvas = paint.blank(self.width, self.height)
        half = np.array([self.width, self.height]) / (2.0 * self.scale)
        low, high = self._middle - half, self._middle + half
        for axis in (0, 1):
            for value in np.arange(np.ceil(low[axis] / self._step), np.floor(high[axis] / self._step) + 1) * self._step:
                ends = np.stack([low, high])
                ends[:, axis] = value
                paint.draw_lines(canvas, self.place(ends)[None], paint.GRID)
        for track in range(len(self._replay.sequence.tracks)):
            paint.draw_path(canvas, self.place(self._replay.known.positions[:, track]), paint.TRUTH_FAINT)
        return canvas

    def _draw_field_of_view(self, canvas: Canvas, frame: int) -> None:
        camera, pose = self._replay.camera, self._replay.viewpoints[frame]
        if camera.view is None or np.isnan(pose).any():
            return
        left, right = camera.view
        angles = pose[2] - np.linspace(right, left, 25)
        arc = pose[:2] + self._field * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        corners = self.place(np.vstack([pose[:2], arc]))
        tint = paint.blank(self.width, self.height)
        paint.draw_polygon(tint, corners, paint.FIELD)
        np.minimum(canvas, tint, out=canvas)
        paint.draw_path(canvas, np.vstack([corners, corners[:1]]), paint.FIELD_EDGE)

    def _draw_paths(self, canvas: Canvas, frame: int, people: list[Colour]) -> None:
        replay, now = self._replay, frame + 1
        recent = slice(max(0, now - self._tail), now)
        for track in np.flatnonzero(replay.sequence.observed[frame]):
            paint.draw_path(canvas, self.place(replay.known.positions[recent, track]), paint.TRUTH_TAIL, 2)
            paint.draw_path(canvas, self.place(replay.estimated[recent, track]), people[track], 2)
        paint.draw_path(canvas, self.place(replay.known.poses[:now, :2]), paint.TRUTH, 2)
        if replay.answer is not None:
            paint.draw_path(canvas, self.place(replay.answer.estimate.poses[:now, :2]), paint.ESTIMATE, 2)

    def _draw_people(self, canvas: Canvas, frame: int, people: list[Colour]) -> None:
        places = self._replay.bystanders[0][frame]
        for place in self.place(places[~np.isnan(places[:, 0])]):
            paint.draw_disc(canvas, place, 3.5, paint.WHITE, paint.UNSEEN)
        known, guessed = self.place(self._replay.known.positions[frame]), self.place(self._replay.estimated[frame])
        there = self._replay.sequence.observed[frame] & np.isfinite(known[:, 0])
        if self._replay.answer is None:
            for track in np.flatnonzero(there):
                paint.draw_disc(canvas, known[track], 6.0, people[track], paint.TRUTH)
            return
        for track in np.flatnonzero(there):
            paint.draw_disc(canvas, known[track], 6.5, paint.WHITE, paint.TRUTH)
        paint.draw_lines(canvas, np.stack([known, guessed], axis=1), paint.INK, 2)
        for track in np.flatnonzero(np.isfinite(guessed[:, 0])):
            paint.draw_disc(canvas, guessed[track], 4.5, people[track])

    def _draw_observers(self, canvas: Canvas, frame: int) -> None:
        poses = [(self._replay.viewpoints[frame], paint.TRUTH)]
        if self._replay.answer is not None:
            poses = [(self._replay.known.poses[frame], paint.TRUTH)]
            poses.append((self._replay.answer.estimate.poses[frame], paint.ESTIMATE))
            ends = self.place(np.stack([pose[:2] for pose, _ in poses]))
            paint.draw_lines(canvas, ends[None], paint.INK, 2)
        for pose, colour in poses:
            if np.isfinite(pose).all():
                paint.draw_arrow(canvas, *self._arrow(pose), colour)

    def _arrow(self, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
        tail = self.place(pose[:2])
        return tail, tail + _ARROW * np.array([np.cos(pose[2]), -np.sin(pose[2])])

    def _draw_labels(self, canvas: Canvas, frame: int) -> None:
        """Ids next to people, the nearest first; an id without a free place is omitted."""
        replay = self._replay
        known, estimated = replay.known.positions[frame], replay.estimated[frame]
        places = self.place(np.where(np.isnan(estimated), known, estimated))
        size = np.array([self.width, self.height])
        inside = np.all((places > 0) & (places < size), axis=1)
        shown = np.flatnonzero(replay.sequence.observed[frame] & inside)
        order = shown[np.argsort(replay.distances[frame, shown])]
        texts = [str(track) for track in replay.sequence.tracks[order]]
        poses = replay.viewpoints if replay.answer is None else replay.answer.estimate.poses
        tail, tip = self._arrow(poses[frame])
        bar = np.array([40.0, self.height - 20.0]) + np.linspace(0.0, 1.0, 8)[:, None] * np.array([110.0, 0.0])
        arrow = tail + np.linspace(0.0, 1.0, 6)[:, None] * (tip - tail)
        taken = np.vstack([places[order], self.place(known[order]), arrow, bar])
        offsets = style.free_offsets(places[order], style.text_extent(texts, _LABEL), taken, clearance=5.0)
        for text, place, offset in zip(texts, places[order], offsets, strict=True):
            if np.isfinite(offset[0]):
                paint.draw_text(canvas, text, place + offset, _LABEL, paint.INK, halo=paint.WHITE, align="centre")

    def _draw_scale_bar(self, canvas: Canvas) -> None:
        length, right, row = self._step * self.scale, 16.0 + self._step * self.scale, self.height - 16.0
        ends = [[(x, row - 4.0), (x, row + 4.0)] for x in (16.0, right)]
        paint.draw_lines(canvas, np.array([[(16.0, row), (right, row)], *ends]), paint.INK, 2)
        where = (16.0 + length / 2.0, row - 13.0)
        paint.draw_text(canvas, f"{self._step:g} m", where, 13, paint.INK, halo=paint.WHITE, align="centre")


def _extent(replay: Replay) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest (x, y) in m of what is worth seeing in any frame."""
    path, seen = replay.viewpoints[:, :2], replay.sequence.observed
    reach = np.nanmin(path, axis=0) - _REACH, np.nanmax(path, axis=0) + _REACH
    real = np.vstack([path, replay.known.positions[seen].clip(*reach)])
    points = [real]
    if replay.answer is not None:
        limits = np.nanmin(real, axis=0) - _OUTLIER, np.nanmax(real, axis=0) + _OUTLIER
        estimate = replay.answer.estimate
        points += [estimate.positions[seen].clip(*(limits if replay.places_known else reach))]
        points += [estimate.poses[:, :2].clip(*limits)]
    every = np.vstack(points)
    low, high = np.nanmin(every, axis=0) - _MARGIN, np.nanmax(every, axis=0) + _MARGIN
    more = 0.5 * np.maximum(_LEAST_SPAN - (high - low), 0.0)
    return low - more, high + more


def _window_path(replay: Replay, low: FloatArray, high: FloatArray, half: FloatArray) -> FloatArray:
    """[T, 2] the middle of a window of half size ``half`` in every frame.

    It lies before the observer, and where the window holds low to high at once it stays in the middle of these.
    """
    poses = replay.viewpoints
    known = np.flatnonzero(np.isfinite(poses).all(axis=1))
    ahead = poses[:, :2] + _AHEAD * np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=-1)
    frames = np.arange(len(poses))
    filled = np.stack([np.interp(frames, known, values) for values in ahead[known].T], axis=-1)
    calm = uniform_filter1d(filled, max(1, round(_CALM_SECONDS / replay.info.dt)), axis=0, mode="nearest")
    return np.where(2.0 * half >= high - low - 1e-6, 0.5 * (low + high), calm)
