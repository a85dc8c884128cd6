"""ETH's ``obsmat.txt``: a row ``frame id x z y vx vz vy`` in metres for each person in each frame; z is up."""

from pathlib import Path

from vbbench.scene import Scene
from vbbench_generators.readers.table import TrackTable
from vbbench_generators.readers.textfile import read_numbers

COLUMNS = ("frame", "id", "x", "z", "y", "vx", "vz", "vy")


def read_obsmat(path: Path, *, dt: float, frame_step: int | None = None) -> Scene:
    """Read ground-plane positions (x, y) in m; heights z and velocities are left aside.

    Parameters
    ----------
    path : the file.
    dt : seconds between rows of a person.
    frame_step : video frames between rows of a person; ``None`` takes the commonest.

    Raises
    ------
    FileError
        With file and line, if a row or a track is bad.
    """
    values, lines = read_numbers(path, COLUMNS)
    table = TrackTable(path=path, frame=values[:, 0], person=values[:, 1], positions=values[:, [2, 4]], lines=lines)
    return table.to_scene(dt, frame_step)
