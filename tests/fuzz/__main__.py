"""``python -m tests.fuzz [KIND ...] [--cases N] [--first N] [--case N]``: run the fuzzer by hand."""

import argparse
import sys
from functools import partial

from tests.fuzz.running import KINDS, run

if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("kinds", nargs="*", metavar="KIND", help=f"one of {', '.join(KINDS)}; default: all")
    parser.add_argument("--cases", type=int, default=10_000, help="how many, over all kinds")
    parser.add_argument("--first", type=int, default=0, help="number of every kind's first case")
    parser.add_argument("--case", type=int, help="run only this case of one kind")
    asked = parser.parse_args()
    if unknown := [name for name in asked.kinds if name not in KINDS]:
        parser.error(f"no kind is called {unknown[0]}; known: {', '.join(KINDS)}")
    chosen = [KINDS[name] for name in asked.kinds or KINDS]
    cases, first = (1, asked.case) if asked.case is not None else (asked.cases, asked.first)
    tally, broken = run(chosen, cases, first=first, on_fault=partial(print, flush=True))
    summary = (
        f"{tally.read} read, {tally.refused} refused, {len(broken)} broken; "
        f"{len(tally.kinds)} kinds, slowest case {tally.slowest:.2f} s of processor time"
    )
    print(summary)  # noqa: T201
    sys.exit(bool(broken))
