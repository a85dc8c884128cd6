"""How the solvers' inner loops are compiled: by numba, on first call, cached on disk."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile ``function`` when it is first called; division by zero gives inf or NaN, as in NumPy.

    Kernels see contiguous float64 arrays of their own solver and plain numbers only.
    """
    return cast(F, njit(cache=True, error_model="numpy")(function))
