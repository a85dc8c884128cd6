"""Runs the tests again and again on a machine kept busy, every second time in reverse order: none may fail.

``python -m tests.lib.under_load --runs 20 -- tests/pictures/test_viewer.py``: what follows ``--`` is for pytest.
``make test-under-load`` runs the tests of ``make test``.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

BUSY = "while True: pass"
WRITING = """
import os, tempfile
with tempfile.TemporaryFile() as file:
    while True:
        file.seek(0)
        file.write(os.urandom(1 << 22))
        file.flush()
        os.fsync(file.fileno())
"""


@contextmanager
def load(processes: int) -> Iterator[None]:
    """So many processes that only compute, and one that writes to the disk, as `stress` has them."""
    with ExitStack() as all_of_them:
        for code in [BUSY] * processes + [WRITING]:
            process = all_of_them.enter_context(subprocess.Popen([sys.executable, "-c", code]))
            all_of_them.callback(process.kill)
        yield


def run(arguments: list[str]) -> tuple[int, str]:
    """The exit status of a run of pytest, and its last line."""
    with tempfile.TemporaryFile("w+", encoding="utf-8") as file:
        status = subprocess.run([sys.executable, "-m", "pytest", *arguments], stdout=file, check=False).returncode
        file.seek(0)
        lines = file.read().rstrip().splitlines()
    failed = [line for line in lines if line.startswith(("FAILED", "ERROR"))]
    return status, "\n".join([*failed, lines[-1] if lines else "no output"])


def main() -> int:
    """The number of runs that failed."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--processes", type=int, default=2 * (os.cpu_count() or 1), help="that keep the machine busy")
    parser.add_argument("tests", nargs="*", help="arguments of pytest, after --")
    options = parser.parse_args()
    failures = 0
    with load(options.processes):
        for number in range(options.runs):
            order = ["--reverse"] if number % 2 else []
            started = time.monotonic()
            status, told = run([*order, "-rfE", *options.tests])
            failures += status != 0
            print(f"run {number + 1} {' '.join(order)} {time.monotonic() - started:.0f} s: {told}", flush=True)  # noqa: T201
    return failures


if __name__ == "__main__":
    sys.exit(main())
