"""The verdict of a map, in words: its usable parts by covariances, convergence and plausible speeds."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.estimate import Estimate
from vbbench.geometry import BoolArray, FloatArray, covariance_along, place_levers, runs_of_true
from vbbench.solver import Carrier

FASTEST: dict[Carrier, float] = {"person": 4.0, "robot": 5.0, "vehicle": 30.0, "unknown": 30.0}
"""Speeds in m/s that no camera exceeds, by what carries it."""
FASTEST_PEOPLE = 4.0
"""The same of people."""
SOON = 10.0
"""Seconds from the start after which the drift is stated."""
USABLE, USABLE_SHARE = 3.0, 0.2
"""A path is usable while it is within so many m, or within this share of the way, whichever is more."""
APART = 1.0
"""Parts of a map that are nearer in time than so many seconds are one; a path that holds no longer holds not at all."""
MOST_PARTS, MOST_NAMED = 3, 5
"""Most parts and ids that are named; the rest is counted."""
WHOLE = 0.9
"""If a larger share of the time is not usable, nothing is."""
CERTAIN = NormalDist().inv_cdf(0.975)
"""Standard deviations of an error that hold 95 % of errors along one direction, and more of those in a plane."""
_DEVIATIONS = np.array([NormalDist().inv_cdf(0.5 + (n + 0.5) / 200) for n in range(100)])
"""Sizes of errors in standard deviations, equally probable."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """An unusable part of the map: times in s from the first frame, and the cause."""

    begin: float
    end: float
    cause: str


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The usable parts of a map; times are in s from the first frame.

    Parameters
    ----------
    seconds : length of the recording.
    people : radius in m that holds 95 % of people's places around the camera; ``None`` = not computable.
    soon, soon_after : radius in m that holds the camera's place with 95 % after this time; ``None`` = not reported.
    end : the same in the last frame.
    usable : time until which the path is usable; then it is too uncertain, or the camera jumps.
    parts : the unusable parts, in order of time.
    fast : ids of people who would move faster than people do.
    walkers : number of people whose speed is known.
    """

    seconds: float
    people: float | None
    soon: float | None
    soon_after: float
    end: float | None
    usable: float
    parts: tuple[Part, ...]
    fast: tuple[Any, ...]
    walkers: int

    def sentences(self) -> tuple[str, ...]:
        """The verdict in words."""
        longest = max(self.parts, key=_length, default=None)
        if longest is not None and sum(map(_length, self.parts)) > WHOLE * self.seconds:
            return (f"Nothing of this map is usable: {longest.cause}.",)
        return (*self._places(), *self._path(), *self._parts(), *self._fast())

    def lost(self, frames: int) -> BoolArray:
        """Mask [T] of the recording's ``frames`` in which the path is not usable."""
        time = (np.arange(frames) + 0.5) * self.seconds / frames
        within = [(part.begin < time) & (time < part.end) for part in self.parts]
        return np.asarray(np.any([time > self.usable, *within], axis=0))

    def _places(self) -> Iterator[str]:
        if self.people is not None:
            yield f"Places of people around the camera: within {_metres(self.people)} (95 %)."
        elif self.soon is None:
            yield "The solver reports no uncertainty: how far places and path are off is not known."
        else:
            yield "Places of people around the camera: how far they are off does not follow from the covariances."

    def _path(self) -> Iterator[str]:
        beyond = f"not usable beyond {_seconds(self.usable)}"
        if self.usable < min(APART, self.seconds):
            yield "The path of the camera is not usable."
        elif self.usable < self.soon_after or (self.soon is None and self.usable < self.seconds):
            yield f"The path of the camera is {beyond}."
        elif self.soon is not None and self.end is not None:
            soon = f"within {_metres(self.soon)} after {_seconds(self.soon_after)}"
            end = f"within {_metres(self.end)} at the end ({_seconds(self.seconds)})"
            if self.usable < self.seconds:
                yield f"The path drifts: {soon}, {beyond}."
            elif self.soon_after + APART < self.seconds:
                yield f"The path drifts: {soon}, {end}."
            else:
                yield f"The path of the camera: {end}."

    def _parts(self) -> Iterator[str]:
        for cause in dict.fromkeys(part.cause for part in self.parts):
            own = [part for part in self.parts if part.cause == cause]
            longest = sorted(own, key=_length)[-MOST_PARTS:]
            times = [self._time(part) for part in own if part in longest]
            more = len(own) - len(times)
            shorter = [f"in {more} shorter part{'s' * (more > 1)}"] if more else []
            yield f"Not usable {_listed([*times, *shorter])}: {cause}."

    def _time(self, part: Part) -> str:
        if part.end >= self.seconds:
            return f"from {part.begin:.1f} s to the end"
        return f"from {part.begin:.1f} to {part.end:.1f} s"

    def _fast(self) -> Iterator[str]:
        if self.fast:
            named = ", ".join(map(str, self.fast[:MOST_NAMED])) + (", …" if len(self.fast) > MOST_NAMED else "")
            some = f"{len(self.fast)} of {self.walkers} people ({named})"
            yield f"{some} would move faster than {FASTEST_PEOPLE:g} m/s: their places are not usable."


