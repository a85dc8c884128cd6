"""The rerun package, where it is installed."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from vbbench.errors import needs_extra


def rerun() -> Any:
    """The package.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    with needs_extra("viewer", "vbbench view"):
        import rerun as package
    return package


@contextmanager
def strictly() -> Iterator[None]:
    """Inside, what rerun cannot take is an error; by itself it leaves such data out and warns."""
    from rerun import error_utils

    before = error_utils.strict_mode()
    error_utils.set_strict_mode(True)
    try:
        yield
    finally:
        error_utils.set_strict_mode(before)
