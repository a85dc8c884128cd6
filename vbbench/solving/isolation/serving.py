"""Answers, in the solver's process, the requests that come over the pipe."""

import traceback
from collections.abc import Callable
from dataclasses import fields
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from vbbench.camera import camera_from_dict
from vbbench.errors import VbbenchError
from vbbench.registry import make_solver
from vbbench.sequence import Given, Odometry
from vbbench.solver import Estimate, Frame, FrameEstimate, FrameSolver, Problem, SequenceSolver
from vbbench.solving.isolation.messages import TEXT_LIMIT, ClosedError, read_message, write_message

Arrays = dict[str, NDArray[Any]]

HINT = "; isolated, it reads what is installed and what lies next to it, but nothing in the folder of a dataset"
"""Why a solver may fail to load here that loads elsewhere."""


def serve(name: str, requests: IO[bytes], answers: IO[bytes]) -> None:
    """Make the solver, report its kind, and answer requests until the pipe closes."""
    try:
        solver = make_solver(name)
    except VbbenchError as error:
        hint = HINT if "cannot be imported" in str(error) else ""
        write_message(answers, {"said": "refused", "text": f"{error}"[:TEXT_LIMIT] + hint})
        return
    write_message(answers, {"said": "ready", "solver": _kind(solver)})
    while True:
        try:
            facts, arrays = read_message(requests)
        except ClosedError:
            return
        try:
            answer = _CALLS[facts["call"]](solver, facts, arrays)
        except Exception:
            write_message(answers, {"said": "failed", "text": traceback.format_exc()[-TEXT_LIMIT:]})
        else:
            write_message(answers, {"said": "done"}, answer)


def _kind(solver: object) -> str:
    if isinstance(solver, FrameSolver):
        return "frame"
    return "sequence" if isinstance(solver, SequenceSolver) else type(solver).__name__


def _start(solver: Any, facts: dict[str, Any], arrays: Arrays) -> Arrays:
    threadpool_limits(1)  # libraries loaded since the last call are on one thread too from here on
    solver.start(_problem(facts, arrays))
    return {}


def _step(solver: Any, _facts: dict[str, Any], arrays: Arrays) -> Arrays:
    frame = Frame(index=int(arrays["index"]), observations=arrays["observations"], given=_given(arrays))
    return _arrays(solver.step(frame), FrameEstimate)


def _solve(solver: Any, facts: dict[str, Any], arrays: Arrays) -> Arrays:
    threadpool_limits(1)
    return _arrays(solver.solve(_problem(facts, arrays), arrays["observations"], _given(arrays)), Estimate)


def _given(arrays: Arrays) -> Given:
    measured = "motions" in arrays
    odometry = Odometry(motions=arrays["motions"], covariances=arrays["motion_covariances"]) if measured else None
    return Given(poses=arrays["poses"], positions=arrays["positions"], odometry=odometry)


_CALLS: dict[str, Callable[[Any, dict[str, Any], Arrays], Arrays]] = {"start": _start, "step": _step, "solve": _solve}


def _problem(facts: dict[str, Any], arrays: Arrays) -> Problem:
    return Problem(**{**facts["problem"], "camera": camera_from_dict(facts["camera"]), "tracks": arrays["tracks"]})


def _arrays(answer: object, kind: type[FrameEstimate] | type[Estimate]) -> Arrays:
    """The parts of an answer that a solver reports, by name; marks are bool, everything else is float64."""
    if not isinstance(answer, kind):
        raise TypeError(f"the solver returned a {type(answer).__name__}, not a {kind.__name__}")
    return {
        field.name: np.asarray(value, bool if field.name in ("fallback", "converged") else np.float64)
        for field in fields(kind)
        if (value := getattr(answer, field.name)) is not None
    }
