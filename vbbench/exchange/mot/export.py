"""A dataset's boxes as MOTChallenge folders, one a sequence, with the rendered pictures if wanted."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from vbbench.boxes import rectangles
from vbbench.exchange.box_rows import BoxRows, rows_of
from vbbench.exchange.mot.text import UNLINKED, write_mot
from vbbench.exchange.sequence_files import SEQUENCE_INFO, sequence_info, sequence_name
from vbbench.files.dataset import Dataset
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_bytes_atomically, write_text_atomically
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.rendering import Backend, open_renderer, pictures, scene_of, silent
from vbbench.sequence import Sequence


def export_mot(
    dataset: Dataset,
    out: Path | str,
    *,
    sequence: int | None = None,
    backend: Backend | None = None,
    announce: Callable[[str], object] = silent,
) -> Path:
    """Write the boxes of sequences as MOTChallenge text.

    Each sequence is a folder ``sequence-000012`` with ``gt/gt.txt`` (boxes with their tracks), ``det/det.txt`` (the
    same boxes as detections, without) and ``seqinfo.ini``. A box is `BOX_ASPECT` times as wide as it is high, since an
    observation has no width.

    Parameters
    ----------
    dataset : the dataset.
    out : folder to write into; created if needed.
    sequence : number of the only sequence to write; ``None`` for all.
    backend : renders pictures into ``img1``, which needs truth; ``None`` for no pictures.
    announce : called with a line that names the renderer.

    Returns
    -------
    The folder ``out``.

    Raises
    ------
    VbbenchError
        If there is no such sequence or backend, or pictures are requested and the truth is withheld.
    """
    out = Path(out)
    chosen = dataset.sequences() if sequence is None else [dataset.sequence(sequence)]
    with loose_files(out):
        for one in chosen:
            name = sequence_name(one.index)
            folder, tracks = out / name, _rows(one)
            write_mot(folder / "gt" / "gt.txt", tracks)
            write_mot(folder / "det" / "det.txt", replace(tracks, track=np.full(len(tracks.frame), UNLINKED)))
            info = sequence_info(name, dataset.info.dt, one.frames, dataset.camera(one).picture_size, ".png")
            write_text_atomically(folder / SEQUENCE_INFO, info)
            if backend is not None:
                _write_pictures(dataset, one, folder / "img1", backend, announce)
    return out


def _rows(sequence: Sequence) -> BoxRows:
    frame, column = np.nonzero(sequence.observed)
    boxes = rectangles(sequence.observations[frame, column])
    rows = rows_of(Path(), frame, sequence.tracks[column], boxes, np.ones(len(frame)))
    return replace(rows, visible=sequence.visible[frame, column])


def _write_pictures(
    dataset: Dataset, sequence: Sequence, folder: Path, backend: Backend, announce: Callable[[str], object]
) -> None:
    from vbbench.pictures.video import png_bytes

    scene = scene_of(dataset, sequence.scene)
    with (
        open_renderer(backend, scene, announce=announce) as renderer,
        progress_bar(sequence.frames, folder.parent.name, unit="frame") as bar,
    ):
        for frame, picture in enumerate(pictures(dataset, sequence, renderer)):
            write_bytes_atomically(folder / f"{frame + 1:06d}.png", png_bytes(picture.rgb))
            bar.update()
