"""The crowd engine: agent-steps a second a core beside pysocialforce and JuPedSim, and the first use.

JuPedSim may live in an environment of its own, whose interpreter $JUPEDSIM_PYTHON names:

    python -m venv peers && peers/bin/pip install jupedsim && export JUPEDSIM_PYTHON=peers/bin/python

Runs of the engines alternate and the quickest of each counts, so that other work on the machine disturbs less.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from time import perf_counter

import numpy as np

from tests.lib.library_crowd import walk_by_library
from vbbench_generators.social_force import Crowd, Model, simulate

DT = 0.1  # seconds a step
SIZES = {10: (400, 20, 15), 50: (200, 10, 25), 800: (20, 2, 50)}  # people: our steps, pysocialforce's, target ratio
REPEATS = 7

JUPEDSIM = """
import json, sys, time
import jupedsim as jps
task = json.load(sys.stdin)
far = 500.0
best = float("inf")
for _ in range(task["repeats"]):
    square = [(-far, -far), (far, -far), (far, far), (-far, far)]
    simulation = jps.Simulation(model=jps.SocialForceModel(), geometry=square, dt=task["dt"])
    for place, speed, goal in zip(task["positions"], task["speeds"], task["goals"]):
        stage = simulation.add_waypoint_stage(goal, 0.5)
        journey = simulation.add_journey(jps.JourneyDescription([stage]))
        simulation.add_agent(jps.SocialForceModelAgentParameters(
            position=tuple(place), journey_id=journey, stage_id=stage, desired_speed=speed, radius=0.2))
    started = time.perf_counter()
    simulation.iterate(task["steps"])
    best = min(best, (time.perf_counter() - started) / task["steps"])
print(best)
"""

FIRST_USE = """
from time import perf_counter, process_time
started, busy = perf_counter(), process_time()
from benchmarks.bench_simulation import crowd
from vbbench_generators.social_force import Model, simulate
for people in (10, 300):
    simulate(crowd(people), Model(), frames=2, dt=0.1, substeps=1)
print(perf_counter() - started, process_time() - busy)
"""


def crowd(people: int, seed: int = 0) -> Crowd:
    """People as dense as in Sim, 50 on 16 m x 16 m, whose goals are too far to be reached."""
    rng, half = np.random.default_rng(seed), 8.0 * np.sqrt(people / 50)
    positions, angle = rng.uniform(-half, half, (people, 2)), rng.uniform(-np.pi, np.pi, people)
    ahead, speeds = np.column_stack((np.cos(angle), np.sin(angle))), rng.uniform(0.8, 1.6, people)
    goals = (positions + 100.0 * ahead)[:, None]
    return Crowd(positions=positions, velocities=ahead * speeds[:, None], speeds=speeds, goals=goals)


def quickest(*runs: Callable[[], object], repeats: int = REPEATS) -> list[float]:
    """The least seconds of each of the runs, which take turns."""
    best = [np.inf] * len(runs)
    for turn in range(repeats + 1):
        for n, run in enumerate(runs):
            started = perf_counter()
            run()
            best[n] = min(best[n], perf_counter() - started) if turn else np.inf
    return best


def steps(people: int, count: int) -> Callable[[], object]:
    """A run of ``count`` steps on one thread."""
    one = crowd(people)
    return lambda: simulate(one, Model(), frames=count + 1, dt=DT, substeps=1)


def beside_pysocialforce() -> None:
    print("agent-steps a second a core    pysocialforce     vbbench    ratio  target")
    for people, (ours, theirs, target) in SIZES.items():
        one = crowd(people)
        library = partial(walk_by_library, one, Model(), frames=theirs + 1, dt=DT)
        seconds = quickest(steps(people, ours), library, repeats=REPEATS if people < 800 else 3)
        ours_a_second, library_a_second = people * ours / seconds[0], people * theirs / seconds[1]
        ratio = f"{ours_a_second / library_a_second:7.1f}x  ≥ {target}x"
        print(f"  K = {people:3}                   {library_a_second:13,.0f} {ours_a_second:11,.0f} {ratio}")


def beside_jupedsim() -> None:
    one, python = crowd(50), os.environ.get("JUPEDSIM_PYTHON") or sys.executable
    print("\nsimulated agent-seconds a second a core, K = 50; target ≥ 2x JuPedSim's social force model")
    columns = {"positions": one.positions, "speeds": one.speeds, "goals": one.goals[:, 0]}
    for step in (DT, 0.05, 0.01):
        task = {name: values.tolist() for name, values in columns.items()}
        task |= {"dt": step, "steps": round(10.0 / step), "repeats": 5}
        done = subprocess.run(
            [python, "-c", JUPEDSIM], input=json.dumps(task), capture_output=True, text=True, check=False
        )
        if done.returncode and "ModuleNotFoundError" in done.stderr:
            print(
                "  JuPedSim: not installed; pip install jupedsim, or name an interpreter that has it: $JUPEDSIM_PYTHON"
            )
            return
        if done.returncode:
            print(f"  JuPedSim at {step} s: failed: {done.stderr.strip().splitlines()[-1]}")
            continue
        theirs = 50 * step / float(done.stdout)
        (seconds,) = quickest(steps(50, 100), repeats=10 * REPEATS)
        ours = 50 * 100 * DT / seconds
        both = f"vbbench at steps of {DT} s {ours:,.0f}, JuPedSim at steps of {step} s {theirs:,.0f}"
        print(f"  {both}; ratio {ours / theirs:.1f}x")


def first_use() -> None:
    command = [sys.executable, "-c", FIRST_USE]
    runs = [subprocess.run(command, capture_output=True, text=True, check=True).stdout.split() for _ in range(5)]
    seconds, busy = (min(map(float, column[1:])) for column in zip(*runs, strict=True))
    spent = f"{seconds:.2f} s, of which the processor was busy {busy:.2f} s"
    print(f"\nimport and two crowds: {spent}; target < 1 s")


def main() -> None:
    beside_pysocialforce()
    beside_jupedsim()
    first_use()


if __name__ == "__main__":
    main()
