"""A simulated crowd, annotated as CroHD is: stands in for a recording of Shibuya that is missing (docs/heads.md)."""

import json
from dataclasses import dataclass
from pathlib import Path

from vbbench.exchange.heads import TRUTH_FACTS, HeadOptions, export_heads
from vbbench.generation.generator import Options, Plan, Simulation
from vbbench.registry import load
from vbbench.reproduction.making import Making

SCENARIO = "shibuya"
"""Of split ``sim``: people crossing a square in all directions, 1000 frames at 25 a second."""


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


def record_crowd(what: SimulatedRecording, folder: Path, seed: int, making: Making) -> Path:
    """The folder of a recording of heads in ``folder``, made with the crowd unless it is there."""
    simulation = Simulation(scenario=SCENARIO, sequences=1, people=(what.people,))
    crowd = making.dataset("sim", folder / "crowd", Options(simulation=simulation, seed=seed))
    recording = folder / "recording"
    facts = recording / TRUTH_FACTS  # written last
    if facts.is_file() and json.loads(facts.read_text("utf-8"))["dataset"] == crowd.info.id:
        return recording
    return export_heads(crowd, recording, HeadOptions(), seed=seed)


def stand_in_plan(split: str, folder: Path, seed: int, making: Making) -> Plan:
    """A split of Shibuya, of what stands in for its recording (`STAND_INS`); ``folder`` is as in `record_crowd`."""
    recording = record_crowd(STAND_INS[split], folder, seed, making)
    plan: Plan = load("generator", split).plan(Options(source=recording, seed=seed))
    return plan
