"""Where the pictures of a recording are."""

from pathlib import Path

from vbbench.files.dataset_info import Pictures


def pictures_in(folder: Path, name: str, first: int) -> Pictures | None:
    """The consecutive pictures in a folder, whatever its name, from number ``first`` on; ``None`` if it is not there.

    Parameters
    ----------
    name : of a picture in the form of `str.format`, such as ``{:06d}.png``.
    """
    if not folder.is_dir():
        return None
    whole = str(folder.absolute()).replace("{", "{{").replace("}", "}}")
    return Pictures(pattern=f"{whole}/{name}", first=first, step=1)
