"""How sure a map is: figures of its uncertainty, of its scale and of what does not fit, in words and as JSON."""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from vbbench import __version__
from vbbench.birdify.cues import Cues, compare_cues
from vbbench.birdify.tables import place_std
from vbbench.estimate import Estimate
from vbbench.exchange.own.recording import OwnRecording
from vbbench.files.dataset import Dataset
from vbbench.geometry import BoolArray, FloatArray, world_to_relative
from vbbench.sequence import Sequence

REPORT = "report.json"
SCALE_DOUBT, TILT_DOUBT = 0.1, 0.02
"""A mount height that differs by a larger share, and a tilt of more rad, are worth a warning if they are certain."""
FAST_PEOPLE, SHORT, TALL = 2.5, 1.5, 1.95
"""Median speed in m/s, and heights in m, beyond which people are not what people are."""
FEW_PEOPLE, OFTEN = 3, 0.3
"""Fewer people than this, in a larger share of the frames, tell little of how the camera moves."""
MISPLACED = 0.5
"""A box farther from where its person is estimated, in box heights, does not fit."""


@dataclass(frozen=True, kw_only=True)
class Spread:
    """A quantity over frames or boxes: median, 95th percentile, and the value in the last frame (its median there)."""

    median: float
    p95: float
    last: float


@dataclass(frozen=True, kw_only=True)
class Report:
    """Figures of a map; ``None`` = the solver does not say.

    Parameters
    ----------
    name, solver : of the recording, and what solved it.
    frames, dt, tracks, boxes : of the recording.
    people_mean, people_max : seen in a frame.
    few_people : share of frames with fewer than `FEW_PEOPLE`; ``empty`` those with nobody.
    pixel_std : noise in px that boxes are taken to have.
    camera_height, pitch : as the camera file has them.
    height_mean, height_std : of people, as the solver is told.
    travelled : length of the camera's path in m, over steps of about a second.
    camera_speed, people_speed : in m/s, over about a second.
    place_std, yaw_std : standard deviations of the pose, in m along the worst direction, and in rad.
    position_std : of people's positions, in m.
    converged, fallback : shares of frames where the solver's optimum was found, and where its prior decided.
    cues : what feet and heights say together.
    heights_median, heights_spread : people's heights in m by their boxes and places, over tracks.
    column_error, height_error : of boxes against places and heights: median distance, as shares of the box height.
    misfits : share of boxes farther than `MISPLACED` from where their person is.
    odometry : share of frames with a measured motion; ``None`` without odometry.
    warnings : what the user should know, a line each.
    """

    name: str
    solver: str
    frames: int
    dt: float
    tracks: int
    boxes: int
    people_mean: float
    people_max: int
    few_people: float
    empty: float
    pixel_std: float
    camera_height: float
    pitch: float
    height_mean: float
    height_std: float
    travelled: float
    camera_speed: Spread
    people_speed: Spread
    place_std: Spread | None
    yaw_std: Spread | None
    position_std: Spread | None
    converged: float | None
    fallback: float | None
    cues: Cues | None
    heights_median: float
    heights_spread: float
    column_error: float
    height_error: float
    misfits: float
    odometry: float | None
    warnings: tuple[str, ...] = ()
    vbbench: str = __version__

    def to_json(self) -> str:
        """The text of ``report.json``; NaN as null."""
        return json.dumps(_plain(asdict(self)), indent=2, ensure_ascii=False) + "\n"

    def markdown(self) -> str:
        """The text of ``report.md``."""
        sections = [f"# {self.name}", *self._warning_lines(), _table(self._rows()), _EXPLAINED]
        return "\n\n".join(sections) + "\n"

    def summary(self) -> str:
        """Two lines for the terminal."""
        sure = "the solver reports no uncertainty"
        if self.place_std is not None and self.position_std is not None:
            last, people = self.place_std.last, self.position_std.median
            sure = f"camera ±{last:.2g} m in the last frame, people ±{people:.2g} m"
        scale = "scale by heights alone" if self.cues is None else f"scale: {_scale(self)}"
        return f"{self.travelled:.3g} m travelled in {self.frames * self.dt:.3g} s; {sure}\n{scale}"

    def _warning_lines(self) -> list[str]:
        return ["## Warnings\n\n" + "\n".join(f"- {line}" for line in self.warnings)] if self.warnings else []

    def _rows(self) -> Iterator[tuple[str, str]]:
        yield "recording", f"{self.frames} frames of {self.dt:g} s, {self.boxes} boxes of {self.tracks} tracks"
        yield "people in a frame", f"{self.people_mean:.1f} on average, {self.people_max} at most"
        yield f"frames with fewer than {FEW_PEOPLE} people", f"{self.few_people:.0%}; with nobody {self.empty:.0%}"
        yield (
            "solver",
            f"{self.solver}, told: box noise {self.pixel_std:g} px, heights {_pm(self.height_mean, self.height_std)} m",
        )
        if self.odometry is not None:
            yield "odometry", f"in {self.odometry:.0%} of the frames"
        yield "camera", f"{self.travelled:.3g} m travelled; {_spread(self.camera_speed, 'm/s', last=False)}"
        yield "people's speed", _spread(self.people_speed, "m/s", last=False)
        if self.place_std is not None:
            yield "σ of the camera's place", _spread(self.place_std, "m")
        if self.yaw_std is not None:
            yield "σ of its yaw", _spread(self.yaw_std, "rad")
        if self.position_std is not None:
            yield "σ of people's positions", _spread(self.position_std, "m")
        if self.converged is not None:
            yield "frames whose optimum was found", f"{self.converged:.1%}"
        if self.fallback is not None:
            yield "frames decided by the prior alone", f"{self.fallback:.1%}"
        yield "scale", _scale(self)
        if self.cues is not None:
            yield (
                "tilt by feet and heights",
                f"{_pm(self.cues.tilt, self.cues.tilt_std)} rad besides pitch = {self.pitch:g}",
            )
        yield "people's heights on the map", f"{_pm(self.heights_median, self.heights_spread)} m"
        yield (
            "boxes against the map",
            f"columns off by {self.column_error:.3f} box heights, heights by {self.height_error:.1%} (medians); "
            f"{self.misfits:.1%} of the boxes do not fit",
        )


