"""The rerun package, where it is installed."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from vbbench.errors import VbbenchError


def rerun() -> Any:
    """The package.

    Raises
    ------
    VbbenchError
        If it is not installed.
    """
    try:
        import rerun as package
    except ImportError as error:
        raise VbbenchError("vbbench view needs rerun: python -m pip install 'vbbench[viewer]'") from error
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
