"""Crowds for recordings of heads: scenario files of people crossing a small square, or walking one way."""

from pathlib import Path

from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation

HEADING = """
name = "{name}"
title = "people walking where a camera looks down on them"
sequences = 1
people = [60]
frames = {frames}
dt = 0.04
step = 0.04
camera = "panorama"
warm_up = 4.0
least_way = 8.0
"""
SIDES = ([-14, -12, -9, 12], [9, -12, 14, 12], [-14, -12, 14, -7], [-14, 7, 14, 12])
EVERYWHERE = [-14, -12, 14, 12]


def square(frames: int = 150) -> str:
    """A scenario: people crossing a square in all directions."""
    flows = [f"[[flow]]\nstart = {EVERYWHERE}\ngoal = {side}\nthen = {list(SIDES)}\n" for side in SIDES]
    return HEADING.format(name="square", frames=frames) + "".join(flows)


def one_way() -> str:
    """A scenario: everybody walks the same way."""
    flow = "[[flow]]\nstart = [-7, -25, 7, 12]\ngoal = [-7, 60, 7, 61]\nbeyond = true\n"
    return HEADING.format(name="one-way", frames=150) + flow


def make_crowd(folder: Path, scenario: str, people: int = 60, seed: int = 0) -> Dataset:
    """A dataset of one sequence of a scenario."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "scenario.toml"
    path.write_text(scenario, encoding="utf-8")
    asked = Simulation(scenario=str(path), people=(people,))
    return generate("sim", folder / "crowd", Options(simulation=asked, seed=seed))
