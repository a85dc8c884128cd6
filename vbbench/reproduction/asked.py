"""What several studies are asked for, checked before the work starts."""

from collections.abc import Iterable

from vbbench.errors import VbbenchError
from vbbench.protocol import get_protocol
from vbbench.registry import make_solver


def check_every(every: int) -> None:
    """Raise VbbenchError if every so many-th sequence is no number of sequences."""
    if every < 1:
        raise VbbenchError(f"every must be 1 or more, not {every}; 6 measures every sixth sequence")


def stride_of(every: int) -> int | None:
    """What `vbbench.generation.generator.Options.stride` is for every so many-th sequence: ``None`` for all."""
    return None if every == 1 else every


def check_names(solvers: Iterable[str], protocols: Iterable[str]) -> None:
    """Raise VbbenchError if a protocol or a solver is unknown."""
    for protocol in protocols:
        get_protocol(protocol)
    for solver in solvers:
        make_solver(solver)
