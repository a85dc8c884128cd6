"""Stops a command on a signal: one line, no remaining processes, exit status 128 + the signal.

A signal wakes a thread, which prints the line, silences stderr and ends all processes below this one, whatever the main
thread is doing. The main thread gets a `KeyboardInterrupt`, so that it leaves files and locks in order. If it has not
ended after `GRACE` seconds (a compiler, a library that waits), the process ends without that, as in a power cut, and
the next run continues from there. On Windows, which has no such signals, Ctrl-C raises a `KeyboardInterrupt` alone.
"""

import os
import signal
import sys
import threading
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from time import sleep
from types import FrameType

GRACE = 1.0
"""Seconds that the main thread has after a signal."""

ORPHAN_CHECK = 0.5
"""Seconds between a worker's checks that its parent still runs."""

HAS_SIGNALS = hasattr(signal, "SIGHUP")
"""Whether the system sends signals that a thread can wait for; Windows does not."""

REASONS = {signal.SIGINT: "stopped", signal.SIGTERM: "stopped by SIGTERM"}
"""The signals that stop a command, and the message for each."""

_KILL = signal.SIGTERM  # ends a process at once on Windows
if HAS_SIGNALS:
    REASONS[signal.SIGHUP], _KILL = "stopped by SIGHUP", signal.SIGKILL

_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36


def stoppable(run: Callable[[], int]) -> int:
    """Run a command, in the main thread, and return its exit status; a signal ends the process with that of the signal.

    A signal that is ignored (`nohup`, a job in the background of a script) stays ignored.
    """
    if not HAS_SIGNALS:
        return _until_interrupted(run)
    stop = _Stop()
    if sys.platform == "linux":
        _prctl(_PR_SET_CHILD_SUBREAPER, 1)  # adopts what a worker starts while it is ended, so that it can be found
    try:
        stop.listen()
        return run()
    finally:
        if stop.status is not None:
            end_descendants()
            os._exit(stop.status)


def _until_interrupted(run: Callable[[], int]) -> int:
    """Run a command until it ends or Ctrl-C stops it."""
    try:
        return run()
    except KeyboardInterrupt:
        _say_last(signal.SIGINT)
        return 128 + signal.SIGINT


class _Stop:
    """The handler of signals; the first one counts."""

    def __init__(self) -> None:
        self.status: int | None = None
        """Exit status, once a signal has come."""
        self._announced = threading.Event()
        self._interrupted = False

    def listen(self) -> None:
        """Install the handler: signals stop this process."""
        reader, writer = os.pipe()
        os.set_blocking(writer, False)
        signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
        threading.Thread(target=self._watch, args=(reader,), daemon=True).start()
        for number in REASONS:
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._interrupt)

    def _watch(self, reader: int) -> None:
        """The thread: it waits for a signal and handles it without the main thread."""
        number = os.read(reader, 1)[0]
        while number not in REASONS:
            number = os.read(reader, 1)[0]
        self.status = 128 + number
        threading.Timer(GRACE, self._end).start()
        try:
            _say_last(signal.Signals(number))
            end_descendants()
        finally:
            self._announced.set()

    def _end(self) -> None:
        end_descendants()
        os._exit(self.status or 1)

    def _interrupt(self, _number: int, _frame: FrameType | None) -> None:
        """Interrupt the main thread, as soon as it is back in Python."""
        if self._interrupted:
            return
        self._interrupted = True
        self._announced.wait()
        raise KeyboardInterrupt


def _say_last(reason: signal.Signals) -> None:
    """Print on stderr what stops the command, then silence it, since libraries may print errors as they shut down."""
    if sys.__stderr__ is None:
        return
    line = f"vbbench: {REASONS[reason]}; run the same command again to continue\n"
    with suppress(OSError):  # the terminal may be gone
        os.write(2, ("\n" if os.isatty(2) else "").encode() + line.encode())
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)


def end_descendants() -> None:
    """Send SIGTERM to every process below this one, if the system lists them (Linux).

    Processes that left the session, such as an image viewer, stay. The trackers that clean up after workers ignore
    SIGTERM: they end with the last worker.
    """
    for process in _descendants(os.getpid()):
        with suppress(OSError):
            os.kill(process, signal.SIGTERM)


def _prctl(option: int, value: int) -> None:
    import ctypes

    ctypes.CDLL(None).prctl(option, value)


def _descendants(ancestor: int) -> Iterator[int]:
    children, session = defaultdict(list), os.getsid(0)
    for file in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has ended
            facts = file.read_bytes().rpartition(b")")[2].split()  # state, parent, process group, session, ...
            if int(facts[3]) == session:
                children[int(facts[1])].append(int(file.parent.name))
    generation = children[ancestor]
    while generation:
        yield from generation
        generation = [child for parent in generation for child in children[parent]]


def end_with_parent(parent: int) -> None:
    """Make this process end when its parent ends, for any reason.

    On Linux it ends at once; elsewhere a thread checks every `ORPHAN_CHECK` seconds. ``parent`` is the process id that
    the parent gave: it may have ended already.
    """
    if sys.platform == "linux":
        _prctl(_PR_SET_PDEATHSIG, _KILL)
    threading.Thread(target=_end_when_orphaned, args=(parent,), daemon=True).start()


def _end_when_orphaned(parent: int) -> None:
    while os.getppid() == parent:
        sleep(ORPHAN_CHECK)
    os.kill(os.getpid(), _KILL)
