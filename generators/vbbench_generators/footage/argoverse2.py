"""The split ``argoverse2``: logs of Argoverse 2's sensor data set, people labelled as cuboids around a car."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from pyarrow import feather

from vbbench.errors import FileError, SourceMissingError, UnknownNameError, VbbenchWarning
from vbbench.files.tables import file_sha256
from vbbench.generation.generator import Card, bundled_card
from vbbench.geometry import FloatArray, IntArray
from vbbench_generators.footage.cuboids import (
    DT,
    PANORAMA,
    ArrowTable,
    CarMotion,
    CarRecording,
    Cuboids,
    CuboidSplit,
    Sensor,
    chosen,
    motion_at,
    panorama,
    pinhole,
    rotation_matrices,
)

ANNOTATIONS, POSES, CALIBRATION = "annotations.feather", "city_SE3_egovehicle.feather", "calibration"
INTRINSICS, EXTRINSICS = "intrinsics.feather", "egovehicle_SE3_sensor.feather"
SITE = "argoverse.org/av2.html"
WANTED = f"the folder of logs, such as sensor/val, each with {ANNOTATIONS}, {POSES} and {CALIBRATION}/"
AGAIN = "download the log again"
CARD = bundled_card("vbbench_generators", "argoverse2")

RING = "ring_"
"""How the names of the cameras around the car begin."""
AXLE_HEIGHT = 0.31
"""In m: the car's axes have their origin at the rear axle."""
PERSON = "PEDESTRIAN"
FEWEST_POINTS = 2
"""Lidar points inside a person's cuboid; with fewer, the person is hidden."""
LARGEST_JITTER = 0.3
"""Of the time from a sweep to the next, that a sweep may be early or late."""
MOST_FRAMES = 100_000
LARGEST = 1e19
"""Of any number, time stamps in ns included."""
QUATERNION, PLACE, SIZE = ("qw", "qx", "qy", "qz"), ("tx_m", "ty_m", "tz_m"), ("length_m", "width_m", "height_m")
PIXELS = {"fx_px": "fx", "fy_px": "fy", "cx_px": "cx", "cy_px": "cy", "width_px": "width", "height_px": "height"}


@dataclass(frozen=True, kw_only=True)
class Argoverse2Split(CuboidSplit):
    """Logs at 10 frames a second, of which every fourth is kept; see `CuboidSplit`."""

    card: Card = CARD
    every: int = 4
    height_mean: float = 1.75
    height_std: float = 0.10

    def read(self, source: Path | None, names: tuple[str, ...] | None, cameras: tuple[str, ...]) -> list[CarRecording]:
        """See `CuboidSplit.read`."""
        logs = find_logs(source)
        picked = chosen("argoverse2", names, {name: path.parent.name for name, path in logs.items()})
        return [read_log(logs[name], cameras) for name in picked]


class FeatherTable(ArrowTable):
    """Checked columns of a table of Argoverse 2."""

    again = AGAIN

    def __init__(self, path: Path, numbers: tuple[str, ...], texts: tuple[str, ...] = ()) -> None:
        """Read the columns; raises FileError where one is missing, of another kind, or not finite."""
        self.path = path
        if not path.is_file():
            raise FileError(path, f"is missing; {AGAIN}, or name with --source {WANTED}")
        try:
            table = feather.read_table(path, memory_map=False)
            table.validate(full=True)
        except (pa.ArrowException, OSError, ValueError) as error:
            raise self.fault(f"is no Feather table ({error})") from error
        missing = next((name for name in (*numbers, *texts) if name not in table.column_names), None)
        if missing is not None:
            raise self.fault(f"has no column '{missing}', but {', '.join(table.column_names[:20])}")
        self.texts = {name: self._text(table, name) for name in texts}
        self.numbers = {name: self._number(table, name) for name in numbers}

    def stacked(self, names: tuple[str, ...], rows: IntArray | None = None) -> FloatArray:
        """[N, C] columns of numbers as floats, of all rows or of ``rows``."""
        columns = (self.numbers[name] if rows is None else self.numbers[name][rows] for name in names)
        return np.stack([column.astype(np.float64) for column in columns], axis=-1)

    def rotations(self, rows: IntArray | None = None) -> FloatArray:
        """[N, 4] quaternions (w, x, y, z), of all rows or of ``rows``."""
        quaternions = self.stacked(QUATERNION, rows)
        self.refuse_rotations(quaternions, "qw, qx, qy, qz are", rows)
        return quaternions

    def _text(self, table: pa.Table, name: str) -> pa.ChunkedArray:
        column = table[name]
        if pa.types.is_dictionary(column.type):
            column = column.cast(column.type.value_type)
        if not (pa.types.is_string(column.type) or pa.types.is_large_string(column.type)):
            raise self.fault(f"column '{name}' has {column.type} in place of text")
        self.refuse(np.asarray(pc.is_null(column)), f"'{name}' is empty")
        return column

    def _number(self, table: pa.Table, name: str) -> FloatArray:
        column = table[name]
        if not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)):
            raise self.fault(f"column '{name}' has {column.type} in place of numbers")
        self.refuse(np.asarray(pc.is_null(column)), f"'{name}' is empty")
        values: FloatArray = column.to_numpy()
        wrong = ~np.isfinite(values) | (np.abs(values) > LARGEST)
        self.refuse(wrong, f"'{name}' is {values[wrong][:1]}, which is impossible")
        return values


