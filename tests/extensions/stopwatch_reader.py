"""A recording format of another package: lines ``ms;who;east_cm;north_cm``, people by their first names."""

import csv
from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.parsing.numbers import finite_number
from vbbench.scene import Scene
from vbbench_generators.recordings.loading import Reader, SceneFile
from vbbench_generators.recordings.readers.tracks import scene_of_rows
from vbbench_generators.splits import RecipeSplit

HEADER = ["ms", "who", "east_cm", "north_cm"]


class Stopwatch(Reader):
    """Read places in centimetres, taken whenever somebody pressed the button."""

    signature = "a header ms;who;east_cm;north_cm"

    def recognises(self, line: str) -> bool:
        """By its header."""
        return line.split(";") == HEADER

    def read(self, file: SceneFile) -> Scene:
        """One row a person and time."""
        with file.path.open(encoding="utf-8", newline="") as text:
            header, *rows = csv.reader(text, delimiter=";")
        if header != HEADER or any(len(row) != len(HEADER) for row in rows):
            raise FileError(file.path, f"every line must have the columns {';'.join(HEADER)}")
        names = sorted({row[1] for row in rows})
        values = np.array(
            [
                [finite_number(file.path, n, name, row[k]) for k, name in enumerate(HEADER) if k != 1]
                for n, row in enumerate(rows, 2)
            ]
        )
        ids = np.array([names.index(row[1]) for row in rows], float)
        frames, lines = np.rint(values[:, 0] / 1000.0 / file.dt), np.arange(2, len(rows) + 2)
        return scene_of_rows(file.path, frames, ids, 0.01 * values[:, 1:], lines, dt=file.dt, frame_step=1)


stopwatch = Stopwatch()
park = RecipeSplit("park", Path(__file__).with_name("park.toml"))
