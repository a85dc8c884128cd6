"""Folders with a file for each sequence, for MOTChallenge and TUM: names of files, and ``seqinfo.ini``."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from vbbench.errors import FileError, quoted
from vbbench.exchange.text_tables import decode, read_content
from vbbench.parsing.numbers import parse_number

SEQUENCE_INFO = "seqinfo.ini"
MOST_PIXELS = 10**5
"""Of the longer side of a picture."""
SAME_RATE = 0.01
"""Share by which frame rates may differ that are meant to be the same, as 29.97 and 30 are."""
_LONGEST_NAME = 200
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
    return "[Sequence]\n" + "".join(f"{key}={value}\n" for key, value in facts.items())


class SequenceInfo(NamedTuple):
    """Contents of a ``seqinfo.ini``: ``frames`` pictures of ``size`` px, ``rate`` per second; 0 = not stated."""

    path: Path
    name: str = ""
    rate: float = 0.0
    frames: int = 0
    size: tuple[int, int] = (0, 0)

    def refuse_other(self, whose: str, size: tuple[float, float], dt: float | None = None) -> None:
        """Raise FileError if pictures of a ``size``, one every ``dt`` s, are others; rates may differ by a hundredth.

        ``whose`` pictures these are begins the words about them.
        """
        advice = "write those of the pictures that the boxes are of in both, with the focal length of this size"
        if any(self.size) and self.size != size:
            known = f"{self.size[0]} x {self.size[1]} px, {whose} {size[0]:g} x {size[1]:g}"
            raise FileError(self.path, f"its pictures have {known}; {advice}")
        if dt and self.rate and abs(self.rate * dt - 1.0) > SAME_RATE:
            raise FileError(self.path, f"its frameRate is {self.rate:g}, {whose} {1.0 / dt:.4g}; {advice}")


def picture_facts(*folders: Path) -> SequenceInfo:
    """Size and rate of the pictures by the first ``seqinfo.ini`` in some folders; all 0 without one."""
    found = next((path for folder in folders if (path := folder / SEQUENCE_INFO).is_file()), None)
    if found is None:
        return SequenceInfo(folders[0] / SEQUENCE_INFO)
    return parse_seqinfo(found, read_content(found, "facts of pictures"), whole=False)


def parse_seqinfo(path: Path, content: bytes, *, whole: bool = True) -> SequenceInfo:
    """The contents of a ``seqinfo.ini``: all keys, if it must be ``whole``; else only size and rate."""
    text = decode(path, content).decode("utf-8", "replace")
    lines = {key: re.search(rf"(?im)^[ \t]*{key}[ \t]*=(.*)$", text) for key in ("name", "frameRate", *_MOST)}
    stated = {key: line[1].strip() if line else "" for key, line in lines.items()}
    missing = next((key for key, text in stated.items() if not text), None)
    if whole and missing is not None:
        raise FileError(path, f"key '{missing}' is missing; lines are 'key=value'")
    rate = parse_number(stated["frameRate"] or "0")
    if stated["frameRate"] and (rate is None or not 0.1 <= rate <= 1000.0):
        problem = f"frameRate is {quoted(stated['frameRate'])}, not a number of pictures a second, 0.1 to 1000"
        raise FileError(path, problem)
    counts = dict.fromkeys(_MOST, 0)
    for key in counts if whole else _SIZE if all(stated[one] for one in _SIZE) else ():
        counts[key] = int(stated[key]) if re.fullmatch("[0-9]{1,9}", stated[key]) else 0
        if not 1 <= counts[key] <= _MOST[key]:
            raise FileError(path, f"{key} is {quoted(stated[key])}, not a whole number from 1 to {_MOST[key]}")
    name = stated["name"] if whole else ""
    if len(name) > _LONGEST_NAME or not name.isprintable():
        raise FileError(path, f"name is {quoted(name)}, not up to {_LONGEST_NAME} letters in one line")
    return SequenceInfo(path, name, rate or 0.0, counts["seqLength"], (counts["imWidth"], counts["imHeight"]))
