"""Renderers: their interface, opening one, and pictures and films of a sequence by any of them.

A renderer draws off-screen; it registers under ``vbbench.renderers``.
"""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.tables import file_sha256
from vbbench.geometry import FloatArray, freeze
from vbbench.parallel.parts import progress_bar
from vbbench.registry import load
from vbbench.scene import Scene
from vbbench.sequence import Sequence
from vbbench.version import __version__

if TYPE_CHECKING:
    from vbbench.pictures.film import View
    from vbbench.pictures.replay import Replay

_WIDEST_BELOW, _WIDEST_NEXT = 1920, 1280
"""Width in px to which a film makes recorded pictures smaller, with the map below and next to them."""


@dataclass(frozen=True, kw_only=True)
class Picture:
    """One rendered frame; row 0 is the top.

    Parameters
    ----------
    rgb : [H, W, 3] uint8, sRGB.
    depth : [H, W] float32 in m: along the optical axis for a pinhole (`Camera.intrinsics`), horizontal range for other
        cameras; infinite in the sky.
    ids : [H, W] int32 person id, `vbbench.sequence.NOBODY` where no person shows.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    ids: NDArray[np.int32]

    def __post_init__(self) -> None:
        size = np.shape(self.ids)
        freeze(self, np.uint8, rgb=(*size, 3))
        freeze(self, np.float32, depth=size)
        freeze(self, np.int32, ids=size)


class Renderer(Protocol):
    """Draws the frames of one scene."""

    @property
    def device(self) -> str:
        """Name of the GPU or processor that draws, for the log."""

    def render(self, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None) -> Picture:
        """The picture of a scene frame.

        Raises VbbenchError if the scene has no such frame or observer, or the camera cannot be rendered.

        Parameters
        ----------
        frame : frame of the scene.
        camera : its picture has `Camera.picture_size`.
        pose : [3] (x, y, yaw) in m and rad.
        observer : id of the person who carries the camera, who is not drawn.
        """

    def close(self) -> None:
        """Release what is held on the device."""


class RendererFactory(Protocol):
    """What an entry point of ``vbbench.renderers`` names."""

    def __call__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> Renderer:
        """A renderer of one scene; looks and surroundings follow from the seed.

        Raises VbbenchError if it does not work on this machine; the message says what to install.
        """


AUTO = "auto"
"""The backend that chooses among the others."""


@dataclass(frozen=True, kw_only=True)
class Backend:
    """A renderer and its settings.

    Parameters
    ----------
    name : a registered renderer, or ``module:attribute`` of a `RendererFactory`.
    surroundings : whether to draw more than people, ground and sky.
    seed : of looks and surroundings.
    """

    name: str = AUTO
    surroundings: bool = True
    seed: int = 0


def silent(_text: str) -> None:
    """Say nothing."""


@contextmanager
def open_renderer(backend: Backend, scene: Scene, announce: Callable[[str], object] = silent) -> Iterator[Renderer]:
    """A renderer of one scene, closed at the end; ``announce`` is called once with a line that names it.

    Raises VbbenchError if there is no such backend, it cannot work on this machine, or the seed is negative.
    """
    if backend.seed < 0:
        raise VbbenchError(f"seed must be at least 0, not {backend.seed}")
    factory: RendererFactory = load("renderer", backend.name)
    if not callable(factory):
        raise VbbenchError(f"renderer '{backend.name}' is not a class or function; see RendererFactory")
    with closing(factory(scene, seed=backend.seed, surroundings=backend.surroundings)) as renderer:
        announce(f"rendering with {backend.name} on {renderer.device}")
        yield renderer


def pictures(
    dataset: Dataset, sequence: Sequence, renderer: Renderer, wanted: Iterable[int] | None = None
) -> Iterator[Picture]:
    """What the observer really sees in the ``wanted`` frames (``None``: in all), each rendered when it is needed.

    Raises VbbenchError if the truth is withheld.
    """
    poses, camera = dataset.world(sequence).poses_in_scene(dataset.truth(sequence).poses), dataset.camera(sequence)
    for frame in range(sequence.frames) if wanted is None else wanted:
        yield renderer.render(sequence.first_frame + frame, camera, poses[frame], observer=bearer(sequence))


def bearer(sequence: Sequence) -> int | None:
    """Who of the scene's people carries the camera; ``None`` in footage, whose observer is none of them."""
    return sequence.observer if sequence.observer >= 0 else None


def scene_of(dataset: Dataset, number: int) -> Scene:
    """A scene of a dataset with everybody in it, from its truth, in the scene's own world.

    Raises VbbenchError if the truth is withheld, or less is known than where camera and people are.
    """
    if dataset.info.truth != "whole":
        lacking = "where people really are" if dataset.info.truth == "poses" else "where the camera really is"
        raise VbbenchError(
            f"{dataset.folder} cannot be rendered: {lacking} was never measured; 'vbbench render --footage' needs none"
        )
    people, positions, heights = dataset.scene(number)
    names = dataset.info.scenes
    name = names[number] if number < len(names) else f"{dataset.info.split}-{number}"
    return Scene(name=name, dt=dataset.info.dt, people=people, positions=positions, heights=heights)


