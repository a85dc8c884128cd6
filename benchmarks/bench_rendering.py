"""Frames a second of the backends, RGB + depth + ids, 50 people, beside a plain pyrender loop over the same meshes.

Run from the repository: ``python -m benchmarks.bench_rendering``; with ``--moderngl`` that backend alone, at 50 and 800
people in three sizes, which is what to run on a machine with a GPU. Runs take turns and the quickest of each counts, so
that other work on the machine disturbs less.
"""

import argparse
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from time import perf_counter, process_time
from typing import Any

import numpy as np

from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.registry import load
from vbbench.scene import Scene
from vbbench_renderers.mesh import Mesh, join_meshes
from vbbench_renderers.people import Walkers
from vbbench_renderers.surroundings import plain_surroundings, walking_area

SMALL = PerspectiveCamera(width=640, height=480, focal=320.0, cx=320.0, cy=240.0)
CAMERAS: dict[str, Camera] = {
    "640x480": SMALL,
    "1280x720": PerspectiveCamera(),
    "panorama 1440x480": PanoramaCamera(),
}
FRAMES, REPEATS = 4, 5
Draw = Callable[[int], Any]


def crowd(people: int, seed: int = 0) -> Scene:
    """People as dense as in Sim, 50 on 16 m x 16 m, who walk straight on."""
    rng, half = np.random.default_rng(seed), 8.0 * np.sqrt(people / 50)
    start, angle = rng.uniform(-half, half, (people, 2)), rng.uniform(-np.pi, np.pi, people)
    velocity = np.column_stack((np.cos(angle), np.sin(angle))) * rng.uniform(0.8, 1.6, (people, 1))
    positions = start + 0.1 * np.arange(40)[:, None, None] * velocity
    heights = rng.normal(1.7, 0.07, people)
    return Scene(name="crowd", dt=0.1, people=np.arange(people), positions=positions, heights=heights)


def pose_of(scene: Scene, camera: Camera) -> Any:
    """At the crowd's border, looking in; in its middle for a panorama."""
    edge = 0.0 if camera.period is not None else np.nanmin(scene.positions[..., 0])
    return np.array((edge, 0.0, 0.0))


def person_mesh(walkers: Walkers, person: int, eye: Any, focal: float) -> Mesh:
    """All limbs of somebody in frame 0, dyed, around his or her own place."""
    parts = []
    for level, limbs in walkers.limbs(0, eye, focal):
        library = walkers.library(level)
        for n in np.nonzero(limbs.person == person)[0]:
            mesh, (turn, shift) = library[limbs.mesh[n]], np.split(limbs.transform[n], (3,), axis=1)
            normals = mesh.normals @ np.linalg.inv(turn)
            parts.append(
                Mesh(
                    vertices=mesh.vertices @ turn.T + shift.T,
                    normals=normals / np.linalg.norm(normals, axis=1, keepdims=True),
                    colours=mesh.colours * limbs.colour[n],
                    uv=mesh.uv,
                    layers=mesh.layers,
                    triangles=mesh.triangles,
                )
            )
    return join_meshes(parts)


def limb_mesh(walkers: Walkers, level: int, limbs: Any, n: int) -> Mesh:
    """A limb's mesh, dyed, in its own frame."""
    mesh = walkers.library(level)[limbs.mesh[n]]
    return replace(mesh, colours=mesh.colours * limbs.colour[n])


class NaivePyrender:
    """What a newcomer writes: nodes whose poses are set every frame, one call for colour and depth, one for ids.

    With ``walking`` a node is a limb, which gives the picture that the backends give; without, a stiff person.
    """

    def __init__(self, scene: Scene, camera: PerspectiveCamera, walking: bool) -> None:
        from vbbench_renderers.pyrender_backend.loading import load_pyrender, open_off_screen

        self.pyrender, self.scene, self.walking = load_pyrender(), scene, walking
        self.screen = open_off_screen(camera.width, camera.height)
        self.world = self.pyrender.Scene(ambient_light=(0.3, 0.3, 0.3), bg_color=(0.5, 0.7, 1.0, 1.0))
        self.pose, self.focal, self.walkers = pose_of(scene, camera), camera.focal, Walkers(scene, 0)
        self._node(plain_surroundings(walking_area(scene)).mesh)
        if walking:
            self.nodes = {
                key: self._node(limb_mesh(self.walkers, level, limbs, n)) for key, level, limbs, n in self._limbs(0)
            }
        else:
            meshes = [
                person_mesh(self.walkers, person, self.pose[:2], camera.focal) for person in range(len(scene.people))
            ]
            self.nodes = {(person, 0, 0): self._node(mesh) for person, mesh in enumerate(meshes)}
        looks = np.eye(4)
        looks[:3, :3] = ((0, 0, -1), (-1, 0, 0), (0, 1, 0))  # along +x, z up
        looks[:3, 3] = *self.pose[:2], camera.mount_height
        f = camera.focal
        self.world.add(self.pyrender.IntrinsicsCamera(f, f, camera.cx, camera.cy, znear=0.1, zfar=200.0), pose=looks)
        self.world.add(self.pyrender.DirectionalLight(intensity=3.0), pose=looks)
        self.colours = {node: (person + 1, 0, 0) for (person, _, _), node in self.nodes.items()}

    def _node(self, mesh: Mesh) -> Any:
        import trimesh

        shape = trimesh.Trimesh(
            mesh.vertices, mesh.triangles, vertex_normals=mesh.normals, vertex_colors=mesh.colours, process=False
        )
        return self.world.add(self.pyrender.Mesh.from_trimesh(shape))

    def _limbs(self, frame: int) -> Iterator[tuple[tuple[int, int, int], int, Any, int]]:
        """Every limb of a frame by person, mesh and how many of the kind came before."""
        seen: Counter[tuple[int, int]] = Counter()
        for level, limbs in self.walkers.limbs(frame, self.pose[:2], self.focal):
            for n, kind in enumerate(zip(limbs.person.tolist(), limbs.mesh.tolist(), strict=True)):
                yield (*kind, seen[kind]), level, limbs, n
                seen[kind] += 1

    def _poses(self, frame: int) -> Iterator[tuple[Any, Any]]:
        moved = np.eye(4)
        if self.walking:
            for key, _, limbs, n in self._limbs(frame):
                moved[:3] = limbs.transform[n]
                if key in self.nodes:
                    yield self.nodes[key], moved.copy()
            return
        shift = self.scene.positions[frame] - self.scene.positions[0]
        for (person, _, _), node in self.nodes.items():
            moved[:2, 3] = shift[person]
            yield node, moved.copy()

    def __call__(self, frame: int) -> Any:
        """Colour, depth and ids of a frame."""
        for node, pose in self._poses(frame):
            self.world.set_pose(node, pose)
        colour, depth = self.screen.render(self.world)
        ids, _ = self.screen.render(self.world, flags=self.pyrender.RenderFlags.SEG, seg_node_map=self.colours)
        return colour, depth, ids[..., 0]


