"""What must hold of every case: a file is read or refused in one clear line, with little memory, at once."""

import hashlib
import resource
import signal
import time
import warnings
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from tests.fuzz.kind import Kind, Refused
from tests.fuzz.mutations import mutate
from vbbench.errors import VbbenchError, VbbenchWarning, is_printable

LONGEST_MESSAGE = 6000
MOST_MEMORY = 64 * 2**20
"""Bytes by which the peak of this process may grow in one case; the arrays of an honest file here have some kB."""
MOST_TIME = 1.0
"""Seconds of processor time that a case may take."""


class Broken(AssertionError):  # noqa: N818  what pytest calls it
    """A case that breaks the property, with the command that runs it again."""


@dataclass
class Tally:
    """How many cases were read, and how many refused."""

    read: int = 0
    refused: int = 0
    slowest: float = 0.0
    kinds: dict[str, int] = field(default_factory=dict)


def check(kind: Kind, case: int, folder: Path, tally: Tally) -> None:
    """Run one case: mutate the kind's file in ``folder``, read it, and put the honest one back.

    Raises
    ------
    Broken
        If anything but reading or refusing happened.
    """
    honest = {name: (folder / name).read_bytes() for name in (kind.target, *kind.also)}
    random = Random(f"{kind.name}:{case}")
    content = mutate(honest[kind.target], random, kind.mutations)
    (folder / kind.target).write_bytes(content)
    kind.finish(folder)
    try:
        fault = _fault(kind, folder, content, tally)
    finally:
        for name, before in honest.items():
            (folder / name).write_bytes(before)
    if fault is not None:
        raise Broken(f"{fault}\nagain: python -m tests.fuzz {kind.name} --case {case}")


def _fault(kind: Kind, folder: Path, content: bytes, tally: Tally) -> str | None:
    """What is wrong about how the file was taken; ``None`` if nothing is."""
    before, peak, start = _listing(folder), _peak_from_here(), time.process_time()
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        outcome = _read(kind, folder)
    seconds, growth = time.process_time() - start, _peak() - peak
    tally.slowest = max(tally.slowest, seconds)
    if isinstance(outcome, Refused):
        tally.refused += 1
    else:
        tally.read += 1
    faults = [
        _message_fault(kind, folder, outcome) if isinstance(outcome, Refused) else None,
        f"{outcome!r}: another error than ours" if isinstance(outcome, Exception) else None,
        next((f"warned: {w.message}" for w in warned if not _is_ours(w)), None),
        f"took {seconds:.2f} s" if seconds > MOST_TIME else None,
        f"took {growth / 2**20:.0f} MB" if growth > MOST_MEMORY else None,
        "the folder was changed" if _listing(folder) != before else None,
        None if isinstance(outcome, Exception) or kind.oracle is None else kind.oracle(content, outcome),
    ]
    return next((fault for fault in faults if fault is not None), None)


class _Endless(Exception):  # noqa: N818
    """A case takes so long that it is not waited for."""


def _give_up(*_signal: object) -> None:
    raise _Endless(f"more than {5 * MOST_TIME:g} s")


def _read(kind: Kind, folder: Path) -> object:
    """What the reader returns, its refusal, or another error than ours, which nobody may see."""
    signal.signal(signal.SIGPROF, _give_up)
    signal.setitimer(signal.ITIMER_PROF, 5 * MOST_TIME)
    try:
        return kind.read(folder)
    except VbbenchError as error:
        return Refused(str(error))
    except Exception as error:
        return error
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def _message_fault(kind: Kind, folder: Path, refused: Refused) -> str | None:
    text = refused.message
    lines = text.split("\n") if kind.lists_faults else [text]
    if not all(is_printable(line) and 0 < len(line) <= LONGEST_MESSAGE for line in lines):
        return f"no line for a terminal: {text[:300]!r} ({len(text)} characters)"
    names = (str(folder), Path(kind.target).stem)
    return None if any(name in text for name in names) else f"does not name the file: {text[:300]}"


def _is_ours(warned: warnings.WarningMessage) -> bool:
    return issubclass(warned.category, VbbenchWarning) and is_printable(str(warned.message))


def _listing(folder: Path) -> str:
    """Names, sizes and times of all that is in a folder, as one digest."""
    facts = sorted((str(p), p.stat().st_size, p.stat().st_mtime_ns) for p in folder.rglob("*"))
    return hashlib.sha256(repr(facts).encode()).hexdigest()


def _peak_from_here() -> int:
    """Bytes in memory now; what `_peak` says is the most since then, where the kernel counts anew (Linux)."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
    return _peak()


def _peak() -> int:
    """The most bytes that this process has had in memory."""
    status = Path("/proc/self/status")
    if not status.is_file():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return 1024 * int(status.read_text("utf-8").partition("VmHWM:")[2].split()[0])
