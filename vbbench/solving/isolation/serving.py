"""Answers, in the solver's process, the requests that come over the pipe.

Messages over a solver's pipe: a JSON object, followed by the bytes of the arrays that it lists.

A message is the length of its object in bytes (uint32, little-endian), the object, and the arrays' bytes in order. The
object lists ``arrays`` as [name, dtype, shape]. The reader accepts only expected arrays of expected shapes, and limits
the size of the object, so that the sender does not control how much is allocated. Nothing is unpickled or run.
"""

import json
import struct
import traceback
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import lru_cache
from math import prod
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from vbbench.camera import camera_from_dict
from vbbench.errors import VbbenchError
from vbbench.registry import make_solver
from vbbench.sequence import Given, Odometry
from vbbench.solver import Estimate, Frame, FrameEstimate, FrameSolver, Problem, SequenceSolver

HEADER_LIMIT = 1 << 16
"""Most bytes of the object of an untrusted message."""

TEXT_LIMIT = 5_000
"""Characters of a text in a message; escaped, each takes 12 bytes at most."""

FLOAT, INT, BOOL = "<f8", "<i8", "|b1"
"""Types of arrays, as NumPy spells them."""

READ_AS: dict[str, "np.dtype[Any]"] = {FLOAT: np.dtype(FLOAT), INT: np.dtype(INT), BOOL: np.dtype("u1")}
"""A bool is read as a byte first, which may be neither 0 nor 1."""

Shapes = Mapping[str, tuple[str, tuple[int, ...]]]
"""Arrays that may come: dtype and shape by name."""


class MessageError(Exception):
    """The received bytes are not a valid or expected message; the text is the end of a sentence."""


class ClosedError(MessageError):
    """The other side has closed the pipe."""


def write_message(pipe: IO[bytes], facts: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]] | None = None) -> None:
    """Send ``facts``, which JSON can hold, and ``arrays`` of bool, int64 or float64."""
    values = (arrays or {}).items()
    header = _header(json.dumps(facts), tuple((name, array.dtype.str, array.shape) for name, array in values))
    pipe.write(b"".join([header, *(array.tobytes() for _, array in values)]))
    pipe.flush()


@lru_cache(maxsize=16)
def _header(facts: str, listed: tuple[tuple[str, str, tuple[int, ...]], ...]) -> bytes:
    """Length and object of a message, cached since they are the same in every frame of a sequence."""
    header = json.dumps({**json.loads(facts), "arrays": listed}).encode()
    return struct.pack("<I", len(header)) + header


def read_message(pipe: IO[bytes], expected: Shapes | None = None) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The facts and arrays of the next message.

    Raises ClosedError if the other side has closed the pipe; MessageError if the bytes are not a message, or it has
    unexpected arrays.

    Parameters
    ----------
    expected : the accepted arrays, any of which may be missing; ``None`` trusts the other side.
    """
    (length,) = struct.unpack("<I", _read(pipe, 4))
    if expected is not None and length > HEADER_LIMIT:
        raise MessageError(f"a message that begins with {length} bytes of facts, {HEADER_LIMIT} are allowed")
    facts, listed = _parsed(bytes(_read(pipe, length)))
    if expected is not None:
        _check(listed, expected)
    return facts, _received(pipe, listed)


@lru_cache(maxsize=16)
def _parsed(header: bytes) -> tuple[dict[str, Any], Shapes]:
    try:
        facts = json.loads(header)
    except (ValueError, RecursionError) as error:
        raise MessageError("a message that is not JSON") from error
    if not isinstance(facts, dict):
        raise MessageError("a message that is not a JSON object")
    return facts, _listed(facts.pop("arrays", None))


def _listed(arrays: Any) -> dict[str, tuple[str, tuple[int, ...]]]:
    """The arrays that a message lists, each entry of the right kinds."""
    if not isinstance(arrays, list):
        raise MessageError("a message without a list of arrays")
    found = {}
    for entry in arrays:
        match entry:
            case [str(name), str(dtype), list(shape)] if name not in found and all(type(n) is int for n in shape):
                found[name] = dtype, tuple(shape)
            case _:
                raise MessageError("a message whose list of arrays is garbled")
    return found


def _check(listed: Shapes, expected: Shapes) -> None:
    for name, (dtype, shape) in listed.items():
        if name not in expected:
            raise MessageError(f"an array {plain(name, 40)!r}, which was not requested")
        wanted_dtype, wanted_shape = expected[name]
        if dtype != wanted_dtype:
            raise MessageError(f"'{name}' of type {plain(dtype, 40)}, not {wanted_dtype}")
        if shape != wanted_shape:
            raise MessageError(f"'{name}' of shape {plain(str(list(shape)), 80)}, not {list(wanted_shape)}")


def _received(pipe: IO[bytes], listed: Shapes) -> dict[str, NDArray[Any]]:
    sizes = [(name, dtype, shape, prod(shape)) for name, (dtype, shape) in listed.items()]
    body = _read(pipe, sum(READ_AS[dtype].itemsize * count for _, dtype, _, count in sizes))
    found, start = {}, 0
    for name, dtype, shape, count in sizes:
        array: NDArray[Any] = np.frombuffer(body, READ_AS[dtype], count, start).reshape(shape)
        start += array.nbytes
        found[name] = array != 0 if dtype == BOOL else array if array.flags.aligned else array.copy()
    return found


def _read(pipe: IO[bytes], count: int) -> bytearray:
    buffer = bytearray(count)
    if pipe.readinto(buffer) < count:  # type: ignore[attr-defined]
        raise ClosedError("nothing more")
    return buffer


def plain(text: str, limit: int, *, lines: bool = False) -> str:
    """Untrusted text for a terminal: no control characters, and at most its last ``limit`` characters."""
    shown = text if len(text) <= limit else f"…{text[-limit:]}"
    return "".join(c if c.isprintable() or (lines and c == "\n") else " " for c in shown)


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
    """The same object as before while nothing of it changes: a solver may go on where it was."""
    return _made(json.dumps([facts["problem"], facts["camera"]]), arrays["tracks"].tobytes())


@lru_cache(maxsize=1)
def _made(facts: str, tracks: bytes) -> Problem:
    problem, camera = json.loads(facts)
    return Problem(**{**problem, "camera": camera_from_dict(camera), "tracks": np.frombuffer(tracks, np.int64)})


def _arrays(answer: object, kind: type[FrameEstimate] | type[Estimate]) -> Arrays:
    """The parts of an answer that a solver reports, by name; marks are bool, everything else is float64."""
    if not isinstance(answer, kind):
        raise TypeError(f"the solver returned a {type(answer).__name__}, not a {kind.__name__}")
    return {
        field.name: np.asarray(value, bool if field.name in ("fallback", "converged") else np.float64)
        for field in fields(kind)
        if (value := getattr(answer, field.name)) is not None
    }
