"""Pictures behind the boxes: what the observer sees, rendered or as its camera took it, a small JPEG per frame."""

import shutil
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vbbench.files.dataset import Dataset
from vbbench.folders.work_folder import WorkFolder
from vbbench.geometry import IntArray
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.rendering import Backend, open_renderer, pictures, scene_of

WIDTH = 640
"""Width of a picture in px; one that the camera took is wider if it would be lower than `_LEAST_HEIGHT`."""

_LEAST_HEIGHT = 160

_QUALITY = 70


def picture_folder(work: Path, split: str, number: int) -> Path:
    """Where the pictures of a sequence lie in a work folder: ``00000.jpg`` and so on, one per frame."""
    return work / "pictures" / split / str(number)


def copy_pictures(work: Path, site: Path, split: str, chosen: IntArray) -> dict[str, int]:
    """Copy the pictures of the chosen sequences into a site; sequence → how many there are."""
    counts: dict[str, int] = {}
    for number in map(int, chosen):
        files = sorted(picture_folder(work, split, number).glob("[0-9]*.jpg"))
        target = picture_folder(site / "data" / "player", split, number)
        for file in files:
            target.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target / file.name)
        if files:
            counts[str(number)] = len(files)
    return counts


def make_pictures(dataset: Dataset, split: str, chosen: Iterable[int], work: Path, backend: Backend) -> None:
    """Render the chosen sequences into the work folder, those that are there already left alone.

    Raises
    ------
    VbbenchError
        If the truth is withheld, or the backend cannot work here.
    """
    for number, folder in _missing(work, split, chosen):
        sequence = dataset.sequence(number)
        with open_renderer(backend, scene_of(dataset, sequence.scene)) as renderer:
            _fill(folder, (_small(picture.rgb) for picture in pictures(dataset, sequence, renderer)))


def copy_footage(dataset: Dataset, split: str, chosen: Iterable[int], work: Path) -> None:
    """Put small copies of the pictures that the camera took into the work folder, those there already left alone.

    Frames without a picture have a plain ground; sequences without any have no pictures.

    Raises
    ------
    VbbenchError
        If a file is no picture.
    """
    for number, folder in _missing(work, split, chosen):
        sequence = dataset.sequence(number)
        backdrop = Backdrop(dataset, sequence, widest=WIDTH, least=_LEAST_HEIGHT)
        if backdrop.is_recorded:
            _fill(folder, map(backdrop.picture, range(sequence.frames)))


def _missing(work: Path, split: str, chosen: Iterable[int]) -> Iterator[tuple[int, Path]]:
    """The chosen sequences of which there are no pictures yet, and the folders for these."""
    for number in chosen:
        folder = picture_folder(work, split, number)
        if not folder.is_dir():
            yield number, folder


def _fill(folder: Path, frames: Iterable[NDArray[np.uint8]]) -> None:
    """Make a folder of JPEGs."""
    from PIL import Image

    with WorkFolder(folder) as place:
        place.begin()
        place.new.mkdir()
        for frame, rgb in enumerate(frames):
            Image.fromarray(rgb).save(place.new / f"{frame:05d}.jpg", quality=_QUALITY, optimize=True)
        place.publish()


def _small(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    from PIL import Image

    height, width = rgb.shape[:2]
    return np.asarray(Image.fromarray(rgb).resize((WIDTH, round(height * WIDTH / width)), Image.Resampling.LANCZOS))
