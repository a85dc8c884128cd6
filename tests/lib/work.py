"""How much work something is: counted, never timed, so that a busy machine changes nothing."""

import gc
import sys
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from types import FrameType


@dataclass(frozen=True, kw_only=True)
class Work:
    """``calls`` of functions, of Python and of C, and the most ``bytes`` held at once, arrays included."""

    calls: int
    bytes: int


def work_of(do: Callable[[], object]) -> Work:
    """What ``do`` and all below it take. What is done once only, such as imports, is done before."""
    do()
    calls = 0

    def count(frame: FrameType, event: str, argument: object) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    before, collecting = sys.getprofile(), gc.isenabled()
    gc.disable()  # others listen to it, Hypothesis for one, and would be counted
    tracemalloc.start()
    sys.setprofile(count)
    try:
        do()
        return Work(calls=calls, bytes=tracemalloc.get_traced_memory()[1])
    finally:
        sys.setprofile(before)
        tracemalloc.stop()
        if collecting:
            gc.enable()
