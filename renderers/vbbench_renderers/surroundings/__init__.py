"""Surroundings: ground, houses, trees, lamps and sky around the place where people walk."""

import vbbench_renderers.required  # noqa: F401 (says what to install)
from vbbench_renderers.surroundings.build import build_surroundings, plain_surroundings, surroundings_of, walking_area

__all__ = ["build_surroundings", "plain_surroundings", "surroundings_of", "walking_area"]
