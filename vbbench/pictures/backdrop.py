"""What stands behind the boxes of footage: the pictures that its camera took, or a plain ground."""

import hashlib
import json
import warnings
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from vbbench.errors import FileError, VbbenchWarning
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE
from vbbench.sequence import Sequence

SKY, GROUND, HORIZON = (237, 241, 245), (226, 223, 216), (168, 168, 168)
"""sRGB of the plain ground."""


class Backdrop:
    """Pictures of a sequence in the camera's pixels, one a frame, read when they are needed.

    They lie where the dataset says (`vbbench.files.dataset_info.Pictures`), and are scaled to the camera's width.

    Parameters
    ----------
    dataset, sequence : what is shown.
    frames : the frames that will be asked for, ``None`` for all; one warning says how many of them have no picture.
    widest, least : pictures are made smaller until they are ``widest`` px wide, but no less than ``least`` px high.
    window : left, top, right and bottom in px of what is shown, as `Replay.window`; by default the picture.
    """

    def __init__(
        self,
        dataset: Dataset,
        sequence: Sequence,
        frames: Iterable[int] | None = None,
        *,
        widest: int | None = None,
        least: int = 0,
        window: tuple[float, float, float, float] | None = None,
    ) -> None:
        self._camera, self._sequence = dataset.camera(sequence), sequence
        named = _paths(dataset, sequence, range(sequence.frames) if frames is None else frames)
        self._files = {frame: path for frame, path in named.items() if path.is_file()}
        missing = [path for path in named.values() if not path.is_file()]
        if missing:
            count = f"{len(missing)} of {len(named)} pictures of sequence {sequence.index} are missing"
            advice = "the boxes are drawn on a plain ground"
            warnings.warn(f"{count}, {missing[0]} first; {advice}", VbbenchWarning, stacklevel=3)
        height = self._rows()
        left, top, right, bottom = window or (0.0, 0.0, *self._camera.picture_size)
        self.corner = float(np.floor(left)), float(np.floor(top))
        """Column and row of the camera's picture at the upper left corner of every picture."""
        bottom = bottom if bottom > self._camera.picture_size[1] else height
        width, height = int(np.ceil(right - self.corner[0])), int(np.ceil(bottom - self.corner[1]))
        self.zoom = min(1.0, max((widest or width) / width, least / height))
        """Pixels of a picture for a pixel of the camera."""
        self.width, self.height = max(1, round(self.zoom * width)), max(1, round(self.zoom * height))
        """Size of every picture in px."""

    @property
    def is_recorded(self) -> bool:
        """Whether any of the frames has a picture."""
        return bool(self._files)

    @property
    def identity(self) -> str:
        """SHA-256 of which pictures these are: their paths, sizes and times of change."""
        facts = [(frame, str(path), *_stamp(path)) for frame, path in sorted(self._files.items())]
        return hashlib.sha256(json.dumps(facts).encode()).hexdigest()

    def picture(self, frame: int) -> NDArray[np.uint8]:
        """[height, width, 3] sRGB: the camera's picture of a frame, or the plain ground.

        Raises FileError if the file is no picture.
        """
        recorded = self.recorded(frame)
        return self.plain.copy() if recorded is None else recorded

    def recorded(self, frame: int) -> NDArray[np.uint8] | None:
        """[height, width, 3] sRGB: the camera's picture of a frame, ``None`` where there is none; see `picture`."""
        if frame not in self._files:
            return None
        shown = _read(self._files[frame])
        width = round(self.zoom * self._camera.picture_size[0])
        size = width, max(1, round(shown.height * width / shown.width))
        if shown.size != size:
            shown = shown.resize(size, Image.Resampling.LANCZOS)
        canvas = self.plain.copy()
        column, row = (round(-self.zoom * edge) for edge in self.corner)
        rows = np.array(shown)[: self.height - row, : self.width - column]
        canvas[row : row + len(rows), column : column + rows.shape[1]] = rows
        return canvas

    @cached_property
    def plain(self) -> NDArray[np.uint8]:
        """[height, width, 3] sRGB: sky, ground and the horizon between."""
        columns = (np.arange(self.width, dtype=np.float64) + 0.5) / self.zoom + self.corner[0]
        below = np.arange(self.height)[:, None] - self.zoom * (self._camera.horizon(columns) - self.corner[1])
        ground = np.where((below >= 0.0)[..., None], np.array(GROUND, np.uint8), np.array(SKY, np.uint8))
        return np.where((np.abs(below) < 0.75)[..., None], np.array(HORIZON, np.uint8), ground)

    def _rows(self) -> int:
        """As many as the first picture has at the camera's width; without one a panorama reaches to all feet."""
        width, height = self._camera.picture_size
        for path in self._files.values():
            shown = _read(path)
            return max(1, round(shown.height * width / shown.width))
        if self._camera.period is not None:
            _, v, length = np.moveaxis(self._sequence.observations, -1, 0)
            height = max(height, int(np.nanmax(np.ceil(v + 0.5 * length), initial=0.0)))
        return height


def _paths(dataset: Dataset, sequence: Sequence, frames: Iterable[int]) -> dict[int, Path]:
    """Where the pictures of frames should lie; nowhere if the dataset names none."""
    try:
        pictures = dataset.info.pictures[sequence.index] if dataset.info.pictures else None
        return {} if pictures is None else {frame: pictures.path(frame) for frame in frames}
    except (AttributeError, IndexError, KeyError, ValueError) as error:
        problem = f"key 'pictures': no path of sequence {sequence.index} follows from it"
        raise FileError(dataset.folder / INFO_FILE, f"{problem}; generate the dataset again") from error


def _stamp(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_size, status.st_mtime_ns


def _read(path: Path) -> Image.Image:
    try:
        with Image.open(path) as file:
            return file.convert("RGB")
    except OSError as error:
        raise FileError(path, f"cannot be read as a picture ({error}); copy it again") from error
