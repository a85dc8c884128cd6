"""The player in a site: which sequences it shows, their pictures, and the files that it reads."""

import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_checks import Known
from vbbench.files.dataset_info import INFO_FILE
from vbbench.files.submission import SUBMISSION_FILE
from vbbench.files.submission_rows import SubmittedEstimates
from vbbench.folders.work_folder import WorkFolder
from vbbench.geometry import FloatArray, IntArray
from vbbench.parallel.parts import check_jobs, in_parallel
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.people_colours import ON_DARK, ON_LIGHT
from vbbench.pictures.rendering import Backend, open_renderer, pictures, scene_of
from vbbench.protocol import get_protocol
from vbbench.sequence import Sequence, Truth
from vbbench_leaderboards.results.boards import HEADLINE_TIER
from vbbench_leaderboards.results.folder import Boards, dataset_folder, submission_folder
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.site.clip import (
    encode_clip,
    encode_estimate,
    encode_unboxed,
    find_unboxed,
    shown_estimate,
    shown_truth,
)
from vbbench_leaderboards.site.words import provided

_REFERENCES = (("sequential", HEADLINE_TIER), ("sequential", "noisy"), ("sequential", "ideal"))
"""Protocol and tier by whose errors sequences are chosen: the first of them that has results, or else any board."""

_CHOSEN_BY = ("dx", "dx_rel", "dt")
"""Figures by which sequences are chosen: the first that the truth allows."""

_INDEXED = ("dx", "dt")
_CAPPED = ("dx", "dt", "dr")
_DIGITS = 4


@dataclass(frozen=True, kw_only=True)
class Playable:
    """What of a split can be played.

    Parameters
    ----------
    split : its name.
    boards : the boards whose dataset, with its truth, and submissions are at hand; those results alone.
    datasets : tier → dataset.
    """

    split: str
    boards: Boards
    datasets: Mapping[str, Dataset]


def find_playable(work: Path, boards: Boards) -> Iterator[Playable]:
    """The splits of which something can be played.

    Raises
    ------
    VbbenchError
        If a dataset that lies there is not the one that the results are of.
    """
    for split in sorted({board.split for board in boards}):
        datasets: dict[str, Dataset] = {}
        kept: dict[Board, tuple[Result, ...]] = {}
        for board in sorted(board for board in boards if board.split == split):
            there = tuple(row for row in boards[board] if _has_submission(work, row))
            dataset = datasets.get(board.tier) or _opened(work, board)
            if dataset is not None and there:
                _check_same(dataset, there)
                datasets[board.tier], kept[board] = dataset, there
        if kept:
            yield Playable(split=split, boards=kept, datasets=datasets)


def _has_submission(work: Path, result: Result) -> bool:
    return (submission_folder(work, result.board, result.solver) / SUBMISSION_FILE).is_file()


def _opened(work: Path, board: Board) -> Dataset | None:
    folder = dataset_folder(work, board.split, board.tier)
    dataset = Dataset(folder) if (folder / INFO_FILE).is_file() else None
    return dataset if dataset is not None and dataset.has_truth else None


def _check_same(dataset: Dataset, results: tuple[Result, ...]) -> None:
    for result in results:
        if result.dataset != dataset.info.id:
            raise VbbenchError(
                f"{dataset.folder} is dataset {dataset.info.id}, {result.path} is of {result.dataset}; "
                "run 'vbbench leaderboard rerun' again, or build without --work"
            )


def choose_sequences(results: Boards, count: int, available: int) -> IntArray:
    """Numbers of at most ``count`` sequences, ascending, for all boards of a split.

    They lie evenly over the order of the middle solver's Δx, or where that is not known Δx̃ or Δt; the smallest and the
    largest are among them.

    Parameters
    ----------
    results : the boards of one split.
    count : how many are wanted.
    available : number of sequences in the dataset.
    """
    rows = results[_reference(results)]
    metric = next((name for name in _CHOSEN_BY if _mean(rows[0], name) is not None), _CHOSEN_BY[0])
    own = _middle(rows, metric).per_sequence
    usable = np.isfinite(own.figures[metric]) & (own.sequence < available)
    numbers, errors = own.sequence[usable], own.figures[metric][usable]
    ranked = numbers[np.lexsort((numbers, errors))]
    places = np.unique(np.rint(np.linspace(0, len(ranked) - 1, min(count, len(ranked)))).astype(np.int64))
    return np.sort(ranked[places])


def _reference(results: Boards) -> Board:
    boards = sorted(results)
    for protocol, tier in _REFERENCES:
        found = [board for board in boards if (board.protocol, board.tier) == (protocol, tier) and results[board]]
        if found:
            return found[0]
    return next(board for board in boards if results[board])