def backend(name: str, scene: Scene, camera: Camera, surroundings: bool) -> tuple[Draw, str]:
    """Draws a frame with a backend; and its device."""
    renderer, pose = load("renderer", name)(scene, surroundings=surroundings), pose_of(scene, camera)
    return (lambda frame: renderer.render(frame, camera, pose)), renderer.device


def frames_a_second(runs: dict[str, Draw]) -> tuple[dict[str, float], dict[str, float]]:
    """The best rate of each, in turns of some frames; and the least processor time a frame in ms, on all cores."""
    best, work = dict.fromkeys(runs, np.inf), dict.fromkeys(runs, np.inf)
    for turn in range(REPEATS + 1):
        for name, run in runs.items():
            started, busy = perf_counter(), process_time()
            for frame in range(FRAMES):
                run(FRAMES * turn + frame)
            best[name] = min(best[name], (perf_counter() - started) / FRAMES) if turn else np.inf
            work[name] = min(work[name], 1e3 * (process_time() - busy) / FRAMES)
    return {name: 1.0 / seconds for name, seconds in best.items()}, work


def compare() -> None:
    """The figures that the project holds itself to, in one run."""
    scene, panorama = crowd(50), CAMERAS["panorama 1440x480"]
    runs: dict[str, Draw] = {}
    for name in ("moderngl", "pyrender", "raster"):
        try:
            runs[f"{name}, bare ground"], device = backend(name, scene, SMALL, surroundings=False)
            print(f"{name:<12}{device}")
        except VbbenchError as error:
            print(f"{name:<12}{error}")
    if "pyrender, bare ground" in runs:
        runs["naive pyrender, a node a limb"] = NaivePyrender(scene, SMALL, walking=True)
        runs["naive pyrender, stiff people"] = NaivePyrender(scene, SMALL, walking=False)
    runs["moderngl, surroundings"] = backend("moderngl", scene, SMALL, surroundings=True)[0]
    runs["moderngl, panorama, surroundings"] = backend("moderngl", scene, panorama, surroundings=True)[0]
    runs["raster, surroundings"] = backend("raster", scene, SMALL, surroundings=True)[0]
    rates, work = frames_a_second(runs)
    print(f"\n{'50 people, 640x480 unless said':<40}{'frames/s':>10}{'ms of cores':>13}")
    for name, rate in rates.items():
        print(f"{name:<40}{rate:>10.1f}{work[name]:>13.1f}")
    fast, bar = rates["moderngl, bare ground"], rates.get
    print(f"\n{'':<40}{'reached':>10}{'wanted':>10}")
    rows = (
        ("moderngl over a naive pyrender loop", fast / bar("naive pyrender, a node a limb", np.nan), 5.0),
        ("the same, stiff people", fast / bar("naive pyrender, stiff people", np.nan), 5.0),
        ("moderngl over backend pyrender", fast / bar("pyrender, bare ground", np.nan), 3.0),
        ("moderngl with surroundings, frames/s", rates["moderngl, surroundings"], 20.0),
        ("moderngl panorama, frames/s", rates["moderngl, panorama, surroundings"], 12.0),
        ("raster, frames/s", rates["raster, bare ground"], 20.0),
        ("raster with surroundings, frames/s", rates["raster, surroundings"], 20.0),
    )
    for label, reached, wanted in rows:
        print(f"{label:<40}{reached:>10.1f}{wanted:>10.1f}")


def time_moderngl() -> None:
    """Frames a second of `moderngl` with surroundings at two crowds and three sizes."""
    for people in (50, 800):
        scene = crowd(people)
        for size, camera in CAMERAS.items():
            run, device = backend("moderngl", scene, camera, surroundings=True)
            if (people, size) == (50, "640x480"):
                print(device)
            print(f"{people:>5} people  {size:<20}{frames_a_second({'': run})[0]['']:>8.1f} frames/s", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--moderngl", action="store_true", help="time that backend alone")
    (time_moderngl if parser.parse_args().moderngl else compare)()
