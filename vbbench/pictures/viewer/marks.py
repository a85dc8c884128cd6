"""Colours of a recording, its columns of frames, and marks on the ground plane.

Colours are RGBA, 0 to 255, for rerun's dark background. Each mark on the ground is drawn twice: in the world, and on
the map from above. Rerun's plane has rows downwards, so that the map shows world (x, y) at (x, −y).
"""

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import needs_extra
from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench.pictures.colours import PEOPLE_ON_DARK, SOLVERS_ON_DARK, numbers_apart, person_slots
from vbbench.pictures.replay import Replay


def rerun() -> Any:
    """The package; raises MissingExtraError if it is not installed."""
    with needs_extra("viewer", "vbbench view"):
        import rerun as package
    return package


@contextmanager
def strictly() -> Iterator[None]:
    """Inside, what rerun cannot record is an error; by default it omits such data and warns."""
    from rerun import error_utils

    before = error_utils.strict_mode()
    error_utils.set_strict_mode(True)
    try:
        yield
    finally:
        error_utils.set_strict_mode(before)


class Opened(Enum):
    """The result of opening a recording in the viewer."""

    SHOWN = "shown"
    NO_DISPLAY = "there is no display here"
    NO_VIEWER = "no program 'rerun' is found"


def open_viewer(path: Path) -> Opened:
    """Start the rerun viewer on a recording, and leave it running, if there are a display and a viewer."""
    program, silence = viewer_program(), subprocess.DEVNULL
    if not _has_display():
        return Opened.NO_DISPLAY
    if program is None:
        return Opened.NO_VIEWER
    subprocess.Popen([program, str(path)], stdin=silence, stdout=silence, stderr=silence, start_new_session=True)
    return Opened.SHOWN


def viewer_program() -> str | None:
    """The viewer that came with the SDK, else one on the path."""
    return shutil.which("rerun", path=str(Path(sys.executable).parent)) or shutil.which("rerun")


def how_to_open(path: Path) -> str:
    """The command that opens a recording."""
    return f"rerun {shlex.quote(str(path))}"


def _has_display() -> bool:
    if os.environ.get("CI"):
        return False
    return sys.platform in ("darwin", "win32") or any(os.environ.get(n) for n in ("DISPLAY", "WAYLAND_DISPLAY"))


Colours = NDArray[np.uint8]
"""[N, 4]"""
Colour = tuple[int, int, int, int]

TRUTH, TRAIL, UNSEEN = (214, 214, 214, 255), (150, 150, 150, 255), (110, 110, 110, 255)
GIVEN, ALARM, BORDER = (64, 156, 255, 255), (255, 80, 60, 255), (90, 90, 90, 255)
ERROR = (255, 90, 90, 255)


def people_colours(replay: Replay) -> Colours:
    """The colour [K, 4] of each track's person; those who come near one another have different ones."""
    palette = np.array(list(map(_colour, PEOPLE_ON_DARK)), np.uint8)
    return palette[person_slots(replay.camera, replay.sequence, replay.truth)]


def answer_colours(replay: Replay) -> list[Colour]:
    """The colour of each answer: that of its solver, or another where two answers would share it."""
    numbers = numbers_apart([answer.solver for answer in replay.answers])
    return [_colour(SOLVERS_ON_DARK[number]) for number in numbers]


def _colour(name: str) -> Colour:
    red, green, blue = bytes.fromhex(name[1:])
    return red, green, blue, 255


_FRAME, _TIME = "frame", "time"
"""The two timelines: frame of the sequence from 0, and seconds from its start."""


