"""The leaderboard's site beside its targets: time to build, weight and first paint of its first page, weight of clips.

Builds from the committed results, with player data for whatever lies in ``out/leaderboard``; ``--results`` and
``--work`` name other folders. The first paint needs Debian's ``chromium``.
"""

import argparse
import tempfile
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from statistics import mean, median
from urllib.parse import unquote, urlsplit

from playwright.sync_api import sync_playwright

from tests.lib.browsing import chromium, launch, visit
from vbbench.cli import main as vbbench

VISITS = 5
PAINT = "performance.getEntriesByName('first-contentful-paint')[0].startTime"
Row = tuple[str, float, float | None, str]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", default="leaderboards/results")
    parser.add_argument("--work", default="out/leaderboard")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as room:
        site = Path(room, "site")
        folders = ["--results", options.results, "--work", options.work]
        started = time.perf_counter()
        status = vbbench(["leaderboard", "build", "--out", str(site), *folders])
        seconds = time.perf_counter() - started
        if status:
            raise SystemExit(status)
        print(f"{'':<40}{'measured':>12}{'target':>12}")
        for row in (("build", seconds, 20.0, "s"), *first_page(site), *clips(site)):
            print_row(*row)


def first_page(site: Path) -> Iterator[Row]:
    """What the browser reads before anything is pressed, and when it first paints."""
    if chromium() is None:
        print("no browser: the first page is not measured")
        return
    paints: list[float] = []
    with sync_playwright() as playwright:
        browser = launch(playwright)
        for _ in range(VISITS):
            with visit(browser, site) as visitor:
                page = visitor.open()
                page.wait_for_timeout(500)
                paints.append(float(page.evaluate(PAINT)))
                files = {Path(unquote(urlsplit(address).path)) for address in visitor.asked}
        browser.close()
    yield f"first page, {len(files)} files", sum(file.stat().st_size for file in files) / 1000, 300, "kB"
    yield f"first paint, median of {VISITS}", median(paints), 1000, "ms"
    yield f"first paint, slowest of {VISITS}", max(paints), None, "ms"


def clips(site: Path) -> Iterator[Row]:
    """Weight of the player's data by split: a sequence of one board, with all its solvers."""
    root = site / "data" / "player"
    weights: dict[str, list[float]] = defaultdict(list)
    for board in sorted(root.glob("*/*-*/")):
        tier = board.name.rpartition("-")[2]
        for sequence in board.iterdir():
            clip = root / board.parent.name / tier / f"{sequence.name}.js"
            files = [clip, *sequence.glob("*.js")]
            weights[board.parent.name].append(sum(file.stat().st_size for file in files) / 1000)
    for split, sizes in weights.items():
        target = 60 if split.startswith("students") else None
        yield f"a sequence of {split}, mean", mean(sizes), target, "kB"
        yield f"a sequence of {split}, heaviest", max(sizes), None, "kB"


def print_row(name: str, value: float, target: float | None, unit: str) -> None:
    wanted = "" if target is None else f"{target:g} {unit}"
    missed = "  missed" if target is not None and value > target else ""
    print(f"{name:<40}{value:>9.3g} {unit:<2}{wanted:>12}{missed}")


if __name__ == "__main__":
    main()
