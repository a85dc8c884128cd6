"""Array types, and the one check that every frozen dataclass applies to its arrays."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


def frozen_array(
    name: str, values: ArrayLike, shape: tuple[int | None, ...], dtype: type[Any] = np.float64
) -> NDArray[Any]:
    """Return ``values`` as a read-only array of the wanted shape; ``None`` in ``shape`` means any length.

    Raises
    ------
    ValueError
        If the shape differs; the message names expected and actual shape.
    """
    array = np.asarray(values, dtype=dtype).view()
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape, strict=True)):
        wanted = ", ".join("*" if n is None else str(n) for n in shape)
        raise ValueError(f"{name} must have shape [{wanted}], not {list(array.shape)}")
    array.flags.writeable = False
    return array
