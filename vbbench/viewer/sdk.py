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
    package = rerun()
    before = package.strict_mode()
    package.set_strict_mode(True)
    try:
        yield
    finally:
        package.set_strict_mode(before)
