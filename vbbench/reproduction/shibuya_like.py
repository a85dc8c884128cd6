"""A recording like CroHD's Shibuya, for where its labels are not: a simulated crowd, filmed from above.

`vbbench generate shibuya01 --source FOLDER` reads the folder as it reads the real recording.
"""

import json
from dataclasses import asdict
from pathlib import Path

from vbbench.exchange.heads.recording import TRUTH_FACTS, export_heads
from vbbench.exchange.heads.settings import HeadOptions
from vbbench.generation.generator import Options, Simulation
from vbbench.reproduction.making import Making

SCENARIO = "shibuya"
RECORDING = "HT21-03-like"


def shibuya_like_recording(out: Path, making: Making, *, people: int | None = None, seed: int = 0) -> Path:
    """The folder of the recording below ``out``; it is made unless it is there.

    Parameters
    ----------
    people : in the crowd; ``None`` for as many as the scenario has. The camera above it sees less than half of them at
        a time.

    Raises
    ------
    VbbenchError
        If the crowd beside it is of another seed.
    """
    simulation = Simulation(scenario=SCENARIO, sequences=1, people=None if people is None else (people,))
    options = Options(seed=seed, simulation=simulation)
    crowd = making.dataset("sim", out / "crowd", options)
    folder, camera = out / RECORDING, HeadOptions()
    wanted = {"dataset": crowd.info.id, "seed": seed, "options": asdict(camera)}
    if making.overwrite or not _is_made(folder / TRUTH_FACTS, wanted):
        export_heads(crowd, folder, camera, seed=seed)
    return folder


def _is_made(facts: Path, wanted: dict[str, object]) -> bool:
    """Whether the recording is complete, and of this crowd and camera; its facts are written last."""
    if not facts.is_file():
        return False
    found = json.loads(facts.read_text("utf-8"))
    return all(found.get(name) == value for name, value in wanted.items())
