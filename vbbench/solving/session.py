"""`Session`: a solver on a robot's measurements, frame by frame (docs/robot.md).

A frame-by-frame solver on an endless stream of frames, whose columns are reused for new people.

A `vbbench.solver.ForgettingSolver` is informed which people are gone. Any other solver restarts then; all solvers
restart for more columns, and after a failure. A restarted solver gets the last `SHOWN_AGAIN` frames again, with its
pose in the first of them as the origin. Nothing else is given: two frames of earlier answers, taken as exact, would
turn their errors into velocities and make it diverge. The covariance of that pose is added to its covariances:

    Σ = Σ_s + J Σ_0 Jᵀ,    J = ∂(place, yaw)/∂(pose 0) = [[1, 0, −(y − y_0)], [0, 1, x − x_0], [0, 0, 1]],

where pose 0 is that pose and Σ_0 its covariance: its error shifts and rotates all later answers.
"""

import math
import warnings
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from vbbench.boxes import observations_of, rectangles
from vbbench.camera import Camera
from vbbench.errors import VbbenchError, VbbenchWarning, quoted, user_mistakes
from vbbench.estimate import LARGEST, FrameEstimate, copy_of, is_credible
from vbbench.geometry import FloatArray, IntArray, place_levers, pose_levers, relative_to_world
from vbbench.parsing.numbers import BODY_HEIGHT, FRAME_TIME, Within, notes_on_dt
from vbbench.registry import make_solver
from vbbench.sequence import Given, Odometry
from vbbench.solver import Carrier, ForgettingSolver, Frame, FrameSolver, Problem, SequenceSolver
from vbbench.solving.measured import (
    BoxWatch,
    Columns,
    FrameClock,
    OfTracks,
    check_in_picture,
    read_boxes,
    read_odometry,
    shared_out,
)

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

        Raises VbbenchError if the solver fails. It is restarted without these frames; if it fails again, from the last
        pose alone.

        Parameters
        ----------
        observations : [K, 3] boxes (u, v, l) in px, NaN = none.
        odometry : of the frames since the last answer. All but the last one were missed: they show nobody.
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


PEOPLE, MOST_PEOPLE = 256, 100_000
"""Columns of the solver's arrays to begin with, and at most."""

FORGOTTEN = Within(0.001, 999_999.0, "s")
"""After how long people may be forgotten."""

SPREAD = Within(0.0, 10_000.0)
TILT_SPREAD = Within(0.0, 0.8, "rad")
BOX_SPREAD = Within(0.0, 0.8, "of a box's height")
"""What a standard deviation may be."""


@dataclass(frozen=True, kw_only=True)
class SessionAnswer:
    """Poses and positions of a frame in the map's axes; arrays are read-only.

    Parameters
    ----------
    pose : [3] (x, y, yaw) of the camera in m and rad.
    pose_covariance : [3, 3] covariance of the pose in m², m·rad and rad²; ``None`` if the solver reports none.
    positions : [2] (x, y) in m of every track seen in this frame for which the solver has a place.
    position_covariances : [2, 2] covariances of these in m², if the solver reports any.
    heights : heights of the same people in m, if the solver reports any.
    converged : False warns that the pose may be far off; ``None`` if the solver does not report it.
    """

    pose: FloatArray
    pose_covariance: FloatArray | None
    positions: dict[Hashable, FloatArray]
    position_covariances: dict[Hashable, FloatArray]
    heights: dict[Hashable, float]
    converged: bool | None


