"""vb-former: frames a second of processor time on one core over people K, and how many times as fast others are.

The crowd is that of `bench_estimator` with an uncertain calibration, followed from the first two frames on. The best of
some runs counts; on a busy machine the ratios say more than the frames.

    python -m benchmarks.bench_former [--people 5 20 60] [--solvers vb-sf map-causal] [--runs 5]
"""

import argparse
from time import process_time

import numpy as np

from benchmarks.bench_estimator import crowd
from vbbench.registry import load
from vbbench.solver import Frame, FrameSolver
from vbbench.solving.runner import given_at


def seconds_per_frame(solver: FrameSolver, people: int, runs: int) -> float:
    """The least of ``runs`` runs, the first of one more left out; the two frames that are given are not counted."""
    seen = crowd(people)
    frames = [Frame(index=t, observations=boxes, given=given_at(seen.given, t)) for t, boxes in enumerate(seen.boxes)]
    best = np.inf
    for run in range(runs + 1):
        solver.start(seen.problem)
        for frame in frames[:2]:
            solver.step(frame)
        started = process_time()
        for frame in frames[2:]:
            solver.step(frame)
        if run:
            best = min(best, (process_time() - started) / len(frames[2:]))
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description="Frames a second of vb-former beside others.")
    parser.add_argument("--people", type=int, nargs="+", default=[5, 20, 60])
    parser.add_argument("--solvers", nargs="*", default=["vb-sf", "map-causal"])
    parser.add_argument("--runs", type=int, default=5)
    chosen = parser.parse_args()
    print("people  " + "  ".join(f"{name:>12s} f/s" for name in ("vb-former", *chosen.solvers)))
    for people in chosen.people:
        own, *others = (
            seconds_per_frame(load("solver", name)(), people, chosen.runs) for name in ("vb-former", *chosen.solvers)
        )
        told = [f"{1.0 / other:8,.0f} ({own / other:.2f}x)" for other in others]
        print(f"{people:6d}  {1.0 / own:16,.0f}  " + "  ".join(told))


if __name__ == "__main__":
    main()
