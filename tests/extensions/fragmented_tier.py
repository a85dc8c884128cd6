"""A tier of another package: nobody is tracked for longer than a few frames, and one box of ten is missing."""

from typing import Any

import numpy as np

from vbbench.camera import Camera
from vbbench.generation.tier import Observations, Sight, Tier

LIFE = 6
"""Frames of a track."""
MISSED = 0.1
"""Share of boxes that are missing."""


class Fragmented(Tier):
    """Everybody is somebody new every `LIFE` frames."""

    @property
    def definition(self) -> dict[str, Any]:
        """What boxes follow from."""
        return {"fragments": {"life": LIFE, "missed": MISSED}}

    def pixel_std(self, camera: Camera) -> float:
        """Solvers are told of a noise that is not there, as is best for unreliable tracks."""
        return 0.25

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """One track for each person and `LIFE` frames."""
        frames, people = sight.seen.shape
        there = ~np.isnan(sight.boxes[..., 2]) & (rng.random((frames, people)) >= MISSED)
        shape = (frames, -(-frames // LIFE) * people)
        boxes, visible, persons = np.full((*shape, 3), np.nan), np.full(shape, np.nan), np.full(shape, -1)
        frame, person = np.nonzero(there)
        track = frame // LIFE * people + person
        boxes[frame, track], visible[frame, track] = sight.boxes[frame, person], 1.0
        persons[frame, track] = sight.people[person]
        kept = (persons >= 0).any(axis=0)
        return Observations(boxes=boxes[:, kept], visible=visible[:, kept], persons=persons[:, kept])


fragmented = Fragmented(
    name="fragmented",
    summary="People are lost every six frames and found again as somebody new; one box of ten is missing.",
)
