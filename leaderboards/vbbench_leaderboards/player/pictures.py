"""Pictures behind the boxes: what the observer sees, rendered or as its camera took it, a small JPEG per frame."""

import shutil
from collections.abc import Iterable
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
    for number in chosen:
        folder = picture_folder(work, split, number)
        if folder.is_dir():
            continue
        sequence = dataset.sequence(number)
        scene = scene_of(dataset, sequence.scene)
        with WorkFolder(folder) as place, open_renderer(backend, scene) as renderer:
            place.begin()
            place.new.mkdir()
            for frame, picture in enumerate(pictures(dataset, sequence, renderer)):
                _write_jpeg(place.new / f"{frame:05d}.jpg", picture.rgb)
            place.publish()


def copy_footage(dataset: Dataset, split: str, chosen: Iterable[int], work: Path) -> None:
    """Put small copies of the pictures that the camera took into the work folder, those there already left alone.

    Frames without a picture have a plain ground; sequences without any have no pictures.

    Raises
    ------
    VbbenchError
        If a file is no picture.
    """
    for number in chosen:
        folder = picture_folder(work, split, number)
        if folder.is_dir():
            continue
        sequence = dataset.sequence(number)
        backdrop = Backdrop(dataset, sequence, widest=WIDTH, least=_LEAST_HEIGHT)
        if not backdrop.is_recorded:
            continue
        with WorkFolder(folder) as place:
            place.begin()
            place.new.mkdir()
            for frame in range(sequence.frames):
                _save_jpeg(place.new / f"{frame:05d}.jpg", backdrop.picture(frame))
            place.publish()


def _write_jpeg(path: Path, rgb: NDArray[np.uint8]) -> None:
    from PIL import Image

    height, width = rgb.shape[:2]
    image = Image.fromarray(rgb).resize((WIDTH, round(height * WIDTH / width)), Image.Resampling.LANCZOS)
    _save_jpeg(path, np.asarray(image))


def _save_jpeg(path: Path, rgb: NDArray[np.uint8]) -> None:
    from PIL import Image

    Image.fromarray(rgb).save(path, quality=_QUALITY, optimize=True)
