"""``seqinfo.ini``: what a recording of MOTChallenge is called, how long it is, and how large its pictures are."""

import configparser
import re
from dataclasses import dataclass
from pathlib import Path

from vbbench.errors import FileError, quoted
from vbbench.parsing.numbers import parse_number

_SECTION = "Sequence"
_MOST_FRAMES, _MOST_PIXELS = 10**6, 10**5
_LONGEST_NAME, _LONGEST_ROW, _MOST_BYTES = 200, 2000, 2**16


@dataclass(frozen=True, kw_only=True)
class SequenceInfo:
    """What is told of a recording.

    Parameters
    ----------
    name : what it is called, such as ``HT21-03``.
    frame_rate : pictures a second.
    frames : number of them.
    size : their width and height in px.
    """

    name: str
    frame_rate: float
    frames: int
    size: tuple[int, int]

    @property
    def dt(self) -> float:
        """Seconds a frame."""
        return 1.0 / self.frame_rate


def parse_seqinfo(path: Path, content: bytes) -> SequenceInfo:
    """Read what ``seqinfo.ini`` holds; nothing is taken for granted.

    Parameters
    ----------
    path : what messages call it.
    content : the text, UTF-8.

    Raises
    ------
    FileError
        If it is no such file, or a key is missing or cannot be.
    """
    facts = _section(path, content)
    for key in ("name", "frameRate", "seqLength", "imWidth", "imHeight"):
        if not facts.get(key, "").strip():
            raise FileError(path, f"key '{key}' is missing in its section [{_SECTION}]")
    return SequenceInfo(
        name=_name(path, facts["name"].strip()),
        frame_rate=_rate(path, facts["frameRate"]),
        frames=_count(path, "seqLength", facts["seqLength"], _MOST_FRAMES),
        size=(
            _count(path, "imWidth", facts["imWidth"], _MOST_PIXELS),
            _count(path, "imHeight", facts["imHeight"], _MOST_PIXELS),
        ),
    )


def _section(path: Path, content: bytes) -> configparser.SectionProxy:
    if len(content) > _MOST_BYTES:
        raise FileError(path, f"has {len(content):,} bytes; a file of this kind has a few hundred")
    endless = next((n for n, row in enumerate(content.splitlines(), 1) if len(row) > _LONGEST_ROW), None)
    if endless is not None:  # the time of parsing a line grows with the square of its length
        raise FileError(path, f"has more than {_LONGEST_ROW:,} bytes; a line of this file has a few dozen", endless)
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string(content.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise FileError(path, "is no text file") from error
    except configparser.Error as error:
        line = getattr(error, "lineno", None)
        raise FileError(path, f"is no ini file: wanted are [{_SECTION}] and lines 'key=value'", line) from error
    if not parser.has_section(_SECTION):
        raise FileError(path, f"has no section [{_SECTION}]")
    return parser[_SECTION]


def _name(path: Path, text: str) -> str:
    if len(text) > _LONGEST_NAME or not text.isprintable():
        raise FileError(path, f"name is {quoted(text)}, not up to {_LONGEST_NAME} letters in one line")
    return text


def _rate(path: Path, text: str) -> float:
    rate = parse_number(text)
    if rate is None or not 0.1 <= rate <= 1000.0:
        raise FileError(path, f"frameRate is {quoted(text)}, not a number of pictures a second, 0.1 to 1000")
    return rate


def _count(path: Path, key: str, text: str, most: int) -> int:
    count = int(text) if re.fullmatch("[0-9]{1,9}", text) else 0
    if not 1 <= count <= most:
        raise FileError(path, f"{key} is {quoted(text)}, not a whole number from 1 to {most}")
    return count
