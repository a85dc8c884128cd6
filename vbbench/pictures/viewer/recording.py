"""Writes the recording of a sequence, whole or not at all."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.folders.replacing import replacing
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.rendering import Backend, open_renderer, pictures, scene_of, silent
from vbbench.pictures.viewer.ego import record_boxes, record_pictures
from vbbench.pictures.viewer.estimates import record_estimate
from vbbench.pictures.viewer.ground import Ground
from vbbench.pictures.viewer.layout import layout
from vbbench.pictures.viewer.sdk import rerun, strictly
from vbbench.pictures.viewer.take import Take, load_take
from vbbench.pictures.viewer.tape import Tape
from vbbench.pictures.viewer.words import record_words
from vbbench.pictures.viewer.world import record_world

SUFFIX = ".rrd"


def record_to_file(
    dataset: Dataset,
    sequence: int,
    out: Path | str | None = None,
    *,
    submissions: Sequence[Path | str] = (),
    backend: Backend | None = None,
    announce: Callable[[str], object] = silent,
) -> Path:
    """Write a sequence, and the answers of submissions to it, as a recording for the rerun viewer.

    Parameters
    ----------
    dataset : where the sequence lies; without truth, boxes, what is given and estimates are recorded.
    sequence : its number.
    out : an ``.rrd`` file; by default named after split and sequence, in the working directory.
    submissions : folders of submissions that answer the dataset.
    backend : who renders the picture, depth and ids of every frame; ``None`` for boxes alone.
    announce : is told once what renders.

    Returns
    -------
    The file.

    Raises
    ------
    VbbenchError
        If rerun is not installed, there is no such sequence or backend, a submission answers another dataset,
        pictures are asked for and the truth is withheld, or ``out`` is no ``.rrd`` file.
    """
    package = rerun()
    take = load_take(dataset, sequence, submissions)
    path = _checked(Path(out or f"{dataset.info.split}-{sequence}{SUFFIX}"))
    with replacing(path) as temporary, strictly():
        stream = package.RecordingStream(_application(take))
        if not package.is_enabled(stream):
            raise VbbenchError("rerun is switched off; unset the environment variable RERUN")
        stream.save(temporary)
        stream.send_blueprint(layout(take, pictures=backend is not None), make_active=True, make_default=True)
        _record(Tape(stream, take.sequence.frames, dataset.info.dt), take, backend, announce)
        stream.disconnect()
    return path


def _application(take: Take) -> str:
    """The viewer remembers a layout for each application; that of another sequence does not fit this one."""
    return f"vbbench {take.dataset.info.split} {take.dataset.info.camera.kind} {take.sequence.index}"


def _record(tape: Tape, take: Take, backend: Backend | None, announce: Callable[[str], object]) -> None:
    ground = Ground(tape)
    record_words(tape, take)
    record_world(ground, take)
    record_boxes(tape, take)
    for number in range(len(take.estimates)):
        record_estimate(ground, take, number)
    if backend is not None:
        _render(tape, take, backend, announce)


def _render(tape: Tape, take: Take, backend: Backend, announce: Callable[[str], object]) -> None:
    scene, frames = scene_of(take.dataset, take.sequence.scene), take.sequence.frames
    with open_renderer(backend, scene, announce) as renderer, progress_bar(frames, "frames", unit="frame") as bar:

        def shown() -> Any:
            for picture in pictures(take.dataset, take.sequence, renderer):
                yield picture
                bar.update()

        record_pictures(tape, take, scene.people, shown())


def _checked(path: Path) -> Path:
    if path.suffix != SUFFIX or path.is_dir():
        raise FileError(path, f"a recording is a file that ends in {SUFFIX}; give it such a name")
    return path
