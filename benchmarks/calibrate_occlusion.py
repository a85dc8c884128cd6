"""How far the outlines of tier `occluded` are from rendered people: visible fractions on split `street`.

    python -m benchmarks.calibrate_occlusion            # the outline as it is
    python -m benchmarks.calibrate_occlusion --search   # and the best one of a grid

Every so many frames of some sequences are drawn by the backend `raster`, perspective and panorama; visible fractions,
counted in pixels, are compared with the model's for everybody whose box lies in the picture.
"""

import sys
from dataclasses import dataclass
from itertools import product

import numpy as np

from benchmarks.visibility import Onlooker
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray, IntArray, world_to_relative
from vbbench_generators.splits import street
from vbbench_generators.tiers.noise import Outline, see
from vbbench_renderers.people import Walkers
from vbbench_renderers.raster import RasterRenderer

SEQUENCES, EVERY = 3, 25
SHOULDERS, HEADS = (0.08, 0.09, 0.10, 0.11, 0.12, 0.13, 0.14, 0.15), (0.03, 0.04, 0.05, 0.06)
TOPS = (0.74, 0.77, 0.80, 0.83, 0.86)


@dataclass(frozen=True)
class Sample:
    """One picture: positions [1, K, 2] and heights [K] in m of everybody but the observer, the pose, what was counted.

    ``rendered`` [K] are visible fractions, NaN = not in the picture.
    """

    positions: FloatArray
    heights: FloatArray
    poses: FloatArray
    camera: Camera
    rendered: FloatArray


def samples(camera: Camera, sequences: int = SEQUENCES, every: int = EVERY) -> list[Sample]:
    """What is rendered of the first sequences of split `street`."""
    plan = street.plan(Options(camera=camera))
    taken = []
    for index in range(sequences):
        data = plan.build(index)
        scene, observer = data.scene, data.sequence.observer
        assert scene is not None
        others: IntArray = np.flatnonzero(scene.people != observer)
        renderer = RasterRenderer(scene, seed=0, surroundings=False)
        onlooker = Onlooker(scene, Walkers(scene, 0))
        for frame in range(0, scene.frames, every):
            pose = data.truth.poses[frame]
            picture = renderer.render(frame, camera, pose, observer=observer)
            seen = onlooker.look(picture, frame, camera, pose, observer=observer)
            rendered = np.full(scene.people.max() + 1, np.nan)
            rendered[seen.person] = seen.visible
            positions, heights = scene.positions[frame, others][None], scene.heights[others]
            boxes = camera.project(world_to_relative(positions, pose[None]), heights[None])[0]
            rendered = np.where(np.isnan(boxes[:, 2]), np.nan, rendered[scene.people[others]])
            taken.append(Sample(positions, heights, pose[None], camera, rendered))
    return taken


def differences(taken: list[Sample], outline: Outline) -> FloatArray:
    """Model less renderer, of everybody whom both have in the picture."""
    parts = [see(s.positions, s.heights, s.poses, s.camera, outline).visible[0] - s.rendered for s in taken]
    every = np.concatenate(parts)
    return every[~np.isnan(every)]


def describe(taken: list[Sample], outline: Outline) -> str:
    """How many people were compared, and mean absolute and mean difference, in words."""
    gap = differences(taken, outline)
    return f"{len(gap)} people, mean absolute difference {np.abs(gap).mean():.4f}, mean {gap.mean():+.4f}"


def search(taken: list[Sample]) -> Outline:
    """The outline of two steps with the least mean absolute difference on a grid."""
    grid = [Outline(half=(h, s), top=(1.0, t)) for h, s, t in product(HEADS, SHOULDERS, TOPS) if h < s]
    return min(grid, key=lambda outline: float(np.abs(differences(taken, outline)).mean()))


def main() -> None:
    """Print a line a camera; with ``--search`` the best outline for both, too."""
    every = []
    for camera in (PerspectiveCamera(), PanoramaCamera()):
        taken = samples(camera)
        every += taken
        hidden = np.concatenate([s.rendered for s in taken])
        hidden = hidden[~np.isnan(hidden)]
        partly = np.mean((hidden > 0.02) & (hidden < 0.98))
        print(f"{camera.kind}: {describe(taken, Outline())}; {partly:.0%} of them partly hidden", flush=True)
    if "--search" in sys.argv[1:]:
        best = search(every)
        print(f"best: {best}: {describe(every, best)}")


if __name__ == "__main__":
    main()
