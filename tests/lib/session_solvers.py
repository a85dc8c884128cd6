"""Small solvers that keep what a session shows them: shared by the tests of sessions."""

from dataclasses import replace
from typing import Any

import numpy as np

from vbbench.geometry import FloatArray, IntArray, relative_to_world
from vbbench.solver import Frame, FrameEstimate, Problem


class Watched:
    """Answers with the given or measured pose, and with places for the mean height; keeps all it is shown."""

    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self.starts: list[int] = []
        self.fail_next = self.fail_at_start = False

    def start(self, problem: Problem) -> None:
        self.problem, self.pose = problem, np.full(3, np.nan)
        self.starts.append(len(self.frames))

    def step(self, frame: Frame) -> FrameEstimate:
        self.frames.append(frame)
        if self.fail_next or (self.fail_at_start and frame.index == 0):
            self.fail_next = self.fail_at_start = False
            raise np.linalg.LinAlgError("Singular matrix")
        given, odometry = frame.given.poses[-1], frame.given.odometry
        if not np.isnan(given[0]):
            self.pose = given
        elif odometry is not None:
            self.pose = moved(self.pose, np.nan_to_num(odometry.motions[-1]))
        people = len(frame.observations)
        relative = self.problem.camera.unproject(frame.observations, np.full(people, self.problem.height_mean))
        answer = FrameEstimate(pose=self.pose, positions=relative_to_world(relative, self.pose), converged=True)
        return answer if not self.problem.covariances else replace(answer, **self.covariances(frame))

    def covariances(self, frame: Frame) -> dict[str, Any]:
        """Unsure of the yaw only: a standard deviation of .1 rad in every frame but the first."""
        sigma = np.diag([0.0, 0.0, 0.01 if frame.index else 0.0])
        return {
            "pose_covariance": sigma,
            "position_covariances": np.tile(0.04 * np.eye(2), (len(frame.observations), 1, 1)),
            "heights": np.full(len(frame.observations), self.problem.height_mean),
        }


class Forgetful(Watched):
    """The same; it can forget single people."""

    def __init__(self) -> None:
        super().__init__()
        self.forgotten: list[tuple[int, list[int]]] = []

    def forget(self, columns: IntArray) -> None:
        self.forgotten.append((len(self.frames), columns.tolist()))


class SilentAfterTheOrigin(Watched):
    """A solver that says nothing but the first pose."""

    def step(self, frame: Frame) -> FrameEstimate:
        answer = super().step(frame)
        return answer if frame.index == 0 else replace(answer, pose=np.full(3, np.nan))


def moved(pose: FloatArray, motion: FloatArray) -> FloatArray:
    """A pose [3] after a motion (forward, left, turn)."""
    place = relative_to_world(np.array([[-motion[1], motion[0]]]), pose)[0]
    return np.array([*place, pose[2] + motion[2]])
