"""How the renderer's inner loops are compiled: by numba, on first call, cached on disk.

No ``fastmath``: neighbouring triangles share their edges to the last bit, which reordered sums would spoil.
"""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile ``function`` when it is first called; division by zero gives inf or NaN, as in NumPy."""
    return cast(F, njit(cache=True, error_model="numpy")(function))


def parallel_kernel(function: F) -> F:
    """Compile ``function`` with its ``prange`` loops spread over numba's threads."""
    return cast(F, njit(cache=True, error_model="numpy", parallel=True)(function))
