"""The paper's Tables 2 and 3 as a report: its figures beside ours, its way of averaging and ours, and a picture."""

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from vbbench.paper import COLUMNS, HEADLINE, SIGMA_H, the_paper
from vbbench.reproduction.report import Report
from vbbench.reproduction.tables.solver_figure import plot_solver_table
from vbbench.reproduction.tables.solver_tables import SolverRow, SolverTable, counterpart
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import interval_text
from vbbench.table import Table

_LABELS = tuple(METRICS[metric].label for metric in COLUMNS)
_DX = METRICS[HEADLINE].symbol


def solver_table_report(found: SolverTable) -> Report:
    """Times the paper's at a glance, then two tables for each recording: over frames, and over sequences."""
    study = found.study
    tables = [_at_a_glance(found)] if found.measured and SIGMA_H in study.sigmas else []
    for split in found.measured:
        tables += [_over_frames(found, split), _over_sequences(found, split)]
    return Report(
        name=f"table{study.table}",
        title=f"Table {study.table}: every solver, panorama, tier ideal, {conditions(found)}",
        facts=[*_facts(found)],
        tables=tables,
        values=solver_table_values(found),
        pictures={"": plot_solver_table(found, conditions(found))} if found.measured else {},
        whole=not found.missing and not any(own.simulated for own in found.measured.values()),
    )


def conditions(found: SolverTable) -> str:
    """Which sequences were used, as text."""
    counts = ", ".join(f"{found.name(split)} {own.sequences}" for split, own in found.measured.items())
    return f"seed {found.study.seed}, sequences: {counts or 'none'}"


def _facts(found: SolverTable) -> Iterator[str]:
    yield (
        "The paper: the first two positions of everybody are given and the rest is estimated one after the other "
        "(here: `sequential`); of heights nothing but N(1.70, σ_h²) m is known; recordings are scaled to [−8, 8] m; ± "
        f"is over frames. Quoted are its means at σ_h = {SIGMA_H:g} m, from `vbbench/paper.toml`. Its ± and its rows "
        "at other σ_h are not quoted there, so ours stand alone."
    )
    yield (
        "Here: metres, exact boxes, a panorama, and both protocols, because the paper's figures are reached under "
        "`one-step`, where the true last two frames are given at every step, and not under its own text: `vbbench "
        "reproduce readings` tries every reading. `vb-cv` and `vb-sf` learn each person's height where positions are "
        "given, and expect the observer to walk like the others, which the text does not. Under `one-step` one given "
        "frame tells a height exactly, so that σ_h does not matter; under `sequential` who arrives late is given a "
        "place but is seen from a pose that is itself an estimate. `map-causal` and `map-batch`, no solvers of the "
        "paper, measure distances by the feet, too, and σ_h hardly matters to them. `vb-sf-literal` is the paper to "
        "the letter and learns no height: with σ_h = 0 all are given to it."
    )
    yield (
        "`cv` and `sf` look at a box only to place somebody of whom nothing else is known. The paper's CV and SF fit "
        "no reading: ours are below them under `one-step`, which asks for one frame, and above them under "
        "`sequential`, where a straight line goes on to the end of the sequence. `vb-sf-literal`, `map-causal` and "
        "`map-batch` are compared with the paper's VB-SF."
    )
    if found.study.table == 3:
        yield (
            "On Shibuya `one-step` says little: boxes of heads jitter by more than people move in the 0.04 s from "
            "frame to frame, so tracks are smoothed, and on smooth tracks the last two frames predict the next one "
            "almost exactly. The paper does not say how smooth its tracks are; its figures cannot be compared with "
            "one-step figures here."
        )
    for split, own in found.measured.items():
        if own.simulated:
            yield (
                f"**`{split}` is a stand-in**, because CroHD is not here (`vbbench fetch {split}` gets it): a crowd "
                "was simulated, recorded by a camera above it, annotated as CroHD is, and lifted like it. These "
                "figures reproduce nothing of the paper's. They say what this table is like on a crowd of that kind, "
                "and the ratios are for scale only."
            )
    yield from found.missing.values()


def _at_a_glance(found: SolverTable) -> Table:
    """Δx at the paper's σ_h over frames, by solver, protocol and split, with how many times the paper's it is."""
    protocols, splits = found.study.protocols, list(found.measured)
    combinations = [*itertools.product(protocols, splits)]
    rows = []
    for solver in found.study.solvers:
        own = [found.one(split, protocol, SIGMA_H, solver) for protocol, split in combinations]
        cells = [_with_ratio(f"{_size(row.summaries[HEADLINE].frame_mean)}", row.times_the_paper()) for row in own]
        times = [_ratio(found.times_the_paper(protocol, solver)) for protocol in protocols]
        rows.append([f"`{solver}`", counterpart(solver), *cells, *times])
    return Table(
        title=f"{_DX} at a glance, σ_h = {SIGMA_H:g} m",
        facts=[
            f"{METRICS[HEADLINE].label}, mean over frames (in brackets: divided by the paper's). Last columns: "
            "geometric mean of these ratios over the recordings."
        ],
        head=[
            "solver",
            "compared with",
            *(f"{protocol}, {found.name(split)}" for protocol, split in combinations),
            *(f"{protocol}: times the paper's" for protocol in protocols),
        ],
        rows=rows,
        names=2,
    )


