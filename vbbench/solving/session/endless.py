"""A frame-by-frame solver on an endless stream of frames, whose columns are reused for new people.

A `vbbench.solver.ForgettingSolver` is informed which people are gone. Any other solver restarts then; all solvers
restart for more columns, and after a failure. A restarted solver gets the last `SHOWN_AGAIN` frames again, with its
pose in the first of them as the origin. Nothing else is given: two frames of earlier answers, taken as exact, would
turn their errors into velocities and make it diverge. The covariance of that pose is added to its covariances:

    Σ = Σ_s + J Σ_0 Jᵀ,    J = ∂(place, yaw)/∂(pose 0) = [[1, 0, −(y − y_0)], [0, 1, x − x_0], [0, 0, 1]],

where pose 0 is that pose and Σ_0 its covariance: its error shifts and rotates all later answers.
"""

from dataclasses import dataclass, replace

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.estimate import FrameEstimate, copy_of, is_credible
from vbbench.geometry import FloatArray, IntArray, place_levers, pose_levers, relative_to_world
from vbbench.sequence import Given, Odometry
from vbbench.solver import ForgettingSolver, Frame, FrameSolver, Problem

SHOWN_AGAIN = 12
"""Frames from which a solver starts again: about as many as solvers look back."""


@dataclass(frozen=True, kw_only=True)
class _Answered:
    """An answered frame: boxes [K, 3] in px and odometry, and the pose [3] with its covariance [3, 3]."""

    observations: FloatArray
    odometry: Odometry
    pose: FloatArray
    covariance: FloatArray | None

    @property
    def base(self) -> tuple[FloatArray, FloatArray] | None:
        """Pose 0 and Σ_0 for a restart at this frame; ``None`` if the solver reported no covariance."""
        known = self.covariance is not None and np.isfinite(self.covariance).all()
        return (self.pose, np.asarray(self.covariance)) if known else None

    def without(self, columns: IntArray) -> "_Answered":
        """The frame without the people in these columns [M]."""
        observations = self.observations.copy()
        observations[columns] = np.nan
        return replace(self, observations=observations)

    def widened(self, columns: int) -> "_Answered":
        """The frame with so many columns; added ones are empty."""
        more = ((0, columns - len(self.observations)), (0, 0))
        return replace(self, observations=np.pad(self.observations, more, constant_values=np.nan))


_UNKNOWN = np.full(3, np.nan)


