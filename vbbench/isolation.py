"""Runs a solver in a process of its own that is fed over a pipe: truth is nowhere in its memory."""

import multiprocessing
from multiprocessing.connection import Connection
from typing import Any

from threadpoolctl import threadpool_limits

from vbbench.arrays import FloatArray
from vbbench.errors import VbbenchError
from vbbench.registry import make_solver
from vbbench.sequence import Given
from vbbench.solver import Estimate, Frame, FrameEstimate, FrameSolver, Problem


class _Remote:
    def __init__(self, name: str, pipe: Connection) -> None:
        self._name, self._pipe = name, pipe

    def _call(self, method: str, *arguments: Any) -> Any:
        self._pipe.send((method, arguments))
        failed, answer = self._pipe.recv()
        if failed:
            raise RuntimeError(f"solver '{self._name}' failed in its process:\n{answer}")
        return answer


class _RemoteFrameSolver(_Remote):
    def start(self, problem: Problem) -> None:
        self._call("start", problem)

    def step(self, frame: Frame) -> FrameEstimate:
        answer: FrameEstimate = self._call("step", frame)
        return answer


class _RemoteSequenceSolver(_Remote):
    def solve(self, problem: Problem, observations: FloatArray, given: Given) -> Estimate:
        answer: Estimate = self._call("solve", problem, observations, given)
        return answer


class IsolatedSolver:
    """A solver in a child process; use it in a ``with`` block, which gives the solver to drive."""

    def __init__(self, name: str) -> None:
        context = multiprocessing.get_context("spawn")
        self._name = name
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(name, theirs), daemon=True)

    def __enter__(self) -> _RemoteFrameSolver | _RemoteSequenceSolver:
        if multiprocessing.current_process().daemon:
            raise VbbenchError(
                "--isolate needs workers that may start processes: start them with 'dask worker --no-nanny', "
                "or with DASK_DISTRIBUTED__WORKER__DAEMON=False"
            )
        self._process.start()
        failed, kind = self._pipe.recv()
        if failed:
            raise VbbenchError(kind)
        if kind == "frame":
            return _RemoteFrameSolver(self._name, self._pipe)
        return _RemoteSequenceSolver(self._name, self._pipe)

    def __exit__(self, *_error: object) -> None:
        self._pipe.close()
        self._process.join(timeout=5)
        self._process.kill()


def _serve(name: str, pipe: Connection) -> None:
    """The child's loop: answer calls until the pipe closes."""
    import traceback

    try:
        solver = make_solver(name)
    except VbbenchError as error:
        pipe.send((True, str(error)))
        return
    pipe.send((False, "frame" if isinstance(solver, FrameSolver) else "sequence"))
    while True:
        try:
            method, arguments = pipe.recv()
        except EOFError:
            return
        if method != "step":  # what it loads on the way is on one thread from the next sequence on
            threadpool_limits(1)
        try:
            pipe.send((False, getattr(solver, method)(*arguments)))
        except Exception:
            pipe.send((True, traceback.format_exc()))
