"""The network at run time: in C++ (``baselines/cpp/former``), frame by frame, of one sequence.

State and measurements are NumPy records, one a person. Their fields are those of `Walkers`, `Observer`, `Sights` and
`Told`, and those of the structs of ``network.hpp``.

Files of weights. Those of the package are in ``weights``, each with its recipe as TOML, which holds its SHA-256.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from importlib.resources import as_file, files
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError
from vbbench.parsing.toml_text import read_toml
from vbbench_baselines import _core
from vbbench_baselines.former.layers import shapes
from vbbench_baselines.former.network import Answer
from vbbench_baselines.former.pose_fit import Motion
from vbbench_baselines.former.scene import Sights, Told
from vbbench_baselines.former.state import Observer, Walkers, nothing_seen

Weights = Mapping[str, NDArray[np.float32]]

_WHENCE = "put there what 'vbbench train vb-former' made, or install vbbench again where they came with it"


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """How weights were learned.

    Parameters
    ----------
    sha256 : checksum of the file of weights.
    pure : whether the network outputs the pose, and does not fit it.
    training : further facts: data, steps, seeds, seconds.
    """

    sha256: str
    pure: bool = False
    training: Mapping[str, Any] = field(default_factory=dict)


@cache
def bundled_weights(solver: str) -> Weights:
    """The weights that come with the package, of the solver ``vb-former`` or ``vb-former-pure``."""
    with as_file(files(__package__).joinpath("weights")) as folder:
        return read_weights(folder / f"{solver}.npz")


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
    return _checked(path, packed, recipe.pure)


def _checked(path: Path, packed: bytes, pure: bool) -> Weights:
    """The arrays of a file; raises FileError if their names or shapes are not the network's."""
    with np.load(BytesIO(packed), allow_pickle=False) as arrays:
        weights = {name: arrays[name].astype(np.float32) for name in arrays.files}
    wanted = shapes(pure)
    for name in sorted(wanted.keys() | weights.keys()):
        shape = weights[name].shape if name in weights else None
        if shape != wanted.get(name):
            raise FileError(path, f"'{name}' has the shape {shape}, and the network needs {wanted.get(name)}")
    for array in weights.values():
        array.flags.writeable = False
    return weights


Records = NDArray[Any]
"""An array of records."""


def _numbers(*shape: int) -> NDArray[np.float32]:
    return np.zeros(shape, np.float32)


def _points(*shape: int) -> NDArray[np.complex64]:
    return np.zeros(shape, np.complex64)


def _record(parts: Walkers | Observer, axes: int) -> np.dtype[np.void]:
    """The type of a record of the fields of ``parts``, each without its first ``axes`` axes."""
    return np.dtype([(name, part.dtype, part.shape[axes:]) for name, part in zip(parts._fields, parts, strict=True)])


_NOTHING = nothing_seen(_numbers, _points, 1)
WALKER, OBSERVER = _record(_NOTHING.people, 1), _record(_NOTHING.observer, 0)
POINT, NUMBER = np.complex64, np.float32
SIGHT = np.dtype(
    [
        ("seen", NUMBER),
        ("ray", POINT),
        ("by_height", NUMBER),
        ("by_feet", NUMBER),
        ("has_feet", NUMBER),
        ("noise", NUMBER, 3),
        ("cut", NUMBER, 3),
        ("place", POINT),
        ("placed", NUMBER),
    ]
)
GIVEN = np.dtype(
    [
        ("step", POINT),
        ("turn", NUMBER),
        ("moved", NUMBER),
        ("measured_step", POINT),
        ("measured_turn", NUMBER),
        ("information", NUMBER, 3),
        ("sure", NUMBER),
    ]
)
POSE = np.dtype(
    [("step", POINT), ("turn", NUMBER), ("rough_step", POINT), ("rough_turn", NUMBER), ("spread", NUMBER, 3)]
)
PLACE = np.dtype([("place", POINT), ("spread", NUMBER, 2)])


class Remembered(NamedTuple):
    """The state between frames, as records; see `State`.

    Attributes
    ----------
    people : [K] records `WALKER`.
    observer : a record `OBSERVER`.
    """

    people: Records
    observer: Records


def nothing_remembered(people: int) -> Remembered:
    """The state of so many people before frame 0."""
    return Remembered(np.zeros(people, WALKER), np.zeros((), OBSERVER))


class Inference:
    """The compiled network with these weights, immutable; see `vbbench_baselines.former.network.Birdifier`.

    Raises VbbenchError if the weights are not those of a network, see `layers.shapes`.
    """

    def __init__(self, weights: Weights, heads: bool = True) -> None:
        self.weights, self.heads = weights, heads
        made = {name: np.ascontiguousarray(values, np.float32) for name, values in weights.items()}
        self._network = _core.FormerNetwork(made, heads)

    def __deepcopy__(self, memo: Mapping[int, Any]) -> Self:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return Inference, (self.weights, self.heads)

    def advance(self, remembered: Remembered, sights: Sights, told: Told, dt: float, spread: float) -> Answer:
        """The answer for a frame of ``dt`` s; replaces the state in ``remembered`` by that after the frame.

        ``spread`` is the standard deviation of heights, as a share of their mean.
        """
        people = len(remembered.people)
        boxes, pose, places = np.empty(people, SIGHT), np.empty((), POSE), np.empty(people, PLACE)
        for name, values in zip(Sights._fields, sights, strict=True):
            boxes[name] = values
        boxes["place"], boxes["placed"] = told.places, told.placed
        self._network.advance(
            _floats(remembered.people),
            _floats(remembered.observer),
            _floats(boxes),
            _floats(_given(told)),
            dt,
            spread,
            _floats(pose),
            _floats(places),
        )
        return Answer(
            motion=Motion(pose["step"][()], pose["turn"][()]),
            rough=Motion(pose["rough_step"][()], pose["rough_turn"][()]),
            places=places["place"],
            pose_spread=pose["spread"],
            place_spread=places["spread"],
        )


def _given(told: Told) -> Records:
    """What is given, as a record `GIVEN`; without odometry its information is 0."""
    given = np.zeros((), GIVEN)
    given["step"], given["turn"], given["moved"] = *told.motion, told.moved
    if told.measured is not None:
        (given["measured_step"], given["measured_turn"]), given["information"], given["sure"] = told.measured
    return given


def _floats(records: Records) -> NDArray[np.float32]:
    """Records [...] as numbers [..., n]."""
    return records.view((np.float32, records.dtype.itemsize // 4))
