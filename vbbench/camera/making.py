"""Cameras from names and parameters, and to and from the JSON of ``dataset.json``."""

from dataclasses import asdict
from typing import Any, cast

from vbbench.camera.interface import Camera
from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.registry import load, registered

_LEVEL_AND_SQUARE = {"pitch": 0.0, "roll": 0.0, "vertical_focal": None}
"""Parameters that files leave out where they say nothing, as those from before there were any do."""


def make_camera(kind: str, **parameters: Any) -> Camera:
    """A camera of a registered model.

    Raises
    ------
    UnknownNameError
        If no model is called so.
    VbbenchError
        If a parameter is unknown, or a value cannot be.
    """
    if kind not in registered("camera"):  # never a module's name: kinds are read from strangers' files
        raise UnknownNameError("camera", kind, registered("camera"))
    try:
        made: Camera = load("camera", kind)(**parameters)
    except (TypeError, ValueError) as error:
        raise VbbenchError(f"camera '{kind}': {error}") from error
    return made


def camera_to_dict(camera: Camera) -> dict[str, Any]:
    """The camera as it stands in ``dataset.json``."""
    values = asdict(cast(Any, camera))
    told = {name: value for name, value in values.items() if (name, value) not in _LEVEL_AND_SQUARE.items()}
    return {"kind": camera.kind, **told}


def camera_from_dict(values: dict[str, Any]) -> Camera:
    """The camera that `camera_to_dict` wrote.

    Raises
    ------
    VbbenchError
        As of `make_camera`.
    """
    return make_camera(str(values.get("kind", "")), **{name: value for name, value in values.items() if name != "kind"})
