"""The figure over σ_h as files: Markdown table, CSV and picture."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path

from vbbench.folders.replacing import write_text_atomically
from vbbench.reproduction.curves import PANELS, Statistic
from vbbench.reproduction.sigma import Curve, SigmaFigure, measure_sigma
from vbbench.reproduction.study import SigmaStudy, title_of
from vbbench.scoring.metrics import METRICS

NAME = "figure-sigma"
COLUMNS = ("solver", "sigma_h", "people", "sequences", "seen", "coverage", "metric", "mean", "low", "high", "median")


def reproduce_sigma(study: SigmaStudy, out: Path | str, *, jobs: int = 1, overwrite: bool = False) -> str:
    """Measure, write ``figure-sigma.md``, ``.csv`` and ``.png`` into ``out``, and return the table and their paths.

    Raises
    ------
    VbbenchError
        As `vbbench.reproduction.sigma.measure_sigma` does.
    """
    from vbbench.reproduction.sigma_plot import plot_sigma_to_file

    figure = measure_sigma(study, out, jobs=jobs, overwrite=overwrite)
    files = [Path(out) / f"{NAME}{suffix}" for suffix in (".md", ".csv", ".png")]
    table = sigma_table(figure)
    write_text_atomically(files[0], table)
    write_text_atomically(files[1], sigma_csv(figure))
    plot_sigma_to_file(figure, files[2])
    return "\n".join([table, *map(str, files)])


def sigma_table(figure: SigmaFigure) -> str:
    """A Markdown table a solver: a row for each metric and σ_h, a column for each K."""
    heading = [
        f"# Errors over the number of people: {figure.conditions}",
        "Mean over sequences [95 % bootstrap interval] by the number K of people in the scene, the observer included. "
        "Last column: change of the mean (of the median) from the fewest people to the most.",
    ]
    return "\n\n".join([*heading, *(_solver_table(name, curves) for name, curves in figure.solvers.items())]) + "\n"


def sigma_csv(figure: SigmaFigure) -> str:
    """Every number of the figure: a row for each solver, σ_h (m), K and metric (m, rad)."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for curve in figure.curves:
        for point in curve.points:
            head = (curve.solver, curve.sigma_h, point.people, point.sequences, point.seen, point.coverage)
            for metric, s in point.statistics.items():
                writer.writerow([*head, metric, s.mean, s.low, s.high, s.median])
    return text.getvalue()


def _solver_table(solver: str, curves: list[Curve]) -> str:
    points = curves[0].points
    lines = [
        f"| | σ_h (m) | {' | '.join(f'K = {point.people}' for point in points)} | change |",
        f"|---|---|{'---|' * (len(points) + 1)}",
        *(_row(metric, curve) for metric in PANELS for curve in curves),
    ]
    return "\n\n".join([f"## {title_of(solver)}", "\n".join(_facts(solver, curves)), "\n".join(lines)])


def _facts(solver: str, curves: list[Curve]) -> Iterator[str]:
    """What the table rests on, one line a fact."""
    points = curves[0].points
    yield f"- solver `{solver}`"
    yield f"- sequences at each K: {_each(str(point.sequences) for point in points)}"
    yield f"- people scored in a frame: {_each(f'{point.seen:.1f}' for point in points)}"
    if fallbacks := [curve.fallback_frames for curve in curves if curve.fallback_frames is not None]:
        yield f"- frames decided by the observer's own prior, at each σ_h: {_each(map(str, fallbacks))}"
    if (coverage := min(point.coverage for curve in curves for point in curve.points)) < 1.0:
        yield f"- coverage: {coverage:.1%} at least; missing answers are held, not left out"


def _each(texts: Iterator[str]) -> str:
    return ", ".join(texts)


def _row(metric: str, curve: Curve) -> str:
    own = [point.statistics[metric] for point in curve.points]
    cells = [_cell(statistic) for statistic in own]
    return f"| {METRICS[metric].label} | {curve.sigma_h:g} | {' | '.join(cells)} | {_change(own[0], own[-1])} |"


def _cell(statistic: Statistic) -> str:
    return f"{statistic.mean:.4f} [{statistic.low:.4f}, {statistic.high:.4f}]"


def _change(first: Statistic, last: Statistic) -> str:
    """From the fewest people to the most, of the mean and of the median."""
    if not (first.mean > 0.0 and first.median > 0.0):
        return "–"
    return f"{last.mean / first.mean - 1.0:+.0%} ({last.median / first.median - 1.0:+.0%})"
