"""Files of weights: those of the package are in ``weights``, with their recipe as TOML, which holds their SHA-256."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from importlib.resources import as_file, files
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError
from vbbench.parsing.toml_text import read_toml
from vbbench_baselines.former.layers import shapes

Weights = Mapping[str, NDArray[np.float32]]

_WHENCE = "put there what 'vbbench train vb-former' made, or install vbbench again where they came with it"


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """How weights were learned.

    Parameters
    ----------
    sha256 : checksum of the file of weights.
    training : further facts: data, steps, seeds, seconds.
    """

    sha256: str
    training: Mapping[str, Any] = field(default_factory=dict)


@cache
def bundled_weights() -> Weights:
    """The weights that come with the package."""
    with as_file(files(__package__).joinpath("weights")) as folder:
        return read_weights(folder / "vb-former.npz")


def read_weights(path: Path) -> Weights:
    """The weights of a file, float32 and read-only, whose recipe is next to it.

    Raises FileError if there are none, they are not those of the recipe, or their shapes are not the network's.
    """
    recipe = read_toml(path.with_suffix(".toml"), Recipe, "recipe")
    try:
        packed = path.read_bytes()
    except OSError as error:
        raise FileError(path, f"the weights cannot be read; {_WHENCE}") from error
    found = sha256(packed).hexdigest()
    if found != recipe.sha256:
        raise FileError(path, f"its SHA-256 is {found}, and its recipe says {recipe.sha256}; {_WHENCE}")
    with np.load(BytesIO(packed), allow_pickle=False) as arrays:
        weights = {name: arrays[name].astype(np.float32) for name in arrays.files}
    wanted = shapes()
    for name in sorted(wanted.keys() | weights.keys()):
        shape = weights[name].shape if name in weights else None
        if shape != wanted.get(name):
            raise FileError(path, f"'{name}' has the shape {shape}, and the network needs {wanted.get(name)}")
    for array in weights.values():
        array.flags.writeable = False
    return weights
