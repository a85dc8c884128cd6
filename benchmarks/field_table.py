"""What the tier `field` shows of each split, and how its detector and tracker do: the tables of docs/tiers.md.

python -m benchmarks.field_table hotel students --every 8 --observer vehicle
"""

import argparse
from dataclasses import dataclass, field, replace

import numpy as np

from vbbench.boxes import pair_overlaps, rectangles
from vbbench.generation.generator import Observer, Options
from vbbench.generation.tier import Observations, Sight, Tier
from vbbench.geometry import FloatArray, IntArray, world_to_relative
from vbbench.registry import load
from vbbench_generators.tiers.field import get_field
from vbbench_generators.tiers.field.tier import field_tier

SPLITS = ("hotel", "eth", "students", "street")
OBSERVERS: tuple[Observer, ...] = ("walker", "vehicle")


@dataclass(frozen=True, kw_only=True)
class Watching(Tier):
    """The tier, which keeps what it sees."""

    sights: list[Sight] = field(default_factory=list)
    hides = True

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """What annotators draw of the sight, which is kept."""
        self.sights.append(sight)
        return field_tier.annotated().observe(sight, rng)


def sights(split: str, observer: Observer, every: int) -> list[Sight]:
    """Those of every so many-th sequence of a split."""
    watching = Watching(name="field", summary="")
    plan = replace(load("generator", split).plan(Options(tier="field", observer=observer)), tier=watching)
    for index in range(0, len(plan), every):
        plan.build(index)
    return watching.sights


def drawn_row(seen: list[Sight]) -> str:
    """Frames, people a frame, feet cut off, distances and how much shows, of boxes as people draw them."""
    camera, reach, cut, visible, frames, empty = get_field().camera, [], 0, [], 0, 0
    for number, sight in enumerate(seen):
        made = field_tier.annotated().observe(sight, np.random.default_rng(number))
        t, k, people = paired(sight, made)
        relative = world_to_relative(sight.truth.positions, sight.truth.poses)[t, people]
        reach.append(np.hypot(*relative.T))
        _, v, length = made.boxes[t, k].T
        cut += int(np.count_nonzero(v + 0.5 * length >= camera.height - 2))
        visible.append(made.visible[t, k])
        frames += len(sight.watched)
        empty += int(len(sight.watched) > 0 and not len(t))
    all_reach, shown = np.concatenate(reach), np.concatenate(visible)
    distances = " / ".join(f"{value:.1f}" for value in np.percentile(all_reach, [5, 25, 50, 75, 95]))
    return (
        f"{len(seen)} sequences ({empty / len(seen):.0%} see nobody), {frames / len(seen):.1f} frames, "
        f"{len(shown) / frames:.1f} people a frame, feet cut {cut / len(shown):.1%}, "
        f"partly hidden {np.mean(shown < 0.9):.0%}, distance {distances} m"
    )


def tracked_row(seen: list[Sight]) -> str:
    """Missed, false, switches a video frame, overlap and errors of boxes that were found and tracked."""
    there = found = false = switches = 0
    video, overlap, errors = 0, [], []
    for number, sight in enumerate(seen):
        film = field_tier.film(sight, get_field(), np.random.default_rng(number))
        made = field_tier.observe(sight, np.random.default_rng(number))
        true = film.boxes[:: film.every]
        visible = film.showing.visible[:: film.every] >= get_field().annotator.least_visible
        there += int(np.count_nonzero(~np.isnan(true[..., 2]) & visible))
        t, k, people = paired(sight, made)
        found, video = found + len(t), video + len(t) * film.every
        false += int(np.count_nonzero(~np.isnan(made.boxes[..., 2]))) - len(t)
        assert made.persons is not None
        switches += sum(changes(persons[persons >= 0]) for persons in made.persons.T)
        boxes, real = made.boxes[t, k], true[t, people]
        aspect = get_field().body.aspect
        overlap += pair_overlaps(rectangles(boxes, aspect), rectangles(real, aspect)).tolist()
        errors.append((edges(boxes) - edges(real)) / real[:, 2:])
    column, top, bottom = (1.4826 * np.median(np.abs(np.concatenate(errors)), axis=0)).tolist()
    return (
        f"missed {1 - found / there:.1%}, false {false / (found + false):.1%}, overlap {np.mean(overlap):.2f}, "
        f"switches {switches / found:.1%} of boxes, {switches / video:.2%} of video boxes, "
        f"column {column:.3f}, top {top:.3f}, bottom {bottom:.3f} of the height"
    )


def paired(sight: Sight, made: Observations) -> tuple[IntArray, IntArray, IntArray]:
    """Frames, tracks and columns of people [N] of every box of somebody."""
    if made.persons is None:
        frame, person = np.nonzero(~np.isnan(made.boxes[..., 2]))
        return frame, person, person
    frame, track = np.nonzero(made.persons >= 0)
    return frame, track, np.searchsorted(sight.people, made.persons[frame, track])


def changes(persons: IntArray) -> int:
    """How often a track goes on with somebody else."""
    return int(np.count_nonzero(np.diff(persons)))


def edges(boxes: FloatArray) -> FloatArray:
    """[N, 3] centre column, top and bottom of boxes."""
    u, v, length = boxes.T
    return np.stack([u, v - 0.5 * length, v + 0.5 * length], axis=-1)


def main() -> None:
    """Print two lines a split and observer."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("splits", nargs="*", default=SPLITS)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--observer", nargs="+", choices=OBSERVERS, default=OBSERVERS)
    asked = parser.parse_args()
    for split in asked.splits:
        for observer in asked.observer:
            seen = sights(split, observer, asked.every)
            print(f"{split}, {observer}\n  drawn: {drawn_row(seen)}\n  found: {tracked_row(seen)}", flush=True)


if __name__ == "__main__":
    main()
