"""What a command line asks of simulated crowds and of footage, read from its words."""

import re
from typing import Any

from vbbench.errors import VbbenchError
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import MOST_PEOPLE, Engine, Simulation


def as_simulation(
    scenario: str | None, sequences: int | None, people: str | None, engine: Engine | None
) -> Simulation | None:
    """What a command line asks of a simulated crowd; ``None`` where it asks for nothing."""
    if all(asked is None for asked in (scenario, sequences, people, engine)):
        return None
    counts = None if people is None else parse_people(people)
    return Simulation(scenario=scenario, sequences=sequences, people=counts, engine=engine or "vbbench")


def as_footage(sequences: str | None, **asked: Any) -> FootageOptions | None:
    """What a command line asks of footage, recordings with commas between; ``None`` where it asks for nothing.

    Raises
    ------
    VbbenchError
        If there are commas but no names.
    """
    given = {name: value for name, value in asked.items() if value is not None}
    if sequences is not None:
        given["sequences"] = tuple(name.strip() for name in sequences.split(",") if name.strip())
        if not given["sequences"]:
            raise VbbenchError(f"no recording is named in '{sequences}'; name some, with commas between")
    return FootageOptions(**given) if given else None


def parse_count(text: str) -> int:
    """A number of sequences; raises VbbenchError if it is none."""
    if not re.fullmatch(r"-?[0-9]{1,9}", text):
        raise VbbenchError(
            f"a number of sequences is a whole number, not '{text}'; only footage has recordings with names"
        )
    return int(text)


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
