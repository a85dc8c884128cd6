"""Cameras from names and parameters, and to and from the JSON of ``dataset.json``."""

from dataclasses import asdict, fields
from typing import Any, cast

from vbbench.camera.interface import Camera
from vbbench.errors import VbbenchError
from vbbench.registry import load_registered

_LATER = ("pitch", "roll", "vertical_focal")
"""Parameters that files omit where they are a model's defaults, as files from before there were any do."""


def make_camera(kind: str, **parameters: Any) -> Camera:
    """A camera of a registered model.

    Raises
    ------
    UnknownNameError
        If no model is called so.
    VbbenchError
        If a parameter is unknown, or a value is not valid.
    """
    model = load_registered("camera", kind)
    try:
        made: Camera = model(**parameters)
    except (TypeError, ValueError) as error:
        raise VbbenchError(f"camera '{kind}': {error}") from error
    return made


def camera_to_dict(camera: Camera) -> dict[str, Any]:
    """The camera as it stands in ``dataset.json``."""
    model = cast(Any, camera)
    usual = {field.name: field.default for field in fields(model) if field.name in _LATER}
    stated = {name: value for name, value in asdict(model).items() if name not in usual or value != usual[name]}
    return {"kind": camera.kind, **stated}


def camera_from_dict(values: dict[str, Any]) -> Camera:
    """The camera that `camera_to_dict` wrote.

    Raises
    ------
    VbbenchError
        As of `make_camera`.
    """
    return make_camera(str(values.get("kind", "")), **{name: value for name, value in values.items() if name != "kind"})
