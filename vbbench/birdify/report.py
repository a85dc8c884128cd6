"""Report of a map: a verdict, figures of uncertainty and scale, and warnings, in words and as JSON; and its tables."""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from vbbench.birdify.cues import Cues
from vbbench.birdify.verdict import Verdict
from vbbench.estimate import Estimate
from vbbench.exchange.box_rows import Timeline
from vbbench.exchange.tum import export_tum
from vbbench.files.tables import arrow_array
from vbbench.folders.replacing import replacing
from vbbench.geometry import FloatArray
from vbbench.parsing.json_text import without_nan
from vbbench.sequence import Sequence
from vbbench.table import Table
from vbbench.version import __version__


def write_tables(
    folder: Path,
    sequence: Sequence,
    timeline: Timeline,
    answer: Estimate,
    mount_height: float,
    ids: NDArray[Any],
) -> None:
    """Write ``poses`` and ``positions`` as Parquet and CSV, and poses as a TUM trajectory.

    Parameters
    ----------
    folder : the folder to write into.
    sequence : the sequence of boxes.
    timeline : numbers and times of its frames in the file of boxes.
    answer : the solver's estimate.
    mount_height : the camera's height in m, for the trajectory.
    ids : [K] ids of the tracks in the file of boxes.
    """
    times, numbers = timeline.times, timeline.first_number + timeline.step * np.arange(timeline.frames)
    known = np.isfinite(answer.poses).all(axis=1)
    poses: dict[str, NDArray[Any]] = {"frame": numbers[known], "time": times[known]}
    poses |= dict(zip(("x", "y", "yaw"), answer.poses[known].T, strict=True))
    if answer.pose_covariances is not None:
        spread = answer.pose_covariances[known]
        poses |= {"std": place_std(spread[:, :2, :2]), "yaw_std": np.sqrt(spread[:, 2, 2])}
    _write(folder, "poses", poses)
    frame, column = np.nonzero(sequence.observed & np.isfinite(answer.positions[..., 0]))
    positions: dict[str, NDArray[Any]] = {
        "frame": numbers[frame],
        "time": times[frame],
        "id": ids[column],
        "x": answer.positions[frame, column, 0],
        "y": answer.positions[frame, column, 1],
    }
    if answer.position_covariances is not None:
        positions["std"] = place_std(answer.position_covariances[frame, column])
    _write(folder, "positions", positions)
    export_tum(answer.poses, times, mount_height, folder / "poses.txt")


def place_std(covariances: FloatArray) -> FloatArray:
    """[N] greatest standard deviation in m over directions, from covariances [N, 2, 2] of places; NaN for NaN."""
    (a, b), (_, c) = np.moveaxis(covariances, (-2, -1), (0, 1))
    largest = 0.5 * (a + c) + np.sqrt(0.25 * (a - c) ** 2 + b * b)
    return np.asarray(np.sqrt(np.maximum(largest, 0.0)))


def _write(folder: Path, name: str, columns: dict[str, NDArray[Any]]) -> None:
    types = {"i": pa.int64(), "f": pa.float64(), "U": pa.string()}
    kinds = {key: types[values.dtype.kind] for key, values in columns.items()}
    table = pa.table({key: arrow_array(values, kinds[key]) for key, values in columns.items()})
    with replacing(folder / f"{name}.parquet") as temporary:
        pq.write_table(table, temporary)
    with replacing(folder / f"{name}.csv") as temporary, temporary.open("wb") as file:
        file.write((",".join(table.column_names) + "\n").encode())
        pa_csv.write_csv(table, file, pa_csv.WriteOptions(include_header=False, quoting_style="none"))


