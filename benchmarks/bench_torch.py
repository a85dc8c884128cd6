"""Samples for training per second, from folders and generators, beside reading the same sequences as most would.

    python -m benchmarks.bench_torch FOLDER [--frames 8] [--samples 640]

The peers make the boxes and true poses of the same windows, and nothing else: ``pandas`` filters the Parquet files by
sequence, ``rows`` holds the whole tables in memory and fills arrays row by row. Seconds are of this process where there
are no workers, and of the clock where there are.
"""

import argparse
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from vbbench.generation.generator import Look, Options, Simulation
from vbbench.training import FolderSamples, GeneratedSamples
from vbbench.training.torch import Feed

BATCH = 32


def windows(source: FolderSamples, samples: int) -> list[tuple[int, int]]:
    """The windows of the first batches of a shuffled epoch: sequence and first frame."""
    feed = Feed(source, BATCH, seed=0)
    return [
        (int(i), int(s))
        for batch in islice(feed, samples // BATCH)
        for i, s in zip(batch.index, batch.start, strict=True)
    ]


def by_pandas(folder: Path, wanted: list[tuple[int, int]], frames: int) -> Iterator[Any]:
    """Each window on its own, by a filter."""
    import pandas as pd

    for sequence, start in wanted:
        only = [("sequence", "==", sequence)]
        boxes = pd.read_parquet(folder / "observations.parquet", filters=only)
        poses = pd.read_parquet(folder / "truth" / "poses.parquet", filters=only)
        boxes = boxes[(boxes["frame"] >= start) & (boxes["frame"] < start + frames)]
        yield boxes.pivot_table(index="frame", columns="track", values=["u", "v", "l"]).to_numpy(), poses.to_numpy()


def by_rows(folder: Path, wanted: list[tuple[int, int]], frames: int) -> Iterator[Any]:
    """Everything in memory, and a loop over the rows of each window."""
    import pandas as pd

    boxes, poses = (pd.read_parquet(folder / name) for name in ("observations.parquet", "truth/poses.parquet"))
    for sequence, start in wanted:
        mine = boxes[(boxes["sequence"] == sequence) & (boxes["frame"] >= start) & (boxes["frame"] < start + frames)]
        tracks = {track: k for k, track in enumerate(sorted(set(mine["track"])))}
        filled = np.full((frames, len(tracks), 3), np.nan)
        for row in mine.itertuples():
            filled[row.frame - start, tracks[row.track]] = row.u, row.v, row.l
        yield filled, poses[poses["sequence"] == sequence].to_numpy()


def per_second(count: int, work: Callable[[], Any], clock: Callable[[], float] = process_time) -> float:
    started = clock()
    work()
    return count / (clock() - started)


def bench_folder(folder: Path, frames: int, samples: int) -> None:
    source = FolderSamples(folder, frames=frames)
    wanted = windows(source, samples)
    few = wanted[: max(1, len(wanted) // 5)]
    pandas = per_second(len(few), lambda: list(by_pandas(folder, few, frames)))
    rows = per_second(len(few), lambda: list(by_rows(folder, few, frames)))

    def timed(workers: int, clock: Callable[[], float]) -> float:
        feed = Feed(FolderSamples(folder, frames=frames), BATCH, workers=workers)
        return per_second(len(wanted), lambda: list(islice(feed, len(wanted) // BATCH)), clock)

    alone = per_second(len(wanted), lambda: one_by_one(FolderSamples(folder, frames=frames), wanted))
    print(f"| {folder.name}, {len(wanted)} windows of {frames} frames | samples/s | beside pandas | beside rows |")
    print("|---|---|---|---|")
    for name, speed in (("one by one", alone), ("in batches", timed(0, process_time))):
        print(f"| {name} | {speed:.0f} | {speed / pandas:.1f} x | {speed / rows:.1f} x |", flush=True)
    speeds = [timed(workers, perf_counter) for workers in (0, 1, 2)]
    told = ", ".join(f"{n} workers {speed:.0f} ({speed / speeds[0]:.2f} x)" for n, speed in enumerate(speeds))
    print(f"\nBy the clock: {told}", flush=True)


def one_by_one(source: FolderSamples, wanted: list[tuple[int, int]]) -> None:
    for number in np.random.default_rng(0).permutation(len(source))[: len(wanted)].tolist():
        source.read([number])


def bench_generator(samples: int) -> None:
    print("\n| simulated, 20 frames | camera | people | look | sequences/s | frames/s |\n|---|---|---|---|---|---|")
    looks: dict[str, tuple[Look, ...]] = {"noisy": ("motion", "natural"), "field": ("natural",)}
    for tier, camera, people in [
        (tier, camera, people)
        for tier in ("noisy", "field", "field drawn")
        for camera in ("perspective", "panorama")
        for people in (5, 20, 50)
    ]:
        for look in looks[tier.split()[0]]:
            options = made_with(tier, camera, people, look)
            source = GeneratedSamples("sim", options)
            source.read(range(2))
            count = max(4, samples // (people * (8 if tier == "field" else 1)))
            speed = per_second(count, lambda source=source, count=count: source.read(range(2, 2 + count)))
            print(f"| {tier} | {camera} | {people} | {look} | {speed:.0f} | {20 * speed:.0f} |", flush=True)


def made_with(tier: str, camera: str, people: int, look: Look) -> Options:
    from vbbench.camera import make_camera

    return Options(
        tier=tier.split()[0],
        detector="drawn" not in tier,
        camera=make_camera(camera),
        look=look,
        simulation=Simulation(people=(people,)),
        seed=2,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="*")
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--samples", type=int, default=640)
    asked = parser.parse_args()
    for folder in asked.folders:
        bench_folder(folder, asked.frames, asked.samples)
    bench_generator(asked.samples)


if __name__ == "__main__":
    main()
