"""The demo: one simulated split, a few solvers and protocols or all, and a page with a map, a table and the player."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.folders.locks import locked
from vbbench.folders.replacing import is_unused, write_text_atomically
from vbbench.folders.work_folder import check_free
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.parallel.parts import in_parallel, progress_bar, without_bars
from vbbench.pictures.plotting import plot_to_file
from vbbench.protocol import PROTOCOLS, get_protocol
from vbbench.solving import solve
from vbbench.solving.provenance import solver_cards
from vbbench.table import Table
from vbbench_leaderboards.results.boards import REFERENCES
from vbbench_leaderboards.results.folder import dataset_folder, read_results, submission_folder
from vbbench_leaderboards.results.ranking import headline
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.site.pages import build, render
from vbbench_leaderboards.site.player import Films
from vbbench_leaderboards.submitting import add

SPLIT, TIER, SEQUENCES = "demo", "field", 12
FEW = ("sequential", "cold-start")
SOLVERS = {
    "ground-plane": "distances by box height, a Kalman filter a person",
    "vb-sf": "the paper's cascade",
    "vb-former": "a network trained on simulated crowds",
    "map-causal": "all paths estimated jointly",
}
"""The solvers, each with what it is."""
SHOWN = "map-causal"
"""The solver on the map and in the player."""
PAGE = "index.html"


def make_demo(out: Path | str, *, full: bool = False, jobs: int = 1) -> str:
    """Generate `SEQUENCES` sequences, solve them with `SOLVERS` under two protocols, and write the page; the table.

    Parameters
    ----------
    out : folder to make: ``index.html``, ``map.png``, datasets, submissions, results and the site with the player.
    full : with every bundled solver under every protocol.
    jobs : processes.
    """
    out, protocols, solvers = Path(out), PROTOCOLS if full else FEW, SOLVERS
    if full:
        solvers = {card.name: card.summary for card in solver_cards() if card.name in REFERENCES}
    with _demo_folder(out):
        folder, options = dataset_folder(out, SPLIT, TIER), Options(tier=TIER, limit=SEQUENCES)
        dataset = generate(SPLIT, folder, options, jobs=jobs, overwrite=True)
        results = _results(dataset, out, [(one, protocol) for protocol in protocols for one in solvers], jobs)
        rows = [_row(one, words, [results[one, protocol] for protocol in protocols]) for one, words in solvers.items()]
        head = ["solver", "what it is", *(f"Δx, {name} (m)" for name in protocols), "ms per frame"]
        shown, board = _shown_sequence(dataset, results[SHOWN, FEW[0]]), _board(FEW[0])
        plot_to_file(dataset, shown, out / "map.png", submissions=[submission_folder(out, board, SHOWN)])
        build(out / "site", out / "results", films=Films(work=out))
        facts = {"sequences": len(dataset), "sequence": shown, "shown": SHOWN, "cap": get_protocol(FEW[0]).caps["dx"]}
        page = render("demo.html", board=board.key, head=head, rows=rows, **facts)
        write_text_atomically(out / PAGE, page)
    table = "\n".join(Table(head=head, rows=rows, names=2).text())
    words = f"{len(dataset)} sequences of simulated crowds, with the boxes of a detector and a tracker (tier {TIER})"
    return f"{words}\n\n{table}\n\nOpen {out / PAGE} in a browser."


@contextmanager
def _demo_folder(out: Path) -> Iterator[None]:
    """The folder of a demo, locked; its page says that it was interrupted until it is written.

    Raises VbbenchError if the folder is in use and holds no demo.
    """
    if not is_unused(out):
        check_free(out, PAGE, "demo", overwrite=True)
    with locked(out):
        if not (out / PAGE).exists():
            text = "<title>vbbench demo</title>It was interrupted; run it again.\n"
            write_text_atomically(out / PAGE, text)
        yield


def _shown_sequence(dataset: Dataset, result: Result) -> int:
    """The number of the sequence that is shown: of the third with the most usual Δx, the one with the most people."""
    scored = result.per_sequence
    errors = scored.figures["dx"]
    usual = np.argsort(np.abs(errors - np.nanmedian(errors)), kind="stable")[: max(1, len(errors) // 3)]
    numbers = scored.sequence[usual]
    return int(numbers[dataset.rows["people"][numbers].argmax()])


def _results(dataset: Dataset, out: Path, calls: list[tuple[str, str]], jobs: int) -> dict[tuple[str, str], Result]:
    """The results of solvers and protocols, as the page reads them."""
    with progress_bar(len(calls), "solve", unit="submission") as bar:
        for _ in in_parallel(partial(_solve, dataset, out), calls, jobs):
            bar.update()
    rows = [result for results in read_results(out / "results").values() for result in results]
    return {(result.solver, result.board.protocol): result for result in rows}


def _solve(dataset: Dataset, out: Path, solver: str, protocol: str) -> None:
    with without_bars():
        submission = submission_folder(out, _board(protocol), solver)
        solve(dataset, solver, protocol, submission, overwrite=True)
    add(submission, dataset.folder, out / "results", overwrite=True)


def _board(protocol: str) -> Board:
    return Board(split=SPLIT, protocol=protocol, tier=TIER)


def _row(solver: str, words: str, results: list[Result]) -> list[str]:
    errors = [f"{headline(one, 'dx').value:.2f}" for one in results]
    return [solver, words, *errors, f"{1e3 * (results[0].score['seconds_per_frame'] or 0.0):.1f}"]
