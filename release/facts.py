"""Writes what bundled solvers declare of themselves into their committed results: ``python -m release.facts``.

Facts are metadata: figures, days and history stay as they are. Run this after a change of a solver's ``facts``.
"""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from vbbench.solving.submissions import declared_facts
from vbbench_leaderboards.results.boards import REFERENCES
from vbbench_leaderboards.results.folder import published_results, result_paths
from vbbench_leaderboards.results.result import Result, read_result, write_result


def outdated(results: Path) -> Iterator[Result]:
    """The results of bundled solvers whose facts are not those of the code, with these in their place."""
    for path in result_paths(results):
        result = read_result(results / path)
        if result.solver not in REFERENCES:
            continue
        about = replace(result.about, **declared_facts(result.solver))
        if about != result.about:
            yield replace(result, about=about)


if __name__ == "__main__":
    for result in list(outdated(published_results())):
        print(write_result(result, published_results()))  # noqa: T201