def _over_frames(found: SolverTable, split: str) -> Table:
    own = found.measured[split]
    paper = [
        ["the paper", f"{SIGMA_H:g}", row.solver, *(_three(row.figures.get(metric)) for metric in COLUMNS)]
        for row in the_paper().select(split)
    ]
    caution = [f"Caution: {own.caution}."] if own.caution else []
    return Table(
        title=f"{found.name(split)}, the paper's way: mean ± standard deviation over frames",
        facts=[f"{own.title}; {own.sequences} sequences. In brackets: divided by the paper's.", *caution],
        head=["protocol", "σ_h (m)", "solver", *_LABELS],
        rows=[*paper, *([*_names(row), *(_frames_cell(row, metric) for metric in COLUMNS)] for row in found.of(split))],
        names=3,
    )


def _over_sequences(found: SolverTable, split: str) -> Table:
    return Table(
        title=f"{found.name(split)}, over sequences",
        facts=[
            "Mean over sequences [95 % interval]; then the capped mean, by which boards rank, and the share of "
            f"sequences that failed, both of {_DX}. {_intervals(found.of(split))}"
        ],
        head=["protocol", "σ_h (m)", "solver", *_LABELS, f"{_DX} capped (m)", f"{_DX} failed"],
        rows=[[*_names(row), *_sequence_cells(row)] for row in found.of(split)],
        names=3,
    )


def _intervals(rows: Sequence[SolverRow]) -> str:
    blocks = [row.summaries[HEADLINE].blocks for row in rows]
    if all(np.isnan(row.summaries[HEADLINE].ci95).any() for row in rows):
        return f"No intervals: {max(blocks):.1f} blocks of time are too few for honest ones."
    least, most = f"{min(blocks):.0f}", f"{max(blocks):.0f}"
    count = least if least == most else f"{least} to {most}"
    return f"Intervals are from a block bootstrap over time, with {count} blocks."


def _names(row: SolverRow) -> list[str]:
    answered = "" if row.coverage == 1.0 else f" (answered {row.coverage:.1%})"
    return [row.protocol, f"{row.sigma_h:g}", f"`{row.solver}`{answered}"]


def _frames_cell(row: SolverRow, metric: str) -> str:
    own = row.summaries[metric]
    return _with_ratio(f"{_size(own.frame_mean)} ± {_size(own.frame_std)}", row.times_the_paper(metric))


def _sequence_cells(row: SolverRow) -> Iterator[str]:
    for metric in COLUMNS:
        own = row.summaries[metric]
        yield _size(own.mean) if np.isnan(own.ci95).any() else f"{_size(own.mean)} [{interval_text(own.ci95)}]"
    own = row.summaries[HEADLINE]
    yield _size(own.capped)
    yield f"{own.failure_rate:.1%}"


def _size(value: float) -> str:
    """Four decimals; two digits of what is smaller than 0.001."""
    return f"{value:.4f}" if value >= 0.001 else _two_digits(value)


def _with_ratio(text: str, ratio: float) -> str:
    return f"{text} ({_ratio(ratio)})" if _ratio(ratio) else text


def _ratio(value: float) -> str:
    """Two decimals; two digits of what is smaller than 0.1; nothing where the paper has no figure."""
    return "" if np.isnan(value) else f"{value:.2f}" if value >= 0.1 else _two_digits(value)


def _two_digits(value: float) -> str:
    return "< 0.00001" if value < 1e-5 else np.format_float_positional(value, 2, fractional=False, trim="-")


def _three(value: float | None) -> str:
    return "" if value is None else f"{value:.3f}"


def solver_table_values(found: SolverTable) -> dict[str, Any]:
    """Every figure: the study, the paper's rows, and a row for each combination with all metrics."""
    study = found.study
    return {
        "table": study.table,
        "every": study.every,
        "seed": study.seed,
        "recordings": {split: dict(vars(own)) for split, own in found.measured.items()},
        "missing": dict(found.missing),
        "paper": {split: _quoted(split) for split in study.splits},
        "rows": [_row_values(row) for row in found.rows],
    }


def _quoted(split: str) -> dict[str, dict[str, float]]:
    return {row.solver: dict(row.figures) for row in the_paper().select(split)}


def _row_values(row: SolverRow) -> dict[str, Any]:
    times = {metric: row.times_the_paper(metric) for metric in COLUMNS}
    return {
        "split": row.split,
        "protocol": row.protocol,
        "sigma_h": row.sigma_h,
        "solver": row.solver,
        "compared_with": counterpart(row.solver),
        "coverage": row.coverage,
        "figures": {metric: summary.to_dict() for metric, summary in row.summaries.items()},
        "times_the_paper": times,
    }
