"""How many sequences separate a board's leader from the second, by the errors in the published results.

``python -m benchmarks.separation [--results leaderboards/results] [--boards kitti/sequential-footage,...]``. On each
board the differences of the two solvers' capped Δx are drawn again, N at a time, as if sequences were independent. They
are separated where the 95 % interval of the mean of N differences does not hold 0. Printed is the least N at which four
draws in five separate them.
"""

import argparse
from pathlib import Path

import numpy as np
from scipy.stats import t as student

from vbbench.geometry import FloatArray
from vbbench.scoring.metrics import METRICS
from vbbench_leaderboards.results.folder import read_results
from vbbench_leaderboards.results.ranking import capped_errors

METRIC = "dx"
DRAWS, POWER, LEVEL = 2000, 0.8, 0.05
COUNTS = (5, 8, 12, 20, 30, 50, 80, 120, 200, 300, 500, 800, 1200, 2000)
BOARDS = ",".join(
    f"{split}/{protocol}-{tier}"
    for split, tier in (("kitti", "footage"), ("street", "field"), ("hotel", "field"), ("students-resampled", "field"))
    for protocol in ("sequential", "rollout", "cold-start")
)


def separated(differences: FloatArray, count: int, rng: np.random.Generator) -> float:
    """The share of draws of ``count`` of the differences [N] whose mean is not 0 by its interval."""
    drawn = rng.choice(differences, (DRAWS, count))
    half = student.ppf(1.0 - 0.5 * LEVEL, count - 1) * drawn.std(axis=1, ddof=1) / np.sqrt(count)
    return float((np.abs(drawn.mean(axis=1)) > half).mean())


def sequences_needed(differences: FloatArray, seed: int = 0) -> int | None:
    """The least of the `COUNTS` at which `POWER` of the draws are separated; ``None`` where none is."""
    rng = np.random.default_rng(seed)
    return next((count for count in COUNTS if separated(differences, count, rng) >= POWER), None)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=Path, default=Path("leaderboards/results"))
    parser.add_argument("--boards", default=BOARDS)
    options = parser.parse_args()
    boards = {board.key: results for board, results in read_results(options.results).items()}
    print("| board | sequences | leader, second | Δx | difference ± sd | needed |\n|---|---|---|---|---|---|")
    for key in options.boards.split(","):
        causal = [one for one in boards.get(key, []) if not one.about.sees_the_future]
        if len(causal) < 2:
            continue
        figures = capped_errors(causal)[0][..., list(METRICS).index(METRIC)]
        best, second = np.argsort(np.nanmean(figures, axis=1))[:2].tolist()
        differences = figures[second] - figures[best]
        differences = differences[np.isfinite(differences)]
        means = " / ".join(f"{np.nanmean(figures[one]):.3f}" for one in (best, second))
        print(
            f"| {key} | {len(differences)} | {causal[best].solver}, {causal[second].solver} | {means} "
            f"| {differences.mean():.3f} ± {differences.std(ddof=1):.3f} "
            f"| {sequences_needed(differences) or f'over {COUNTS[-1]}'} |"
        )


if __name__ == "__main__":
    main()