def _middle(results: tuple[Result, ...], metric: str) -> Result:
    """The result in the middle of the table; of two, the better."""
    ranked = sorted(results, key=lambda result: (_mean(result, metric) or 0.0, result.solver))
    return ranked[(len(ranked) - 1) // 2]


def _mean(result: Result, metric: str) -> float | None:
    mean: float | None = result.score["metrics"][metric]["mean"]
    return mean


def split_index(playable: Playable, chosen: IntArray, pictures: Mapping[str, int]) -> dict[str, Any]:
    """The index as the page gets it.

    Parameters
    ----------
    playable : the split.
    chosen : [S] numbers of its sequences.
    pictures : sequence → how many pictures of it there are.
    """
    dataset = next(iter(playable.datasets.values()))
    known = dataset.info.truth
    boards = {
        f"{board.protocol}-{board.tier}": {
            "tier": board.tier,
            "given": get_protocol(board.protocol).given,
            "caps": {name: get_protocol(board.protocol).caps[name] for name in _CAPPED},
            "solvers": {row.solver: _figures(row, chosen, known) for row in rows},
        }
        for board, rows in playable.boards.items()
    }
    palette = {"light": ON_LIGHT, "dark": ON_DARK}
    facts = {"split": playable.split, "truth": known, "palette": palette, **_facts(dataset, chosen)}
    return {**facts, "pictures": dict(pictures), "boards": boards}


def _facts(dataset: Dataset, chosen: IntArray) -> dict[str, list[int]]:
    columns = {"sequences": "sequence", "frames": "frames", "people": "people"}
    return {name: dataset.rows[column][chosen].tolist() for name, column in columns.items()}


def _figures(result: Result, chosen: IntArray, known: Known) -> dict[str, list[float | None]]:
    """A solver's figures in the chosen sequences, None where it has none; seen from the camera, Δx̃ stands for Δx."""
    own = result.per_sequence
    place = np.searchsorted(own.sequence, chosen).clip(max=len(own.sequence) - 1)
    there = own.sequence[place] == chosen
    source = {"dx": "dx_rel"} if known == "relative" else {}
    found = {name: own.figures[source.get(name, name)][place] for name in _INDEXED}
    return {name: _rounded(np.where(there, values, np.nan)) for name, values in found.items()}


def _rounded(values: FloatArray) -> list[float | None]:
    return [round(float(value), _DIGITS) if np.isfinite(value) else None for value in values]


WIDTH = 640
"""Width of a picture in px; one that the camera took is wider if it would be lower than `_LEAST_HEIGHT`."""

_LEAST_HEIGHT = 160

_QUALITY = 70


def picture_folder(work: Path, split: str, number: int) -> Path:
    """Where the pictures of a sequence lie in a work folder: ``00000.jpg`` and so on, one per frame."""
    return work / "pictures" / split / str(number)


def copy_pictures(work: Path, site: Path, split: str, chosen: IntArray) -> dict[str, int]:
    """Copy the pictures of the chosen sequences into a site; sequence → how many there are."""
    counts: dict[str, int] = {}
    for number in map(int, chosen):
        files = sorted(picture_folder(work, split, number).glob("[0-9]*.jpg"))
        target = picture_folder(site / "data" / "player", split, number)
        for file in files:
            target.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target / file.name)
        if files:
            counts[str(number)] = len(files)
    return counts


def make_pictures(dataset: Dataset, split: str, chosen: Iterable[int], work: Path, backend: Backend) -> None:
    """Render the chosen sequences into the work folder, those that are there already left alone.

    Raises
    ------
    VbbenchError
        If the truth is withheld, or the backend cannot work here.
    """
    for number, folder in _missing(work, split, chosen):
        sequence = dataset.sequence(number)
        with open_renderer(backend, scene_of(dataset, sequence.scene)) as renderer:
            _fill(folder, (_small(picture.rgb) for picture in pictures(dataset, sequence, renderer)))


def copy_footage(dataset: Dataset, split: str, chosen: Iterable[int], work: Path) -> None:
    """Put small copies of the pictures that the camera took into the work folder, those there already left alone.

    Frames without a picture have a plain ground; sequences without any have no pictures.

    Raises
    ------
    VbbenchError
        If a file is no picture.
    """
    for number, folder in _missing(work, split, chosen):
        sequence = dataset.sequence(number)
        backdrop = Backdrop(dataset, sequence, widest=WIDTH, least=_LEAST_HEIGHT)
        if backdrop.is_recorded:
            _fill(folder, map(backdrop.picture, range(sequence.frames)))


def _missing(work: Path, split: str, chosen: Iterable[int]) -> Iterator[tuple[int, Path]]:
    """The chosen sequences of which there are no pictures yet, and the folders for these."""
    for number in chosen:
        folder = picture_folder(work, split, number)
        if not folder.is_dir():
            yield number, folder


