"""Regenerates docs/results.md: the paper's solvers on Hotel, ETH and Students, under every protocol.

    VBBENCH_DATA=... python benchmarks/results_table.py [--out docs/results.md] [--work FOLDER] [--jobs 2]

Takes some minutes. Figures are means over sequences, with medians beside them; rows quoted from the paper say so.
"""

import argparse
import itertools
import tempfile
from collections.abc import Iterator
from pathlib import Path

from vbbench import __version__
from vbbench.camera import make_camera
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import summary
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.paper import Quoted, the_paper
from vbbench.protocol import PROTOCOLS
from vbbench.scoring import score
from vbbench.scoring.metrics import section
from vbbench.scoring.scorecard import Score
from vbbench.solving import hardware, solve

SPLITS = ("hotel", "eth", "students")
TIERS = ("ideal", "noisy")
SOLVERS = ("cv", "sf", "vb-cv", "vb-sf")
METRICS = {name: metric.symbol for name, metric in section("metrics").items()}

INTRODUCTION = """\
# Results

`make results` writes this page (vbbench {version}, {hardware}; σ_h = 0.07 m, seed 0). The datasets and their rules
are in [splits.md](splits.md), the solvers in [solvers.md](solvers.md), the protocols and metrics in
[protocols-and-metrics.md](protocols-and-metrics.md).

Lengths are in metres, angles in radians. Each figure is the mean, or the median, over sequences of the mean of each
sequence. Sequential and rollout errors are heavy-tailed (a few sequences with two or three people have very large
errors), so read the median too. µs per frame is the time inside the solver per frame, with two processes and with warm
compiled code. Coverage is the share of scored rows that were submitted. Estimates are never aligned to truth.

Rows marked *paper* are quoted from Table 2 of arXiv 2111.05060, not measured here. Its numbers
are reached under one-step with heights known from the given frames; under its own text (sequential, heights from their
prior only), [no implementation here gets near them](reproduce.md#readings). Its CV and SF rows fit no single
reading and are left out.

`map-causal` and `map-batch`, which are not the paper's solvers, have [separate tables](map-solver.md#figures).
"""


def main() -> None:
    arguments = _arguments()
    with tempfile.TemporaryDirectory() as scratch:
        work = arguments.work or Path(scratch)
        sections = [_section(split, work, arguments.jobs) for split in SPLITS]
    introduction = INTRODUCTION.format(version=__version__, hardware=hardware())
    table_1, results = zip(*sections, strict=True)
    page = [introduction, _table_1(table_1), *results]
    write_text_atomically(arguments.out, "\n".join(page))
    print(arguments.out)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent.parent / "docs" / "results.md")
    parser.add_argument("--work", type=Path, help="keep datasets and submissions here")
    parser.add_argument("--jobs", type=int, default=2)
    return parser.parse_args()


def _table_1(rows: tuple[str, ...]) -> str:
    head = [
        "## Datasets: the paper's Table 1\n",
        "Sequences, mean frames, people min / mean / max (Hotel and ETH without the observer, Students with it).\n",
        "| split | vbbench | the paper |",
        "|---|---|---|",
    ]
    return "\n".join([*head, *rows, ""])


def _section(split: str, work: Path, jobs: int) -> tuple[str, str]:
    """The split's row of Table 1, and its results."""
    row, parts = "", [f"## {split}\n"]
    for camera, tier in itertools.product(("panorama", "perspective"), TIERS):
        dataset = _generate(split, camera, tier, work, jobs)
        row = row or _table_1_row(split, dataset)
        quoted = the_paper().select(split, tier) if camera == "panorama" else ()
        parts.append("\n".join([f"### {split}, {camera}, {tier}\n", *_caution(dataset), *_HEAD]))
        parts[-1] += "\n" + "\n".join([*_paper_rows(quoted), *_rows(dataset, jobs)]) + "\n"
    return row, "\n".join(parts)


def _generate(split: str, camera: str, tier: str, work: Path, jobs: int) -> Dataset:
    options = Options(camera=make_camera(camera), tier=tier)
    return generate(split, work / f"{split}-{camera}-{tier}", options, jobs=jobs, overwrite=True)


def _table_1_row(split: str, dataset: Dataset) -> str:
    s = summary(dataset.info)
    people = f"{s['people_min']} / {s['people_mean']:.2f} / {s['people_max']}"
    paper = the_paper().table1[split]
    printed = f"{paper.sequences}, {paper.frames}, {paper.people}"
    return f"| {split} | {s['sequences']}, {s['mean_frames']:.2f}, {people} | {printed} |"


def _caution(dataset: Dataset) -> list[str]:
    return [f"Caution: {dataset.info.caution}.\n"] if dataset.info.caution else []


_HEAD = (
    f"| protocol | solver | {' | '.join(METRICS.values())} | {' | '.join(f'{m} median' for m in METRICS.values())} "
    "| sequences scored | coverage | µs per frame |",
    f"|---|---|{'---:|' * (2 * len(METRICS) + 3)}",
)


def _paper_rows(rows: tuple[Quoted, ...]) -> Iterator[str]:
    """Rows that have more than Δx."""
    for row in rows:
        if len(row.figures) > 1:
            figures = [f"{row.figures[name]:.3f}".removeprefix("0") if name in row.figures else "" for name in METRICS]
            yield f"| one-step | *paper* {row.solver} | {' | '.join(figures)} |{' |' * (len(METRICS) + 3)}"


def _rows(dataset: Dataset, jobs: int) -> Iterator[str]:
    for protocol, solver in itertools.product(PROTOCOLS, SOLVERS):
        out = dataset.folder.with_name(f"{dataset.folder.name}-{protocol}-{solver}")
        solve(dataset, solver, protocol, out, jobs=jobs, overwrite=True)
        yield _row(score(out, dataset.folder))


def _row(score: Score) -> str:
    means = [f"{score.summaries[name].mean:.3f}".removeprefix("0") for name in METRICS]
    medians = [f"{score.summaries[name].median:.3f}".removeprefix("0") for name in METRICS]
    scored = f"{score.sequences} of {score.total_sequences}"
    cost = f"{1e6 * (score.info.seconds_per_frame or 0.0):.0f}"
    cells = [score.protocol.name, score.info.solver, *means, *medians, scored, f"{score.coverage:.0%}", cost]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
