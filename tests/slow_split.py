"""A split and a solver that take their time, so that workers can be lost in the middle."""

import os
import signal
import time
from dataclasses import dataclass, replace

from vbbench.dataset_info import DatasetInfo
from vbbench.generator import Generator, Options, Plan, SequenceData
from vbbench.registry import load
from vbbench.scene import Scene
from vbbench.solver import Problem
from vbbench_baselines.extrapolation import ConstantVelocity

SEQUENCES = 320
SECONDS = 0.005


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
        time.sleep(SECONDS)
        data = self.plan.build(index % len(self.plan))
        return replace(data, sequence=replace(data.sequence, index=index))


class SlowDemo:
    """The split."""

    def plan(self, options: Options) -> SlowPlan:
        generator: Generator = load("generator", "demo")
        return SlowPlan(generator.plan(options))


class SlowSolver(ConstantVelocity):
    """Waits before every sequence."""

    def start(self, problem: Problem) -> None:
        time.sleep(SECONDS)
        super().start(problem)


class DeadlySolver(ConstantVelocity):
    """Takes its process with it at one sequence."""

    def start(self, problem: Problem) -> None:
        if problem.sequence == SEQUENCES // 2:
            os.kill(os.getpid(), signal.SIGKILL)
        super().start(problem)


SLOW = SlowDemo()