_EXPLAINED = """\
σ is what the solver believes, along the worst direction, if its model of people and boxes is right. Metres come from
people's heights, and from the camera's height where the solver trusts feet: a camera file that is off by 10 % gives a
map that is. How fast everybody moves together is hardly seen in boxes: without odometry the whole map may drift along
the way the crowd goes, by more than σ says, while places relative to the camera hold."""


def make_report(dataset: Dataset, recording: OwnRecording, answer: Estimate, solver: str) -> Report:
    """Measure a map.

    Parameters
    ----------
    dataset : what was solved.
    recording : what was read.
    answer : poses and positions.
    solver : its name.
    """
    sequence, info = dataset.sequence(0), dataset.info
    camera, seen = dataset.camera(sequence), sequence.observed
    count = seen.sum(axis=1)
    step = max(1, round(1.0 / info.dt))
    moved = np.linalg.norm(answer.poses[step:, :2] - answer.poses[:-step, :2], axis=-1) / (step * info.dt)
    walked = np.linalg.norm(answer.positions[step:] - answer.positions[:-step], axis=-1)[seen[step:] & seen[:-step]]
    heights, column_error, height_error, misfits = _residuals(dataset, sequence, answer)
    odometry = sequence.given.odometry
    report = Report(
        name=recording.footage.name,
        solver=solver,
        frames=sequence.frames,
        dt=info.dt,
        tracks=len(sequence.tracks),
        boxes=int(seen.sum()),
        people_mean=float(count.mean()),
        people_max=int(count.max()),
        few_people=float((count < FEW_PEOPLE).mean()),
        empty=float((count == 0).mean()),
        pixel_std=info.pixel_std,
        camera_height=camera.mount_height,
        pitch=recording.own.facts.pitch,
        height_mean=info.height_mean,
        height_std=info.height_std,
        travelled=float(np.nansum(np.linalg.norm(np.diff(answer.poses[::step, :2], axis=0), axis=-1))),
        camera_speed=_over(moved),
        people_speed=_over(walked / (step * info.dt)),
        place_std=None if answer.pose_covariances is None else _over(place_std(answer.pose_covariances[:, :2, :2])),
        yaw_std=None if answer.pose_covariances is None else _over(np.sqrt(answer.pose_covariances[:, 2, 2])),
        position_std=_position_std(answer, sequence),
        converged=_share(answer.converged),
        fallback=_share(answer.fallback),
        cues=compare_cues(sequence.observations, camera, info.height_mean, info.height_std),
        heights_median=float(np.median(heights)) if len(heights) else np.nan,
        heights_spread=float(1.4826 * np.median(np.abs(heights - np.median(heights)))) if len(heights) else np.nan,
        column_error=column_error,
        height_error=height_error,
        misfits=misfits,
        odometry=None if odometry is None else float(np.isfinite(odometry.motions[1:, 0]).mean()),
    )
    return Report(**{**vars(report), "warnings": (*recording.notes, *_doubts(report))})


