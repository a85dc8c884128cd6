"""Surroundings: ground, houses, trees, street furniture and sky around the place where people walk."""

from vbbench_renderers.surroundings.build import (
    build_surroundings,
    plain_surroundings,
    surroundings_of,
    walking_area,
)

__all__ = ["build_surroundings", "plain_surroundings", "surroundings_of", "walking_area"]