class Session:
    """A solver on a robot.

    The first frame fixes the map: its pose is ``origin``, and nothing else is ever given (protocol `cold-start`).
    A track that was not seen for ``forget_after`` seconds is forgotten, and its id then stands for a new person. Memory
    is bounded by the greatest number of people seen at once. Boxes that cannot be people in this picture, such as
    corners, shares or px of another size, cause a VbbenchWarning, once for each map.

    A frame that cannot be used raises VbbenchError and is skipped; the odometry of the next one must reach back to the
    last frame that was answered.

    Raises VbbenchError if a number lies outside its range, or the solver is unknown or solves whole sequences only.

    Parameters
    ----------
    solver : a registered name, ``module:attribute``, or an object with ``start`` and ``step``, which then belongs to
        the session.
    camera : intrinsics, mount height and tilt.
    dt : seconds per frame.
    height_mean, height_std : prior N(μ_h, σ_h²) of a person's height, in m.
    pixel_std : standard deviation in px of a box's column, top and bottom.
    tilt_std, mount_height_std : standard deviations in rad and m of tilt and mount height about those of ``camera``; 0
        where they are exact.
    box_std : standard deviation of a box's borders, as a share of its height, in addition to ``pixel_std``.
    carried_by : carrier of the camera: ``person``, ``vehicle``, ``robot`` or ``unknown``.
    box_edge : distance in m from a person's axis to the plane in which top and bottom of a box lie, such as .45 for
        projections of cuboids; ``None`` where it is not known.
    covariances : whether covariances are computed; this takes time.
    origin : (x, y, yaw) of the camera in the first frame, in m and rad.
    forget_after : seconds out of sight after which a track is forgotten.
    people : initial number of columns of the solver's arrays; more are added when needed.
    """

    def __init__(
        self,
        solver: str | FrameSolver,
        camera: Camera,
        dt: float,
        *,
        height_mean: float = 1.72,
        height_std: float = 0.09,
        pixel_std: float = 2.0,
        tilt_std: float = 0.0,
        mount_height_std: float = 0.0,
        box_std: float = 0.0,
        carried_by: Carrier = "unknown",
        box_edge: float | None = None,
        covariances: bool = True,
        origin: ArrayLike = (0.0, 0.0, 0.0),
        forget_after: float = 10.0,
        people: int = PEOPLE,
    ) -> None:
        spreads = {
            "height_std": (height_std, SPREAD),
            "pixel_std": (pixel_std, SPREAD),
            "tilt_std": (tilt_std, TILT_SPREAD),
            "mount_height_std": (mount_height_std, SPREAD),
            "box_std": (box_std, BOX_SPREAD),
        }
        if not isinstance(camera, Camera) or isinstance(camera, type):
            raise VbbenchError(f"camera must be one such as vbbench.PerspectiveCamera(...), not {quoted(camera)}")
        with user_mistakes():
            FRAME_TIME.check("dt", dt)
            BODY_HEIGHT.check("height_mean", height_mean)
            FORGOTTEN.check("forget_after", forget_after)
            for name, (value, possible) in spreads.items():
                possible.check(name, value)
        if isinstance(people, bool) or not isinstance(people, (int, np.integer)) or not 1 <= people <= MOST_PEOPLE:
            raise VbbenchError(f"people must be a whole number from 1 to {MOST_PEOPLE:,}, not {quoted(people)}")
        start = _numbers(origin)
        if start.shape != (3,) or not np.isfinite(start).all():
            raise VbbenchError(f"origin must be (x, y, yaw) in m and rad, not {quoted(origin)}")
        if not is_credible(start).all():
            far = f"origin is {quoted(origin)}, and no answer goes beyond {LARGEST:,.0f} m"
            raise VbbenchError(f"{far}; begin at a place nearby, and add what is left to the answers")
        with user_mistakes():
            problem = Problem(
                camera=camera,
                dt=float(dt),
                tracks=np.arange(int(people)),
                height_mean=height_mean,
                height_std=float(height_std),
                pixel_std=float(pixel_std),
                tilt_std=float(tilt_std),
                mount_height_std=float(mount_height_std),
                box_std=float(box_std),
                carried_by=carried_by,
                box_edge=box_edge,
                covariances=covariances,
            )
        for note in notes_on_dt(dt):
            warnings.warn(VbbenchWarning(note), stacklevel=2)
        self.camera = camera
        self._solver, self._problem, self._origin = _frame_solver(solver), problem, start
        self._patience = max(1, math.ceil(forget_after / dt))
        self.reset()

    def reset(self) -> None:
        """Begin a new map: the next frame is its first, with any time stamp, and all people are forgotten."""
        self._columns = Columns(len(self._problem.tracks), self._patience)
        self._run = EndlessRun(self._solver, self._problem, self._origin)
        self._clock, self._frame = FrameClock(dt=self._problem.dt), -1
        self._watch = BoxWatch(self.camera, self._problem.height_mean)
        self._asked = False

    def step(
        self,
        boxes: OfTracks,
        odometry: tuple[ArrayLike, ArrayLike] | None = None,
        *,
        time: float | None = None,
    ) -> SessionAnswer:
        """The answer for the next frame.

        Raises VbbenchError if an argument is not valid, or the solver fails.

        Parameters
        ----------
        boxes : {id: (left, top, width, height)} in px of all people seen, or pairs of these; may be empty. Ids are
            hashable objects.
        odometry : the motion [3] (forward, left, turn) since the last frame that was answered, in m and rad in that
            frame's axes, and its covariance [3, 3]; ``None`` where none was measured.
        time : time of the frame, in s of any clock. Missed frames since the last one are then added, without boxes. By
            default, a frame is ``dt`` later than the one before.
        """
        tracks, sides = read_boxes(boxes, ("left", "top", "width", "height"))
        self._watch.see(sides)
        return self._step(tracks, observations_of(sides, self.camera), odometry, time)

    def step_observations(
        self,
        observations: OfTracks,
        odometry: tuple[ArrayLike, ArrayLike] | None = None,
        *,
        time: float | None = None,
    ) -> SessionAnswer:
        """As `step`, from {id: (u, v, l)}: the centres and heights of boxes in px, as in a dataset."""
        tracks, numbers = read_boxes(observations, ("u", "v", "l"))
        self._watch.see(rectangles(numbers))
        return self._step(tracks, numbers, odometry, time)

    def _step(
        self,
        tracks: list[Hashable],
        observations: FloatArray,
        odometry: tuple[ArrayLike, ArrayLike] | None,
        time: float | None,
    ) -> SessionAnswer:
        check_in_picture(tracks, observations, self.camera)
        passed, clock = self._clock.advanced(time)
        seconds = passed * self._problem.dt
        if passed >= max(2, self._patience) and self._columns.know(tracks) and not self._asked:
            self._asked = True
            again = f"the same people are seen again after {seconds:g} s, {passed} frames: is the time in s?"
            warnings.warn(VbbenchWarning(again), stacklevel=3)
        passed = min(passed, self._patience)  # by then everybody is forgotten, and more frames would add nothing
        moved = (
            Odometry.unmeasured(passed) if odometry is None else shared_out(read_odometry(odometry, seconds), passed)
        )
        columns = self._columns_of(tracks, self._frame + passed)
        shown = np.full((self._columns.count, 3), np.nan)
        shown[columns] = observations
        answer = self._run.step(shown, moved)
        self._clock, self._frame = clock, self._frame + passed
        return _answer_of(answer, tracks, columns.tolist())

    def _columns_of(self, tracks: Sequence[Hashable], frame: int) -> IntArray:
        """The columns [N] of the tracks of a frame; informs the solver of people who are gone and of added columns."""
        columns = self._columns
        columns.expire(frame)
        self._run.forget(columns.clear_for(tracks))
        if columns.lack(tracks):
            columns.widen(tracks)
            self._run.widen(columns.count)
        return columns.place(tracks, frame)


