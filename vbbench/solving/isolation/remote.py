"""Calls a solver in another process, and checks every answer before it is used."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from vbbench.camera import camera_to_dict
from vbbench.errors import VbbenchError, VbbenchWarning
from vbbench.geometry import FloatArray
from vbbench.sequence import Given
from vbbench.solver import Estimate, Frame, FrameEstimate, Problem
from vbbench.solving.isolation.confinement import device_paths, landlock_version, readable_paths
from vbbench.solving.isolation.serving import (
    BOOL,
    FLOAT,
    TEXT_LIMIT,
    ClosedError,
    MessageError,
    Shapes,
    plain,
    read_message,
    write_message,
)
from vbbench.solving.provenance import source_places

LAST_WORDS = 4096
"""Bytes kept of what a solver prints."""


class Child:
    """A running process and its pipes."""

    def __init__(self, name: str, process: "subprocess.Popen[bytes]") -> None:
        self._name, self._process = name, process
        self._printed = bytearray()
        self._listener = Thread(target=self._listen, daemon=True)
        self._listener.start()
        self.working_on = "loading"

    def introduced(self) -> "RemoteFrameSolver | RemoteSequenceSolver":
        """The solver to run, of the kind that the process reports."""
        facts, _ = self._receive({})
        if facts["said"] != "ready":
            raise self._nonsense("no greeting")
        self.working_on = "solving"
        match facts.get("solver"):
            case "frame":
                return RemoteFrameSolver(self)
            case "sequence":
                return RemoteSequenceSolver(self)
            case other:
                kind = plain(str(other), 80)
                raise VbbenchError(f"{kind} is not a solver: it has neither start and step nor solve")

    def call(
        self,
        facts: Mapping[str, Any],
        arrays: Mapping[str, NDArray[Any]],
        expected: Shapes,
        needed: Sequence[str] = (),
    ) -> dict[str, NDArray[Any]]:
        """Make one request; the answer holds some of the ``expected`` arrays, and all ``needed`` ones."""
        try:
            write_message(pipe_of(self._process.stdin), facts, arrays)
        except OSError as error:
            raise self._ended() from error
        said, answer = self._receive(expected)
        if said["said"] != "done":
            raise self._nonsense("something else than an answer")
        for name in needed:
            if name not in answer:
                raise self._nonsense(f"an answer without '{name}'")
        return answer

    def end(self) -> None:
        """Kill the process and the rest of its process group."""
        with suppress(OSError):
            if hasattr(os, "killpg"):
                os.killpg(self._process.pid, signal.SIGKILL)
            self._process.kill()
        self._process.wait()
        with suppress(OSError):  # bytes that it did not read
            pipe_of(self._process.stdin).close()
        if self._process.stdout is not None:
            self._process.stdout.close()

    def _receive(self, expected: Shapes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
        try:
            facts, arrays = read_message(pipe_of(self._process.stdout), expected)
        except ClosedError as error:
            raise self._ended() from error
        except MessageError as error:
            raise self._nonsense(str(error)) from error
        if not isinstance(facts.get("said"), str):
            raise self._nonsense("a message that says nothing")
        text = plain(str(facts.get("text", "")), TEXT_LIMIT, lines=True)
        if facts["said"] == "refused":
            raise VbbenchError(text)
        if facts["said"] == "failed":
            raise VbbenchError(f"solver '{self._name}' failed while {self.working_on}:", *text.splitlines())
        return facts, arrays

    def _nonsense(self, what: str) -> VbbenchError:
        return VbbenchError(f"solver '{self._name}' sent {what}, while {self.working_on}; its answers are not used")

    def _ended(self) -> VbbenchError:
        """An error that says how the process ended, and what it printed last."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=1)
        self._listener.join(timeout=1)
        printed = plain(" ".join(self._printed.decode("utf-8", "replace").split()), 300)
        said = f"; it printed last: {printed}" if printed else ""
        return VbbenchError(f"solver '{self._name}' {_how(self._process.poll())} while {self.working_on}{said}")

    def _listen(self) -> None:
        with pipe_of(self._process.stderr) as pipe:
            while text := os.read(pipe.fileno(), 1 << 16):
                self._printed = (self._printed + text)[-LAST_WORDS:]


def _how(status: int | None) -> str:
    """The end of a process, as part of a sentence."""
    if status is None:
        return "closed its pipe"
    if status >= 0:
        return f"left with exit status {status}"
    try:
        return f"was ended by {signal.Signals(-status).name}"
    except ValueError:
        return f"was ended by signal {-status}"


def pipe_of(pipe: IO[bytes] | None) -> IO[bytes]:
    """A pipe of a process that was started with all three, narrowed for the type checker."""
    if pipe is None:
        raise VbbenchError("the solver's process has no pipe")
    return pipe


class Remote:
    """A solver in another process, as the runner sees it."""

    def __init__(self, child: Child) -> None:
        self._child = child

    def is_now(self, working_on: str) -> None:
        """Set the solver's present work, for error messages; the solver does not get this."""
        self._child.working_on = working_on


class RemoteFrameSolver(Remote):
    """A `FrameSolver` in another process."""

    def start(self, problem: Problem) -> None:
        """See `FrameSolver.start`."""
        people = len(problem.tracks)
        self._expected: Shapes = {
            "pose": (FLOAT, (3,)),
            "pose_covariance": (FLOAT, (3, 3)),
            **_shapes_of_people((), people),
        }
        self._child.call({"call": "start", **_facts(problem)}, {"tracks": problem.tracks}, {})

    def step(self, frame: Frame) -> FrameEstimate:
        """See `FrameSolver.step`."""
        shown = {"index": np.array(frame.index), "observations": frame.observations, **_given(frame.given)}
        answer: dict[str, Any] = self._child.call({"call": "step"}, shown, self._expected, ("pose", "positions"))
        for mark in answer.keys() & {"fallback", "converged"}:
            answer[mark] = bool(answer[mark])
        return FrameEstimate(**answer)


