"""Every system call by which a process changes files, seen before it happens, and done or refused.

A seccomp filter (`man 2 seccomp_unotify`) stops the calls of a child process, of its threads and of its own children,
until the supervisor answers. So nothing that writes can be missed, whatever library it writes with, and nothing in the
program is patched.
"""

import ctypes
import errno
import fcntl
import os
import platform
import select
import signal
import socket
import struct
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

Answer = Literal["do", "refuse"]
"""Let a call happen, or have it fail because the disk is full."""

_NUMBERS = {
    1: "write", 2: "open", 18: "pwrite64", 20: "writev", 40: "sendfile", 74: "fsync", 75: "fdatasync", 76: "truncate",
    77: "ftruncate", 82: "rename", 83: "mkdir", 84: "rmdir", 86: "link", 87: "unlink", 88: "symlink", 90: "chmod",
    91: "fchmod", 257: "openat", 258: "mkdirat", 263: "unlinkat", 264: "renameat", 265: "linkat", 266: "symlinkat",
    268: "fchmodat", 285: "fallocate", 296: "pwritev", 316: "renameat2", 326: "copy_file_range",
}  # fmt: skip
"""The calls that change files, by number on x86-64 (Linux ``unistd_64.h``)."""

_NAMED_BY = {
    "write": ["fd0"], "open": ["path0"], "pwrite64": ["fd0"], "writev": ["fd0"], "sendfile": ["fd0"],
    "fsync": ["fd0"], "fdatasync": ["fd0"], "truncate": ["path0"], "ftruncate": ["fd0"],
    "rename": ["path0", "path1"], "mkdir": ["path0"], "rmdir": ["path0"], "link": ["path0", "path1"],
    "unlink": ["path0"], "symlink": ["path1"], "chmod": ["path0"], "fchmod": ["fd0"], "openat": ["at0"],
    "mkdirat": ["at0"], "unlinkat": ["at0"], "renameat": ["at0", "at2"], "linkat": ["at0", "at2"],
    "symlinkat": ["at1"], "fchmodat": ["at0"], "fallocate": ["fd0"], "pwritev": ["fd0"],
    "renameat2": ["at0", "at2"], "copy_file_range": ["fd2"],
}  # fmt: skip
"""Which arguments name files: a descriptor, a path, or a folder's descriptor and a path in the argument after it."""

WRITES = {"write", "pwrite64", "writev", "pwritev", "sendfile", "copy_file_range", "ftruncate", "fallocate"}
"""The calls that change what is in a file."""

TAKE_SPACE = WRITES | {"open", "openat", "mkdir", "mkdirat", "symlink", "symlinkat", "link", "linkat"}
"""The calls that a full disk refuses."""

_ADD_LISTENER, _SET_FILTER, _NO_NEW_PRIVILEGES, _SECCOMP = 8, 1, 38, 317
_ALLOW, _NOTIFY = 0x7FFF0000, 0x7FC00000
_RECEIVE, _SEND = 0xC0502100, 0xC0182101
_CONTINUE = 1
_HERE = -100
_CREATES_OR_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
_PATIENCE = 120.0
"""Seconds after which a command counts as hung."""


@dataclass(frozen=True)
class Call:
    """One call, about to happen: its name, and the paths that it is about, relative to the watched folder."""

    name: str
    paths: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.name} {' → '.join(self.paths)}"


def why_not() -> str | None:
    """Why system calls cannot be watched here; ``None`` if they can."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return "system calls are watched on Linux on x86-64 only"
    try:
        available = Path("/proc/sys/kernel/seccomp/actions_avail").read_text()
    except OSError:
        available = ""
    return None if "user_notif" in available else "this kernel hands no system calls to a supervisor (user_notif)"


def run_watched(work: Callable[[], int], root: Path, before: Callable[[Call], Answer]) -> int:
    """Run ``work`` in a fork of this process, ask ``before`` ahead of every call that changes files below ``root``.

    Returns the exit status, the negative number of the signal that ended it, or raises TimeoutError.
    """
    here, there = socket.socketpair()
    child = os.fork()
    if child == 0:
        _leave(work, there)
    there.close()
    with here:
        listener = socket.recv_fds(here, 1, 1)[1][0]
    try:
        _supervise(listener, child, root, before)
    finally:
        os.close(listener)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def run_alone(work: Callable[[], int]) -> int:
    """Run ``work`` in a fork of this process, with nobody watching; otherwise as `run_watched`."""
    child = os.fork()
    if child == 0:
        _leave(work)
    handle = os.pidfd_open(child)
    try:
        if not select.select([handle], [], [], _PATIENCE)[0]:
            _give_up(child)
    finally:
        os.close(handle)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _leave(work: Callable[[], int], supervisor: socket.socket | None = None) -> None:
    """In the child: work, and end without the parent's clean-up."""
    status = 1
    try:
        if supervisor is not None:
            listener = _install_filter()
            socket.send_fds(supervisor, [b"-"], [listener])
            os.close(listener)
            supervisor.close()
        status = work()
    finally:
        os._exit(status)


