"""The datasets of the benchmark, made once in a folder, and what is done to their sequences."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from vbbench.camera import Camera
from vbbench.files.dataset import Dataset
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Observer, Options
from vbbench.generation.planning import thinned
from vbbench.geometry import BoolArray, FloatArray, world_to_relative
from vbbench.protocol import arrivals_given
from vbbench.registry import load
from vbbench.reproduction.grid import Making
from vbbench.sequence import Sequence, Truth
from vbbench_generators.footage.kitti import WALKERS
from vbbench_generators.footage.kitti.split import KittiSplit

STRIDES = {"hotel": None, "eth-15fps": None, "students-resampled": 8, "sim": 4}
"""The splits of the boards, and every how many-th sequence is taken of each."""
FIELD_STRIDES = {"hotel": None, "eth-15fps": None, "students-resampled": 2, "sim": 4}
"""The same of tier `field`, where there are fewer sequences."""

NOISE, MEMORY = 0.03, 1.0
"""Standard deviation of a box's height, as a share of it, and the time in s in which that is forgotten."""

EDGE = 0.45
"""In m, how much nearer the edge of a body is that a box is about than its middle."""

GAP, BEFORE = 27, 5
"""Frames without a box, and frames before them."""
STILL = 0.3
"""How far in m a camera that stands may be from where it was first: truth moves by some centimetres."""


@dataclass(frozen=True, kw_only=True)
class Scenes:
    """Makes datasets and keeps them.

    Parameters
    ----------
    kitti : KITTI's folder, with ``training`` and ``poses`` in it.
    cache : folder for the datasets.
    detections : folder of a detector's boxes on KITTI; ``None`` for ``detections`` beside ``training``.
    jobs : processes.
    """

    kitti: Path
    cache: Path
    detections: Path | None = None
    jobs: int = 1

    def footage(self, recording: str, every: int, *, seated: bool = False, found: bool = False) -> Dataset:
        """A recording of KITTI.

        Without people who sit it has the runs of REAL.md: 6 and 18 of 0019, 1 and 3 of 0015, 1 and 4 of 0017.

        Parameters
        ----------
        every : every how many frames.
        seated : whether people who sit count, as ``vbbench generate kitti`` has it.
        found : whether boxes are the detector's.
        """
        boxes = (self.detections or self.kitti / "detections") if found else None
        asked = FootageOptions(sequences=(recording,), every=every, poses=self.kitti / "poses", boxes=boxes)
        split = KittiSplit(classes=WALKERS if seated else ("Pedestrian",))
        name = f"kitti-{recording}-{every}{'-seated' * seated}{'-found' * found}"
        return Making(jobs=self.jobs).planned(split.plan(Options(source=self.kitti, footage=asked)), self.cache / name)

    def board(self, split: str, tier: str) -> Dataset:
        """Some sequences of a board; in tier `field` a vehicle watches, as on the boards."""
        observer: Observer = "vehicle" if tier == "field" else "walker"
        stride = (FIELD_STRIDES if tier == "field" else STRIDES)[split]
        plan = load("generator", split).plan(Options(tier=tier, observer=observer))
        return Making(jobs=self.jobs).planned(thinned(plan, stride), self.cache / f"{split}-{tier}")


def stands(truth: Truth) -> bool:
    """Whether the camera stays where it is."""
    return bool(np.hypot(*(truth.poses[:, :2] - truth.poses[0, :2]).T).max() < STILL)


def has_gap(truth: Truth) -> bool:
    """Whether a sequence is long enough for a gap and ten frames after it."""
    return len(truth.poses) >= BEFORE + GAP + 10


def noisy_heights(dt: float, foot: bool) -> Callable[[Sequence, Truth, int], Sequence]:
    """Boxes whose height errs slowly, about the centre, or with the bottom where it is (``foot``); see `NOISE`."""

    def change(sequence: Sequence, _truth: Truth, seed: int) -> Sequence:
        boxes = sequence.observations.copy()
        errors = autoregression(boxes.shape[:2], dt, np.random.default_rng((seed, sequence.index)))
        heights = boxes[..., 2] * (1.0 + NOISE * errors)
        if foot:
            boxes[..., 1] += 0.5 * (boxes[..., 2] - heights)
        boxes[..., 2] = heights
        return replace(sequence, observations=boxes)

    return change


def exact_boxes(camera: Camera) -> Callable[[Sequence, Truth, int], Sequence]:
    """The boxes that people's true places have in a level ``camera`` without any error, about their nearer edge."""

    def change(sequence: Sequence, truth: Truth, _seed: int) -> Sequence:
        relative = world_to_relative(truth.positions, truth.poses)
        heights = np.broadcast_to(truth.heights, relative.shape[:-1])
        boxes, nearer = camera.project(relative, heights), relative - (0.0, EDGE)
        boxes[..., 1:] = camera.project(nearer, heights)[..., 1:]
        return replace(sequence, observations=np.where(sequence.observed[..., None], boxes, np.nan))

    return change


def autoregression(shape: tuple[int, int], dt: float, rng: np.random.Generator) -> FloatArray:
    """[T, K] normal errors of variance 1 whose correlation falls by e in `MEMORY` s."""
    errors, kept = rng.normal(size=shape), np.exp(-dt / MEMORY)
    for t in range(1, len(errors)):
        errors[t] = kept * errors[t - 1] + np.sqrt(1.0 - kept**2) * errors[t]
    return errors


Company = Literal["everybody", "arrivals", "one"]
"""Who is seen after a gap: everybody who is there, those who come after it, or of these one at a time."""


def with_gap(company: Company, gap: int = GAP, before: int = BEFORE) -> Callable[[Sequence, Truth, int], Sequence]:
    """Nobody is seen for ``gap`` frames after ``before`` of them.

    Everybody seen after it comes as an arrival, whose first two places are given. Whoever is seen before it does not
    come back.
    """

    def change(sequence: Sequence, truth: Truth, _seed: int) -> Sequence:
        frame, observed = np.arange(sequence.frames)[:, None], sequence.observed
        early, after = frame < before, frame >= before + gap
        known = (observed & (early if company == "everybody" else ~after)).any(axis=0)
        late = observed & after & ~known
        seen = (observed & early) | (one_at_a_time(late) if company == "one" else late)
        boxes = np.where(seen[..., None], sequence.observations, np.nan)
        given = arrivals_given(truth, seen & np.isfinite(truth.positions[..., 0]))
        visible = np.where(seen, sequence.visible, np.nan)
        return replace(sequence, observations=boxes, visible=visible, given=given)

    return change


def one_at_a_time(seen: BoolArray) -> BoolArray:
    """Of who is ``seen`` [T, K], one person a frame: the next who arrives, once nobody is there."""
    kept, new, followed = np.zeros_like(seen), np.ones(seen.shape[1], np.bool_), -1
    for t, row in enumerate(seen):
        if followed < 0 or not row[followed]:
            followed = int(np.argmax(row & new)) if (row & new).any() else -1
        if followed >= 0:
            kept[t, followed] = True
        new &= ~row
    return kept
