"""How well the tracker of the tier `tracked` does on each split, in the terms in which trackers are published."""

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vbbench.boxes import cut_to_picture, overlaps, rectangles
from vbbench.generation.generator import Options
from vbbench.registry import load
from vbbench.generation.tier import Observations, Sight, Tier, get_tier
from vbbench.geometry import IntArray

SPLITS = ("hotel", "eth", "students", "street")
GIVEN = 2
"""Frames of a track whose positions are given and so not scored."""


@dataclass(frozen=True, kw_only=True)
class Watching(Tier):
    """A tier that keeps what another one sees and makes of it."""

    tier: Tier
    kept: list[tuple[Sight, Observations]] = field(default_factory=list)
    tracks = True
    hides = True

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        made = self.tier.observe(sight, rng)
        self.kept.append((sight, made))
        return made


@dataclass
class Tally:
    """Boxes of people in the picture, of them found; boxes of nobody; overlaps; switches; boxes that are scored."""

    people: int = 0
    found: int = 0
    nobody: int = 0
    switches: int = 0
    scored: int = 0
    tracks: int = 0
    overlap: float = 0.0

    def add(self, sight: Sight, made: Observations) -> None:
        assert made.persons is not None
        true = sight.boxes
        self.people += int(np.count_nonzero(~np.isnan(true[..., 2])))
        self.found += int(np.count_nonzero(made.persons >= 0))
        self.nobody += int(np.count_nonzero((made.persons < 0) & ~np.isnan(made.boxes[..., 2])))
        self.tracks += made.persons.shape[1]
        self.switches += switches(made.persons)
        self.scored += int(np.maximum(np.count_nonzero(made.persons >= 0, axis=0) - GIVEN, 0).sum())
        frame, track = np.nonzero(made.persons >= 0)
        pair = made.boxes[frame, track], true[frame, np.searchsorted(sight.people, made.persons[frame, track])]
        cut = [cut_to_picture(rectangles(boxes), sight.camera) for boxes in pair]
        for n in range(len(frame)):
            self.overlap += float(overlaps(cut[0][n : n + 1], cut[1][n : n + 1], sight.camera.period)[0, 0])

    def row(self) -> str:
        people = self.people
        figures = [1 - self.found / people, self.nobody / people, self.switches / people]
        return " | ".join(
            [
                f"{people:,}",
                *(f"{100 * value:.2f} %" for value in figures),
                f"{self.overlap / max(self.found, 1):.3f}",
                f"{100 * self.scored / people:.1f} %",
            ]
        )


def switches(persons: IntArray) -> int:
    """How often somebody is found in another track than the last time (CLEAR MOT's identity switches)."""
    frame, track = np.nonzero(persons >= 0)
    person = persons[frame, track]
    order = np.lexsort((frame, person))
    same = person[order][1:] == person[order][:-1]
    return int(np.count_nonzero(same & (track[order][1:] != track[order][:-1])))


if __name__ == "__main__":
    from vbbench_generators.tiers.tracking.fine_time import finer
    from vbbench.camera import PerspectiveCamera, PanoramaCamera

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("splits", nargs="*", default=SPLITS)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--fine", action="store_true")
    parser.add_argument("--camera")
    o = parser.parse_args()
    for split in o.splits:
        watching = Watching(name="tracked", summary="", tier=get_tier("tracked"))
        cam = {"p": PerspectiveCamera(), "o": PanoramaCamera(), None: None}[o.camera]
        plan = replace(load("generator", split).plan(Options(tier="tracked", camera=cam)), tier=watching)
        coarse, fine = Tally(), Tally()
        n = 0
        t0 = time.process_time()
        for index in range(0, len(plan), o.every):
            plan.build(index)
            n += 1
        spent = time.process_time() - t0
        for sight, made in watching.kept:
            coarse.add(sight, made)
        print(split, n, f"{spent:.1f}s", coarse.row(), coarse.tracks)
        if o.fine:
            for i, (sight, _) in enumerate(watching.kept):
                f, _n = finer(sight)
                fine.add(f, get_tier("tracked").observe(f, np.random.default_rng(i)))
            print(split, "fine", fine.row(), fine.tracks)
