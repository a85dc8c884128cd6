"""Computes a map's report: uncertainty, scale, and misfit of the boxes."""

from collections.abc import Iterator

import numpy as np

from vbbench.birdify.cues import HeightPrior, compare_cues
from vbbench.birdify.report import FEW_PEOPLE, MISPLACED, Report, Spread, place_std, plus_minus
from vbbench.birdify.verdict import judge
from vbbench.camera import Camera
from vbbench.estimate import Estimate
from vbbench.exchange.own.recording import OwnRecording
from vbbench.files.dataset import Dataset
from vbbench.geometry import BoolArray, FloatArray, shorter_way, world_to_relative
from vbbench.sequence import Sequence

SCALE_DOUBT, TILT_DOUBT = 0.1, 0.02
"""A mount height that differs by a larger share, and a tilt of more rad, are worth a warning if they are certain."""
FAST_PEOPLE, SLOW_PEOPLE, SHORT, TALL = 2.5, 0.45, 1.5, 1.95
"""Median speeds in m/s, and heights in m, beyond which people are not what people are, unless they stand."""
NEAR_EDGE = 0.45
"""In m, by how much the edge of a body that its box is about is nearer than its middle, as in tier ``field``."""
COMMON = 0.3
"""In m/s: velocities that differ by less are a common one, which boxes do not separate from the camera's."""
OFTEN = 0.3
"""Share of frames with few people above which a warning says so."""


def make_report(dataset: Dataset, recording: OwnRecording, answer: Estimate, solver: str) -> Report:
    """Compute the report of a map.

    Parameters
    ----------
    dataset : the recording as a dataset.
    recording : the recording.
    answer : poses and positions.
    solver : name of the solver.
    """
    sequence, info = dataset.sequence(0), dataset.info
    camera, seen = dataset.camera(sequence), sequence.observed
    count = seen.sum(axis=1)
    step = max(1, round(1.0 / info.dt))
    moved = np.linalg.norm(answer.poses[step:, :2] - answer.poses[:-step, :2], axis=-1) / (step * info.dt)
    velocities = (answer.positions[step:] - answer.positions[:-step]) / (step * info.dt)
    velocities[~(seen[step:] & seen[:-step])] = np.nan
    heights, column_error, height_error, misfits = _residuals(dataset, sequence, answer)
    odometry = sequence.given.odometry
    report = Report(
        name=recording.footage.name,
        solver=solver,
        verdict=judge(answer, seen, info.dt, recording.rows.ids.of(sequence.tracks), info.carried_by),
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
        travelled=path_length(answer.poses[:, :2], step),
        camera_speed=_over(moved),
        people_speed=_over(np.linalg.norm(velocities, axis=-1)),
        people_differ=spread_of_velocities(velocities),
        place_std=None if answer.pose_covariances is None else _over(place_std(answer.pose_covariances[:, :2, :2])),
        yaw_std=None if answer.pose_covariances is None else _over(np.sqrt(answer.pose_covariances[:, 2, 2])),
        position_std=_position_std(answer, sequence),
        converged=_share(answer.converged),
        fallback=_share(answer.fallback),
        cues=compare_cues(sequence.observations, camera, HeightPrior(info.height_mean, info.height_std), info.dt),
        heights_median=float(np.median(heights)) if len(heights) else np.nan,
        heights_spread=float(1.4826 * np.median(np.abs(heights - np.median(heights)))) if len(heights) else np.nan,
        column_error=column_error,
        height_error=height_error,
        misfits=misfits,
        odometry=None if odometry is None else float(np.isfinite(odometry.motions[1:, 0]).mean()),
    )
    doubts = (*_doubts_of_cues(report, camera), *_doubts(report))
    return Report(**{**vars(report), "warnings": (*recording.notes, *doubts)})


def path_length(places: FloatArray, step: int) -> float:
    """Length in m of a path [T, 2], sampled every ``step`` frames and at its end; parts that are NaN do not count."""
    corners = places[np.unique(np.append(np.arange(0, len(places), step), len(places) - 1))]
    return float(np.nansum(np.linalg.norm(np.diff(corners, axis=0), axis=-1)))


def spread_of_velocities(velocities: FloatArray) -> float:
    """Median over frames of the RMS deviation of velocities [T, K, 2] from their mean in the frame; NaN without any."""
    several = velocities[(~np.isnan(velocities[..., 0])).sum(axis=1) > 1]
    apart = several - np.nanmean(several, axis=1, keepdims=True)
    return float(np.median(np.sqrt(np.nanmean((apart**2).sum(axis=-1), axis=1)))) if len(several) else np.nan


