"""Files of one sequence each, as MOTChallenge and TUM folders hold them: their names, and ``seqinfo.ini``."""

import configparser
import re
from collections.abc import Mapping
from pathlib import Path

from vbbench.errors import FileError

SEQUENCE_INFO = "seqinfo.ini"
_NAME = re.compile(r"sequence-(\d+)")


def sequence_name(number: int) -> str:
    """Name of the file or folder of a sequence."""
    return f"sequence-{number:06d}"


def files_by_sequence(named: Mapping[Path, str], sequences: int) -> dict[int, Path]:
    """The file of each sequence, by number, ascending.

    Parameters
    ----------
    named : each file with its `sequence_name`.
    sequences : how many the dataset has.

    Raises
    ------
    FileError
        At the first file that belongs to no sequence, or to the same sequence as another.
    """
    found: dict[int, Path] = {}
    for path, stem in named.items():
        name = _NAME.fullmatch(stem)
        if name is None or int(name[1]) >= sequences or int(name[1]) in found:
            known = f"sequences 0 to {sequences - 1}, one file each, are called {sequence_name(0)}.txt and so on"
            raise FileError(path, f"belongs to no sequence of the dataset; {known}")
        found[int(name[1])] = path
    return dict(sorted(found.items()))


def sequence_info(name: str, dt: float, frames: int, size: tuple[int, int], extension: str) -> str:
    """The text of ``seqinfo.ini``, as MOTChallenge has it: ``frames`` pictures of ``size`` px, one every ``dt`` s."""
    facts = {
        "name": name,
        "imDir": "img1",
        "frameRate": f"{1.0 / dt:.10g}",
        "seqLength": frames,
        "imWidth": size[0],
        "imHeight": size[1],
        "imExt": extension,
    }
    return "[Sequence]\n" + "".join(f"{key}={value}\n" for key, value in facts.items())


def picture_size_of(path: Path) -> tuple[int, int] | None:
    """Width and height in px of the pictures that a ``seqinfo.ini`` is about; ``None`` if it is missing or silent.

    Raises
    ------
    FileError
        If it cannot be read.
    """
    if not path.is_file():
        return None
    text = configparser.ConfigParser(strict=False, interpolation=None)
    try:
        text.read_string(path.read_text("utf-8-sig"))
        section = text["Sequence"]
        return int(section["imWidth"]), int(section["imHeight"])
    except KeyError:
        return None
    except (OSError, ValueError, configparser.Error) as error:
        raise FileError(path, f"cannot be read: {str(error).splitlines()[0]}") from error
