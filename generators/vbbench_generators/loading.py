"""From a recipe to scenes: finds the source files, checks them, reads them."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from vbbench.arrays import FloatArray
from vbbench.errors import FileError, VbbenchError
from vbbench.scene import Scene
from vbbench.sources import locate
from vbbench.tables import file_sha256
from vbbench_generators.readers.detect import detect_format
from vbbench_generators.readers.homography import read_homography
from vbbench_generators.readers.obsmat import read_obsmat
from vbbench_generators.readers.smooth import smooth_curve
from vbbench_generators.readers.trajnet import read_trajnet
from vbbench_generators.readers.vsp import FRAME_RATE, polyline, read_vsp
from vbbench_generators.recipe import Recipe

FileSum = tuple[str, str]
"""A source file's path, the same on every machine, and its SHA-256."""


def load_scenes(
    recipe: Recipe, source: Path | None, *, seed: int, dt: float | None = None, homography: Path | None = None
) -> tuple[list[Scene], list[FileSum]]:
    """The scenes of a split.

    Parameters
    ----------
    recipe : the split's recipe.
    source : file or folder to look in first; for ``custom`` the user's own file.
    seed : decides the jitter of resampled scenes, and nothing else.
    dt, homography : seconds a frame, and 3x3 file from pixels to metres, of a user's own file.

    Raises
    ------
    VbbenchError
        If a file is missing or bad, or an option does not fit the split.
    """
    if recipe.reads_own_file:
        return _load_own(recipe, source, dt, homography)
    if dt is not None or homography is not None:
        raise VbbenchError(f"{recipe.name}: --dt and --homography are for the split 'custom'; this recipe has its own")
    paths = locate(recipe.sources, source, split=recipe.name)
    matrix = read_homography(paths.pop()) if recipe.homography is not None else None
    scenes = [_read(recipe, path, recipe.format, recipe.dt, matrix) for path in paths]
    if recipe.resampling is not None:
        scenes = [_jittered(scene, recipe.resampling.jitter, seed, index) for index, scene in enumerate(scenes)]
    return scenes, [(file.path, file.sha256) for file in recipe.sources]


def _load_own(
    recipe: Recipe, source: Path | None, dt: float | None, homography: Path | None
) -> tuple[list[Scene], list[FileSum]]:
    if source is None or not source.is_file():
        found = "" if source is None else f"; {source} is no file"
        raise VbbenchError(f"{recipe.name} is made from a file of yours: name it with --source FILE{found}")
    matrix = None if homography is None else read_homography(homography)
    scene = _read(recipe, source, detect_format(source), recipe.dt if dt is None else dt, matrix)
    read = [source] if homography is None else [source, homography]
    return [scene], [(path.name, file_sha256(path)) for path in read]


def _read(recipe: Recipe, path: Path, kind: str, dt: float | None, homography: FloatArray | None) -> Scene:
    if dt is None or not (np.isfinite(dt) and dt > 0):
        raise VbbenchError(f"{recipe.name}: say how many seconds a frame lasts with --dt, a positive number")
    if kind == "trajnet":
        return read_trajnet(path, dt=dt, frame_step=recipe.frame_step, homography=homography)
    if kind == "obsmat":
        if homography is not None:
            raise FileError(path, "is an obsmat table, which is in metres already: leave --homography out")
        return read_obsmat(path, dt=dt, frame_step=recipe.frame_step)
    if homography is None:
        raise FileError(path, "is a spline annotation in pixels: name the file of its homography with --homography")
    curve = polyline if recipe.resampling is None else smooth_curve
    step = recipe.frame_step or _spline_step(path, dt)
    return read_vsp(path, dt=dt, frame_step=step, homography=homography, curve=curve)


def _spline_step(path: Path, dt: float) -> int:
    """Video frames in ``dt``."""
    frames = dt * FRAME_RATE
    if frames < 0.5 or abs(frames - round(frames)) > 1e-6:
        raise FileError(path, f"counts frames at {FRAME_RATE:g} Hz: --dt must be a multiple of {1.0 / FRAME_RATE:g} s")
    return round(frames)


def _jittered(scene: Scene, std: float, seed: int, index: int) -> Scene:
    """The scene with noise on every position; it follows from the seed and the scene's place in the recipe alone."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))
    return replace(scene, positions=scene.positions + rng.normal(0.0, std, scene.positions.shape))
