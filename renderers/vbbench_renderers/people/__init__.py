"""Procedural people: what they look like, how they walk, and the limbs that a backend draws."""

from vbbench_renderers.people.gait import Feet
from vbbench_renderers.people.walkers import Walkers

__all__ = ["Feet", "Walkers"]
