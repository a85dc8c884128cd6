"""Tables of positions, a row for each person in each frame: Trajnet's ``frame id x y``, and ETH's ``obsmat.txt``.

The latter is ``frame id x z y vx vz vy`` in metres, where z is up.
Which one a user's own file is, its columns tell.
"""

from pathlib import Path

from vbbench.errors import FileError
from vbbench.geometry import FloatArray
from vbbench.scene import Scene
from vbbench_generators.recordings.loading import Reader, SceneFile
from vbbench_generators.recordings.readers.text import count_columns, read_numbers, to_ground
from vbbench_generators.recordings.readers.tracks import scene_of_rows

TRAJNET = ("frame", "id", "x", "y")
OBSMAT = ("frame", "id", "x", "z", "y", "vx", "vz", "vy")
"""Names of the columns."""


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
    values, lines = read_numbers(path, TRAJNET)
    positions = values[:, 2:]
    if homography is not None:
        positions = to_ground(positions, homography)
    return scene_of_rows(path, values[:, 0], values[:, 1], positions, lines, dt=dt, frame_step=frame_step)


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
    values, lines = read_numbers(path, OBSMAT)
    return scene_of_rows(path, values[:, 0], values[:, 1], values[:, [2, 4]], lines, dt=dt, frame_step=frame_step)


class Trajnet(Reader):
    """Rows ``frame id x y`` in metres, or in pixels with a homography."""

    signature = f"{len(TRAJNET)} columns ({' '.join(TRAJNET)})"

    def recognises(self, line: str) -> bool:
        """By the number of columns."""
        return count_columns(line) == len(TRAJNET)

    def read(self, file: SceneFile) -> Scene:
        """As `read_trajnet`."""
        return read_trajnet(file.path, dt=file.dt, frame_step=file.frame_step, homography=file.homography)


class Obsmat(Reader):
    """ETH's ``obsmat.txt``, in metres."""

    signature = f"{len(OBSMAT)} columns ({' '.join(OBSMAT)})"

    def recognises(self, line: str) -> bool:
        """By the number of columns."""
        return count_columns(line) == len(OBSMAT)

    def read(self, file: SceneFile) -> Scene:
        """As `read_obsmat`."""
        if file.homography is not None:
            raise FileError(file.path, "is an obsmat table, which is in metres already: leave `homography` out")
        return read_obsmat(file.path, dt=file.dt, frame_step=file.frame_step)


trajnet = Trajnet()
obsmat = Obsmat()
