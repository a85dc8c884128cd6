"""The tiers' speed: observations a second of the occlusion model, on one core, over the crowd of scenario `street`."""

from dataclasses import replace
from time import perf_counter

import numpy as np

from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.generation.generator import Options, Simulation
from vbbench_generators.crowds.scenario import get_scenario
from vbbench_generators.splits import sim
from vbbench_generators.tiers.occlusion import see

REPEATS = 10


def observations_a_second(camera: Camera, repeats: int = REPEATS, frames: int | None = None) -> float:
    """Boxes a second, the quickest of some repeats."""
    plan = sim.plan(Options(camera=camera, simulation=Simulation(scenario="street", people=(50,))))
    scenario = get_scenario("street")
    plan = replace(plan, scenario=replace(scenario, frames=frames or scenario.frames))
    data = plan.build(0)
    assert data.scene is not None
    others = data.scene.people != data.sequence.observer
    positions, heights = data.scene.positions[:, others], data.scene.heights[others]
    boxes = np.count_nonzero(~np.isnan(see(positions, heights, data.truth.poses, camera).visible))
    best = np.inf
    for _ in range(repeats):
        started = perf_counter()
        see(positions, heights, data.truth.poses, camera)
        best = min(best, perf_counter() - started)
    return boxes / best


def main() -> None:
    """Print a line a camera."""
    for camera in (PerspectiveCamera(), PanoramaCamera()):
        print(f"occlusion, {camera.kind}: {observations_a_second(camera) / 1e6:.2f} million observations a second")


if __name__ == "__main__":
    main()
