"""Boxes a second of the readers of Argoverse 2 and nuScenes, and the seconds from a fresh log to a dataset.

Run from the repository: ``python -m benchmarks.bench_cars [--rows 500000] [LOG]``. Recordings are made up and repeated
until they are long enough. With the folder of a log of Argoverse 2, `vbbench generate` is timed on it in a process of
its own. The quickest of three runs counts, by the clock and by processor time.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter, process_time

import pyarrow as pa
import pyarrow.compute as pc
from pyarrow import feather

from tests.lib.cars import LOG, Drive, write_log, write_tables
from vbbench_generators.footage.argoverse2 import argoverse2
from vbbench_generators.footage.cuboids import PANORAMA, CuboidSplit, footage_of
from vbbench_generators.footage.nuscenes import nuscenes

REPEATS = 3
FRAMES, PEOPLE = 20, 50


def long_log(folder: Path, rows: int) -> Path:
    """A log of so many cuboids: one of two seconds, again and again."""
    write_log(folder, Drive(frames=FRAMES, people=PEOPLE))
    for name in ("annotations.feather", "city_SE3_egovehicle.feather"):
        table = feather.read_table(folder / name)
        times = table["timestamp_ns"]
        later = [pc.add(times, pa.scalar(round(n * FRAMES * 1e8))) for n in range(rows // (FRAMES * PEOPLE))]
        parts = [table.set_column(0, "timestamp_ns", one) for one in later]
        feather.write_feather(pa.concat_tables(parts), folder / name, compression="lz4")
    return folder


def many_scenes(folder: Path, rows: int) -> Path:
    """Tables of scenes with so many cuboids, interpolated ones included: one scene under many names."""
    name = "scene-0001"
    write_tables(folder, {name: Drive(frames=FRAMES * 5 + 1, people=PEOPLE, ground=0.0)})
    for path in folder.glob("*.json"):
        text = path.read_text()
        if name in text:
            body = text.strip("[]\n")
            count = max(rows // (FRAMES * 5 * PEOPLE), 1)
            path.write_text("[" + ",\n".join(body.replace(name, f"scene-{n:04d}") for n in range(1, count + 1)) + "]")
    return folder


def boxes(split: CuboidSplit, folder: Path) -> int:
    """Read all recordings as footage; how many cuboids they have."""
    count = 0
    for one in split.read(folder, None, (PANORAMA,)):
        footage_of(one, one.name, PANORAMA)
        count += len(one.cuboids.frame)
    return count


def quickest(run: Callable[[], int]) -> tuple[int, float, float]:
    """What a run returns, and its seconds by the clock and by processor time."""
    clock, processor, count = [], [], 0
    for _ in range(REPEATS):
        start = perf_counter(), process_time()
        count = run()
        clock.append(perf_counter() - start[0])
        processor.append(process_time() - start[1])
    return count, min(clock), min(processor)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("log", type=Path, nargs="?")
    parser.add_argument("--rows", type=int, default=500_000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as room:
        made = {
            argoverse2: long_log(Path(room) / LOG, options.rows),
            nuscenes: many_scenes(Path(room) / "v1.0-mini", options.rows),
        }
        for split, folder in made.items():
            count, clock, processor = quickest(partial(boxes, split, folder))
            rates = f"{count / clock:,.0f} a second by the clock, {count / processor:,.0f} by processor time"
            print(f"{split.card.name}: {count:,} boxes, {rates}")
        if options.log:
            command = [sys.executable, "-m", "vbbench", "generate", "argoverse2", "--source", str(options.log)]
            command += ["--out", f"{room}/dataset", "--overwrite"]
            seconds = quickest(lambda: subprocess.run(command, check=True, capture_output=True).returncode)[1]
            print(f"{options.log.name} to a dataset: {seconds:.2f} s")


if __name__ == "__main__":
    main()
