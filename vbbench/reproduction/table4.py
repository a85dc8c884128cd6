"""The paper's Table 4: split `street`, one-step, with both of its inputs, beside what the paper prints."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation.generator import Options, Simulation
from vbbench.paper import the_paper
from vbbench.reproduction.reuse import ensure_dataset, ensure_scores
from vbbench.scoring.metrics import METRICS

SPLIT, PROTOCOL, NAME = "street", "one-step", "table4"
SOLVERS = ("vb-sf", "vb-cv")
INPUTS = {"cline": "ideal", "tracked": "tracked"}
"""The paper's inputs, and their tiers."""
COLUMNS = ("dx_rel", "dx", "dr", "dt")
"""The metrics of the paper's table."""


def reproduce_table4(
    out: Path | str,
    *,
    solvers: Sequence[str] = SOLVERS,
    sequences: int | None = None,
    seed: int = 0,
    jobs: int = 1,
    overwrite: bool = False,
) -> str:
    """Generate, solve and score, write ``table4.md`` into ``out``, and return the table and its path.

    Datasets and submissions are kept in ``out``; complete ones are reused.

    Parameters
    ----------
    sequences : of each input; ``None`` for as many as the scenario has.

    Raises
    ------
    VbbenchError
        If an argument is invalid, or another dataset or submission is in the way.
    """
    out = Path(out)
    heads = " | ".join(METRICS[metric].label for metric in COLUMNS)
    rows = [f"| | input | {heads} |", f"|---|---|{'---|' * len(COLUMNS)}"]
    rows += [_row("the paper", name, _printed(tier)) for name, tier in INPUTS.items()]
    simulation = None if sequences is None else Simulation(sequences=sequences)
    with loose_files(out):
        for name, tier in INPUTS.items():
            options = Options(tier=tier, seed=seed, simulation=simulation)
            dataset = ensure_dataset(SPLIT, out / name / "dataset", options, jobs=jobs, overwrite=overwrite)
            for solver, found in ensure_scores(dataset, solvers, PROTOCOL, jobs=jobs, overwrite=overwrite):
                rows.append(_row(f"`{solver}`", name, (found.summaries[metric].mean for metric in COLUMNS)))
        heading = f"# Table 4: split {SPLIT}, {PROTOCOL}, seed {seed}; means over {len(dataset)} sequences"
        path = out / f"{NAME}.md"
        text = "\n".join([heading, "", *rows]) + "\n"
        write_text_atomically(path, text)
    return f"{text}\n{path}"


def _printed(tier: str) -> tuple[float, ...]:
    """The paper's row on that input; its centre lines were drawn by hand."""
    (row,) = the_paper().select(SPLIT, tier)
    return tuple(row.figures[metric] for metric in COLUMNS)


def _row(who: str, name: str, values: Iterable[float]) -> str:
    return f"| {who} | {name} | {' | '.join(f'{value:.4f}' for value in values)} |"