def judge(
    answer: Estimate, observed: BoolArray, dt: float, ids: Sequence[Any] | NDArray[Any], carried_by: Carrier = "unknown"
) -> Verdict:
    """Judge a map.

    Parameters
    ----------
    answer : the estimate, whose first pose is given.
    observed : [T, K] mask of boxes.
    dt : seconds per frame.
    ids : [K] ids of people.
    carried_by : carrier of the camera.
    """
    frames = len(answer.poses)
    second = min(max(1, round(1.0 / dt)), frames - 1)
    camera = _speeds(answer.poses[:, :2], second, dt)
    people = _speeds(np.where(observed[..., None], answer.positions, np.nan), second, dt)
    crowd, usual = _medians(people), _medians(people.T, fewest=1)
    leaps = _around(camera > FASTEST[carried_by], second)
    lost = {
        f"the camera would move at {np.nanmax(camera, initial=0.0):.0f} m/s": leaps,
        f"people would move at {np.nanmax(crowd, initial=0.0):.0f} m/s": _around(crowd > FASTEST_PEOPLE, second),
        "the estimate did not converge": ~answer.converged if answer.converged is not None else np.zeros_like(leaps),
    }
    seconds, radii = frames * dt, _radii(answer)
    near = ~(radii > np.maximum(USABLE, USABLE_SHARE * _way(answer.poses, second)))
    soon, known = min(round(SOON / dt), frames - 1), bool(np.isfinite(radii).any())
    return Verdict(
        seconds=seconds,
        people=_radius_of_people(answer, observed & ~np.any(list(lost.values()), axis=0)[:, None]),
        soon=float(radii[soon]) if known else None,
        soon_after=min(SOON, seconds),
        end=float(radii[-1]) if known else None,
        usable=dt * min(int(np.flatnonzero(near).max(initial=-1)) + 1, int(np.append(leaps, True).argmax())),
        parts=tuple(_lost_parts(lost, dt)),
        fast=tuple(np.asarray(ids)[usual > FASTEST_PEOPLE].tolist()),
        walkers=int(np.isfinite(usual).sum()),
    )


def _speeds(places: FloatArray, second: int, dt: float) -> FloatArray:
    """[T − ``second``, ...] speeds in m/s over so many frames, of places [T, ..., 2]."""
    return np.asarray(np.linalg.norm(places[second:] - places[:-second], axis=-1) / (second * dt))


def _medians(values: FloatArray, fewest: int = 2) -> FloatArray:
    """[N] medians of the known values [N, M], if there are at least ``fewest``; else NaN."""
    ordered, count = np.sort(values, axis=1), np.isfinite(values).sum(axis=1)
    medians = np.full(len(values), np.nan)
    enough = np.flatnonzero(count >= fewest)
    middle = [ordered[enough, place] for place in ((count[enough] - 1) // 2, count[enough] // 2)]
    medians[enough] = np.mean(middle, axis=0)
    return medians


def _around(marks: BoolArray, second: int) -> BoolArray:
    """Mask [T] of the frames within the marked intervals [T − ``second``], each of ``second`` frames."""
    reached = np.convolve(marks, np.ones(second + 1))
    return np.asarray(reached > 0)


def _way(poses: FloatArray, second: int) -> FloatArray:
    """[T] distance in m travelled so far, over steps of a second."""
    corners = np.arange(0, len(poses), second)
    steps = np.nan_to_num(np.linalg.norm(np.diff(poses[corners, :2], axis=0), axis=-1))
    return np.asarray(np.interp(np.arange(len(poses)), corners, np.append(0.0, np.cumsum(steps))))


def _radii(answer: Estimate) -> FloatArray:
    """[T] radius in m that holds the camera's place with 95 %, interpolated over frames without covariance."""
    radii = np.full(len(answer.poses), np.nan)
    if answer.pose_covariances is None:
        return radii
    variance = np.trace(answer.pose_covariances[:, :2, :2], axis1=1, axis2=2)
    known = np.flatnonzero(np.isfinite(variance))
    if not len(known):
        return radii
    return np.asarray(np.interp(np.arange(len(radii)), known, CERTAIN * np.sqrt(np.maximum(variance[known], 0.0))))


def _radius_of_people(answer: Estimate, seen: BoolArray) -> float | None:
    """Radius in m that holds 95 % of the places, relative to the camera, of people who are ``seen`` [T, K].

    The error of a place in the map is that of the pose, propagated to it, plus one relative to the camera. The
    covariance of the latter is the difference of the two covariances. If that is hardly positive, these are
    inconsistent.
    """
    if answer.pose_covariances is None or answer.position_covariances is None:
        return None
    frame, column = np.nonzero(seen & np.isfinite(answer.position_covariances[..., 0, 0]))
    levers = place_levers(answer.positions[frame, column], answer.poses[frame].T)
    of_pose = covariance_along(levers, answer.pose_covariances[frame])
    variance = np.trace(answer.position_covariances[frame, column] - of_pose, axis1=1, axis2=2)
    variance = variance[np.isfinite(variance)]
    if not len(variance) or np.median(variance) <= 0.0:
        return None
    return float(np.quantile(np.outer(np.sqrt(np.maximum(variance, 0.0)), _DEVIATIONS), 0.95, method="hazen"))


def _lost_parts(lost: Mapping[str, BoolArray], dt: float) -> Iterator[Part]:
    """The parts of consecutive lost frames; the first cause counts."""
    marks = np.any(list(lost.values()), axis=0)
    for begin, end in runs_of_true(~marks):
        if (end - begin) * dt < APART and begin > 0 and end < len(marks):
            marks[begin:end] = True
    for begin, end in runs_of_true(marks):
        cause = next(cause for cause, mask in lost.items() if mask[begin:end].any())
        yield Part(begin=float(begin * dt), end=float(end * dt), cause=cause)


def _listed(texts: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(texts[:-1]), texts[-1])))


def _length(part: Part) -> float:
    return part.end - part.begin


def _metres(value: float) -> str:
    return f"{value:.0f} m" if value >= 9.95 else f"{value:.1f} m" if value >= 0.095 else f"{value:.1g} m"


def _seconds(value: float) -> str:
    return f"{value:.0f} s" if value >= 9.95 else f"{value:.1f} s"
