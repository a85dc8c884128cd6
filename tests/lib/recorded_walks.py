"""Recorded walks as text files: how a format's reader is called, and people in pixels of a tilted camera."""

from pathlib import Path
from typing import Any

import numpy as np

from vbbench.scene import Scene
from vbbench_generators.recordings.loading import SceneFile, get_reader
from vbbench_generators.recordings.readers.tracks import to_ground

WALK = "0 1 0.0 0.0\n10 1 0.5 0.0\n20 1 1.0 0.0\n"
CENTIMETRES = np.diag([0.01, 0.01, 1.0])
TILTED = np.array([[1.1e-2, 8e-4, -1.2], [4e-4, -1.3e-2, 9.1], [1e-5, -3e-4, 1.0]])
"""From a picture's pixels to metres."""


def read(path: Path, form: str = "trajnet", **facts: Any) -> Scene:
    """The scene of a file in a format."""
    return get_reader(form).read(SceneFile(path=path, **{"dt": 0.4, **facts}))


def walk_in_pixels(people: int = 4, frames: int = 12) -> list[tuple[int, int, float, float]]:
    """Rows (frame, id, x, y) of people who walk at 1.2 m/s, in pixels of the picture that `TILTED` maps to metres."""
    rng = np.random.default_rng(1)
    start, way = rng.uniform(1.0, 8.0, (people, 2)), rng.normal(0.0, 1.0, (people, 2))
    way *= 1.2 * 0.4 / np.linalg.norm(way, axis=1, keepdims=True)
    frame, person = (array.ravel() for array in np.mgrid[:frames, :people])
    return rows_in_pixels(frame, person, start[person] + frame[:, None] * way[person])


def rows_in_pixels(frame: Any, person: Any, places: Any) -> list[tuple[int, int, float, float]]:
    """Rows (frame, id, x, y) in pixels of people at ``places`` [N, 2] in m."""
    pixels = to_ground(places, np.linalg.inv(TILTED)).tolist()
    return [(10 * f, p + 1, *at) for f, p, at in zip(frame.tolist(), person.tolist(), pixels, strict=True)]


def text_of(rows: list[tuple[Any, ...]]) -> str:
    """Rows as a text with blanks between."""
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows)
