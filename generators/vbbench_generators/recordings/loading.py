"""From a recipe to scenes: the interface of a format's reader, and its registry."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.text_tables import split_header
from vbbench.files.tables import file_sha256
from vbbench.generation.generator import Options
from vbbench.generation.sources import locate
from vbbench.geometry import FloatArray
from vbbench.parsing.numbers import FRAME_TIME
from vbbench.registry import load_all, load_registered
from vbbench.scene import Scene
from vbbench.streams import Stream, random_stream
from vbbench_generators.recordings.readers.tracks import NOUNS, count_columns, read_homography, read_text
from vbbench_generators.recordings.recipe import DETECTED, Recipe, Rules


def scale_to_field(scenes: Sequence[Scene], rules: Rules, half_width: float) -> tuple[list[Scene], Rules]:
    """The scenes, centred and scaled by one factor so that the largest fits ±``half_width`` m; and scaled rules."""
    corners = [(np.nanmin(scene.positions, axis=(0, 1)), np.nanmax(scene.positions, axis=(0, 1))) for scene in scenes]
    factor = 2.0 * half_width / float(max(np.max(high - low) for low, high in corners))
    scaled = [
        replace(scene, positions=(scene.positions - (low + high) / 2.0) * factor)
        for scene, (low, high) in zip(scenes, corners, strict=True)
    ]
    return scaled, replace(rules, standing_displacement=rules.standing_displacement * factor)


FileSum = tuple[str, str]
"""A source file's path, the same on every machine, and its SHA-256."""


@dataclass(frozen=True, kw_only=True)
class Loaded:
    """The scenes of a split, with their sources.

    Parameters
    ----------
    scenes : people on the ground.
    files : every file that was read, with its checksum.
    calibration : the estimated calibration of the camera, for `DatasetInfo`; ``None`` where metres were given.
    """

    scenes: list[Scene]
    files: list[FileSum]
    calibration: dict[str, Any] | None = None

    @property
    def is_surveyed(self) -> bool:
        """Whether metres come from the user's homography, where the split otherwise estimates them."""
        return self.calibration is not None and not self.calibration["pseudo_metric"]


@dataclass(frozen=True, kw_only=True)
class SceneFile:
    """A file of one scene, with the parameters for reading it.

    Parameters
    ----------
    path : the file.
    dt : seconds per frame.
    frame_step : difference of the file's frame numbers from one frame to the next; ``None``: the commonest one.
    homography : [3, 3] from the file's coordinates to metres; ``None`` if they are metres or unknown.
    smooth : whether places between key points lie on a smooth curve, in formats that have key points.
    """

    path: Path
    dt: float
    frame_step: int | None = None
    homography: FloatArray | None = None
    smooth: bool = False


class Reader:
    """A format of recordings, registered under ``vbbench.readers`` by its name in recipes.

    A format with one file a scene implements `read`; any other implements `load`.
    """

    signature = ""
    """How a user's own file of this format is recognised, in a few words; none for what `recognises` never says."""

    def recognises(self, line: str) -> bool:  # noqa: ARG002
        """Whether a file with this first ``line``, stripped of blanks and comments, has this format."""
        return False

    def read(self, file: SceneFile) -> Scene:
        """Read one scene."""
        raise NotImplementedError

    def load(self, recipe: Recipe, options: Options) -> Loaded:
        """Find the recipe's files, check and read them, as the options ``source``, ``dt`` and ``homography`` say.

        The option ``seed`` is that of the jitter of resampled scenes, and of places within a grid's cells.
        """
        if options.dt is not None or options.homography is not None:
            raise VbbenchError(
                f"{recipe.name}: `dt` and `homography` are for the split 'custom'; this recipe has its own"
            )
        paths = locate(recipe.sources, options.source, split=recipe.name)
        matrix = read_homography(paths.pop()) if recipe.homography is not None else None
        scenes = [self.read(_scene_file(recipe, path, recipe.dt, matrix)) for path in paths]
        if recipe.resampling is not None:
            jitter = recipe.resampling.jitter
            scenes = [_jittered(scene, jitter, options.seed, index) for index, scene in enumerate(scenes)]
        if recipe.grid is not None:
            scenes = [off_grid(scene, recipe.grid, options.seed, index) for index, scene in enumerate(scenes)]
        return Loaded(scenes=scenes, files=[(file.path, file.sha256) for file in recipe.sources])


