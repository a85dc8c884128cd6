"""Speed of scoring a split of the size of Students, against pandas with a Python loop over rows.

Run from the repository: ``python -m benchmarks.bench_scoring [--quick]``. The loop scores the first sequences only,
which is extrapolated by rows; its bootstrap (one resample after the other) is run in full for one metric, times six.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd

from tests.lib.answers import submit, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from tests.lib.slow_score import bootstrap, score_rows
from vbbench.scoring import score

STUDENTS = Crowd(scenes=2, people=425, frames=435, stay=(47, 51), seed=1)
QUICK = Crowd(scenes=2, people=30, frames=80, stay=(46, 50), seed=1)
LOOPED = {"iterrows": 40, "itertuples": 400}
"""Ways to loop over the rows of a pandas table, and how many sequences are scored in each."""


def main(crowd: Crowd) -> None:
    with tempfile.TemporaryDirectory() as name:
        data, answer = Path(name) / "data", Path(name) / "answer"
        write_dataset(data, crowd)
        submit(answer, data, true_answers(data, 0.1))
        counts = pd.read_parquet(data / "observations.parquet", columns=["sequence"]).value_counts(sort=False)
        fast = min(_seconds(score, answer, data)[0] for _ in range(3))
        figures = list(score(answer, data).per_sequence.figures["dx"])
        print(f"{len(counts)} sequences, {counts.sum()} observations; score: {fast:.2f} s")
        print(f"{'per-row loop over pandas':<28}{'rows s':>9}{'bootstrap s':>13}{'ratio':>8}")
        resampling = 6 * _seconds(bootstrap, figures)[0]
        for each, looped in LOOPED.items():
            reading = _seconds(score_rows, data, answer, sequences=1, each=each)[0]
            rows = _seconds(score_rows, data, answer, sequences=looped, each=each)[0] - reading
            slow = reading + rows * counts.sum() / counts.iloc[1:looped].sum()
            print(f"{each:<28}{slow:>9.1f}{resampling:>13.1f}{(slow + resampling) / fast:>7.0f}x")


def _seconds(function: Callable[..., Any], *arguments: Any, **options: Any) -> tuple[float, Any]:
    start = time.perf_counter()
    result = function(*arguments, **options)
    return time.perf_counter() - start, result


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a small crowd")
    main(QUICK if parser.parse_args().quick else STUDENTS)