REPORT = "report.json"
FEW_PEOPLE = 3
"""Fewer people than this in a frame have little information on how the camera moves."""
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
    """Figures of a map; ``None`` = the solver does not report it.

    Parameters
    ----------
    name, solver : names of the recording and of the solver.
    verdict : the usable parts of the map.
    frames, dt, tracks, boxes : size of the recording; ``dt`` in s.
    people_mean, people_max : number of people seen in a frame.
    few_people, empty : shares of frames with fewer than `FEW_PEOPLE` people, and without any.
    pixel_std : assumed noise of boxes in px.
    camera_height, pitch : of the camera file, in m and rad.
    height_mean, height_std : prior of people's heights in m.
    travelled : length of the camera's path in m, over steps of about a second.
    camera_speed, people_speed : in m/s, over about a second.
    people_differ : RMS deviation in m/s of people's velocities from their mean in a frame, the median over frames.
    place_std, yaw_std : standard deviations of the pose, in m along the worst direction, and in rad.
    position_std : standard deviation in m of people's positions.
    converged, fallback : shares of frames in which the solver converged, and in which its pose is the prior.
    cues : the calibration by height and foot cues.
    heights_median, heights_spread : people's heights in m by their boxes and places, over tracks.
    column_error, height_error : median residuals of boxes about the estimate, as shares of the box height.
    misfits : share of boxes farther than `MISPLACED` from their person's estimate.
    odometry : share of frames with a measured motion; ``None`` without odometry.
    warnings : warnings for the user, a line each.
    """

    name: str
    solver: str
    verdict: Verdict
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
    people_differ: float
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
        """The text of ``report.json``; NaN as null. The verdict has its sentences, too."""
        values = asdict(self)
        values["verdict"] = {"sentences": self.verdict.sentences(), **values["verdict"]}
        return json.dumps(without_nan(values), indent=2, ensure_ascii=False) + "\n"

    def markdown(self) -> str:
        """The text of ``report.md``."""
        sections = [f"# {self.name}", " ".join(self.verdict.sentences())]
        if self.warnings:
            sections.append("## Warnings\n\n" + "\n".join(f"- {line}" for line in self.warnings))
        table = Table(head=("", ""), rows=list(self._rows()), names=2)
        return "\n\n".join([*sections, "\n".join(table.markdown()).rstrip(), _EXPLAINED]) + "\n"

    def summary(self) -> str:
        """The verdict and a few figures, in lines for the terminal."""
        lines = [*self.verdict.sentences(), f"{self.travelled:.3g} m travelled in {self.frames * self.dt:.3g} s"]
        lines += ["scale by heights alone" if self.cues is None else f"scale: {_scale(self)}"]
        if self.odometry is None:
            lines += ["without odometry the map may drift with the crowd by more than that"]
        return "\n".join(lines)

    def _rows(self) -> Iterator[tuple[str, str]]:
        yield "recording", f"{self.frames} frames of {self.dt:g} s, {self.boxes} boxes of {self.tracks} tracks"
        yield "people in a frame", f"{self.people_mean:.1f} on average, {self.people_max} at most"
        yield f"frames with fewer than {FEW_PEOPLE} people", f"{self.few_people:.0%}; with nobody {self.empty:.0%}"
        heights = plus_minus(self.height_mean, self.height_std)
        yield "solver", f"{self.solver}, given: box noise {self.pixel_std:g} px, heights {heights} m"
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
            yield "frames without a warning of the solver", f"{self.converged:.1%}"
        if self.fallback is not None:
            yield "frames decided by the prior alone", f"{self.fallback:.1%}"
        yield "scale", _scale(self)
        if self.cues is not None:
            horizon = plus_minus(self.cues.horizon, self.cues.horizon_std)
            more = f"; horizon {horizon} rad lower all around" if self.cues.horizon_std else ""
            tilt = plus_minus(self.cues.tilt, self.cues.tilt_std)
            yield "tilt by feet and heights", f"{tilt} rad besides pitch = {self.pitch:g}{more}"
        yield "people's heights on the map", f"{plus_minus(self.heights_median, self.heights_spread)} m"
        yield (
            "boxes against the map",
            f"columns off by {self.column_error:.3f} box heights, heights by {self.height_error:.1%} (medians); "
            f"{self.misfits:.1%} of the boxes do not fit",
        )


_EXPLAINED = """\
Seconds count from the first frame. A radius of 95 % is 1.96 standard deviations of the whole error in the plane. σ is
the solver's standard deviation along the worst direction; it holds if the model of people and boxes does. Metres come
from people's heights, and from the camera's height where the solver trusts feet: a camera file that is off by 10 %
gives a map that is. How fast everybody moves together is hardly seen in boxes: without odometry the whole map may drift
along the way the crowd goes, by more than σ, while places relative to the camera hold."""


def _scale(report: Report) -> str:
    if report.cues is None:
        why = "too few whole boxes, or feet that fit no tilt, to hold against the mount height"
        return f"by heights of {report.height_mean:g} m on average; {why}"
    found, std = report.cues.mount_height, report.cues.mount_height_std
    return (
        f"heights of {report.height_mean:g} m on average put the camera {plus_minus(found, std)} m above the ground; "
        f"its file says {report.camera_height:g} m ({found / report.camera_height - 1.0:+.0%})"
    )


def plus_minus(value: float, std: float) -> str:
    """A figure and its standard deviation in few characters."""
    return f"{value:.3g} ± {std:.1g}"


def _spread(spread: Spread, unit: str, *, last: bool = True) -> str:
    ends = f", {spread.last:.2g} in the last frame" if last else ""
    return f"{spread.median:.2g} {unit} (median), {spread.p95:.2g} (95 %){ends}"
