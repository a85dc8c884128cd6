"""Writing the player's data into a site: an index a split, a file a sequence and tier, a file a sequence and solver."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from vbbench.parallel import check_jobs, in_parallel
from vbbench.rendering import Backend
from vbbench.sequence import Sequence, Truth
from vbbench.submitted import SubmittedEstimates
from vbbench.tables import write_text_atomically
from vbbench_leaderboards.player.playable import choose_sequences
from vbbench_leaderboards.player.clip import encode_clip, encode_estimate
from vbbench_leaderboards.player.playable import split_index
from vbbench_leaderboards.player.pictures import copy_pictures, make_pictures
from vbbench_leaderboards.player.playable import Boards, Playable, find_playable, submission_folder
from vbbench_leaderboards.results.result import Board

FOLDER = Path("data", "player")
"""Where the data lie in a site."""

_HERE = Path(__file__).parent
_PARTS = "data moment theme ego trails map legend strip gestures controls words session player"
"""Files of which the page's ``player.js`` is made, in the order in which they need one another."""


@dataclass(frozen=True, kw_only=True)
class Clip:
    """A sequence whose file is written.

    Parameters
    ----------
    sequence, truth : what it is of.
    coarse : how many quanta its file takes at a time.
    """

    sequence: Sequence
    truth: Truth
    coarse: int


@dataclass(frozen=True, kw_only=True)
class Films:
    """What the player is to show.

    Parameters
    ----------
    work : work folder of ``vbbench leaderboard rerun``, with datasets and submissions.
    sequences : at most so many of a split.
    pictures : who draws pictures to stand behind the boxes, into ``work``; by default those that are there are shown.
    jobs : processes.
    """

    work: Path
    sequences: int = 24
    pictures: Backend | None = None
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
    if films.pictures is not None:
        dataset = next(iter(playable.datasets.values()))
        make_pictures(dataset, playable.split, chosen.tolist(), work, films.pictures)
    pictures = copy_pictures(work, site, playable.split, chosen)
    write_data(site, playable.split, split_index(playable, chosen, pictures))
    for tier in playable.datasets:
        clips = list(_write_clips(site, playable, tier, chosen.tolist()))
        for board in (board for board in playable.boards if board.tier == tier):
            _write_board(site, playable, board, work, clips)


def _write_clips(site: Path, playable: Playable, tier: str, chosen: list[int]) -> Iterator[Clip]:
    dataset = playable.datasets[tier]
    for number in chosen:
        sequence = dataset.sequence(number)
        truth = dataset.truth(sequence)
        values = encode_clip(dataset.info.camera, dataset.info.dt, sequence, truth)
        write_data(site, f"{playable.split}/{tier}/{number}", values)
        yield Clip(sequence=sequence, truth=truth, coarse=values["coarse"])


def _write_board(site: Path, playable: Playable, board: Board, work: Path, clips: list[Clip]) -> None:
    for result in playable.boards[board]:
        submitted = SubmittedEstimates(playable.datasets[board.tier], submission_folder(work, result))
        for clip in clips:
            estimate = submitted.of(clip.sequence)
            values = encode_estimate(clip.sequence, clip.truth, estimate, clip.coarse)
            write_data(site, f"{board.folder.as_posix()}/{clip.sequence.index}/{result.solver}", values)


def write_data(site: Path, name: str, values: dict[str, Any]) -> None:
    """One data file, which the page asks for by its name; what is half-written no site ever shows."""
    key, value = json.dumps(f"player/{name}"), json.dumps(values, ensure_ascii=False, separators=(",", ":"))
    path = site / FOLDER / f"{name}.js"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"vbbench.provide({key},{value});\n", encoding="utf-8")
