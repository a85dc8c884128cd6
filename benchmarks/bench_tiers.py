"""The tiers' speed on one core: the occlusion model over the crowd of scenario `street`, and `field` beside `noisy`.

Sequences are built from a synthetic crowd as large as Students, in seconds of the processor; nothing is written.
"""

from dataclasses import replace
from time import perf_counter, process_time

import numpy as np

from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.generation.generator import Card, Observer, Options, Simulation
from vbbench_generators.crowds.scenario import get_scenario
from vbbench_generators.crowds.sim import record_plaza
from vbbench_generators.recordings.recipe import Rules
from vbbench_generators.splits import sim
from vbbench_generators.tiers.field.recipe import get_field
from vbbench_generators.tiers.noise import see
from vbbench_generators.views.reprojection import plan_reprojection

REPEATS, BUILDS = 10, 3


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


def built_a_second(options: Options, every: int) -> float:
    """Observations a second, the quickest of some repeats, of every so many-th sequence."""
    scenes = [record_plaza(0, index, 60, 300) for index in range(2)]
    card = Card(name="made", title="Synthetic crowds", licence="", citation="", sources=())
    plan = plan_reprojection(card, Rules(), scenes, options, {})
    best = 0.0
    for _ in range(BUILDS):
        started = process_time()
        count = sum(int(plan.build(index).sequence.observed.sum()) for index in range(0, len(plan), every))
        best = max(best, count / (process_time() - started))
    return best


def main() -> None:
    """Print a line a camera, observer and kind of boxes."""
    whole: tuple[Camera, ...] = (PerspectiveCamera(), PanoramaCamera())
    for camera in whole:
        print(f"occlusion, {camera.kind}: {observations_a_second(camera) / 1e6:.2f} million observations a second")
    cameras: tuple[Camera, ...] = (get_field().camera, PanoramaCamera())
    observers: tuple[Observer, ...] = ("walker", "vehicle")
    for observer in observers:
        for camera in cameras:
            noisy = built_a_second(Options(tier="noisy", camera=camera, observer=observer), 4)
            for detector, every in ((False, 4), (True, 40)):
                options = Options(tier="field", camera=camera, observer=observer, detector=detector)
                speed, boxes = built_a_second(options, every), "found" if detector else "drawn"
                share = f"{speed / noisy:.3f} of noisy"
                print(f"field, {boxes}, {camera.kind}, {observer}: {speed:,.0f} observations a second, {share}")


if __name__ == "__main__":
    main()
