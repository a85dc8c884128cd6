"""Frames a second of the renderers, RGB + depth + ids: ``python -m benchmarks.bench_rendering [--sizes 320x240 …]``.

Fifty people walk on 16 m x 16 m, as dense as in Sim. Renderers take turns and the quickest turn of each counts, so that
other work on the machine disturbs less.
"""

import argparse
from collections.abc import Callable
from time import perf_counter, process_time

import numpy as np

from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench.pictures.rendering import Picture
from vbbench.registry import load
from vbbench.scene import Scene

CAMERAS: dict[str, Camera] = {
    "320x240": PerspectiveCamera(width=320, height=240, focal=160.0, cx=160.0, cy=120.0),
    "640x480": PerspectiveCamera(width=640, height=480, focal=320.0, cx=320.0, cy=240.0),
    "1280x720": PerspectiveCamera(),
    "panorama": PanoramaCamera(),
}
RENDERERS = ("raster", "pyrender")
FRAMES, TURNS = 4, 5


def crowd(people: int, seed: int = 0) -> Scene:
    """People who walk straight on."""
    rng, half = np.random.default_rng(seed), 8.0 * np.sqrt(people / 50)
    start, angle = rng.uniform(-half, half, (people, 2)), rng.uniform(-np.pi, np.pi, people)
    velocity = np.column_stack((np.cos(angle), np.sin(angle))) * rng.uniform(0.8, 1.6, (people, 1))
    positions = start + 0.1 * np.arange(40)[:, None, None] * velocity
    return Scene(
        name="crowd", dt=0.1, people=np.arange(people), positions=positions, heights=rng.normal(1.7, 0.07, people)
    )


def pose_of(scene: Scene, camera: Camera) -> FloatArray:
    """At the crowd's border, looking in; in its middle for a panorama."""
    edge = 0.0 if camera.period is not None else np.nanmin(scene.positions[..., 0])
    return np.array((edge, 0.0, 0.0))


def drawing(name: str, scene: Scene, camera: Camera) -> Callable[[int], Picture]:
    """The function that draws a frame with a renderer."""
    renderer, pose = load("renderer", name)(scene), pose_of(scene, camera)
    return lambda frame: renderer.render(frame, camera, pose)


def main(sizes: list[str]) -> None:
    """Print frames a second, and processor time on all cores, of every renderer at every size."""
    scene, runs = crowd(50), {}
    for size in sizes:
        for name in RENDERERS:
            try:
                runs[name, size] = drawing(name, scene, CAMERAS[size])
            except VbbenchError as error:
                print(f"{name}: {error}")
    best, work = dict.fromkeys(runs, np.inf), dict.fromkeys(runs, np.inf)
    for turn in range(TURNS + 1):  # the first warms up
        for key, draw in runs.items():
            started, busy = perf_counter(), process_time()
            for frame in range(FRAMES):
                draw(FRAMES * turn + frame)
            best[key] = min(best[key], (perf_counter() - started) / FRAMES) if turn else np.inf
            work[key] = min(work[key], 1e3 * (process_time() - busy) / FRAMES)
    print(f"{'50 people':<24}{'frames/s':>10}{'ms of cores':>13}")
    for name, size in runs:
        print(f"{name + ', ' + size:<24}{1.0 / best[name, size]:>10.1f}{work[name, size]:>13.1f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", nargs="+", choices=CAMERAS, default=list(CAMERAS))
    main(parser.parse_args().sizes)
