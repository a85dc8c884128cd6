"""Generating Students against a straightforward loop over frames with NumPy and pandas.

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
from vbbench_generators.demo import record_plaza
from vbbench_generators.eligibility import Rules
from vbbench_generators.planning import plan_reprojection
from vbbench_generators.reprojection import Reprojection

NAIVE_SEQUENCES = 40


def plan() -> Reprojection:
    options = Options(camera=PanoramaCamera())
    try:
        return load("generator", "students").plan(options)
    except SourceMissingError:
        scenes = [record_plaza(0, index, 60, 500) for index in range(2)]
        card = Card(name="made", title="Made crowds", licence="", citation="", sources=())
        return plan_reprojection(card, Rules(skip_first_frames=1), scenes, options, {})


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
    """Observations a second, on sequences spread over the split."""
    chosen = [int(index) for index in np.linspace(0, len(laid_out) - 1, NAIVE_SEQUENCES)]
    tables = {scene: as_table(laid_out, scene) for scene in range(len(laid_out.scenes))}
    started = time.perf_counter()
    rows = sum(naive(laid_out, tables[laid_out.spans[index].scene], index, room) for index in chosen)
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
    print(f"  loop over frames    {slow / 1e6:8.3f}")
    print(f"  ratio               {fast / slow:8.1f}   (target 20, and 1.5 million a second)")


if __name__ == "__main__":
    main()