def _residuals(dataset: Dataset, sequence: Sequence, answer: Estimate) -> tuple[FloatArray, float, float, float]:
    """Heights [K] of people by their boxes and places; median errors of columns and heights; share of misfits."""
    camera, mean = dataset.camera(sequence), dataset.info.height_mean
    middles = world_to_relative(answer.positions, answer.poses)
    reach = np.maximum(np.linalg.norm(middles, axis=-1, keepdims=True), 2.0 * NEAR_EDGE)
    edges = middles * (1.0 - NEAR_EDGE / reach)
    expected = camera.project_unbounded(edges, np.full(edges.shape[:2], mean))
    known = sequence.observed & np.isfinite(expected[..., 2])
    frame, track = np.nonzero(known)
    if not len(frame):
        return np.empty(0), np.nan, np.nan, np.nan
    seen, real = sequence.observations[frame, track], expected[frame, track]
    aside = shorter_way(seen[:, 0] - real[:, 0], camera.period)
    ratio = np.full(known.shape, np.nan)
    ratio[frame, track] = seen[:, 2] / real[:, 2]
    of_track = np.array([np.nanmedian(column[np.isfinite(column)]) for column in ratio.T if np.isfinite(column).any()])
    columns = np.cumsum(known.any(axis=0))[track] - 1
    height_error = float(np.median(np.abs(ratio[frame, track] / of_track[columns] - 1.0)))
    column_error = np.abs(aside) / seen[:, 2]
    return mean * of_track, float(np.median(column_error)), height_error, float((column_error > MISPLACED).mean())


def _doubts(report: Report) -> Iterator[str]:
    """Warnings about the map by its figures."""
    yield from _doubts_of_speed(report)
    if not SHORT <= report.heights_median <= TALL:
        yield f"people come out {report.heights_median:.2f} m high (median): the map's scale does not fit their boxes"
    if report.few_people > OFTEN:
        share = f"{report.few_people:.0%} of the frames show fewer than {FEW_PEOPLE} people"
        yield f"{share}: they have little information on how the camera moves"
    if report.misfits > SCALE_DOUBT:
        yield f"{report.misfits:.0%} of the boxes are not where their person is on the map: do tracks switch people?"


def _doubts_of_cues(report: Report, camera: Camera) -> Iterator[str]:
    """Warnings if foot and height cues contradict the camera file, with possible causes."""
    cues = report.cues
    if cues is None:
        return
    off = cues.mount_height / report.camera_height - 1.0
    if abs(off) > max(SCALE_DOUBT, 2.0 * cues.mount_height_std / report.camera_height):
        found = plus_minus(cues.mount_height, cues.mount_height_std)
        height = report.height_mean / (1.0 + off)  # the focal length cancels
        yield (
            f"feet and heights put the camera {found} m above the ground, the camera file {report.camera_height:g} m: "
            f"mount_height is wrong, people are {height:.2f} m tall in place of {report.height_mean:g} m "
            "(height_mean), or boxes do not end at head and feet"
        )
    agree = "feet and heights agree best if"
    if _is_doubtful(cues.tilt, cues.tilt_std):
        found, way = plus_minus(abs(cues.tilt), cues.tilt_std), "higher" if cues.tilt > 0.0 else "lower"
        causes = f"try pitch = {report.pitch + cues.tilt:.3f}, or check cy and the focal length"
        yield f"{agree} the camera looks {found} rad {way} than its file says: {causes}"
    if _is_doubtful(cues.roll, cues.roll_std):
        found, side = plus_minus(abs(cues.roll), cues.roll_std), "right" if cues.roll > 0.0 else "left"
        roll = vars(camera).get("roll", 0.0) + cues.roll
        yield f"{agree} the camera's {side} side hangs {found} rad lower than its file says: try roll = {roll:.3f}"
    if _is_doubtful(cues.horizon, cues.horizon_std):
        row = float(camera.horizon(np.zeros(1))[0]) + cues.horizon * camera.focal
        found, way = plus_minus(abs(cues.horizon), cues.horizon_std), "lower" if cues.horizon > 0.0 else "higher"
        yield (
            f"{agree} the horizon is {found} rad {way} all around than the camera file says: "
            f"try cy = {row:.0f}, or check that the model is '{camera.kind}'"
        )


def _is_doubtful(angle: float, std: float) -> bool:
    return abs(angle) > max(TILT_DOUBT, 2.0 * std)


def _doubts_of_speed(report: Report) -> Iterator[str]:
    """Warnings if people's speeds are implausible."""
    if report.people_speed.median > FAST_PEOPLE:
        common = report.odometry is not None and report.people_differ < 0.5 * report.people_speed.median
        causes = "the odometry (unit, axes, clock), then dt and fps" if common else "dt, fps, and the focal length"
        how = ", all much the same" if common else ""
        yield f"people walk at {report.people_speed.median:.2g} m/s (median){how}: check {causes}"
    if report.odometry is None and report.people_differ < COMMON:
        yield (
            f"people move together (their velocities differ by {report.people_differ:.2g} m/s): boxes alone do not "
            "show whether they go one way or the camera the other, and neither does the map; give it --odometry"
        )
    elif report.odometry is None and report.people_speed.median < SLOW_PEOPLE:
        yield (
            f"people walk at {report.people_speed.median:.2g} m/s (median): if most of them do not stand, dt or fps is "
            "wrong, or the map has given their motion to the camera, and may be turned; give it --odometry"
        )


def _over(values: FloatArray) -> Spread:
    """Statistics over frames [T], or frames and people [T, K]."""
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
