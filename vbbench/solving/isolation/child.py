"""The side of `process` that runs the solver: it gives up its rights, then answers one request after the other.

This module is imported before that, and with it nothing that starts threads or is the solver's.
"""

import os
import sys
from typing import IO, Any

from vbbench.solving.isolation import landlock


def main(requests: IO[bytes], facts: dict[str, Any]) -> None:
    """Confine this process and serve the solver that ``facts`` name until ``requests`` end."""
    answers = _take_stdout()
    _confine(facts)
    from vbbench.solving.isolation.serving import serve  # with NumPy, whose libraries start threads

    serve(facts["name"], requests, answers)


def _take_stdout() -> IO[bytes]:
    """The pipe that stdout was: what a solver prints goes to stderr, and it reads nothing."""
    answers = open(os.dup(1), "wb")  # noqa: PTH123, SIM115
    os.dup2(2, 1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    return answers


def _confine(facts: dict[str, Any]) -> None:
    if os.name == "posix":
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if not sys.platform.startswith("linux"):
        from vbbench.parallel.stopping import end_with_parent

        end_with_parent(facts["parent"])
        return
    landlock.leave_namespaces()
    if landlock.version():
        landlock.restrict(facts["readable"], facts["writable"])
    landlock.drop_capabilities()
    landlock.die_with_parent(facts["parent"])