@dataclass(frozen=True)
class Rendered:
    """What a renderer draws of a sequence whose truth is known."""

    replay: "Replay"
    renderer: Renderer
    zoom: float = 1.0
    corner: tuple[float, float] = (0.0, 0.0)

    @property
    def width(self) -> int:
        """The camera's."""
        return self.replay.camera.picture_size[0]

    @property
    def height(self) -> int:
        """The camera's."""
        return self.replay.camera.picture_size[1]

    def picture(self, frame: int) -> NDArray[np.uint8]:
        """See `vbbench.pictures.film.View`."""
        sequence = self.replay.sequence
        pose = self.replay.dataset.world(sequence).poses_in_scene(self.replay.known.poses[frame])
        place = sequence.first_frame + frame
        return np.array(self.renderer.render(place, self.replay.camera, pose, observer=bearer(sequence)).rgb)


def render_to_file(
    dataset: Dataset,
    sequence: int,
    out: Path | str,
    *,
    backend: Backend | None = None,
    footage: bool = False,
    submission: Path | str | None = None,
    announce: Callable[[str], object] = silent,
) -> Path:
    """Film a sequence: what the observer sees, with boxes and ids, next to the map of truth and estimate.

    Frames are written as they are made, so that memory does not grow with their number. In a folder of PNG files, an
    interrupted call continues where it stopped.

    Raises VbbenchError if there is no such sequence or backend, a renderer lacks truth, the submission answers
    another dataset, or ``out`` cannot be written.

    Parameters
    ----------
    dataset : the dataset; a renderer needs its truth.
    sequence : number of the sequence.
    out : an ``.mp4`` file in real time, or a folder for one PNG file per frame.
    backend : the renderer; by default the best that works.
    footage : show the pictures that the camera itself took, or a plain ground where there are none, without a renderer.
    submission : folder of a submission to draw over the truth.
    announce : called once with a line that names the renderer, or says what stands in for pictures.

    Returns
    -------
    ``out``.
    """
    from vbbench.pictures.film import Film
    from vbbench.pictures.replay import load_replay
    from vbbench.pictures.video import write_mp4, write_png_folder

    out, backend = Path(out), backend or Backend()
    if out.suffix not in ("", ".mp4") and not out.is_dir():
        raise VbbenchError(f"{out}: a film is a file that ends in .mp4, or a folder of PNG files")
    if out.suffix == ".mp4" and out.is_dir():
        raise VbbenchError(f"{out} is a folder; name a file that ends in .mp4, or a folder that does not")
    replay = load_replay(dataset, sequence, [] if submission is None else [submission])
    count = replay.sequence.frames
    with _opened_view(replay, None if footage else backend, announce) as (view, made_by):
        film = Film(replay, view)
        with progress_bar(count, "frames", unit="frame") as bar:
            if out.suffix == ".mp4":
                write_mp4(out, film.frames, count, 1.0 / dataset.info.dt, bar.update)
            else:
                key = _key(dataset, sequence, submission, made_by)
                write_png_folder(out, film.frames, count, key, bar.update)
    return out


@contextmanager
def _opened_view(
    replay: "Replay", backend: Backend | None, announce: Callable[[str], object]
) -> Iterator[tuple["View", dict[str, Any]]]:
    """What the observer sees, by a renderer or without one as it was recorded, and what determines its pictures."""
    from vbbench.pictures.backdrop import Backdrop
    from vbbench.pictures.film import is_wide

    dataset, sequence = replay.dataset, replay.sequence
    if backend is None:
        widest = _WIDEST_BELOW if is_wide(replay.camera) else _WIDEST_NEXT
        shown = Backdrop(dataset, sequence, widest=widest, window=replay.window)
        if not dataset.info.pictures:
            announce("no pictures came with this dataset; boxes are drawn on a plain ground")
        yield shown, {"footage": shown.identity}
        return
    with open_renderer(backend, scene_of(dataset, sequence.scene), announce) as renderer:
        yield Rendered(replay, renderer), {**asdict(backend), "device": renderer.device}


def _key(dataset: Dataset, sequence: int, submission: Path | str | None, made_by: dict[str, Any]) -> str:
    """Everything that determines the pictures, as a line of text."""
    facts = {"dataset": dataset.info.id, "sequence": sequence, "vbbench": __version__, **made_by}
    if submission is not None:
        sums = [(path.name, file_sha256(path)) for path in sorted(Path(submission).iterdir()) if path.is_file()]
        facts["submission"] = hashlib.sha256(json.dumps(sums).encode()).hexdigest()
    return json.dumps(facts) + "\n"
