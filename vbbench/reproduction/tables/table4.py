"""The paper's Table 4: split `street`, one-step, with both of its inputs, beside what the paper prints."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from vbbench.folders.locks import loose_files
from vbbench.generation.generator import Options, Simulation
from vbbench.paper import the_paper
from vbbench.reproduction.making import Making
from vbbench.reproduction.report import Report, Table
from vbbench.scoring.metrics import METRICS

SPLIT, PROTOCOL, NAME = "street", "one-step", "table4"
SOLVERS = ("vb-sf", "vb-cv")
INPUTS = {"cline": "ideal", "tracked": "tracked"}
"""The paper's inputs, and their tiers."""
COLUMNS = ("dx_rel", "dx", "dr", "dt")
"""The metrics of the paper's table."""


@dataclass(frozen=True, kw_only=True)
class Table4Study:
    """What to measure.

    Parameters
    ----------
    solvers : registered names or ``module:attribute``.
    sequences : of each input; ``None`` for as many as the scenario has.
    seed : of the datasets.
    """

    solvers: Sequence[str] = SOLVERS
    sequences: int | None = None
    seed: int = 0


@dataclass(frozen=True, kw_only=True)
class Table4:
    """The results: how many sequences, and the means by input and solver."""

    study: Table4Study
    sequences: int
    means: Mapping[str, Mapping[str, Mapping[str, float]]]


def measure_table4(study: Table4Study, out: Path | str, making: Making = Making()) -> Table4:  # noqa: B008
    """Generate, solve and score; datasets and submissions are kept in ``out``, and complete ones reused.

    Raises
    ------
    VbbenchError
        If an argument is invalid, or another dataset or submission is in the way.
    """
    means, sequences, out = {}, 0, Path(out)
    simulation = None if study.sequences is None else Simulation(sequences=study.sequences)
    with loose_files(out):
        for name, tier in INPUTS.items():
            options = Options(tier=tier, seed=study.seed, simulation=simulation)
            dataset = making.dataset(SPLIT, out / name / "dataset", options)
            sequences = len(dataset)
            means[name] = {
                solver: {metric: found.summaries[metric].mean for metric in COLUMNS}
                for solver, found in making.scores(dataset, study.solvers, PROTOCOL)
            }
    return Table4(study=study, sequences=sequences, means=means)


def table4_report(found: Table4) -> Report:
    """A row for each input, of the paper and of every solver."""
    rows = [_row("the paper", name, _printed(tier)) for name, tier in INPUTS.items()]
    for name, own in found.means.items():
        rows += [_row(f"`{solver}`", name, figures.values()) for solver, figures in own.items()]
    return Report(
        name=NAME,
        title=f"Table 4: split {SPLIT}, {PROTOCOL}, seed {found.study.seed}; means over {found.sequences} sequences",
        tables=[Table(head=["", "input", *(METRICS[metric].label for metric in COLUMNS)], rows=rows, names=2)],
        values={"sequences": found.sequences, "seed": found.study.seed, "means": found.means},
    )


def _printed(tier: str) -> tuple[float, ...]:
    """The paper's row on that input; its centre lines were drawn by hand."""
    (row,) = the_paper().select(SPLIT, tier)
    return tuple(row.figures[metric] for metric in COLUMNS)


def _row(who: str, name: str, values: Iterable[float]) -> list[str]:
    return [who, name, *(f"{value:.4f}" for value in values)]
