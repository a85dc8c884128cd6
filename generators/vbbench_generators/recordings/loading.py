"""From a recipe to scenes: finds the source files, checks them, reads them."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError, VbbenchError
from vbbench.files.tables import file_sha256
from vbbench.generation.sources import locate
from vbbench.geometry import FloatArray
from vbbench.scene import Scene
from vbbench_generators.lifting.calibration import describe_calibration
from vbbench_generators.lifting.lift import lift
from vbbench_generators.recordings.readers.crohd import find_recording, read_heads
from vbbench_generators.recordings.readers.tables import detect_format, read_obsmat, read_trajnet
from vbbench_generators.recordings.readers.text import read_homography
from vbbench_generators.recordings.readers.tracks import check_speed
from vbbench_generators.recordings.readers.vsp import FRAME_RATE, polyline, read_vsp, smooth_curve
from vbbench_generators.recordings.recipe import Recipe

FileSum = tuple[str, str]
"""A source file's path, the same on every machine, and its SHA-256."""


@dataclass(frozen=True, kw_only=True)
class Loaded:
    """What a split is made of.

    Parameters
    ----------
    scenes : people on the ground.
    files : every file they come from.
    calibration : what was found of the camera that saw them, for `DatasetInfo`; ``None`` where metres were given.
    """

    scenes: list[Scene]
    files: list[FileSum]
    calibration: dict[str, Any] | None = None

    @property
    def is_surveyed(self) -> bool:
        """Whether the user's own homography gave metres where the split's are otherwise estimated."""
        return self.calibration is not None and not self.calibration["pseudo_metric"]


def load_scenes(
    recipe: Recipe, source: Path | None, *, seed: int, dt: float | None = None, homography: Path | None = None
) -> Loaded:
    """The scenes of a split.

    Parameters
    ----------
    recipe : the split's recipe.
    source : file or folder to look in first; for ``custom`` the user's own file.
    seed : decides the jitter of resampled scenes, and nothing else.
    dt, homography : seconds a frame, and 3x3 file from pixels to metres, of a user's own file; a homography is also
        taken for a surveillance camera, in place of its calibration.

    Raises
    ------
    VbbenchError
        If a file is missing or bad, or an option does not fit the split.
    """
    if recipe.reads_own_file:
        return _load_own(recipe, source, dt, homography)
    if recipe.format == "crohd":
        return _load_heads(recipe, source, dt, homography)
    if dt is not None or homography is not None:
        raise VbbenchError(f"{recipe.name}: --dt and --homography are for the split 'custom'; this recipe has its own")
    paths = locate(recipe.sources, source, split=recipe.name)
    matrix = read_homography(paths.pop()) if recipe.homography is not None else None
    scenes = [_read(recipe, path, recipe.format, recipe.dt, matrix) for path in paths]
    if recipe.resampling is not None:
        scenes = [_jittered(scene, recipe.resampling.jitter, seed, index) for index, scene in enumerate(scenes)]
    return Loaded(scenes=scenes, files=[(file.path, file.sha256) for file in recipe.sources])


def _load_own(recipe: Recipe, source: Path | None, dt: float | None, homography: Path | None) -> Loaded:
    if source is None or not source.is_file():
        found = "" if source is None else f"; {source} is no file"
        raise VbbenchError(f"{recipe.name} is made from a file of yours: name it with --source FILE{found}")
    matrix = None if homography is None else read_homography(homography)
    scene = _read(recipe, source, detect_format(source), recipe.dt if dt is None else dt, matrix)
    read = [source] if homography is None else [source, homography]
    return Loaded(scenes=[scene], files=[(path.name, file_sha256(path)) for path in read])


def _load_heads(recipe: Recipe, source: Path | None, dt: float | None, homography: Path | None) -> Loaded:
    if dt is not None:
        raise VbbenchError(f"{recipe.name}: --dt is for the split 'custom'; here seqinfo.ini tells the frame rate")
    if recipe.recording is None or recipe.lifting is None:
        raise VbbenchError(f"{recipe.name}: a recipe of format crohd needs the key 'recording' and a table [lifting]")
    files = find_recording(recipe.recording, recipe.source[0], source, split=recipe.name)
    heads = read_heads(files)
    matrix = None if homography is None else read_homography(homography)
    lifted = lift(heads, recipe.lifting, matrix)
    scene = every_frame(lifted.tracks, recipe.frame_step or 1)
    check_speed(files.boxes.path, scene)
    sums = [(f"{recipe.recording}/{name}", digest) for name, digest in files.sums]
    if homography is not None:
        sums.append(("homography", file_sha256(homography)))
    return Loaded(scenes=[scene], files=sums, calibration=describe_calibration(lifted.calibration))


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


def every_frame(scene: Scene, step: int) -> Scene:
    """The scene in every ``step``-th frame from the first one on, with whoever is there in any of them."""
    if step == 1:
        return scene
    positions, present = scene.positions[::step], scene.present[::step].any(axis=0)
    return replace(
        scene,
        dt=step * scene.dt,
        people=scene.people[present],
        positions=positions[:, present],
        heights=scene.heights[present],
    )
