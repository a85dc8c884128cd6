"""A site to visit: the committed results, and those of small made crowds, added as a stranger would add them."""

import shutil
from pathlib import Path

from vbbench.cli import main

COMMITTED = Path(__file__).parents[2] / "leaderboards" / "results"
SPLIT = "demo"
SOLVERS = ("cv", "sf", "vb-cv", "vb-sf")
PROTOCOLS = ("sequential", "one-step")
TIERS = ("ideal", "noisy")
SEQUENCES = 6


def make_site(room: Path) -> Path:
    """Generate, solve, add and build below ``room``; returns the site's folder."""
    results, work, site = room / "results", room / "work", room / "site"
    shutil.copytree(COMMITTED, results)
    for tier in TIERS:
        dataset = work / "datasets" / f"{SPLIT}-{tier}"
        run("generate", SPLIT, "--tier", tier, "--limit", SEQUENCES, "--out", dataset)
        for protocol in PROTOCOLS:
            for solver in SOLVERS:
                out = work / "submissions" / SPLIT / f"{protocol}-{tier}" / solver
                run("solve", dataset, "--solver", solver, "--protocol", protocol, "--out", out)
                run("leaderboard", "add", out, "--dataset", dataset, "--results", results)
    run("leaderboard", "build", "--out", site, "--results", results, "--work", work)
    return site


def run(*arguments: object) -> None:
    """``vbbench …``, which must not fail."""
    status = main([str(argument) for argument in arguments])
    if status:
        raise RuntimeError(f"vbbench {' '.join(map(str, arguments))}: exit status {status}")
