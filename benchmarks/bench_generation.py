"""Generating Students against a straightforward loop over frames with NumPy and pandas.

Both read the same scenes and write observations of the same sequences; without the recordings a crowd of the same
size takes their place. Both are measured in seconds of the processor: what the clock says depends on the disk, for
which only `generate` waits (it flushes every table), and on what else the machine does. Run with ``make bench`` or
``python -m benchmarks.bench_generation``; ``make bench-summary`` prints one line.
"""

import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from vbbench.camera import PanoramaCamera
from vbbench.errors import SourceMissingError
from vbbench.generation import generate
from vbbench.generation.generator import Card, Options
from vbbench.registry import load
from vbbench_generators.crowds.sim import record_plaza
from vbbench_generators.recordings.recipe import Rules
from vbbench_generators.views import Reprojection, plan_reprojection

NAIVE_SEQUENCES = 40
RUNS = 3
TARGET = 25


def plan() -> Reprojection:
    options = Options(camera=PanoramaCamera())
    try:
        return load("generator", "students").plan(options)
    except SourceMissingError:
        scenes = [record_plaza(0, index, 60, 500) for index in range(2)]
        return plan_reprojection(_Made.card, Rules(skip_first_frames=1), scenes, options, {})


def as_table(laid_out: Reprojection, scene: int) -> pd.DataFrame:
    """A scene as trajectory files hold it: a row a frame and person."""
    recorded = laid_out.scenes[scene]
    frame, column = np.nonzero(recorded.present)
    x, y = recorded.positions[frame, column].T
    who = {"person": recorded.people[column], "height": recorded.heights[column]}
    return pd.DataFrame({"frame": frame, **who, "x": x, "y": y})


def naive(laid_out: Reprojection, table: pd.DataFrame, index: int, out: Path) -> int:
    """One sequence as most people would write it: frame by frame with NumPy, a data frame each, joined at the end."""
    sequence, camera = laid_out.build(index), laid_out.info.camera
    observer, first = sequence.sequence.observer, sequence.sequence.first_frame
    seen = []
    for t, (x, y, yaw) in enumerate(sequence.truth.poses):
        now = table[(table.frame == first + t) & (table.person != observer)]
        dx, dy = now.x.to_numpy() - x, now.y.to_numpy() - y
        right, forward = dx * np.sin(yaw) - dy * np.cos(yaw), dx * np.cos(yaw) + dy * np.sin(yaw)
        reach, h = np.hypot(right, forward), now.height.to_numpy()
        u = (np.arctan2(right, forward) + np.pi) * camera.width / (2 * np.pi) % camera.width
        v = camera.cy + camera.focal * (camera.mount_height - h / 2) / reach
        boxes = {"track": now.person.to_numpy(), "u": u, "v": v, "l": camera.focal * h / reach, "visible": 1.0}
        seen.append(pd.DataFrame({"sequence": index, "frame": t, **boxes}))
    rows = pd.concat(seen)
    rows.to_parquet(out / f"{index}.parquet", compression="zstd")
    return len(rows)


def measure_naive(laid_out: Reprojection, room: Path) -> float:
    """Observations a second of the processor, on sequences spread over the split."""
    chosen = [int(index) for index in np.linspace(0, len(laid_out) - 1, NAIVE_SEQUENCES)]
    tables = {scene: as_table(laid_out, scene) for scene in range(len(laid_out.scenes))}
    return best_rate(lambda: sum(naive(laid_out, tables[laid_out.spans[n].scene], n, room) for n in chosen))


def measure(room: Path) -> float:
    """Observations a second of the processor through `generate`: laying out, writing, hashing and all."""
    split, options = _split()

    def run() -> int:
        shutil.rmtree(room / "data", ignore_errors=True)
        return int(generate(split, room / "data", options).info.counts["observations"])

    return best_rate(run)


def best_rate(run: Callable[[], int]) -> float:
    """What ``run`` counts a second of the processor, in its best of `RUNS` runs."""
    best = 0.0
    for _ in range(RUNS):
        started = time.process_time()
        count = run()
        best = max(best, count / (time.process_time() - started))
    return best


def _split() -> tuple[str, Options]:
    return f"{__name__}:MADE", Options(camera=PanoramaCamera())


class _Made:
    card = Card(name="made", title="Synthetic crowds", licence="", citation="", sources=())

    def plan(self, _options: Options) -> Reprojection:
        return plan()


MADE = _Made()


def main(arguments: Sequence[str]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        room = Path(folder)
        fast, slow = measure(room), measure_naive(plan(), room)
    ratio = f"{fast / slow:.1f} times the loop over frames (target {TARGET})"
    if "--summary" in arguments:
        print(f"generation: {fast / 1e6:.2f} million observations a second of one core, {ratio}")
        return
    print("Generating Students (panorama, ideal), in seconds of one core")
    print(f"  vbbench generate    {fast / 1e6:8.2f} million observations a second (target 1.5)")
    print(f"  loop over frames    {slow / 1e6:8.3f}")
    print(f"  {ratio}")


if __name__ == "__main__":
    main(sys.argv[1:])
