"""Which rows were trained or tuned on recordings of their board, by what the rows declare.

A row names recordings in ``trained_on`` and ``tuned_on``: a split or the data set that it belongs to, the numbers of
recordings after the name ("KITTI 0015, 0017 and 0019", "Zara 1"), or the SHA-256 of source files. A name without
numbers means all of its recordings. Simulated crowds are no recordings: they are drawn again by another seed.
"""

import re
from collections.abc import Iterator
from functools import cache

from vbbench.registry import load, registered
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.result import About

SIMULATED = ("sim", "street", "demo")
"""Splits that are made of no recording."""

_UNNAMED = ("custom", "own")
"""Splits of a user's own files, whose recordings have no name that a fact could give."""

_SAME = {"eth-15fps": "eth", "students-resampled": "students"}
"""Splits of a recording that another split is named after."""

_DATA_SETS = {"hotel": r"biwi|ewap|eth\W+ucy", "eth": "biwi|ewap", "students": "ucy", "zara": "ucy"}
"""Recording → other names of the data sets that contain it."""

_ELSEWHERE = r"(?<!logs of )(?<!scenes of )({})(?!\W*(?:train|tune))"
_OFFICIAL = {"argoverse2": _ELSEWHERE.format(r"argoverse[ -]?2"), "nuscenes": _ELSEWHERE.format("nuscenes")}
"""Splits whose boards stand on the official part `test`. Facts that name the other parts, or count the logs and scenes
that were looked at while solvers were written, name none of it: those tune."""

_LISTED = (
    r"(?:(?:[\s:_-]|tracking|training|sequences?|recordings?)*"
    r"(\d+(?:(?:[\s,;&–-]|and|to)+\d+)*))?"
)
"""Numbers of recordings directly after a name."""

_LARGEST = 999
"""Of the numbers of recordings; larger ones are years."""

_FACTS = {"trained": "trained_on", "tuned": "tuned_on"}


def seen_by(about: About, record: BoardDataset) -> str:
    """How a solver saw recordings of its board: "trained", "tuned", "trained and tuned", or "" if not at all."""
    if record.split in (*SIMULATED, *_UNNAMED):
        return ""
    return " and ".join(how for how, fact in _FACTS.items() if _names_one(getattr(about, fact).casefold(), record))


def _names_one(fact: str, record: BoardDataset) -> bool:
    """Whether a declared fact names a recording of the dataset."""
    if record.split in _OFFICIAL:
        return any(_words(_OFFICIAL[record.split], fact))
    name, own = _recordings(record)
    listed = [_numbers(found[1]) for found in _words(rf"{re.escape(name)}s?{_LISTED}", fact)]
    if any(not numbers or not own or numbers & own for numbers in listed):
        return True
    whole = name in _DATA_SETS and any(_words(_DATA_SETS[name], fact))
    return whole or not _sources(record.split).isdisjoint(re.findall(r"\b[0-9a-f]{64}\b", fact))


def _words(pattern: str, fact: str) -> Iterator[re.Match[str]]:
    """Where a pattern stands in a fact as separate words."""
    return re.finditer(rf"(?<![a-z0-9])(?:{pattern})(?![a-z])", fact)


def _recordings(record: BoardDataset) -> tuple[str, set[int]]:
    """The name of a dataset's recordings, and the numbers of those that it is made of; none where all count."""
    chosen = re.search(r"--sequences (\d+(?:,\d+)*)(?!\S)", record.command)
    name = _SAME.get(record.split, record.split)
    numbered = re.fullmatch(r"(.*?[a-z])0*(\d+)", name)
    if numbered:
        return numbered[1], {int(numbered[2])}
    return name, {int(number) for number in chosen[1].split(",")} if chosen else set()


def _numbers(listed: str | None) -> set[int]:
    """The numbers of a list; of a range ("0000-0020", "0 to 20") all of them."""
    found: set[int] = set()
    for first, last in re.findall(r"(\d+)(?:\s*(?:-|–|to)\s*(\d+))?", listed or ""):
        if max(int(first), int(last or 0)) <= _LARGEST:
            found.update(range(int(first), int(last or first) + 1))
    return found


@cache
def _sources(split: str) -> frozenset[str]:
    """SHA-256 of the source files of a split that is installed here."""
    card = load("generator", split).card if split in registered("generator") else None
    return frozenset(source.sha256 for source in card.sources) if card else frozenset()
