"""Writes the player into a site: an index per split, a file per sequence and tier, a file per sequence and solver."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from vbbench.files.dataset import Dataset
from vbbench.files.submission_rows import SubmittedEstimates
from vbbench.folders.replacing import write_text_atomically
from vbbench.parallel.parts import check_jobs, in_parallel
from vbbench.pictures.rendering import Backend
from vbbench.sequence import Sequence, Truth
from vbbench_leaderboards.markup import provided
from vbbench_leaderboards.player.clip import encode_clip, encode_estimate, encode_unboxed, shown_estimate, shown_truth
from vbbench_leaderboards.player.pictures import copy_footage, copy_pictures, make_pictures
from vbbench_leaderboards.player.playable import Playable, choose_sequences, find_playable, split_index
from vbbench_leaderboards.player.unboxed import find_unboxed
from vbbench_leaderboards.results.folder import Boards, submission_folder
from vbbench_leaderboards.results.result import Board

FOLDER = Path("data", "player")
"""Where the data lie in a site."""

_HERE = Path(__file__).parent
_PARTS = "data moment others moments theme ego trails map edges legend strip gestures controls words session player"
"""Files of which the page's ``player.js`` is made, in the order in which they need one another."""


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
    for name, text in player_assets().items():
        write_text_atomically(site / "assets" / name, text)
    if films is None or films.sequences < 1:
        return {}
    playable = list(find_playable(films.work, results))
    for _ in in_parallel(partial(_write_split, site, films), [(one,) for one in playable], films.jobs):
        pass
    return {board: tuple(row.solver for row in rows) for one in playable for board, rows in one.boards.items()}


def player_assets() -> dict[str, str]:
    """The player's script, its parts on end, and its style sheet, by file name."""
    script = "\n".join((_HERE / "scripts" / f"{name}.js").read_text(encoding="utf-8") for name in _PARTS.split())
    return {"player.js": script, "player.css": (_HERE / "assets" / "player.css").read_text(encoding="utf-8")}


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
