"""Shibuya01 at its full size beside the targets: seconds, memory and bytes of generating, solving and scoring.

806 sequences of 317 frames with 523 people on average, 134 million observations, of a simulated crowd: everybody of
the scenario `shibuya` is seen for some 317 frames about the middle of the recording, so that the picture fills up to
some 760 people and empties again. With ``--source`` the split `shibuya01` itself is measured, from that folder.

Run from the repository: ``python -m benchmarks.bench_shibuya --full``, with 10 GB of free disk in ``--work`` and some
ten minutes. Without ``--full`` a tenth of the sequences is made, and counts are compared with a tenth of the targets.
Memory is the greatest sum of the proportional set sizes of a command and all its workers (Linux).
"""

import argparse
import json
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.generation.generator import Card, Options
from vbbench.scene import Scene
from vbbench_generators.crowds import draw_crowd, get_scenario, walk
from vbbench_generators.recordings.recipe import Rules
from vbbench_generators.social_force import Model
from vbbench_generators.tiers.noise import Precision
from vbbench_generators.views import Reprojection, plan_reprojection

SEQUENCES = 806
PRECISION = Precision(u_bits=10, v_bits=10, l_bits=12)
STAY, FILLING = (217, 418), 300
"""Frames that somebody is seen, from and to, and frames over which the people come."""
GIB, GB = 2**30, 1e9
PAUSE = 0.2
"""Seconds from one look at the memory to the next."""


@dataclass(frozen=True)
class Crossing:
    """The split ``benchmarks.bench_shibuya:CROSSING``; ``jitter`` in m is added to everybody's every coordinate."""

    jitter: float = 0.0
    card: ClassVar[Card] = Card(
        name="crossing", title="A crossing as large as Shibuya01", licence="", citation="", sources=()
    )

    def plan(self, options: Options) -> Reprojection:
        """The plan of the synthetic crowd."""
        facts = {"jitter": self.jitter}
        rules = Rules(skip_first_frames=1, count_observer=False)
        return plan_reprojection(
            self.card, rules, [record(options.seed, self.jitter)], options, facts, precision=PRECISION
        )


CROSSING = Crossing()
JITTERED = Crossing(jitter=0.0075)
"""With jitter as annotations have: the one-step error of constant velocity then is that of the paper's Table 3."""


def record(seed: int, jitter: float) -> Scene:
    """`SEQUENCES` people of the scenario, each there for a while."""
    rng = np.random.default_rng(seed)
    first = rng.integers(0, FILLING, SEQUENCES)
    last = first + rng.integers(*STAY, SEQUENCES)
    scenario = replace(get_scenario("shibuya"), people=(SEQUENCES,), frames=int(last.max()))
    positions = walk(scenario, draw_crowd(scenario, SEQUENCES, Model(), rng), Model(), "vbbench")
    positions += jitter * rng.standard_normal(positions.shape)
    frame = np.arange(len(positions))[:, None]
    positions[(frame < first) | (frame >= last)] = np.nan
    unknown = np.full(SEQUENCES, np.nan)
    return Scene(name="crossing", dt=scenario.dt, people=np.arange(SEQUENCES), positions=positions, heights=unknown)


def vbbench(*arguments: str) -> tuple[float, float, str]:
    """Run one command: seconds, greatest memory in bytes, and what it printed."""
    started = time.perf_counter()
    process = subprocess.Popen([sys.executable, "-m", "vbbench", *arguments], stdout=subprocess.PIPE, text=True)
    most = [0]
    watch = threading.Thread(target=_watch, args=(process, most), daemon=True)
    watch.start()
    printed, _ = process.communicate()
    watch.join()
    if process.returncode:
        raise SystemExit(process.returncode)
    return time.perf_counter() - started, most[0], printed


def _watch(process: "subprocess.Popen[str]", most: list[int]) -> None:
    while process.poll() is None:
        most[0] = max(most[0], sum(_proportional(number) for number in _family(process.pid)))
        time.sleep(PAUSE)


