"""Folders with a file for each sequence, for MOTChallenge and TUM: names of files, and ``seqinfo.ini``."""

import configparser
import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from vbbench.errors import FileError, plain_errors, quoted
from vbbench.parsing.numbers import parse_number

SEQUENCE_INFO = "seqinfo.ini"
SECTION = "Sequence"
MOST_PIXELS = 10**5
"""Of the longer side of a picture."""
SAME_RATE = 0.01
"""Share by which frame rates may differ that are meant to be the same, as 29.97 and 30 are."""
_LONGEST_ROW, _LONGEST_NAME, _MOST_BYTES = 2000, 200, 2**16
_SIZE = ("imWidth", "imHeight")
_MOST = {**dict.fromkeys(_SIZE, MOST_PIXELS), "seqLength": 10**6}
"""Whole numbers in the file, and the largest that they can be."""
_NAME = re.compile(r"sequence-(\d+)")


def sequence_name(number: int) -> str:
    """Name of the file or folder of a sequence."""
    return f"sequence-{number:06d}"


def files_by_sequence(named: Mapping[Path, str], sequences: int) -> dict[int, Path]:
    """The file of each of a dataset's ``sequences``, by number, ascending, from files with their `sequence_name`."""
    found: dict[int, Path] = {}
    for path, stem in named.items():
        name = _NAME.fullmatch(stem)
        if name is None or int(name[1]) >= sequences or int(name[1]) in found:
            known = f"sequences 0 to {sequences - 1}, one file each, are called {sequence_name(0)}.txt and so on"
            raise FileError(path, f"belongs to no sequence of the dataset; {known}")
        found[int(name[1])] = path
    return dict(sorted(found.items()))


def sequence_info(name: str, dt: float, frames: int, size: tuple[int, int], extension: str) -> str:
    """The text of MOTChallenge's ``seqinfo.ini``: ``frames`` pictures of ``size`` px, one every ``dt`` s."""
    facts = {"name": name, "imDir": "img1", "frameRate": f"{1.0 / dt:.10g}", "seqLength": frames}
    facts |= {"imWidth": size[0], "imHeight": size[1], "imExt": extension}
    return f"[{SECTION}]\n" + "".join(f"{key}={value}\n" for key, value in facts.items())


class SequenceInfo(NamedTuple):
    """Contents of a ``seqinfo.ini``: ``frames`` pictures of ``size`` px, ``rate`` per second; 0 = not stated."""

    name: str = ""
    rate: float = 0.0
    frames: int = 0
    size: tuple[int, int] = (0, 0)

    def has_dt(self, dt: float) -> bool:
        """Whether a frame may last ``dt`` seconds, to the hundredth."""
        return not self.rate or abs(self.rate * dt - 1.0) <= SAME_RATE


def picture_facts(*folders: Path) -> tuple[Path, SequenceInfo]:
    """The first ``seqinfo.ini`` in some folders, and size and rate of its pictures; all 0 without one."""
    found = next((path for folder in folders if (path := folder / SEQUENCE_INFO).is_file()), None)
    if found is None:
        return folders[0] / SEQUENCE_INFO, SequenceInfo()
    with plain_errors(found):
        return found, parse_seqinfo(found, found.read_bytes(), whole=False)


def parse_seqinfo(path: Path, content: bytes, *, whole: bool = True) -> SequenceInfo:
    """The contents of a ``seqinfo.ini``: all keys, each once, if it must be ``whole``; else only size and rate."""
    if len(content) > _MOST_BYTES:
        raise FileError(path, f"has {len(content):,} bytes; a file of this kind has a few hundred")
    endless = next((n for n, row in enumerate(content.splitlines(), 1) if len(row) > _LONGEST_ROW), None)
    if endless is not None:  # the time of parsing a line grows with the square of its length
        raise FileError(path, f"has more than {_LONGEST_ROW:,} bytes; a line of this file has a few dozen", endless)
    parser = configparser.ConfigParser(interpolation=None, strict=whole)
    try:
        parser.read_string(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise FileError(path, "is not a text file") from error
    except configparser.Error as error:
        line = getattr(error, "lineno", None)
        raise FileError(path, f"is not an ini file: expected [{SECTION}] and lines 'key=value'", line) from error
    facts = dict(parser[SECTION]) if parser.has_section(SECTION) else {}
    stated = {key: facts.get(key.lower(), "").strip() for key in ("name", "frameRate", "seqLength", *_SIZE)}
    counts = dict.fromkeys(_MOST, 0)
    missing = next((key for key, text in stated.items() if not text), None)
    if whole and missing is not None:
        raise FileError(path, f"key '{missing}' is missing in its section [{SECTION}]")
    rate = parse_number(stated["frameRate"] or "0")
    if stated["frameRate"] and (rate is None or not 0.1 <= rate <= 1000.0):
        problem = f"frameRate is {quoted(stated['frameRate'])}, not a number of pictures a second, 0.1 to 1000"
        raise FileError(path, problem)
    for key in counts if whole else _SIZE if all(stated[one] for one in _SIZE) else ():
        counts[key] = int(stated[key]) if re.fullmatch("[0-9]{1,9}", stated[key]) else 0
        if not 1 <= counts[key] <= _MOST[key]:
            raise FileError(path, f"{key} is {quoted(stated[key])}, not a whole number from 1 to {_MOST[key]}")
    name = stated["name"] if whole else ""
    if len(name) > _LONGEST_NAME or not name.isprintable():
        raise FileError(path, f"name is {quoted(name)}, not up to {_LONGEST_NAME} letters in one line")
    return SequenceInfo(name, rate or 0.0, counts["seqLength"], (counts["imWidth"], counts["imHeight"]))
