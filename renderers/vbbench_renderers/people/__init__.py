"""Procedural people: what they look like, how they walk, and the limbs that a backend draws."""

import vbbench_renderers.required  # noqa: F401 (says what to install)
from vbbench_renderers.people.gait import Feet
from vbbench_renderers.people.walkers import Walkers

__all__ = ["Feet", "Walkers"]