def load_scenes(recipe: Recipe, options: Options) -> Loaded:
    """The scenes of a split, read by the reader of its recipe's format.

    Raises VbbenchError if a file is missing or bad, or an option does not fit the split.
    """
    reads_own = _load_own if recipe.reads_own_file else get_reader(recipe.format).load
    return reads_own(recipe, options)


def get_reader(name: str) -> Reader:
    """The reader of a format.

    Raises UnknownNameError if there is none; the nearest name is suggested; VbbenchError if its plugin cannot be
    loaded.
    """
    found: Reader = load_registered("reader", name)
    return found


COUNTED = ("obsmat", "trajnet")
"""Formats that the number of columns is enough for; others are asked first."""


def detect_format(path: Path) -> str:
    """The format of a user's own file, by the line that names its columns, or else the first row.

    Raises FileError if no reader recognises it.
    """
    body, header, number = split_header(read_text(path), NOUNS)
    line = " ".join(header.names) if header else body.partition(b"\n")[0].decode().strip()
    if not line:
        raise FileError(path, "is empty: it holds no row of numbers")
    if line.startswith(("{", "[")):
        raise FileError(path, "is JSON; write lines of frame, id, x, y under a first line with these names", number)
    readers = load_all("reader")
    names = sorted(readers, key=COUNTED.__contains__)
    found = next((name for name in names if readers[name].recognises(line)), None)
    if found is None:
        known = ", ".join(sorted(reader.signature for reader in readers.values() if reader.signature))
        raise FileError(path, f"has {count_columns(line)} columns; known are {known}", number)
    return found


def _load_own(recipe: Recipe, options: Options) -> Loaded:
    source, homography = options.source, options.homography
    if source is None or not source.is_file():
        found = "" if source is None else f"; {source} is not a file"
        raise VbbenchError(f"{recipe.name} is made from a file of yours: name it with --source FILE{found}")
    matrix = None if homography is None else read_homography(homography)
    reader = get_reader(detect_format(source) if recipe.format == DETECTED else recipe.format)
    scene = reader.read(_scene_file(recipe, source, recipe.dt if options.dt is None else options.dt, matrix))
    read = [source] if homography is None else [source, homography]
    return Loaded(scenes=[scene], files=[(path.name, file_sha256(path)) for path in read])


def _scene_file(recipe: Recipe, path: Path, dt: float | None, homography: FloatArray | None) -> SceneFile:
    if dt is None:
        raise VbbenchError(f"{recipe.name}: give the seconds per frame with `dt`, {FRAME_TIME}")
    smooth = recipe.resampling is not None
    return SceneFile(path=path, dt=dt, frame_step=recipe.frame_step, homography=homography, smooth=smooth)


def _jittered(scene: Scene, std: float, seed: int, index: int) -> Scene:
    """The scene with Gaussian noise of ``std`` m on every position, drawn from the seed and the scene's ``index``."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index,)))
    return replace(scene, positions=scene.positions + rng.normal(0.0, std, scene.positions.shape))


def off_grid(scene: Scene, grid: float, seed: int, index: int) -> Scene:
    """The scene with places drawn uniformly within the cell of the source's ``grid`` (m) that they were rounded to.

    With exact boxes, multiples of the grid would reveal the world's axes and people's displacements to a solver. The
    places follow from the seed and the scene's ``index`` alone.
    """
    rng = random_stream(seed, index, Stream.GRID)
    return replace(scene, positions=scene.positions + rng.uniform(-grid / 2.0, grid / 2.0, scene.positions.shape))


def every_frame(scene: Scene, step: int) -> Scene:
    """The scene in every ``step``-th frame from the first one on, without people who are in none of these."""
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
