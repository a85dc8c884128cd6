"""``seqinfo.ini``: what a recording of MOTChallenge is called, how long it is, and how large its pictures are."""

import configparser
import math
from dataclasses import dataclass
from pathlib import Path

from vbbench.errors import FileError

_SECTION = "Sequence"
_MOST_FRAMES, _MOST_PIXELS = 10**6, 10**5


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
        name=facts["name"].strip(),
        frame_rate=_rate(path, facts["frameRate"]),
        frames=_count(path, "seqLength", facts["seqLength"], _MOST_FRAMES),
        size=(
            _count(path, "imWidth", facts["imWidth"], _MOST_PIXELS),
            _count(path, "imHeight", facts["imHeight"], _MOST_PIXELS),
        ),
    )


def _section(path: Path, content: bytes) -> configparser.SectionProxy:
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


def _rate(path: Path, text: str) -> float:
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    if not 0.1 <= rate <= 1000.0:
        raise FileError(path, f"frameRate is '{text}', not a number of pictures a second")
    return rate


def _count(path: Path, key: str, text: str, most: int) -> int:
    if not text.strip().isdecimal() or not 1 <= int(text) <= most:
        raise FileError(path, f"{key} is '{text}', not a whole number from 1 to {most}")
    return int(text)