def find_logs(source: Path | None) -> dict[str, Path]:
    """Folders of logs by name: the folder itself, those in it, or those in its folders ``train`` and ``val``."""
    if source is None:
        raise SourceMissingError(f"argoverse2: name with --source {WANTED}; download it from {SITE}")
    if not source.is_dir():
        raise FileError(source, f"is not a folder; name {WANTED}")
    if (source / ANNOTATIONS).is_file():
        folder = source.resolve()
        return {folder.name: folder}
    found = sorted(path.parent for depth in ("*", "*/*", "*/*/*") for path in source.glob(f"{depth}/{ANNOTATIONS}"))
    if not found:
        raise SourceMissingError(f"{source}: holds no {ANNOTATIONS}, nor do its folders; name {WANTED}")
    logs: dict[str, Path] = {}
    for path in found:
        if path.name in logs:
            raise FileError(path, f"is the same log as {logs[path.name]}; name the folder of one of them")
        logs[path.name] = path
    return logs


def read_log(folder: Path, cameras: tuple[str, ...]) -> CarRecording:
    """One log, seen by ``cameras``."""
    annotations = FeatherTable(
        folder / ANNOTATIONS,
        ("timestamp_ns", *SIZE, *QUATERNION, *PLACE, "num_interior_pts"),
        ("track_uuid", "category"),
    )
    frame, times = _frames(annotations)
    motion = _motion(folder / POSES, annotations, times)
    sensors, files = _sensors(folder, cameras)
    cuboids = _people(annotations, frame, motion)
    files = {"annotations": folder / ANNOTATIONS, "motion": folder / POSES, **files}
    return CarRecording(
        name=folder.name,
        sensors=sensors,
        motions=dict.fromkeys(cameras, motion),
        cuboids=cuboids,
        digests={kind: file_sha256(path) for kind, path in files.items()},
    )


def _frames(annotations: FeatherTable) -> tuple[IntArray, IntArray]:
    """The frame of each row [N], and the time of each frame [T] in ns, between two sweeps where one is missing."""
    times = annotations.numbers["timestamp_ns"]
    if not len(times) or not np.issubdtype(times.dtype, np.integer):
        kind = "no rows" if not len(times) else f"time stamps of {times.dtype} in place of whole ns"
        raise annotations.fault(f"has {kind}")
    sweeps, sweep = np.unique(times, return_inverse=True)
    start, lasting = int(sweeps[0]), (int(sweeps[-1]) - int(sweeps[0])) * 1e-9
    if lasting > MOST_FRAMES * DT:
        raise annotations.fault(f"row {int(times.argmax())}: is {lasting:.0f} s after the first")
    passed = np.diff(sweeps) / (DT * 1e9)
    steps = np.round(passed).astype(np.int64)
    wrong = np.append(False, (np.abs(passed - steps) > LARGEST_JITTER) | (steps < 1))
    annotations.refuse((sweep == wrong.argmax()) & wrong.any(), "its time is not that of a sweep, ten a second")
    frame = np.append(0, np.cumsum(steps))
    later = np.interp(np.arange(frame[-1] + 1), frame, (sweeps - start).astype(np.float64))
    return frame[sweep], start + np.round(later).astype(np.int64)


