"""A split and solvers that wait at a gate, so that workers can be lost in the middle and nowhere else."""

import os
import signal
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.sequence_tables import PART_SIZE
from vbbench.generation.generator import Card, Generator, Options, Plan
from vbbench.registry import load
from vbbench.scene import Scene
from vbbench.sequence import SequenceData
from vbbench.solver import Frame, FrameEstimate
from vbbench_baselines.extrapolation import ConstantVelocity

PARTS, BEFORE_THE_GATE = 6, 3
SEQUENCES = PARTS * PART_SIZE

GATE = "VBBENCH_TEST_GATE"
"""Environment variable of a file: while it is not there, no part but the first three comes to its end."""


def pass_gate(sequence: int) -> None:
    """Wait until the gate is open; a file beside it says that somebody waits."""
    gate, end = os.environ.get(GATE), time.monotonic() + 600
    if sequence < BEFORE_THE_GATE * PART_SIZE or not gate:
        return
    while not Path(gate).exists():
        Path(gate + ".reached").touch()
        assert time.monotonic() < end, "nobody opened the gate"
        time.sleep(0.01)


@dataclass(frozen=True)
class SlowPlan:
    """The sequences of the demo split again and again."""

    plan: Plan

    @property
    def info(self) -> DatasetInfo:
        return replace(self.plan.info, split="slow")

    @property
    def scenes(self) -> tuple[Scene, ...]:
        return self.plan.scenes

    def __len__(self) -> int:
        return SEQUENCES

    def build(self, index: int) -> SequenceData:
        pass_gate(index)
        data = self.plan.build(index % len(self.plan))
        boxes = data.sequence.observations.copy()
        boxes[0, data.sequence.observed[0], 1] = -1.0 - index  # solvers are not told which sequence it is
        return replace(data, sequence=replace(data.sequence, index=index, observations=boxes))


def sequence_of(frame: Frame) -> int:
    """The number of the sequence that begins with this frame of the split; −1 for any other frame."""
    rows = frame.observations[:, 1]
    told = frame.index == 0 and (rows < 0.0).any()
    return int(-1.0 - np.nanmin(rows)) if told else -1


class SlowDemo:
    """The split."""

    @property
    def card(self) -> Card:
        """That of the split which it slows down."""
        generator: Generator = load("generator", "demo")
        return generator.card

    def plan(self, options: Options) -> SlowPlan:
        generator: Generator = load("generator", "demo")
        return SlowPlan(generator.plan(options))


class DeadlySolver(ConstantVelocity):
    """Takes its process with it in the last sequence."""

    def step(self, frame: Frame) -> FrameEstimate:
        if sequence_of(frame) == SEQUENCES - 1:
            os.kill(os.getpid(), signal.SIGKILL)
        return super().step(frame)


SLOW = SlowDemo()
