"""Files of one sequence each, as MOTChallenge and TUM folders hold them: their names, and ``seqinfo.ini``."""

import configparser
import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from vbbench.errors import FileError, quoted
from vbbench.parsing.numbers import parse_number

SEQUENCE_INFO = "seqinfo.ini"
SECTION = "Sequence"
MOST_PIXELS = 10**5
"""Of the longer side of a picture."""
SAME_RATE = 0.01
"""Share by which frame rates may differ that are meant to be the same, as 29.97 and 30 are."""
_LONGEST_ROW, _MOST_BYTES = 2000, 2**16
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


class PictureFacts(NamedTuple):
    """What a ``seqinfo.ini`` says of its pictures: ``size`` in px and ``rate`` a second, or ``None``."""

    size: tuple[int, int] | None = None
    rate: float | None = None

    def has_dt(self, dt: float) -> bool:
        """Whether a frame may last ``dt`` seconds, to the hundredth."""
        return self.rate is None or abs(self.rate * dt - 1.0) <= SAME_RATE


def picture_facts(path: Path) -> PictureFacts:
    """What a ``seqinfo.ini`` says of its pictures: nothing if it is missing.

    Raises
    ------
    FileError
        If it cannot be read.
    """
    if not path.is_file():
        return PictureFacts()
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror or error}") from error
    facts = sequence_facts(path, content) or {}
    rate = frame_rate(path, facts["frameRate"]) if facts.get("frameRate", "").strip() else None
    if "imWidth" not in facts or "imHeight" not in facts:
        return PictureFacts(rate=rate)
    width, height = (whole_number(path, key, facts[key], MOST_PIXELS) for key in ("imWidth", "imHeight"))
    return PictureFacts(size=(width, height), rate=rate)


def sequence_facts(path: Path, content: bytes, *, strict: bool = False) -> Mapping[str, str] | None:
    """What a ``seqinfo.ini`` says, by key, whatever its case; ``None`` without a section [Sequence].

    Parameters
    ----------
    path : what messages call it.
    content : the text, UTF-8.
    strict : whether no key may stand twice.

    Raises
    ------
    FileError
        If it is not such a file.
    """
    if len(content) > _MOST_BYTES:
        raise FileError(path, f"has {len(content):,} bytes; a file of this kind has a few hundred")
    endless = next((n for n, row in enumerate(content.splitlines(), 1) if len(row) > _LONGEST_ROW), None)
    if endless is not None:  # the time of parsing a line grows with the square of its length
        raise FileError(path, f"has more than {_LONGEST_ROW:,} bytes; a line of this file has a few dozen", endless)
    parser = configparser.ConfigParser(interpolation=None, strict=strict)
    try:
        parser.read_string(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise FileError(path, "is not a text file") from error
    except configparser.Error as error:
        line = getattr(error, "lineno", None)
        raise FileError(path, f"is not an ini file: expected [{SECTION}] and lines 'key=value'", line) from error
    return parser[SECTION] if parser.has_section(SECTION) else None


def whole_number(path: Path, key: str, text: str, most: int) -> int:
    """The number that a file states under a key.

    Raises
    ------
    FileError
        If it is not a whole number from 1 to ``most``.
    """
    count = int(text) if re.fullmatch("[0-9]{1,9}", text) else 0
    if not 1 <= count <= most:
        raise FileError(path, f"{key} is {quoted(text)}, not a whole number from 1 to {most}")
    return count


def frame_rate(path: Path, text: str) -> float:
    """Pictures a second that a file states under ``frameRate``.

    Raises
    ------
    FileError
        If it is not a number from 0.1 to 1000.
    """
    rate = parse_number(text)
    if rate is None or not 0.1 <= rate <= 1000.0:
        raise FileError(path, f"frameRate is {quoted(text)}, not a number of pictures a second, 0.1 to 1000")
    return rate
