"""A site to visit: results made of figures, and those of small crowds, added as a stranger would add them."""

import shutil
from dataclasses import dataclass
from pathlib import Path

from tests.lib.made_results import made_results
from vbbench.cli import main

SPLIT = "demo"
TIERS = ("ideal", "noisy")
PROTOCOLS = ("sequential", "one-step")
SOLVERS = ("cv", "sf", "vb-cv", "vb-sf")
STRANGER, TWIN = "stranger", "vb-cv"
HOSTILE = '<img src=x onerror="throw 1">&amp; "quoted" \'words\''
SEQUENCES = 6


@dataclass(frozen=True, kw_only=True)
class Made:
    """The folder of the site, and of the results that it shows."""

    site: Path
    results: Path


def make_site(room: Path) -> Made:
    """Generate, solve, add and build below ``room``. The stranger answers as its twin does, and has odd words."""
    results, work = room / "results", room / "work"
    made_results(results)
    for tier in TIERS:
        dataset = work / "datasets" / f"{SPLIT}-{tier}"
        run("generate", SPLIT, "--tier", tier, "--limit", SEQUENCES, "--out", dataset)
        for protocol in PROTOCOLS:
            answers = work / "submissions" / SPLIT / f"{protocol}-{tier}"
            for solver in SOLVERS:
                run("solve", dataset, "--solver", solver, "--protocol", protocol, "--out", answers / solver)
                run("leaderboard", "add", answers / solver, "--dataset", dataset, "--results", results)
            shutil.copytree(answers / TWIN, answers / STRANGER)
            words = ["--name", STRANGER, "--about", f"reference={HOSTILE}", "code=https://example.org/?a=1&b=2"]
            run("leaderboard", "add", answers / STRANGER, "--dataset", dataset, "--results", results, *words)
    run("leaderboard", "build", "--out", room / "site", "--results", results, "--work", work)
    return Made(site=room / "site", results=results)


def run(*arguments: object) -> None:
    """``vbbench …``, which must not fail."""
    status = main([str(argument) for argument in arguments])
    if status:
        raise RuntimeError(f"vbbench {' '.join(map(str, arguments))}: exit status {status}")
