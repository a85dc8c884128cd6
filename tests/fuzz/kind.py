"""A kind of file: how an honest one is made, what is done to it, who reads it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tests.fuzz.mutations import Mutation


@dataclass(frozen=True)
class Refused:
    """A file was refused with this message."""

    message: str


def _as_it_is(_folder: Path) -> None:
    pass


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of file.

    Parameters
    ----------
    name : of the kind.
    make : writes honest files into an empty folder.
    target : the file in it that is mutated.
    mutations : what is done to it.
    read : reads it, in the folder.
    oracle : from the mutated bytes and what `read` returned (or `Refused`): what is wrong, or ``None``.
    finish : makes digests fit again, as somebody who means harm would; it may change the files `also`.
    also : other files that `finish` changes.
    lists_faults : whether a refusal has a line for each fault.
    weight : how many cases it gets, beside others.
    """

    name: str
    make: Callable[[Path], object]
    target: str
    mutations: tuple[Mutation, ...]
    read: Callable[[Path], object]
    oracle: Callable[[bytes, object], str | None] | None = None
    finish: Callable[[Path], object] = _as_it_is
    also: tuple[str, ...] = ()
    lists_faults: bool = False
    weight: int = 1
