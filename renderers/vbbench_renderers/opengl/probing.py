"""Whether OpenGL works here, tested in a child process: a broken driver may crash or block its caller."""

import signal
import subprocess
import sys
from functools import cache

from vbbench.errors import VbbenchError

PACKAGE = "mesa-utils-bin"
"""The Debian package that contains EGL and a software driver."""
PATIENCE = 60.0
_CHILD = """
import sys
from vbbench_renderers.opengl.context import device_name, open_context
try:
    context = open_context()
    target = context.simple_framebuffer((4, 4))
    target.clear(1.0, 1.0, 1.0, 1.0)
    works = set(target.read()) == {255}
except Exception as error:
    sys.exit(f"{error}")
print(device_name(context) if works else sys.exit("a picture came back wrong"))
"""


class OpenGLError(VbbenchError):
    """OpenGL does not work on this machine."""

    def __init__(self, problem: str) -> None:
        self.problem = problem
        super().__init__(
            f"OpenGL does not work here: {problem}. Install EGL, on Debian or Ubuntu 'apt-get install {PACKAGE}',"
            " or draw with the backend 'raster', which needs no OpenGL"
        )


def find_device() -> str:
    """What OpenGL draws with on this machine; tested once per process.

    Raises
    ------
    OpenGLError
        If it does not work; the message says what to install.
    """
    device, problem = _ask(PATIENCE)
    if problem:
        raise OpenGLError(problem)
    return device


@cache
def _ask(patience: float) -> tuple[str, str]:
    """Device and "", or "" and what is wrong."""
    try:
        child = subprocess.run(
            [sys.executable, "-c", _CHILD], capture_output=True, text=True, timeout=patience, check=False
        )
    except subprocess.TimeoutExpired:
        return "", f"the driver did not answer within {patience:.0f} s"
    if child.returncode < 0:
        return "", f"the driver crashed ({signal.Signals(-child.returncode).name})"
    lines = (child.stdout if child.returncode == 0 else child.stderr).strip().splitlines()
    last = lines[-1].rstrip(".") if lines else f"its check ended with status {child.returncode}"
    return (last, "") if child.returncode == 0 else ("", last)
