"""Runs many cases over all kinds; which ones follows from their number alone."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.fuzz import datasets, settings, trajectories
from tests.fuzz.kind import Kind
from tests.fuzz.property import Broken, Tally, check

KINDS: dict[str, Kind] = {kind.name: kind for kind in (*trajectories.KINDS, *settings.KINDS, *datasets.KINDS)}


def share(kinds: Iterable[Kind], cases: int) -> Iterator[tuple[Kind, int]]:
    """Each kind with its number of cases, one at least, in proportion to its weight."""
    chosen = list(kinds)
    total = sum(kind.weight for kind in chosen)
    for kind in chosen:
        yield kind, max(1, round(cases * kind.weight / total))


def run(
    kinds: Iterable[Kind], cases: int, *, first: int = 0, on_fault: Callable[[Broken], object] = repr
) -> tuple[Tally, list[Broken]]:
    """Run so many cases, cases ``first`` on of every kind; what was counted, and what broke.

    ``on_fault`` is told of each fault at once.
    """
    tally, broken = Tally(), []
    with ExitStack() as rooms:
        for kind, count in share(kinds, cases):
            folder = Path(rooms.enter_context(TemporaryDirectory(prefix=f"fuzz-{kind.name}-")))
            kind.make(folder)
            kind.read(folder)  # imports, so that no case pays for it; an honest file is read
            tally.kinds[kind.name] = count
            for case in range(first, first + count):
                try:
                    check(kind, case, folder, tally)
                except Broken as fault:
                    broken.append(fault)
                    on_fault(fault)
    return tally, broken