def _fill(folder: Path, frames: Iterable[NDArray[np.uint8]]) -> None:
    """Make a folder of JPEGs."""
    from PIL import Image

    with WorkFolder(folder) as place:
        place.begin()
        place.new.mkdir()
        for frame, rgb in enumerate(frames):
            Image.fromarray(rgb).save(place.new / f"{frame:05d}.jpg", quality=_QUALITY, optimize=True)
        place.publish()


def _small(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    from PIL import Image

    height, width = rgb.shape[:2]
    return np.asarray(Image.fromarray(rgb).resize((WIDTH, round(height * WIDTH / width)), Image.Resampling.LANCZOS))


FOLDER = Path("data", "player")
"""Where the data lie in a site."""

Clip = tuple[Sequence, Truth, int]
"""A sequence whose file is written, its truth, and how many quanta the file takes at a time."""


@dataclass(frozen=True, kw_only=True)
class Films:
    """What the player is to show.

    Parameters
    ----------
    work : work folder of ``vbbench leaderboard rerun``, with datasets and submissions.
    sequences : at most so many of a split.
    pictures : who draws pictures to stand behind the boxes, into ``work``; by default those that are there are shown.
    footage : put small copies of the pictures that a camera took into ``work``.
    jobs : processes.
    """

    work: Path
    sequences: int = 24
    pictures: Backend | None = None
    footage: bool = False
    jobs: int = 1

    def __post_init__(self) -> None:
        check_jobs(self.jobs)


def write_player(site: Path, results: Boards, films: Films | None) -> dict[Board, tuple[str, ...]]:
    """Write the player and, for all that lies in the work folder, its data into a site.

    Parameters
    ----------
    site : folder of the site.
    results : the results on the page, by board.
    films : which sequences can be played; ``None`` writes no data.

    Returns
    -------
    The boards that can be played, each with its solvers.

    Raises
    ------
    VbbenchError
        If what lies in the work folder is not what the results are of, or cannot be read.
    """
    if films is None or films.sequences < 1:
        return {}
    playable = list(find_playable(films.work, results))
    for _ in in_parallel(partial(_write_split, site, films), [(one,) for one in playable], films.jobs):
        pass
    return {board: tuple(row.solver for row in rows) for one in playable for board, rows in one.boards.items()}


def _write_split(site: Path, films: Films, playable: Playable) -> None:
    work = films.work
    available = min(len(dataset) for dataset in playable.datasets.values())
    chosen = choose_sequences(playable.boards, films.sequences, available)
    dataset = next(iter(playable.datasets.values()))
    if films.footage:
        copy_footage(dataset, playable.split, chosen.tolist(), work)
    elif films.pictures is not None:
        make_pictures(dataset, playable.split, chosen.tolist(), work, films.pictures)
    pictures = copy_pictures(work, site, playable.split, chosen)
    write_data(site, playable.split, split_index(playable, chosen, pictures))
    for tier, dataset in playable.datasets.items():
        clips = list(_write_clips(site, playable.split, tier, dataset, chosen.tolist()))
        for board, rows in playable.boards.items():
            for result in rows if board.tier == tier else ():
                _write_estimates(site, board, result.solver, work, dataset, clips)


def _write_clips(site: Path, split: str, tier: str, dataset: Dataset, chosen: list[int]) -> Iterator[Clip]:
    for number in chosen:
        sequence = dataset.sequence(number)
        truth = shown_truth(dataset, sequence)
        values = encode_clip(dataset.camera(sequence), dataset.info.dt, sequence, truth)
        unboxed = find_unboxed(dataset, sequence, truth)
        write_data(site, f"{split}/{tier}/{number}", {**values, "unboxed": unboxed is not None})
        if unboxed is not None:
            write_data(site, f"{split}/{tier}/{number}/unboxed", encode_unboxed(truth, unboxed))
        yield sequence, truth, values["coarse"]


def _write_estimates(site: Path, board: Board, solver: str, work: Path, dataset: Dataset, clips: list[Clip]) -> None:
    submitted = SubmittedEstimates(dataset, submission_folder(work, board, solver))
    for sequence, truth, coarse in clips:
        values = encode_estimate(sequence, truth, shown_estimate(dataset, submitted.of(sequence)), coarse)
        write_data(site, f"{board.key}/{sequence.index}/{solver}", values)


def write_data(site: Path, name: str, values: dict[str, Any]) -> None:
    """One data file, which the page asks for by its name; what is half-written no site ever shows."""
    path = site / FOLDER / f"{name}.js"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(provided(f"player/{name}", values), encoding="utf-8")