class Tape:
    """Records entities for all frames in columns: no loop over frames, and a small file.

    Parameters
    ----------
    stream : a ``rerun.RecordingStream``.
    frames : number of frames.
    dt : seconds per frame.
    """

    def __init__(self, stream: Any, frames: int, dt: float) -> None:
        self.rr = rerun()
        self.stream, self.frames, self.dt = stream, frames, dt

    def always(self, path: str, shown: Any) -> None:
        """Record something for all frames."""
        self.stream.log(path, shown, static=True)

    def now(self, frame: int, path: str, shown: Any) -> None:
        """Record something too large for columns, in one frame."""
        self.stream.set_time(_FRAME, sequence=frame)
        self.stream.set_time(_TIME, duration=frame * self.dt)
        self.stream.log(path, shown)

    def each(self, path: str, kind: Any, frames: IntArray | None = None, **values: Any) -> None:
        """One value of every component in each of the ``frames`` (``None``: in all)."""
        wanted = np.arange(self.frames) if frames is None else frames
        if len(wanted):
            self.stream.send_columns(path, self._times(wanted), kind.columns(**values))

    def many(self, path: str, kind: Any, counts: IntArray, **values: Any) -> None:
        """Counts [T] of instances in each frame, and components with those of all frames, concatenated."""
        if counts.any():
            columns = kind.columns(**values).partition(counts)
            self.stream.send_columns(path, self._times(np.arange(self.frames)), columns)

    def _times(self, frames: IntArray) -> list[Any]:
        column = self.rr.TimeColumn
        return [column(_FRAME, sequence=frames), column(_TIME, duration=frames * self.dt)]


WORLD, MAP = "world", "map"
_LIFT = 0.02  # m over the ground, so that marks do not sink into it
_ARROW_LIFT = 0.05  # the same for arrows, which are thicker
_MAP_WIDTH = 40.0  # points of the screen on the map for a metre in the world
_ABOVE_LINES = 31.0  # rerun draws what has a higher number later; points have 30 by themselves, lines 20
_FLIP = np.array([1.0, -1.0])

GIRTH = 0.22
"""Half the width in m of a person as drawn; only heights are known."""


@dataclass(frozen=True)
class People:
    """How people are marked: colours [K, 4], and texts [K], shown always or on hover."""

    colours: Colours
    labels: list[str] | None = None
    shown: bool = False

    def rows(self, there: BoolArray) -> dict[str, Any]:
        """Components of those present [T, K], of all frames, concatenated."""
        person = np.nonzero(there)[1]
        labels = {} if self.labels is None else {"labels": np.array(self.labels, dtype=str)[person]}
        return {"colors": self.colours[person], **labels}


