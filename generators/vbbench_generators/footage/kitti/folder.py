"""Finds KITTI's files: ``label_02``, ``calib``, ``oxts`` and ``image_02`` of the folder ``training``."""

from dataclasses import dataclass
from pathlib import Path

from vbbench.errors import FileError, SourceMissingError, VbbenchError, quoted, suggestion
from vbbench.files.dataset_info import Pictures
from vbbench.generation.sources import data_folders
from vbbench_generators.footage.pictures import pictures_in

LABELS, CALIBRATION, OXTS, PICTURES = "label_02", "calib", "oxts", "image_02"
SITE = "https://www.cvlibs.net/datasets/kitti/eval_tracking.php"
WANTED = f"training/{LABELS}, training/{CALIBRATION} and training/{OXTS} of the tracking benchmark, from {SITE}"


@dataclass(frozen=True)
class KittiFolder:
    """The folder ``training``.

    Parameters
    ----------
    root : it.
    """

    root: Path

    @property
    def names(self) -> list[str]:
        """Names of the sequences that have labels, sorted."""
        return sorted(path.stem for path in (self.root / LABELS).glob("*.txt"))

    def chosen(self, names: tuple[str, ...] | None) -> list[str]:
        """The sequences called ``names``, or all of them.

        Raises
        ------
        VbbenchError
            If there is none of a name; the nearest is suggested.
        """
        known = self.names
        if not known:
            raise FileError(self.root / LABELS, "holds no labels; they are called 0000.txt and so on")
        for name in names or ():
            if name not in known:
                raise VbbenchError(f"no sequence of {self.root} is called {quoted(name)}; {suggestion(name, known)}")
        return list(dict.fromkeys(names)) if names else known

    def file(self, kind: str, name: str) -> Path:
        """The file of a sequence in one of the folders."""
        return self.root / kind / f"{name}.txt"

    def pictures(self, name: str) -> Pictures | None:
        """Where the pictures of a sequence are; ``None`` if they are not here."""
        return pictures_in(self.root / PICTURES / name, "{:06d}.png", first=0)

    def size_of_pictures(self, name: str) -> tuple[int, int] | None:
        """Width and height of the first picture of a sequence in px; ``None`` if it is not here."""
        from PIL import Image, UnidentifiedImageError

        pictures = self.pictures(name)
        if pictures is None or not pictures.path(0).is_file():
            return None
        try:
            with Image.open(pictures.path(0)) as picture:
                return picture.size
        except (OSError, UnidentifiedImageError) as error:
            raise FileError(pictures.path(0), "is no picture that can be read; download it again") from error


def find_folder(source: Path | None) -> KittiFolder:
    """The folder ``training`` that the user names, or whose parent; ``kitti`` in the data folders if nothing is named.

    Raises
    ------
    VbbenchError
        If it is not there; says what is wanted and where to get it.
    """
    places = [folder / "kitti" for folder in data_folders()] if source is None else [source]
    for place in places:
        for root in (place / "training", place):
            if (root / LABELS).is_dir():
                return KittiFolder(root)
    if source is None:
        raise SourceMissingError(f"kitti is made from files of your own: name with --source the folder with {WANTED}")
    raise FileError(source, f"holds no {LABELS}; kitti is made from a folder with {WANTED}")
