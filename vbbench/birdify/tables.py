"""Poses and positions as tables for people: with times, the ids of the boxes, and standard deviations."""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv as pa_csv
import pyarrow.parquet as pq
from numpy.typing import NDArray

from vbbench.estimate import Estimate
from vbbench.exchange.own.timing import Timeline
from vbbench.exchange.tum import export_tum
from vbbench.files.tables import arrow_array
from vbbench.folders.replacing import replacing
from vbbench.geometry import FloatArray
from vbbench.sequence import Sequence


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
    folder : where to.
    sequence : what was seen.
    timeline : of its frames; the tables have the numbers and times of the boxes' file.
    answer : the solver's.
    mount_height : the camera's height in m, for the trajectory.
    ids : [K] what the boxes' file calls the tracks.
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
    """[N] standard deviation in m of places along their worst direction, from covariances [N, 2, 2]; NaN of NaN."""
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