def _residuals(dataset: Dataset, sequence: Sequence, answer: Estimate) -> tuple[FloatArray, float, float, float]:
    """Heights [K] of people by their boxes and places; median errors of columns and heights; share of misfits."""
    camera, mean = dataset.camera(sequence), dataset.info.height_mean
    relative = world_to_relative(answer.positions, answer.poses)
    expected = camera.project_unbounded(relative, np.full(relative.shape[:2], mean))
    known = sequence.observed & np.isfinite(expected[..., 2])
    frame, track = np.nonzero(known)
    if not len(frame):
        return np.empty(0), np.nan, np.nan, np.nan
    seen, real = sequence.observations[frame, track], expected[frame, track]
    aside = seen[:, 0] - real[:, 0]
    if camera.period is not None:
        aside = aside - camera.period * np.round(aside / camera.period)
    ratio = np.full(known.shape, np.nan)
    ratio[frame, track] = seen[:, 2] / real[:, 2]
    of_track = np.array([np.nanmedian(column[np.isfinite(column)]) for column in ratio.T if np.isfinite(column).any()])
    columns = np.cumsum(known.any(axis=0))[track] - 1
    height_error = float(np.median(np.abs(ratio[frame, track] / of_track[columns] - 1.0)))
    column_error = np.abs(aside) / seen[:, 2]
    return mean * of_track, float(np.median(column_error)), height_error, float((column_error > MISPLACED).mean())


def _doubts(report: Report) -> Iterator[str]:
    """What in the figures speaks against the map."""
    cues = report.cues
    if cues is not None:
        off = cues.mount_height / report.camera_height - 1.0
        if abs(off) > max(SCALE_DOUBT, 2.0 * cues.mount_height_std / report.camera_height):
            yield (
                f"feet say that the camera is {_pm(cues.mount_height, cues.mount_height_std)} m above the ground, the "
                f"camera file says {report.camera_height:g} m: one of mount_height, focal and height_mean is wrong"
            )
        if abs(cues.tilt) > max(TILT_DOUBT, 2.0 * cues.tilt_std):
            yield (
                f"feet and heights agree best if the camera looks {_pm(cues.tilt, cues.tilt_std)} rad higher than its "
                f"file says: try pitch = {report.pitch + cues.tilt:.3f}, or check cy"
            )
    if report.people_speed.median > FAST_PEOPLE:
        yield f"people walk at {report.people_speed.median:.2g} m/s (median): check dt, fps, and the focal length"
    if not SHORT <= report.heights_median <= TALL:
        yield f"people come out {report.heights_median:.2f} m high (median): the map's scale does not fit their boxes"
    if report.few_people > OFTEN:
        share = f"{report.few_people:.0%} of the frames show fewer than {FEW_PEOPLE} people"
        yield f"{share}: they tell little of how the camera moves"
    if report.converged is not None and report.converged < 1.0 - SCALE_DOUBT:
        yield f"the solver found its optimum in {report.converged:.0%} of the frames only"
    if report.misfits > SCALE_DOUBT:
        yield f"{report.misfits:.0%} of the boxes are not where their person is on the map: do tracks switch people?"


def _over(values: FloatArray) -> Spread:
    """Over frames [T], or frames and people [T, K]."""
    known = values[np.isfinite(values)]
    if not len(known):
        return Spread(median=np.nan, p95=np.nan, last=np.nan)
    last = values[np.isfinite(values.reshape(len(values), -1)).any(axis=1)][-1]
    return Spread(median=float(np.median(known)), p95=float(np.quantile(known, 0.95)), last=float(np.nanmedian(last)))


def _position_std(answer: Estimate, sequence: Sequence) -> Spread | None:
    if answer.position_covariances is None:
        return None
    spread = np.full(sequence.observed.shape, np.nan)
    spread[sequence.observed] = place_std(answer.position_covariances[sequence.observed])
    return _over(spread)


def _share(marks: BoolArray | None) -> float | None:
    return None if marks is None else float(marks.mean())


def _scale(report: Report) -> str:
    if report.cues is None:
        return (
            f"by heights of {report.height_mean:g} m on average; too few whole boxes to hold against the mount height"
        )
    found, std = report.cues.mount_height, report.cues.mount_height_std
    return (
        f"heights of {report.height_mean:g} m on average put the camera {_pm(found, std)} m above the ground; its "
        f"file says {report.camera_height:g} m ({found / report.camera_height - 1.0:+.0%})"
    )


def _pm(value: float, std: float) -> str:
    return f"{value:.3g} ± {std:.1g}"


def _spread(spread: Spread, unit: str, *, last: bool = True) -> str:
    ends = f", {spread.last:.2g} in the last frame" if last else ""
    return f"{spread.median:.2g} {unit} (median), {spread.p95:.2g} (95 %){ends}"


def _table(rows: Iterator[tuple[str, str]]) -> str:
    return "\n".join(["| | |", "|---|---|", *(f"| {name} | {text} |" for name, text in rows)])


def _plain(value: Any) -> Any:
    """Values that JSON has: no NaN."""
    if isinstance(value, dict):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