def _frame_solver(solver: str | FrameSolver) -> FrameSolver:
    """The solver, made if it is a name."""
    made = make_solver(solver) if isinstance(solver, str) else solver
    if isinstance(made, type):
        raise VbbenchError(f"{made.__name__} is a class; give the session an object of it, {made.__name__}()")
    if isinstance(made, FrameSolver):
        return made
    kind = "solves whole sequences" if isinstance(made, SequenceSolver) else "has no start and step"
    raise VbbenchError(f"{type(made).__name__} {kind}; a session needs a solver that works frame by frame: map-causal")


def _numbers(values: ArrayLike) -> FloatArray:
    """A copy of the values as an array; an empty one if they are not numbers."""
    try:
        return np.array(values, np.float64)
    except (TypeError, ValueError):
        return np.empty(0)


def _answer_of(answer: FrameEstimate, tracks: list[Hashable], columns: list[int]) -> SessionAnswer:
    known = [
        (track, column)
        for track, column, x in zip(tracks, columns, answer.positions[columns, 0].tolist(), strict=True)
        if not math.isnan(x)
    ]
    covariances, heights = answer.position_covariances, answer.heights
    return SessionAnswer(
        pose=answer.pose,
        pose_covariance=answer.pose_covariance,
        positions={track: answer.positions[column] for track, column in known},
        position_covariances={} if covariances is None else {track: covariances[column] for track, column in known},
        heights={} if heights is None else {track: float(heights[column]) for track, column in known},
        converged=answer.converged,
    )
