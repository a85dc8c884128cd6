"""Simulated crowds that stand in for recordings of Shibuya that are missing, annotated as CroHD is."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class SimulatedRecording:
    """What is simulated.

    Parameters
    ----------
    people : in the crowd; the camera above it sees less than half of them at a time.
    every : only every so-many-th of those who are recorded becomes an observer, unless a study says otherwise.
    """

    people: int
    every: int

    def title(self, split: str) -> str:
        """What stands in for ``split``."""
        return f"Simulated crowd of {self.people} people, lifted like {split}"


STAND_INS = {
    "shibuya01": SimulatedRecording(people=575, every=100),
    "shibuya02": SimulatedRecording(people=390, every=60),
}
"""So that 254 and 178 people are seen at a time; by the paper's Table 1 it is 806 · 317 / 1000 = 256 and 170."""
