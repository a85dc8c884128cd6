"""Generating Students against a straightforward loop over frames and people with NumPy and pandas.

Both read the same scenes and write observations of the same sequences; without the recordings a made crowd of the same
size takes their place. Run with ``make bench`` or ``python -m benchmarks.bench_generation``.
"""

import math
import shutil
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

from vbbench.camera import PanoramaCamera
from vbbench.errors import SourceMissingError
from vbbench.generation import generate
from vbbench.generator import Card, Options
from vbbench.registry import load
from vbbench_generators.crowd import make_crowd
from vbbench_generators.eligibility import Rules
from vbbench_generators.planning import plan_reprojection
from vbbench_generators.reprojection import Reprojection

NAIVE_SEQUENCES = 12


def plan() -> Reprojection:
    options = Options(camera=PanoramaCamera())
    try:
        return load("generator", "students").plan(options)
    except SourceMissingError:
        scenes = [make_crowd(0, index, 44, 500, 0.4) for index in range(2)]
        card = Card(name="made", title="Made crowds", licence="", citation="", sources=())
        return plan_reprojection(card, Rules(skip_first_frames=1), scenes, options, {})


def naive(laid_out: Reprojection, index: int, out: Path) -> int:
    """One sequence as most people would write it: loops, a dict a row, a data frame at the end."""
    span = laid_out.spans[index]
    scene, camera = laid_out.scenes[span.scene], laid_out.info.camera
    data = laid_out.build(index)
    rows = []
    for t in range(len(span.counted)):
        x, y, yaw = data.truth.poses[t]
        for column, person in enumerate(scene.people):
            px, py = scene.positions[span.first + t, column]
            if column == span.column or math.isnan(px):
                continue
            right = (px - x) * math.sin(yaw) - (py - y) * math.cos(yaw)
            forward = (px - x) * math.cos(yaw) + (py - y) * math.sin(yaw)
            reach, h = math.hypot(right, forward), scene.heights[column]
            u = (math.atan2(right, forward) + math.pi) * camera.width / (2 * math.pi)
            v = camera.cy + camera.focal * (camera.mount_height - h / 2) / reach
            box = {"u": u % camera.width, "v": v, "l": camera.focal * h / reach, "visible": 1.0}
            rows.append({"sequence": index, "frame": t, "track": int(person), **box})
    pd.DataFrame(rows).to_parquet(out / f"{index}.parquet", compression="zstd")
    return len(rows)


def measure_naive(laid_out: Reprojection, room: Path) -> float:
    """Observations a second, on sequences spread over the split; the time to lay them out is not counted."""
    chosen = np.linspace(0, len(laid_out) - 1, NAIVE_SEQUENCES).astype(int)
    for index in chosen:
        laid_out.build(int(index))
    started = time.perf_counter()
    rows = sum(naive(laid_out, int(index), room) for index in chosen)
    return rows / (time.perf_counter() - started)


def measure(room: Path) -> float:
    """Observations a second through `generate`, laying out, writing, hashing and all; the best of three."""
    best = math.inf
    split, options = _split()
    for _ in range(3):
        shutil.rmtree(room / "data", ignore_errors=True)
        started = time.perf_counter()
        made = generate(split, room / "data", options)
        best = min(best, time.perf_counter() - started)
    return made.info.counts["observations"] / best


def _split() -> tuple[str, Options]:
    return f"{__name__}:MADE", Options(camera=PanoramaCamera())


class _Made:
    def plan(self, _options: Options) -> Reprojection:
        return plan()


MADE = _Made()


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        room = Path(folder)
        fast, slow = measure(room), measure_naive(plan(), room)
    print("Generating Students (panorama, ideal), one core")
    print(f"  vbbench generate    {fast / 1e6:8.2f} million observations a second")
    print(f"  loop, pandas        {slow / 1e6:8.2f}")
    print(f"  ratio               {fast / slow:8.1f}   (target 20, and 1.5 million a second)")


if __name__ == "__main__":
    main()
