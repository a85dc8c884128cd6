"""The page's player: how long its data take to write, how large they are, and how long a picture takes to draw.

    python -m benchmarks.bench_player [--work out/leaderboard] [--results leaderboards/results] [--sequences 24]

Sizes are of the data files as they lie on disk. Drawing is timed in headless Chromium, without a graphics card, on the
sequence of Students of middle size, and on a synthetic crowd of 500 people over 300 frames; a pixel is read
back after each picture, so that nothing is put off. Figures: median and 95th percentile of a call.
"""

import argparse
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tests.lib.browsing import chromium
from tests.lib.made_player import write_crowd, write_page
from tests.lib.made_sequence import made_sequence
from vbbench_leaderboards.results.folder import read_results
from vbbench_leaderboards.site.player import FOLDER, Films, write_player

CROWD = {"people": 500, "frames": 300}
SHOWN = 3
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"]

DRAWS = 240
PACES = {"played": 0.0417, "scrubbed": 1.37}
"""Frames from one picture to the next: 60 pictures a second where the recording has 2.5; and a hasty hand."""

MOUNT = """async ([key, state]) => {
  const { player } = vbbench, names = state.solvers.split(",");
  player.mount(document.body, { board: { key, solvers: names.map((name, n) => ({ name, colour: n + 1 })) }, state });
  while (!player.session.moment) await new Promise((done) => setTimeout(done, 20));
  return `${player.session.clip.K} people, ${player.session.clip.T} frames`;
}"""

DRAW = """([pace, draws]) => {
  const s = vbbench.player.session, times = [];
  s.playing = true;
  for (let n = 0; n < draws; n++) {
    s.at = 2 + ((n * pace) % (s.clip.T - 3));
    const start = performance.now();
    s.draw();
    for (const view of Object.values(s.views)) view.context.getImageData(0, 0, 1, 1);
    times.push(performance.now() - start);
  }
  s.playing = false;
  return times;
}"""


def main(work: Path, results: Path, sequences: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        site = Path(name)
        start = time.perf_counter()
        boards = read_results(results)
        reading = time.perf_counter() - start
        played = write_player(site, boards, Films(work=work, sequences=sequences))
        writing = time.perf_counter() - start - reading
        count = sum(1 for _ in site.rglob("*.js"))
        print(f"{len(played)} boards, {count} files: written in {writing:.1f} s (results read in {reading:.1f} s)")
        for split in sorted({board.split for board in played}):
            report_sizes(split, list(sizes(site, split)))
        report_drawing(site)


def sizes(site: Path, split: str) -> Iterator[tuple[int, str, int]]:
    """Bytes of a sequence with its three largest solvers, board, and number, on every board of a split."""
    folder = site / FOLDER / split
    for board in sorted(path for path in folder.iterdir() if "-" in path.name):
        for number in board.iterdir():
            solvers = sorted((path.stat().st_size for path in number.iterdir()), reverse=True)[:SHOWN]
            clip = folder / board.name.rpartition("-")[2] / f"{number.name}.js"
            yield clip.stat().st_size + sum(solvers), board.name, int(number.name)


def report_sizes(split: str, found: list[tuple[int, str, int]]) -> None:
    data = np.array([size for size, _, _ in found]) / 1e3
    largest = f"{data.max():6.1f} kB ({max(found)[1]}, sequence {max(found)[2]})"
    print(f"{split:<20}median {np.median(data):6.1f} kB, max {largest}, {np.mean(data <= 60.0):.0%} at most 60 kB")


def report_drawing(site: Path) -> None:
    from playwright.sync_api import sync_playwright

    cases = [("made/sequential-noisy", made_crowd(site))]
    found = list(sizes(site, "students")) if (site / FOLDER / "students").is_dir() else []
    if found:
        _, board, number = sorted(found)[len(found) // 2]
        cases.insert(0, (f"students/{board}", {"sequence": number, "solvers": "cv,vb-cv,vb-sf"}))
    write_page(site)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium(), args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.goto((site / "index.html").as_uri())
        clock = page.context.new_cdp_session(page)
        clock.send("Performance.enable")
        for key, state in cases:
            print(f"{key}: {page.evaluate(MOUNT, [key, state])}")
            for way, pace in PACES.items():
                print(f"  {way:<10}{timed(page, clock, pace)}")
        browser.close()


def timed(page: Any, clock: Any, pace: float) -> str:
    page.evaluate(DRAW, [pace, DRAWS // 4])
    before = processor_seconds(clock)
    times = page.evaluate(DRAW, [pace, DRAWS])
    spent = 1e3 * (processor_seconds(clock) - before) / DRAWS
    return (
        f"median {np.median(times):.1f} ms, p95 {np.quantile(times, 0.95):.1f} ms, processor {spent:.1f} ms a picture"
    )


def processor_seconds(clock: Any) -> float:
    """What the page's main thread has had of the processor, which does all the drawing."""
    metrics = {row["name"]: row["value"] for row in clock.send("Performance.getMetrics")["metrics"]}
    return float(metrics["ThreadTime"])


def made_crowd(site: Path) -> dict[str, Any]:
    """A large crowd that was never solved, as if it had been."""
    made, rng = made_sequence(**CROWD, share=1.0), np.random.default_rng(0)
    names = ["cv", "vb-cv", "vb-sf"]
    write_crowd(site, made, {name: made.estimate(rng, 0.2) for name in names})
    return {"sequence": 0, "solvers": ",".join(names)}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, default=Path("out/leaderboard"))
    parser.add_argument("--results", type=Path, default=Path("leaderboards/results"))
    parser.add_argument("--sequences", type=int, default=24)
    arguments = parser.parse_args()
    main(arguments.work, arguments.results, arguments.sequences)
