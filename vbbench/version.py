"""The version of vbbench that is installed; in a checkout, that of the commit it was installed from."""

from importlib.metadata import PackageNotFoundError, version


def _installed() -> str:
    try:
        return version("vbbench")
    except PackageNotFoundError:  # the source tree is on the path, and nothing is installed
        return "unknown"


__version__ = _installed()

ON_PYPI = False
"""Whether a release can be had by its name. Docs and page say it only then: `tests/release/test_installing.py`."""

INSTALL = (
    "python -m pip install vbbench" if ON_PYPI else "git clone <this repository> && python -m pip install ./vbbench"
)
"""The line that installs it into an empty environment."""
