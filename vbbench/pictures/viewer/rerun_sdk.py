"""The rerun package, if it is installed, and its viewer, if there is a display."""

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from typing import Any

from vbbench.errors import needs_extra


def rerun(purpose: str = "vbbench view") -> Any:
    """The package; ``purpose`` begins the message where it is missing.

    Raises MissingExtraError if it is not installed.
    """
    with needs_extra("viewer", purpose):
        import rerun as package
    return package


@contextmanager
def strictly() -> Iterator[None]:
    """Inside, what rerun cannot record is an error; by default it omits such data and warns."""
    from rerun import error_utils

    before = error_utils.strict_mode()
    error_utils.set_strict_mode(True)
    try:
        yield
    finally:
        error_utils.set_strict_mode(before)


class Opened(Enum):
    """The result of opening a recording in the viewer."""

    SHOWN = "shown"
    NO_DISPLAY = "there is no display here"
    NO_VIEWER = "no program 'rerun' is found"


def open_viewer(path: Path) -> Opened:
    """Start the rerun viewer on a recording, and leave it running, if there are a display and a viewer."""
    program, found = viewer_program(), can_open()
    if found is Opened.SHOWN and program is not None:
        silence = subprocess.DEVNULL
        subprocess.Popen([program, str(path)], stdin=silence, stdout=silence, stderr=silence, start_new_session=True)
    return found


def can_open() -> Opened:
    """What a viewer that is started now would be."""
    if not _has_display():
        return Opened.NO_DISPLAY
    return Opened.SHOWN if viewer_program() else Opened.NO_VIEWER


def viewer_program() -> str | None:
    """The viewer that came with the SDK, else one on the path."""
    return shutil.which("rerun", path=str(Path(sys.executable).parent)) or shutil.which("rerun")


def how_to_open(path: Path) -> str:
    """The command that opens a recording."""
    return f"rerun {shlex.quote(str(path))}"


def _has_display() -> bool:
    if os.environ.get("CI"):
        return False
    return sys.platform in ("darwin", "win32") or any(os.environ.get(n) for n in ("DISPLAY", "WAYLAND_DISPLAY"))
