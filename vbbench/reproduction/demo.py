"""The demo: all steps from trajectories to numbers and pictures, in one folder."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import describe
from vbbench.folders.locks import locked
from vbbench.folders.replacing import is_unused, write_text_atomically
from vbbench.folders.work_folder import check_free
from vbbench.generation import generate
from vbbench.generation.generator import Generator, Options
from vbbench.generation.sources import is_here
from vbbench.parallel.parts import in_parallel, progress_bar, without_bars
from vbbench.pictures.plotting import plot_to_file
from vbbench.protocol import PROTOCOLS
from vbbench.registry import load, registered
from vbbench.scoring import score
from vbbench.scoring.metrics import METRICS, section
from vbbench.scoring.scorecard import Score
from vbbench.solving import solve
from vbbench.table import Table

REAL, SYNTHETIC = "hotel", "demo"
"""The real split if its source is available, and the synthetic one otherwise."""
ASKED = {REAL: Options(stride=4), SYNTHETIC: Options()}
"""Of the real one every fourth sequence: a first result is there sooner, and its errors are about those of all."""
PAGE = "index.md"
DRAWN_SOLVER = "vb-cv"
_DETAILED = METRICS["dx"]


def run_demo(out: Path | str, *, jobs: int = 1) -> str:
    """Generate, solve with every solver under every protocol, score and draw; the table as text.

    The folder ``out`` then holds ``dataset``, a submission for each protocol and solver, pictures, and ``index.md``.
    """
    out = Path(out)
    real: Generator = load("generator", REAL)
    with demo_folder(out, PAGE, "# vbbench demo\n\nIt was interrupted; run it again.\n"):
        split = REAL if all(map(is_here, real.card.sources)) else SYNTHETIC
        dataset = generate(split, out / "dataset", ASKED[split], jobs=jobs, overwrite=True)
        facts, table = describe(dataset.info), score_table(_scores(dataset, out, jobs))
        pictures = [_draw(dataset, protocol, out) for protocol in PROTOCOLS]
        shown = "\n\n".join(f"## {one.stem}, {DRAWN_SOLVER}\n\n![{one.stem}]({one.name})" for one in pictures)
        write_text_atomically(out / PAGE, f"# vbbench demo\n\n```\n{facts}\n```\n\n{table}\n\n{shown}\n")
    return f"{facts}\n\n{table}\n\nPictures and files: {out / PAGE}"


@contextmanager
def demo_folder(out: Path, page: str, interrupted: str) -> Iterator[None]:
    """The folder of a demo, locked; ``interrupted`` marks it until its page is written, so that it may be made again.

    Raises
    ------
    VbbenchError
        If the folder is in use and holds no demo.
    """
    if not is_unused(out):
        check_free(out, page, "demo", overwrite=True)
    with locked(out):
        if not (out / page).exists():
            write_text_atomically(out / page, interrupted)
        yield


def _scores(dataset: Dataset, out: Path, jobs: int) -> list[Score]:
    """Of every solver under every protocol, the protocols in order; a process solves the dataset with one solver."""
    solvers = sorted(registered("solver"))
    calls = [(dataset, solver, protocol, out) for protocol in PROTOCOLS for solver in solvers]
    with progress_bar(len(calls), "solve", unit="submission") as bar:
        found = {}
        for (_, solver, protocol, _), submission in zip(calls, in_parallel(_solve, calls, jobs), strict=True):
            found[protocol, solver] = score(submission, dataset.folder)
            bar.update()
    return [found[protocol, solver] for protocol in PROTOCOLS for solver in solvers]


def _solve(dataset: Dataset, solver: str, protocol: str, out: Path) -> Path:
    """A submission, without its own progress bar."""
    with without_bars():
        return solve(dataset, solver, protocol, out / f"{protocol}-{solver}", overwrite=True)


def score_table(scores: list[Score]) -> str:
    """Scores as a Markdown table, a row per protocol and solver: capped means, by which boards rank, and more of Δx."""
    columns = section("metrics")
    labels = [metric.label for metric in columns.values()]
    rows = []
    for s in scores:
        dx, cost = s.summaries["dx"], 1e6 * (s.info.seconds_per_frame or 0.0)
        more = [f"{dx.failure_rate:.1%}", *(f"{value:.3f}" for value in (dx.median, dx.mean, dx.frame_mean))]
        figures = [f"{s.summaries[name].capped:.3f}" for name in columns]
        rows.append([s.protocol.name, s.info.solver, *figures, *more, f"{s.coverage:.0%}", f"{cost:.0f}"])
    table = Table(
        facts=[
            "Mean over sequences of min(error, cap of the protocol), by which boards rank; of "
            f"{_DETAILED.symbol} also how many sequences failed, the median, the mean without a cap, and that over all "
            "frames."
        ],
        head=["protocol", "solver", *labels, "failed", "median", "mean", "over frames", "coverage", "µs per frame"],
        rows=rows,
        names=2,
    )
    return "\n".join(table.markdown()).rstrip()


def _draw(dataset: Dataset, protocol: str, out: Path) -> Path:
    """The sequence that is shown, as the drawn solver sees it."""
    submission = out / f"{protocol}-{DRAWN_SOLVER}"
    return plot_to_file(dataset, shown_sequence(dataset), out / f"{protocol}.png", submissions=[submission])


def shown_sequence(dataset: Dataset) -> int:
    """The number of the sequence that a demo shows: of those of about median length, the one with the most people."""
    frames, people = dataset.rows["frames"], dataset.rows["people"]
    typical = abs(frames - sorted(frames)[len(frames) // 2]) <= 2
    return int((people * typical).argmax())