def _family(number: int) -> list[int]:
    """A process and all that it started."""
    try:
        texts = [file.read_text() for file in Path(f"/proc/{number}/task").glob("*/children")]
    except OSError:
        return [number]
    children = [int(child) for text in texts for child in text.split()]
    return [number, *(member for child in children for member in _family(child))]


def _proportional(number: int) -> int:
    """Proportional set size in bytes; 0 for a process that has ended."""
    try:
        lines = Path(f"/proc/{number}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0
    return sum(1024 * int(line.split()[1]) for line in lines if line.startswith("Pss:"))


def show(what: str, value: float, unit: str, target: str = "") -> None:
    print(f"  {what:<44}{value:>10.2f} {unit:<14}{target}", flush=True)


def measure_generating(room: Path, options: argparse.Namespace, share: float) -> Path:
    data = room / "data"
    split = "shibuya01" if options.source else "benchmarks.bench_shibuya:CROSSING"
    source = ["--source", str(options.source)] if options.source else []
    limit = [] if options.full else ["--limit", str(round(SEQUENCES * share))]
    seconds, memory, _ = vbbench("generate", split, "--out", str(data), "--jobs", str(options.jobs), *source, *limit)
    counts = Dataset(data).info.counts
    people = counts["observations"] / counts["frames"]
    print(f"{counts['sequences']} sequences, {counts['frames'] / counts['sequences']:.0f} frames, people ", end="")
    print(f"{counts['people_min']} / {people:.0f} / {counts['people_max']}; {options.jobs} jobs")
    show("observations", counts["observations"] / 1e6, "million", f"at least {120 * share:.0f}")
    show("generate", seconds, "s", f"under {240 * share:.0f}")
    show("its memory, workers included", memory / GIB, "GiB", "under 2")
    show("the dataset on disk", _bytes(data) / GB, "GB", f"under {1.2 * share:.2f}")
    return data


def measure_solving(room: Path, data: Path, jobs: int, share: float) -> Path:
    answer = room / "vb-cv"
    command = ("solve", str(data), "--protocol", "one-step", "--jobs", str(jobs), "--solver", "vb-cv")
    seconds, memory, _ = vbbench(*command, "--out", str(answer))
    show("solve, vb-cv, one-step", seconds, "s", f"under {600 * share:.0f}")
    show("its memory, workers included", memory / GIB, "GiB", "under 2")
    show("the submission on disk", _bytes(answer) / GB, "GB")
    show("of it vb-cv, one core", 1 / _seconds_a_frame(answer), "frames/s")
    return answer


def measure_scoring(data: Path, answer: Path, share: float) -> None:
    seconds, memory, printed = vbbench("score", str(answer), "--dataset", str(data))
    show("score", seconds, "s", f"under {120 * share:.0f}")
    show("its memory", memory / GIB, "GiB", "under 2")
    print(printed)


def measure_social_force(room: Path, options: argparse.Namespace) -> None:
    """vb-sf on a few sequences, one process."""
    data, answer = room / "few", room / "vb-sf"
    split = "shibuya01" if options.source else "benchmarks.bench_shibuya:CROSSING"
    source = ["--source", str(options.source)] if options.source else []
    vbbench("generate", split, "--out", str(data), "--limit", "24", *source)
    vbbench("solve", str(data), "--protocol", "one-step", "--solver", "vb-sf", "--out", str(answer))
    show("vb-sf, one-step, one core", 1 / _seconds_a_frame(answer), "frames/s", "at least 150")


def _seconds_a_frame(answer: Path) -> float:
    return float(json.loads((answer / "submission.json").read_text())["seconds_per_frame"])


def _bytes(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--full", action="store_true", help="all sequences, not a tenth")
    parser.add_argument("--source", type=Path, help="folder of HT21-03: measure shibuya01 itself")
    parser.add_argument("--work", type=Path, help="folder for what is written meanwhile")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    share = 1.0 if options.full else 0.1
    with tempfile.TemporaryDirectory(dir=options.work) as folder:
        room = Path(folder)
        data = measure_generating(room, options, share)
        answer = measure_solving(room, data, options.jobs, share)
        measure_scoring(data, answer, share)
        measure_social_force(room, options)


if __name__ == "__main__":
    main()
