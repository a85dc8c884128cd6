"""Solvers on every family of recordings, next to the naive ``ground-plane``, as a Markdown table.

    python -m benchmarks.families map-causal vb-sf [--only robot,kitti] [--jobs 2] [--json families.json] [--page FILE]

A solver is a registered name or ``module:attribute``. ``--only`` takes names of families, or how they begin; ``--list``
prints them. ``--data`` is the folder of the recordings ($VBBENCH_DATA); families whose recordings are not there are
left out, with a line that says so. Datasets are kept in ``--cache``. ``--smoke`` solves a few small ones without data.
"""

import argparse
import json
import os
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter

from benchmarks.families.families import Family, families
from benchmarks.families.places import Places
from benchmarks.families.table import NAIVE, Row, brief, lines, written
from benchmarks.real_camera.measuring import measure
from vbbench.errors import SourceMissingError, VbbenchError
from vbbench.protocol import get_protocol

NAIVE_SOLVER = "vbbench_baselines.ground_plane:GroundPlane"


def chosen(only: str, *, smoke: bool) -> list[Family]:
    """The families whose names begin with one of those asked for.

    Raises
    ------
    VbbenchError
        If none begins with one of them.
    """
    known, names = families(smoke=smoke), [name.strip() for name in only.split(",") if name.strip()]
    for name in names:
        if not any(family.name.startswith(name) for family in known):
            there = ", ".join(family.name for family in known)
            raise VbbenchError(f"no family begins with '{name}'; there are {there}")
    return [family for family in known if not names or any(family.name.startswith(name) for name in names)]


def rows(family: Family, solvers: list[str], places: Places) -> Iterator[Row]:
    """The rows of a family, first that of the naive solver; none if its recordings are missing."""
    try:
        trial = family.make(places)
    except SourceMissingError as error:
        print(f"{family.name} is left out: {error}", file=sys.stderr, flush=True)
        return
    rules = get_protocol(trial.protocol)
    caps = [rules.caps[name] for name in ("dx", "dt", "dx_rel")]
    for name in dict.fromkeys([NAIVE, *solvers]):
        started = perf_counter()
        runs = measure(trial, NAIVE_SOLVER if name == NAIVE else name, jobs=places.jobs)
        print(f"{family.name}, {name}: {perf_counter() - started:.1f} s", file=sys.stderr, flush=True)
        yield Row.of(family.name, name, runs, caps)


def write_json(path: Path, found: list[list[Row]]) -> None:
    """All figures so far."""
    values = [row.values() for group in found for row in group]
    path.write_text(json.dumps(values, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("solvers", nargs="*", metavar="SOLVER")
    parser.add_argument("--only", default="", metavar="FAMILY,...", help="families, or how their names begin")
    parser.add_argument("--data", type=Path, default=os.environ.get("VBBENCH_DATA"), help="folder of the recordings")
    parser.add_argument("--cache", type=Path, default=Path("out/families"), help="where datasets are kept")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path, help="file for all figures")
    parser.add_argument("--page", type=Path, help="page whose table of families is written again, docs/families.md")
    parser.add_argument("--smoke", action="store_true", help="the smallest size, without data")
    parser.add_argument("--list", action="store_true", help="print the names of the families")
    asked = parser.parse_args()
    warnings.filterwarnings("ignore")
    try:
        wanted = chosen(asked.only, smoke=asked.smoke)
        if asked.list:
            print("\n".join(family.name for family in wanted))
            return
        data = None if asked.data is None else Path(asked.data)
        places = Places(data=data, cache=asked.cache, jobs=asked.jobs, smoke=asked.smoke)
        found: list[list[Row]] = []
        for family in wanted:
            found.append(list(rows(family, asked.solvers, places)))
            if asked.json is not None:
                write_json(asked.json, found)
    except VbbenchError as error:
        sys.exit(f"families: {error}")
    if asked.page is not None:
        asked.page.write_text(written(asked.page.read_text("utf-8"), brief(found)), encoding="utf-8")
    print("\n".join(lines([list(row.cells(group[0])) for group in found for row in group])))


if __name__ == "__main__":
    main()