class EndlessRun:
    """A solver on an endless stream.

    Parameters
    ----------
    solver : the solver.
    problem : its problem, whose tracks are the numbers of the columns.
    origin : [3] pose (x, y, yaw) of the first frame, the only given one.
    """

    def __init__(self, solver: FrameSolver, problem: Problem, origin: FloatArray) -> None:
        self._solver, self._problem, self._origin = solver, problem, origin
        self._past: tuple[_Answered, ...] = ()
        self._forgotten: list[int] = []
        self._base: tuple[FloatArray, FloatArray] | None = None
        self._must_start = True

    def forget(self, columns: IntArray) -> None:
        """From the next frame on, these columns [M] stand for new people."""
        if len(columns):
            self._past = tuple(frame.without(columns) for frame in self._past)
            self._forgotten += columns.tolist()

    def widen(self, columns: int) -> None:
        """From the next frame on, there are so many columns."""
        self._past = tuple(frame.widened(columns) for frame in self._past)
        self._problem = replace(self._problem, tracks=np.arange(columns))
        self._must_start = True

    def step(self, observations: FloatArray, odometry: Odometry) -> FrameEstimate:
        """The answer for the next frame.

        Parameters
        ----------
        observations : [K, 3] boxes (u, v, l) in px, NaN = none.
        odometry : of the frames since the last answer. All but the last one were missed: they show nobody.

        Raises
        ------
        VbbenchError
            If the solver fails. It is restarted without these frames; if it fails again, from the last pose alone.
        """
        past, starts = self._past, self._must_start
        try:
            self._prepare()
            nobody = np.full_like(observations, np.nan)
            for frame in range(len(odometry.motions) - 1):
                self._answer(nobody, odometry.frames(slice(frame, frame + 1)))
            return self._answer(observations, odometry.frames(slice(-1, None)))
        except Exception as error:
            if starts and past:  # it cannot go on from its own answers: of them only the last pose is kept
                self._origin, self._base, past = past[-1].pose, past[-1].base, ()
            self._past, self._must_start = past, True
            why = str(error) if isinstance(error, VbbenchError) else f"{type(error).__name__}: {error}"
            raise VbbenchError(
                f"{type(self._solver).__name__} failed, and the frame is omitted: {why}; the session goes on"
            ) from error

    def _prepare(self) -> None:
        """Make the solver forget people who are gone, or restart it."""
        if self._forgotten and not self._must_start:
            if isinstance(self._solver, ForgettingSolver):
                self._solver.forget(np.array(self._forgotten, np.int64))
            else:
                self._must_start = True
        self._forgotten = []
        if self._must_start:
            self._start()
            self._must_start = False

    def _start(self) -> None:
        pose = self._origin
        if self._past:
            pose, self._base = self._past[0].pose, self._past[0].base
        columns = len(self._problem.tracks)
        self._index, self._given = 0, Given(poses=np.full((3, 3), np.nan), positions=np.full((3, columns, 2), np.nan))
        self._odometry = Odometry.unmeasured(3)
        self._solver.start(self._problem)
        for frame in self._past:
            self._feed(frame.observations, pose, frame.odometry)
            pose = _UNKNOWN

    def _answer(self, observations: FloatArray, odometry: Odometry) -> FrameEstimate:
        answer = self._with_base(self._feed(observations, _UNKNOWN if self._past else self._origin, odometry))
        seen = ~np.isnan(observations[:, 2])
        if not is_credible(answer.pose).all():
            if seen.any() or not self._past:
                raise VbbenchError(
                    f"its pose is {np.array2string(answer.pose, precision=3)} in frame {self._index - 1}"
                )
            answer = replace(answer, pose=_moved(self._past[-1].pose, odometry.motions[0]), converged=False)
        answered = _Answered(
            observations=observations, odometry=odometry, pose=answer.pose, covariance=answer.pose_covariance
        )
        self._past = (*self._past, answered)[-SHOWN_AGAIN:]
        known = seen[:, None] & is_credible(answer.positions).all(axis=1, keepdims=True)
        return replace(answer, positions=np.where(known, answer.positions, np.nan))

    def _feed(self, observations: FloatArray, pose: FloatArray, odometry: Odometry) -> FrameEstimate:
        """Give the solver a frame; its ``pose`` is given unless it is NaN."""
        before = self._given
        self._odometry = self._odometry.frames(slice(1, None)).followed_by(odometry)
        self._given = Given(
            poses=np.concatenate([before.poses[1:], pose[None]]),
            positions=before.positions,
            odometry=None if np.isnan(self._odometry.motions).all() else self._odometry,
        )
        answer = self._solver.step(Frame(index=self._index, observations=observations.copy(), given=self._given))
        self._index += 1
        if not isinstance(answer, FrameEstimate):
            raise VbbenchError(f"it returned a {type(answer).__name__}, not a FrameEstimate")
        answer = copy_of(answer)
        if answer.positions.shape != (len(observations), 2):
            raise VbbenchError(f"its positions have shape {list(answer.positions.shape)}, not {[len(observations), 2]}")
        return answer

    def _with_base(self, answer: FrameEstimate) -> FrameEstimate:
        """The answer with the covariance of the restart's pose added."""
        if self._base is None or answer.pose_covariance is None:
            return answer
        start, sigma = self._base
        lever = pose_levers(answer.pose, start)
        positions = answer.position_covariances
        if positions is not None:
            levers = place_levers(answer.positions, start)
            positions = positions + levers @ sigma @ levers.transpose(0, 2, 1)
        return replace(
            answer,
            pose_covariance=answer.pose_covariance + lever @ sigma @ lever.T,
            position_covariances=positions,
        )


def _moved(pose: FloatArray, motion: FloatArray) -> FloatArray:
    """A pose [3] after a motion (forward, left, turn) in its axes; the same where that was not measured."""
    forward, left, turn = np.nan_to_num(motion)
    return np.array([*relative_to_world(np.array([[-left, forward]]), pose)[0], pose[2] + turn])
