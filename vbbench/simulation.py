"""What a user asks of a simulated crowd."""

import re
from dataclasses import dataclass
from typing import Literal

from vbbench.errors import VbbenchError

Engine = Literal["numba", "pysocialforce"]
MOST_PEOPLE = 10_000
"""People of the largest crowd."""


@dataclass(frozen=True, kw_only=True)
class Simulation:
    """What is asked of a simulated crowd; ``None`` leaves it to the scenario.

    Parameters
    ----------
    scenario : name of a scenario, or path of a scenario file.
    sequences : number of sequences.
    people : numbers of people K; the sequences take them in turn.
    engine : which implementation of the social force walks the crowd.
    """

    scenario: str | None = None
    sequences: int | None = None
    people: tuple[int, ...] | None = None
    engine: Engine = "numba"


def as_simulation(
    scenario: str | None, sequences: int | None, people: str | None, engine: Engine | None
) -> Simulation | None:
    """What a command line asks of a simulated crowd; ``None`` where it asks for nothing."""
    if all(asked is None for asked in (scenario, sequences, people, engine)):
        return None
    counts = None if people is None else parse_people(people)
    return Simulation(scenario=scenario, sequences=sequences, people=counts, engine=engine or "numba")


def parse_people(text: str) -> tuple[int, ...]:
    """Numbers of people from ``K``, ``A:B`` (both ends included) or ``A:B:STEP``.

    Raises
    ------
    VbbenchError
        If it is none of these, or no crowd.
    """
    form = re.fullmatch(r"([0-9]{1,9})(?::([0-9]{1,9})(?::([0-9]{1,9}))?)?", text)
    first, last, step = (int(form[1]), int(form[2] or form[1]), int(form[3] or 1)) if form else (0, 0, 1)
    if not 2 <= first <= last <= MOST_PEOPLE or step < 1:
        wanted = f"a number from 2 to {MOST_PEOPLE:,}, A:B, or A:B:STEP such as 10:50:10"
        raise VbbenchError(f"numbers of people are {wanted}, not '{text}'")
    return tuple(range(first, last + 1, step))