def _install_filter() -> int:
    """Have this process's calls wait for an answer; the descriptor that they are read from."""
    libc = ctypes.CDLL(None, use_errno=True)
    code = _filter_code()
    kept = ctypes.create_string_buffer(code)
    program = struct.pack("HxxxxxxQ", len(code) // 8, ctypes.addressof(kept))
    if libc.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0) != 0:
        raise OSError(ctypes.get_errno(), "prctl")
    listener: int = libc.syscall(_SECCOMP, _SET_FILTER, _ADD_LISTENER, program)
    if listener < 0:
        raise OSError(ctypes.get_errno(), "seccomp")
    return listener


def _filter_code() -> bytes:
    """Classic BPF over ``struct seccomp_data``: opening is of interest where it creates or writes."""
    load, equal, any_bit, finish = 0x20, 0x15, 0x45, 0x06
    lines: list[tuple[int, int, int, int]] = [(load, 0, 0, 0)]
    for number, name in _NUMBERS.items():
        if name in ("open", "openat"):
            flags = 16 + 8 * (2 if name == "openat" else 1)
            lines += [(equal, 0, 4, number), (load, 0, 0, flags), (any_bit, 0, 1, _CREATES_OR_WRITES)]
            lines += [(finish, 0, 0, _NOTIFY), (finish, 0, 0, _ALLOW)]
        else:
            lines += [(equal, 0, 1, number), (finish, 0, 0, _NOTIFY)]
    lines.append((finish, 0, 0, _ALLOW))
    return b"".join(struct.pack("HBBI", *line) for line in lines)


def _supervise(listener: int, child: int, root: Path, before: Callable[[Call], Answer]) -> None:
    handle, poll = os.pidfd_open(child), select.poll()
    poll.register(handle, select.POLLIN)
    poll.register(listener, select.POLLIN)
    try:
        while True:
            ready = dict(poll.poll(1000 * _PATIENCE))
            if not ready:
                _give_up(child)
            if not ready.get(listener, 0) & select.POLLIN:
                return
            _answer_one(listener, root, before)
    finally:
        os.close(handle)


def _answer_one(listener: int, root: Path, before: Callable[[Call], Answer]) -> None:
    request = bytearray(80)
    try:
        fcntl.ioctl(listener, _RECEIVE, request)
    except OSError as error:
        if error.errno in (errno.ENOENT, errno.EINTR):  # who called has died since
            return
        raise
    number, caller, _, called, *_ = struct.unpack_from("QIIi", request)
    arguments = struct.unpack_from("6Q", request, 32)
    call = _described(_NUMBERS[called], arguments, caller, root)
    answer = "do" if call is None else before(call)
    refused = -errno.ENOSPC if answer == "refuse" else 0
    reply = bytearray(struct.pack("QqiI", number, 0, refused, 0 if refused else _CONTINUE))
    try:
        fcntl.ioctl(listener, _SEND, reply)
    except OSError as error:
        if error.errno != errno.ENOENT:
            raise


def _described(name: str, arguments: tuple[int, ...], caller: int, root: Path) -> Call | None:
    """The call, if it is about anything below ``root``."""
    paths = [_path(kind, arguments, caller) for kind in _NAMED_BY[name]]
    below = [str(path.relative_to(root)) for path in paths if path and root in path.parents]
    return Call(name, tuple(below)) if below else None


def _path(kind: str, arguments: tuple[int, ...], caller: int) -> Path | None:
    place = int(kind[-1])
    if kind.startswith("fd"):
        return _of_descriptor(caller, arguments[place])
    folder, text = (_HERE, place) if kind.startswith("path") else (ctypes.c_int(arguments[place]).value, place + 1)
    start = Path(f"/proc/{caller}/cwd").readlink() if folder < 0 else _of_descriptor(caller, folder)
    return start and start / _text(caller, arguments[text])


def _of_descriptor(caller: int, descriptor: int) -> Path | None:
    try:
        return Path(f"/proc/{caller}/fd/{descriptor}").readlink()
    except OSError:
        return None


def _text(caller: int, address: int) -> str:
    """The text that ends with a zero byte in the memory of ``caller``."""
    with Path(f"/proc/{caller}/mem").open("rb", 0) as memory:
        found = b""
        while b"\0" not in found:
            memory.seek(address + len(found))
            found += memory.read(4096 - (address + len(found)) % 4096)
    return os.fsdecode(found.partition(b"\0")[0])


def _give_up(child: int) -> None:
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    raise TimeoutError(f"the command did not end within {_PATIENCE:g} s")