def _motion(path: Path, annotations: FeatherTable, times: IntArray) -> CarMotion:
    """The car's motion at the times [T] of frames in ns."""
    table = FeatherTable(path, ("timestamp_ns", *QUATERNION, *PLACE))
    quaternions, places = table.rotations(), table.stacked(PLACE)
    known, first = np.unique(table.numbers["timestamp_ns"], return_index=True)
    if not len(known) or known[0] > times[0] or known[-1] < times[-1]:
        row = int(annotations.numbers["timestamp_ns"].argmax())
        here = f"row {row} of {annotations.path.name} is at {times[-1]} ns, and the first is at {times[0]}"
        there = f"has poses from {known[0]} to {known[-1]} ns" if len(known) else "has no poses"
        raise FileError(path, f"{there}, but {here}: is it of another log? {AGAIN}")
    passed = (known.astype(np.float64) - int(times[0])) * 1e-9
    motion = motion_at(np.asarray(times - times[0], np.float64) * 1e-9, passed, quaternions[first], places[first])
    return CarMotion(rotations=motion.rotations, origins=motion.origins - motion.origins[0])


def _people(annotations: FeatherTable, frame: IntArray, motion: CarMotion) -> Cuboids:
    """Pedestrians, numbered in the order of their ids."""
    rows = np.flatnonzero(np.asarray(pc.equal(annotations.texts["category"], PERSON)))
    ids = annotations.texts["track_uuid"].take(pa.array(rows)).to_pylist()
    _, person = np.unique(np.array(ids, object), return_inverse=True)
    frame = frame[rows]
    sizes = annotations.stacked(SIZE, rows)
    annotations.refuse_sizes(sizes, rows)
    annotations.refuse_twice("its 'track_uuid' has another cuboid in the same sweep", rows, frame, person)
    turned = motion.rotations[frame]
    placed = np.einsum("nij,nj->ni", turned, annotations.stacked(PLACE, rows)) + motion.origins[frame]
    return Cuboids(
        frame=frame,
        person=person,
        centres=placed,
        rotations=turned @ rotation_matrices(annotations.rotations(rows)),
        sizes=sizes,
        visible=np.where(annotations.numbers["num_interior_pts"][rows] >= FEWEST_POINTS, 1.0, 0.0),
    )


def _sensors(folder: Path, cameras: tuple[str, ...]) -> tuple[dict[str, Sensor], Mapping[str, Path]]:
    """The cameras that are asked for, and the files that they are in."""
    place = _calibration(folder)
    outer = FeatherTable(place / EXTRINSICS, (*QUATERNION, *PLACE), ("sensor_name",))
    inner = FeatherTable(place / INTRINSICS, (*PIXELS, "k1", "k2", "k3"), ("sensor_name",))
    rotations, origins = rotation_matrices(outer.rotations()), outer.stacked(PLACE)
    mounted = {name: row for row, name in enumerate(outer.texts["sensor_name"].to_pylist())}
    lenses = {name: row for row, name in enumerate(inner.texts["sensor_name"].to_pylist())}
    ring = [row for name, row in mounted.items() if name.startswith(RING)]
    sensors = {}
    for name in cameras:
        if name == PANORAMA:
            if not ring:
                raise outer.fault(f"has no camera whose name begins with '{RING}'")
            with outer.of_row(ring[0]):
                sensors[name] = panorama(origins[ring], AXLE_HEIGHT)
            continue
        if name not in lenses:
            raise UnknownNameError(f"camera of {folder.name}", name, [PANORAMA, *lenses])
        if name not in mounted:
            raise outer.fault(f"has no row of the camera '{name}'")
        values = {key: float(inner.numbers[column][lenses[name]]) for column, key in PIXELS.items()}
        values |= {key: float(inner.numbers[key][lenses[name]]) for key in ("k1", "k2", "k3")}
        with inner.of_row(lenses[name]):
            sensors[name] = pinhole(rotations[mounted[name]], origins[mounted[name]], AXLE_HEIGHT, values)
    return sensors, {"intrinsics": inner.path, "extrinsics": outer.path}


def _calibration(folder: Path) -> Path:
    """The log's folder of calibration, or the only one next to it."""
    if (folder / CALIBRATION).is_dir():
        return folder / CALIBRATION
    nearby = sorted(path for path in folder.parent.glob(f"{CALIBRATION}*") if path.is_dir())
    if len(nearby) != 1:
        raise FileError(folder / CALIBRATION, f"is missing; {AGAIN}")
    warnings.warn(VbbenchWarning(f"{folder}: has no {CALIBRATION}; {nearby[0]} is used"), stacklevel=2)
    return nearby[0]


argoverse2 = Argoverse2Split()
