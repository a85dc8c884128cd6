"""How well the tracker of the tier `tracked` does, in the terms in which trackers are published, beside published ones.

Run from the repository, with the recordings in ``VBBENCH_DATA``: ``python -m benchmarks.tracker_table [--every 4]
[SPLIT …]``. Everybody in the picture counts, however hidden, as in MOTChallenge; *shown* counts those of whom at least
a quarter shows. Switches are those of CLEAR MOT: somebody is found in another track than the last time. *Scored* is the
share of boxes that remain for scoring when the first two of every track are given.
"""

import argparse
from dataclasses import dataclass, field, replace
from time import process_time

import numpy as np

from vbbench.boxes import cut_to_picture, pair_overlaps, rectangles
from vbbench.camera import Camera
from vbbench.generation.generator import Generator, Options
from vbbench.generation.tier import Observations, Sight, Tier, get_tier
from vbbench.geometry import FloatArray, IntArray
from vbbench.registry import load
from vbbench_generators.tiers.noise import enough, see
from vbbench_generators.tiers.tracking.observing import finer

SPLITS = {"hotel": 1, "eth": 1, "eth-15fps": 1, "students": 16, "students-resampled": 16, "street": 1}
"""Splits, and every how many sequences are measured unless asked otherwise."""
GIVEN, SHOWN = 2, 0.25
PUBLISHED = """\
| published (video) | boxes | missed | | false | switches | overlap |
|---|---:|---:|---:|---:|---:|---:|
| ByteTrack, MOT17 test | 564,228 | 14.8 % | | 4.5 % | 0.39 % | |
| OC-SORT, MOT17 test | 564,228 | 19.0 % | | 2.7 % | 0.35 % | |
| OC-SORT, MOT17 test, public detections | 564,228 | 40.8 % | | 0.8 % | 0.14 % | |
| ByteTrack, MOT20 test | 517,426 | 16.9 % | | 5.1 % | 0.24 % | |
| OC-SORT, MOT20 test | 517,426 | 20.1 % | | 3.9 % | 0.18 % | |
| OC-SORT, MOT20 test, public detections | 517,426 | 39.1 % | | 0.9 % | 0.11 % | |
| StrongSORT on YOLOv5, MOT17 train | 110,407 | 31.8 % | | 6.6 % | 0.36 % | .796 |
| JDE, 1088 x 608, MOT16 train | 110,407 | 19.5 % | | 5.0 % | 1.08 % | |
| JDE, 576 x 320, MOT16 train | 110,407 | 29.7 % | | 6.0 % | 1.18 % | |"""
"""FP, FN and IDs of the authors' READMEs (ifzhang/ByteTrack, noahcao/OC_SORT, Zhongdao/Towards-Realtime-MOT) and of the
wiki page "StrongSORT vs BoTSORT vs OCSORT" of mikel-brostrom/yolo_tracking, divided by the number of labelled boxes."""


@dataclass(frozen=True, kw_only=True)
class Watching(Tier):
    """The tier `tracked`, which keeps what it sees and makes of it."""

    kept: list[tuple[Sight, Observations]] = field(default_factory=list)
    hides = True

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """As `tracked` does."""
        made = get_tier("tracked").observe(sight, rng)
        self.kept.append((sight, made))
        return made


@dataclass
class Tally:
    """Boxes of people (of them shown), boxes of these found, and boxes of nobody; switches; boxes that are scored."""

    people: int = 0
    shown: int = 0
    found: int = 0
    shown_found: int = 0
    nobody: int = 0
    switches: int = 0
    scored: int = 0
    overlap: float = 0.0

    def add(self, sight: Sight, made: Observations) -> None:
        """Count a sequence."""
        assert made.persons is not None
        truth, there, paired = sight.truth, ~np.isnan(sight.boxes[..., 2]), made.persons >= 0
        shown = there & enough(see(truth.positions, truth.heights, truth.poses, sight.camera), SHOWN)
        frame, track = np.nonzero(paired)
        person = np.searchsorted(sight.people, made.persons[frame, track])
        self.people += int(np.count_nonzero(there))
        self.shown += int(np.count_nonzero(shown))
        self.found += len(frame)
        self.shown_found += int(np.count_nonzero(shown[frame, person]))
        self.nobody += int(np.count_nonzero(~np.isnan(made.boxes[..., 2]) & ~paired))
        self.switches += switches(made.persons)
        self.scored += int(np.maximum(paired.sum(axis=0) - GIVEN, 0).sum())
        self.overlap += shares(made.boxes[frame, track], sight.boxes[frame, person], sight.camera).sum()

    def __str__(self) -> str:
        """Cells of the table, in its order."""
        missed, unseen = 1.0 - self.found / self.people, 1.0 - self.shown_found / self.shown
        rates = missed, unseen, self.nobody / self.people
        cells = [f"{self.people:,}", *(f"{100 * rate:.1f} %" for rate in rates)]
        overlap = f"{self.overlap / max(self.found, 1):.3f}".lstrip("0")
        cells += [f"{100 * self.switches / self.people:.2f} %", overlap, f"{100 * self.scored / self.people:.0f} %"]
        return " | ".join(cells)


def switches(persons: IntArray) -> int:
    """How often somebody is found in another track than the last time, by the persons [T, K] behind tracks."""
    frame, track = np.nonzero(persons >= 0)
    person = persons[frame, track]
    order = np.lexsort((frame, person))
    same = person[order][1:] == person[order][:-1]
    return int(np.count_nonzero(same & (track[order][1:] != track[order][:-1])))


def shares(found: FloatArray, true: FloatArray, camera: Camera) -> FloatArray:
    """Intersection over union [N] of boxes [N, 3] with true ones, both cut to the picture."""
    a, b = (cut_to_picture(rectangles(boxes), camera) for boxes in (found, true))
    return pair_overlaps(a, b, camera.period)


def measure(split: str, every: int, camera: Camera | None = None) -> tuple[Tally, Tally, float]:
    """Every so many sequences of a split: in its own frames, in all frames of the video, and processor seconds."""
    generator: Generator = load("generator", split)
    watching = Watching(name="tracked", summary="as tracked")
    plan = replace(generator.plan(Options(tier="tracked", camera=camera)), tier=watching)  # type: ignore[type-var]
    started = process_time()
    for index in range(0, len(plan), every):
        plan.build(index)
    spent = process_time() - started
    own, video = Tally(), Tally()
    for index, (sight, made) in enumerate(watching.kept):
        own.add(sight, made)
        fine, _ = finer(sight)
        video.add(fine, get_tier("tracked").observe(fine, np.random.default_rng(index)))
    return own, video, spent


def main() -> None:
    """Print two tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("splits", nargs="*", default=list(SPLITS))
    parser.add_argument("--every", type=int, help="measure every so many sequences")
    asked = parser.parse_args()
    print("| split, frames | boxes | missed | of the shown | false | switches | overlap | scored |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for split in asked.splits:
        own, video, spent = measure(split, asked.every or SPLITS.get(split, 1))
        print(f"| {split}, its own | {own} |\n| {split}, 25 a second | {video} |", flush=True)
        print(f"[{spent:.1f} s of processor time to make {own.found + own.nobody:,} boxes]", flush=True)
    print(PUBLISHED)


if __name__ == "__main__":
    main()
