"""Figures of a solver on a family, and the table of all of them."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from benchmarks.real_camera.measuring import Runs
from vbbench.geometry import FloatArray

NAIVE = "ground-plane"
"""Name of the rows to which all others are compared."""
HEAD = (
    *("family", "solver", "Δx", "Δt", "Δx̃", "capped Δx", "Δt", "Δx̃", "in 2σ: poses, people"),
    *("squares", "worst run: Δx, Δt", "m/s", "runs", "frames/s"),
)


@dataclass(frozen=True, kw_only=True)
class Row:
    """A solver on a family; NaN where nothing is known.

    Parameters
    ----------
    family, solver : their names.
    plain : means over runs of Δx, Δt and Δx̃ in m, the last in the axes of the camera.
    capped : the same of errors that count at most as the protocol says.
    held : shares of poses and people within 2 σ, means over runs; .954 is correct.
    squares : squared errors of poses and people by their covariances, for each degree of freedom: medians over runs.
    worst : largest Δx and Δt of a run, in m.
    pace : m/s of the estimated camera, mean over runs.
    runs : how many.
    rate : frames/s, median over runs.
    """

    family: str
    solver: str
    plain: tuple[float, ...]
    capped: tuple[float, ...]
    held: tuple[float, ...]
    squares: tuple[float, ...]
    worst: tuple[float, ...]
    pace: float
    runs: int
    rate: float

    @staticmethod
    def of(family: str, solver: str, runs: Runs, caps: Sequence[float]) -> "Row":
        """The figures of some runs, by the ``caps`` of Δx, Δt and Δx̃."""
        errors = (runs.dx, runs.dt, runs.dx_camera)
        return Row(
            family=family,
            solver=solver,
            plain=tuple(_mean(values) for values in errors),
            capped=tuple(_mean(np.minimum(values, cap)) for values, cap in zip(errors, caps, strict=True)),
            held=(_mean(runs.pose_held), _mean(runs.people_held)),
            squares=(_median(runs.pose_squares), _median(runs.people_squares)),
            worst=(_most(runs.dx), _most(runs.dt)),
            pace=_mean(runs.pace),
            runs=len(runs),
            rate=_median(runs.rate),
        )

    def values(self) -> dict[str, object]:
        """For JSON: figures that are not known are ``None``."""
        return {name: _known(value) for name, value in asdict(self).items()}

    def headline(self) -> str:
        """Capped Δx in m; capped Δx̃ where truth is relative, and the camera's speed where there is no truth."""
        dx, _, dx_camera = self.capped
        if not np.isnan(dx):
            return figure(dx)
        return f"{figure(self.pace)} m/s" if np.isnan(dx_camera) else f"{figure(dx_camera)} Δx̃"

    def cells(self, naive: "Row") -> Iterator[str]:
        """What stands in the table; errors have the ratio to those of ``naive`` next to them."""
        yield from (self.family, self.solver)
        for own, others in ((self.plain, naive.plain), (self.capped, naive.capped)):
            for value, other in zip(own, others, strict=True):
                shown = self is not naive and np.isfinite([value, other]).all() and other > 0.0
                yield figure(value) + (f" (×{value / other:.2f})" if shown else "")
        yield ", ".join(map(figure, self.held))
        yield ", ".join(map(figure, self.squares))
        yield ", ".join(map(figure, self.worst))
        yield figure(self.pace)
        yield str(self.runs)
        yield "–" if np.isnan(self.rate) else f"{self.rate:.0f}"


def figure(value: float) -> str:
    """Three digits at most, without a leading zero."""
    if np.isnan(value):
        return "–"
    text = f"{value:.{3 if abs(value) < 1.0 else 2 if abs(value) < 10.0 else 1}f}"
    return text.removeprefix("0") if text.startswith("0.") else text


def lines(cells: Sequence[Sequence[str]]) -> Iterator[str]:
    """A Markdown table below `HEAD`."""
    yield "| " + " | ".join(HEAD) + " |"
    yield "|---" * 2 + "|---:" * (len(HEAD) - 2) + "|"
    yield from ("| " + " | ".join(row) + " |" for row in cells)


def brief(groups: Sequence[Sequence[Row]]) -> str:
    """The Markdown table of docs/families.md: a row a family, a column a solver, `Row.headline` in the cells."""
    solvers = list(dict.fromkeys(row.solver for group in groups for row in group))
    rows = [f"| family | {' | '.join(f'`{solver}`' for solver in solvers)} |", "|---|" + "---:|" * len(solvers)]
    for group in groups:
        cells = {row.solver: row.headline() for row in group}
        rows += [f"| {group[0].family} | {' | '.join(cells.get(solver, '') for solver in solvers)} |"] if group else []
    return "".join(f"{row}\n" for row in rows)


def written(page: str, table: str) -> str:
    """The page with this table in place of its own."""
    return re.sub(r"(?m)^\| family \| `.*\n(?:\|.*\n)+", lambda _: table, page)


def _known(value: object) -> object:
    if isinstance(value, tuple | list):
        return [_known(one) for one in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _mean(values: FloatArray) -> float:
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else np.nan


def _median(values: FloatArray) -> float:
    known = values[~np.isnan(values)]
    return float(np.median(known)) if len(known) else np.nan


def _most(values: FloatArray) -> float:
    known = values[~np.isnan(values)]
    return float(known.max()) if len(known) else np.nan
