"""Trajnet-style text: a row ``frame id x y`` for each person in each frame."""

from pathlib import Path

from vbbench.geometry import FloatArray
from vbbench.scene import Scene
from vbbench_generators.readers.homography import to_ground
from vbbench_generators.readers.table import TrackTable
from vbbench_generators.readers.textfile import read_numbers

COLUMNS = ("frame", "id", "x", "y")


def read_trajnet(
    path: Path, *, dt: float, frame_step: int | None = None, homography: FloatArray | None = None
) -> Scene:
    """Read rows ``frame id x y``, parted by white space, tabs or commas, in any order.

    Parameters
    ----------
    path : the file.
    dt : seconds between rows of a person.
    frame_step : frame numbers between rows of a person; ``None`` takes the commonest.
    homography : [3, 3] from x, y to metres; ``None`` if they are metres.

    Raises
    ------
    FileError
        With file and line, if a row or a track is bad.
    """
    values, lines = read_numbers(path, COLUMNS)
    positions = values[:, 2:]
    if homography is not None:
        positions = to_ground(positions, homography)
    table = TrackTable(path=path, frame=values[:, 0], person=values[:, 1], positions=positions, lines=lines)
    return table.to_scene(dt, frame_step)