class Ground:
    """The ground plane of a recording; what is NaN in a frame is not shown in that frame."""

    def __init__(self, tape: Tape) -> None:
        self.tape = tape

    def dots(self, path: str, places: FloatArray, look: People, points: float) -> None:
        """Dots of a radius in points of the screen, on the map alone, small ones on top: places [T, K, 2] in m."""
        rr, there = self.tape.rr, _there(places)
        radius = rr.Radius.ui_points(points)
        fields = {"radii": radius, "show_labels": look.shown, "draw_order": _ABOVE_LINES - 0.1 * points}
        self.tape.always(f"{MAP}/{path}", rr.Points2D.from_fields(**fields))
        values = {"positions": places[there] * _FLIP, **look.rows(there)}
        self.tape.many(f"{MAP}/{path}", rr.Points2D, there.sum(axis=1), **values)

    def bodies(self, path: str, places: FloatArray, heights: FloatArray, look: People, *, solid: bool) -> None:
        """Upright ellipsoids, or wire frames of them, in the world alone: places [T, K, 2] and heights [K] in m."""
        rr, there = self.tape.rr, _there(places)
        fill = rr.components.FillMode.Solid if solid else rr.components.FillMode.MajorWireframe
        fields = {"fill_mode": fill, "line_radii": 0.01, "show_labels": look.shown}
        self.tape.always(f"{WORLD}/{path}", rr.Ellipsoids3D.from_fields(**fields))
        half = 0.5 * np.broadcast_to(heights, there.shape)[there]
        values = {
            "centers": np.column_stack([places[there], half]),
            "half_sizes": np.column_stack([np.full((len(half), 2), GIRTH), half]),
            **look.rows(there),
        }
        self.tape.many(f"{WORLD}/{path}", rr.Ellipsoids3D, there.sum(axis=1), **values)

    def rings(self, path: str, places: FloatArray, colour: Colour, radius: float) -> None:
        """Circles of a radius in m: places [T, K, 2] in m."""
        covariances = np.broadcast_to(np.eye(2) * radius**2, (*places.shape, 2))
        self.ellipses(path, places, covariances, colour, reach=1.0)

    def ellipses(self, path: str, places: FloatArray, covariances: FloatArray, colour: Colour, *, reach: float) -> None:
        """Ellipses at ``reach`` standard deviations: places [T, K, 2] in m, covariances [T, K, 2, 2] in m²."""
        there = _there(places) & np.isfinite(covariances).all(axis=(-2, -1))
        self.strips(path, there.sum(axis=1), outlines(places[there], covariances[there], reach), colour, 0.01)

    def lines(self, path: str, starts: FloatArray, ends: FloatArray, colour: Colour, radius: float) -> None:
        """Straight lines from starts to ends, both [T, K, 2] in m."""
        there = _there(starts) & _there(ends)
        self.strips(path, there.sum(axis=1), np.stack([starts[there], ends[there]], axis=1), colour, radius)

    def trails(self, path: str, places: FloatArray, now: BoolArray, colour: Colour, past: int) -> None:
        """The last ``past`` steps of everybody present ``now`` [T, K]: places [T, K, 2] in m."""
        frame, person = np.nonzero(now & _there(places))
        window = np.maximum(frame[:, None] + np.arange(-past, 1), 0)
        strips = _held(places)[window, person[:, None]]
        self.strips(path, np.bincount(frame, minlength=len(places)), strips, colour, 0.015)

    def strips(self, path: str, counts: IntArray, strips: FloatArray, colour: Colour, radius: float) -> None:
        """Lines through P points each, [N, P, 2] in m, ``counts`` of them in each frame; equally wide at any zoom."""
        rr = self.tape.rr
        lifted = np.concatenate([strips, np.full((*strips.shape[:2], 1), _LIFT)], axis=2)
        for root, kind, values in ((WORLD, rr.LineStrips3D, lifted), (MAP, rr.LineStrips2D, strips * _FLIP)):
            width = rr.Radius.ui_points(radius * _MAP_WIDTH) if root == MAP else radius
            self.tape.always(f"{root}/{path}", kind.from_fields(radii=width, colors=colour))
            self.tape.many(f"{root}/{path}", kind, counts, strips=values)

    def arrows(self, path: str, poses: FloatArray, colour: Colour, length: float) -> None:
        """An observer's place and direction: poses [T, 3] in m and rad."""
        rr, there = self.tape.rr, np.isfinite(poses).all(axis=1)
        x, y, yaw = poses[there].T
        ahead = length * np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
        level, feet = np.zeros(len(x)), np.stack([x, y], axis=1)
        lifted = {"origins": np.column_stack([feet, level + _ARROW_LIFT]), "vectors": np.column_stack([ahead, level])}
        flat = {"origins": feet * _FLIP, "vectors": ahead * _FLIP}
        for root, kind, values in ((WORLD, rr.Arrows3D, lifted), (MAP, rr.Arrows2D, flat)):
            self.tape.always(f"{root}/{path}", kind.from_fields(colors=colour, radii=0.04))
            self.tape.many(f"{root}/{path}", kind, np.asarray(there, np.int64), **values)


def outlines(places: FloatArray, covariances: FloatArray, reach: float) -> FloatArray:
    """[N, 25, 2] ellipses at ``reach`` standard deviations, about places [N, 2] in m with covariances [N, 2, 2]."""
    variances, axes = np.linalg.eigh(covariances)
    turn = np.linspace(0.0, 2.0 * np.pi, 25)
    circle = reach * np.stack([np.cos(turn), np.sin(turn)])
    spread = (axes * np.sqrt(np.clip(variances, 0.0, None))[:, None, :]) @ circle
    return np.asarray(places[:, None] + np.swapaxes(spread, 1, 2))


def _there(places: FloatArray) -> BoolArray:
    return np.asarray(np.isfinite(places).all(axis=-1))


def _held(places: FloatArray) -> FloatArray:
    """Places [T, K, 2] with gaps filled by the last known place, or before that by the first."""
    row = np.where(_there(places), np.arange(len(places))[:, None], -1)
    last, first = np.maximum.accumulate(row, axis=0), np.argmax(row >= 0, axis=0)
    return np.asarray(np.take_along_axis(places, np.where(last < 0, first, last)[..., None], axis=0))
