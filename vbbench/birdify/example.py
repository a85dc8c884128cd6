"""The example of ``vbbench birdify --example``: 20 s of a simulated robot in a crowd, with the truth.

``example/`` holds a tracker's boxes, the robot's odometry and its camera, in a user's formats. They are simulated by
``benchmarks/families/robot.py``, which shares no code with the generators.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.csv
import pyarrow.parquet

from vbbench.birdify.birdify import birdify
from vbbench.exchange.tum import import_tum
from vbbench.geometry import FloatArray, motion_between

EXAMPLE = Path(__file__).with_name("example")
DT = 0.1
"""Seconds per frame of the example."""


def birdify_example(out: Path, **options: Any) -> str:
    """Make the map of the example by `vbbench.birdify.birdify.birdify`; returns its summary and errors as text."""
    made = birdify(
        EXAMPLE / "boxes.csv",
        EXAMPLE / "camera.toml",
        out,
        odometry=EXAMPLE / "odometry.txt",
        name="example",
        **options,
    )
    people, camera = errors(out)
    return (
        f"{made.folder}: {made.report.summary()}\n"
        f"Against the truth: people are off by {people.mean():.2f} m on average, the camera by {camera.mean():.2f} m.\n"
        f"Open {made.folder / 'map.png'}; of your own boxes: vbbench birdify boxes.csv --camera camera.toml --out map"
    )


def errors(folder: Path) -> tuple[FloatArray, FloatArray]:
    """Errors in m of all places [N] and poses [T] in a map of the example; its origin is the first pose."""
    frames, poses = import_tum(EXAMPLE / "true_poses.txt", DT)
    camera = _columns(pyarrow.parquet.read_table(folder / "poses.parquet"), "time", "x", "y")
    shown = np.searchsorted(frames, np.rint(camera[:, 0] / DT))
    off = camera[:, 1:] - _on_map(poses[shown, :2], poses[0])
    truth = _columns(pyarrow.csv.read_csv(EXAMPLE / "true_people.csv"), "time", "id", "x", "y")
    true = {(round(time, 3), person): place for time, person, *place in truth.tolist()}
    found = _columns(pyarrow.parquet.read_table(folder / "positions.parquet"), "time", "id", "x", "y")
    places = np.array([true[round(time, 3), person] for time, person in found[:, :2].tolist()])
    return np.hypot(*(found[:, 2:] - _on_map(places, poses[0])).T), np.hypot(*off.T)


def _on_map(places: FloatArray, start: FloatArray) -> FloatArray:
    """Places [N, 2] with the first pose as origin, x forward and y left."""
    return motion_between(start, np.column_stack([places, np.zeros(len(places))]))[:, :2]


def _columns(table: pyarrow.Table, *names: str) -> FloatArray:
    return np.column_stack([table[name].to_numpy().astype(np.float64) for name in names])