class RemoteSequenceSolver(Remote):
    """A `SequenceSolver` in another process."""

    def solve(self, problem: Problem, observations: FloatArray, given: Given) -> Estimate:
        """See `SequenceSolver.solve`."""
        shown = {"tracks": problem.tracks, "observations": observations, **_given(given)}
        frames, people = given.positions.shape[:2]
        expected: Shapes = {
            "poses": (FLOAT, (frames, 3)),
            "pose_covariances": (FLOAT, (frames, 3, 3)),
            **_shapes_of_people((frames,), people),
        }
        answer = self._child.call({"call": "solve", **_facts(problem)}, shown, expected, ("poses", "positions"))
        return Estimate(**answer)


def _shapes_of_people(frames: tuple[int, ...], people: int) -> Shapes:
    """Types and shapes of the arrays that answers have for one frame, with no ``frames``, or for several."""
    return {
        "positions": (FLOAT, (*frames, people, 2)),
        "position_covariances": (FLOAT, (*frames, people, 2, 2)),
        **dict.fromkeys(("heights", "height_variances"), (FLOAT, (people,))),
        **dict.fromkeys(("fallback", "converged"), (BOOL, frames)),
    }


def _given(given: Given) -> dict[str, Any]:
    """What is given, as arrays by name."""
    shown = {"poses": given.poses, "positions": given.positions}
    if given.odometry is not None:
        shown |= {"motions": given.odometry.motions, "motion_covariances": given.odometry.covariances}
    return shown


def _facts(problem: Problem) -> dict[str, Any]:
    values = {name: value for name, value in vars(problem).items() if name not in ("camera", "tracks")}
    return {"problem": values, "camera": camera_to_dict(problem.camera)}


BOOT = (
    "import json, os, sys\n"
    "requests = open(os.dup(0), 'rb')\n"
    "facts = json.loads(requests.readline())\n"
    "sys.path[:] = facts['path']\n"
    "from vbbench.solving.isolation.confinement import main\n"
    "main(requests, facts)\n"
)

PASSED_ON = re.compile(
    r"PATH|LANG|LANGUAGE|LC_\w+|TZ|USER|LOGNAME|LD_LIBRARY_PATH|DYLD_\w+|SYSTEMROOT|WINDIR|PYTHON(HASHSEED|HOME|UTF8|"
    r"IOENCODING|WARNINGS|NOUSERSITE)|(OMP|OPENBLAS|MKL|BLIS|KMP|CUDA|NVIDIA|TORCH|PYTORCH|XLA|JAX|TF)_\w+"
)
"""Names of environment variables that a solver sees: the settings of libraries."""


class IsolatedSolver:
    """A solver in a separate process: a context manager that yields the solver to run.

    Raises VbbenchError if the solver cannot be loaded, fails, ends, or answers with anything but the arrays requested.

    Parameters
    ----------
    name : a registered name, or ``module:attribute``, which is not imported in this process.
    hidden : files and folders that it must not read, besides every folder next to it that looks like a dataset.
    """

    def __init__(self, name: str, hidden: Sequence[Path] = ()) -> None:
        self._name, self._hidden = name, [path.resolve() for path in hidden]

    def __enter__(self) -> RemoteFrameSolver | RemoteSequenceSolver:
        self._folder = Path(tempfile.mkdtemp(prefix="vbbench-solver-")).resolve()
        try:
            self._child = Child(self._name, self._start())
            return self._child.introduced()
        except BaseException:
            self.__exit__()
            raise

    def __exit__(self, *_error: object) -> None:
        child = self.__dict__.pop("_child", None)
        if child is not None:
            child.end()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _start(self) -> "subprocess.Popen[bytes]":
        facts = {
            "name": self._name,
            "parent": os.getpid(),
            "path": [str(Path(entry or os.curdir).absolute()) for entry in sys.path],
            "readable": readable_paths(self._hidden, source_places(self._name)),
            "writable": [*device_paths(), str(self._folder)],
        }
        process = subprocess.Popen(
            [sys.executable, "-P", "-c", BOOT],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=self._folder,
            env=self._environment(),
            start_new_session=True,  # a terminal's Ctrl-C must reach this process alone
        )
        with suppress(BrokenPipeError):  # reading the answer then raises an error with the reason
            pipe_of(process.stdin).write(json.dumps(facts).encode() + b"\n")
            pipe_of(process.stdin).flush()
        return process

    def _environment(self) -> dict[str, str]:
        secret = [str(path) for path in self._hidden]
        passed = {
            name: value
            for name, value in os.environ.items()
            if PASSED_ON.fullmatch(name) and not any(path in value for path in secret)
        }
        own = dict.fromkeys(("HOME", "TMPDIR", "TEMP", "TMP"), str(self._folder))
        return {**passed, **own, "PYTHONDONTWRITEBYTECODE": "1"}


def warn_of_open_files() -> None:
    """Warn if the kernel cannot restrict a solver's access to files."""
    if not landlock_version():
        warnings.warn(
            "this system cannot keep files from an isolated solver (it takes Linux 5.13 or later, with Landlock): "
            "truth is in neither its memory nor its messages, but it could be read from the disk",
            VbbenchWarning,
            stacklevel=3,
        )
