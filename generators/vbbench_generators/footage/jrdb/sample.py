"""The sample of JRDB-Traj: boxes in the panorama and places around the robot in one table of numbers."""

from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.parsing.numbers import finite_number
from vbbench.parsing.rows import first_repetition
from vbbench_generators.footage.jrdb.labels import (
    MOST_METRES,
    MOST_PIXELS,
    PictureLabels,
    PlaceLabels,
    wrong_height,
    wrong_size,
)

SAMPLE = ("frame", "id", "x", "y", "h", "w", "l", "rot_z", "left", "top", "width", "height")
"""Its columns."""

MOST_FRAMES, MOST_IDS = 10**6, 10**9
"""Frames, from 0 on, and ids are below these; a million frames of 15 Hz are 18 hours."""


def read_sample(path: Path) -> tuple[PictureLabels, PlaceLabels]:
    """Both kinds of labels: a row for each person in each frame, the columns `SAMPLE`.

    Raises
    ------
    FileError
        At the first row that has other columns, what is no number, or what cannot be.
    """
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, "cannot be read as text") from error
    numbers = [number for number, line in enumerate(lines, 1) if line.strip()]
    if not numbers:
        raise FileError(path, f"is empty; rows of {', '.join(SAMPLE)} are wanted")
    table = np.array([_row(path, number, lines[number - 1]) for number in numbers])
    frames, people = table[:, 0].astype(np.int64), table[:, 1].astype(np.int64)
    found = first_repetition(frames, people)
    if found is not None:
        again = found[1]
        raise FileError(path, f"person {people[again]} stands in frame {frames[again]} twice", numbers[again])
    pictures = PictureLabels(
        path=path,
        frames=frames,
        people=people,
        boxes=table[:, 8:],
        visible=np.ones(len(table)),
        interpolated=np.zeros(len(table), np.bool_),
    )
    return pictures, PlaceLabels(path=path, frames=frames, people=people, places=table[:, 2:4], heights=table[:, 4])


def _row(path: Path, number: int, line: str) -> list[float]:
    cells = line.split(",")
    if len(cells) != len(SAMPLE):
        raise FileError(path, f"has {len(cells)} columns, not {len(SAMPLE)} ({', '.join(SAMPLE)})", number)
    row = [finite_number(path, number, name, cell) for name, cell in zip(SAMPLE, cells, strict=True)]
    problem = _problem(dict(zip(SAMPLE, row, strict=True)))
    if problem:
        raise FileError(path, problem, number)
    return row


def _problem(row: dict[str, float]) -> str:
    """What a row says that cannot be; nothing of one that can."""
    for name, count in (("frame", MOST_FRAMES), ("id", MOST_IDS)):
        if row[name] != int(row[name]) or not 0 <= row[name] < count:
            return f"{name} is {row[name]:g}, not a whole number from 0 to {count - 1:,}"
    for names, most in ((("x", "y"), MOST_METRES), (SAMPLE[8:], MOST_PIXELS)):
        for name in names:
            if abs(row[name]) > most:
                return f"{name} is {row[name]:g}, not a number up to {most:,.0f}"
    return wrong_height(row["h"]) or wrong_size(row["width"], row["height"])
