"""Starts a solver's process; this is the side that may hold truth."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from vbbench.errors import VbbenchWarning
from vbbench.solving.isolation.confinement import landlock_version
from vbbench.solving.isolation.grants import device_paths, readable_paths
from vbbench.solving.isolation.remote import Child, RemoteFrameSolver, RemoteSequenceSolver, pipe_of
from vbbench.solving.provenance import source_places

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
    """A solver in a separate process; use it in a ``with`` block, which gives the solver to run.

    Parameters
    ----------
    name : registered, or ``module:attribute``; it is never imported here.
    hidden : files and folders that it must not read, besides every folder beside it that looks like a dataset.

    Raises
    ------
    VbbenchError
        If the solver cannot be loaded, fails, ends, or answers with anything but the arrays requested.
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
        own = {
            **dict.fromkeys(("HOME", "TMPDIR", "TEMP", "TMP"), str(self._folder)),
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        return {**passed, **own}


def warn_of_open_files() -> None:
    """Warn if the kernel cannot keep files from a solver."""
    if not landlock_version():
        warnings.warn(
            "this system cannot keep files from an isolated solver (it takes Linux 5.13 or later, with Landlock): "
            "truth is in neither its memory nor its messages, but it could be read from the disk",
            VbbenchWarning,
            stacklevel=3,
        )
