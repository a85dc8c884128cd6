"""Two results of one board side by side, sequence by sequence, with the statistics of ``vbbench compare``."""

from collections.abc import Sequence
from dataclasses import dataclass

from vbbench.geometry import FloatArray, IntArray
from vbbench.scoring.block_bootstrap import block_means
from vbbench.scoring.metrics import METRICS
from vbbench_leaderboards.results.ranking import capped_table
from vbbench_leaderboards.results.result import Result


@dataclass(frozen=True, kw_only=True)
class Contrast:
    """One metric of two solvers: mean over sequences of (a − b), both capped, so that below 0 ``a`` is better.

    Parameters
    ----------
    difference, low, high : the mean and its 95 % interval, in the metric's unit; NaN where there is none.
    p : two-sided, for this pair alone; NaN without an interval.
    sequences, won : how many have a figure of both, and in how many of them ``a`` is better.
    """

    difference: float
    low: float
    high: float
    p: float
    sequences: int
    won: int


@dataclass(frozen=True, kw_only=True)
class Contrasts:
    """Every two solvers of a board.

    Parameters
    ----------
    solvers : their names.
    sequences : [N] numbers of the sequences.
    figures : [solvers, N, metrics] capped errors, NaN where there is none; metrics in the order of `METRICS`.
    pairs : (a, b), numbers of solvers with a < b → metric → their difference.
    """

    solvers: tuple[str, ...]
    sequences: IntArray
    figures: FloatArray
    pairs: dict[tuple[int, int], dict[str, Contrast]]


def contrasts(results: Sequence[Result]) -> Contrasts:
    """Every two results of one board, ranked together or not, as ``vbbench compare`` compares their submissions."""
    timeline, sequences, figures = capped_table(results)
    pairs = {}
    for a in range(len(results)):
        for b in range(a + 1, len(results)):
            differences = figures[a] - figures[b]
            means = block_means(timeline, differences)
            known, won = (differences == differences).sum(axis=0), (differences < 0).sum(axis=0)
            columns = zip(METRICS, means.mean, means.interval(), means.p_values(), known, won, strict=True)
            pairs[a, b] = {
                metric: Contrast(
                    difference=float(mean), low=float(low), high=float(high), p=float(p), sequences=int(n), won=int(w)
                )
                for metric, mean, (low, high), p, n, w in columns
            }
    return Contrasts(
        solvers=tuple(result.solver for result in results), sequences=sequences, figures=figures, pairs=pairs
    )
