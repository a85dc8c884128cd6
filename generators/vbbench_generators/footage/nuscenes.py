"""The split ``nuscenes``: scenes of nuScenes, with people labelled as cuboids twice a second, interpolated between."""

import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from pyarrow import json as arrow_json

from vbbench.errors import FileError, SourceMissingError, UnknownNameError
from vbbench.files.tables import file_sha256
from vbbench.generation.generator import Card, bundled_card
from vbbench.geometry import FloatArray, IntArray
from vbbench_generators.footage.cuboids import (
    PANORAMA,
    ArrowTable,
    CarMotion,
    CarRecording,
    Cuboids,
    CuboidSplit,
    Sensor,
    between,
    chosen,
    motion_at,
    panorama,
    pinhole,
    rotation_matrices,
    rows_by_group,
)

SITE = "nuscenes.org/nuscenes"
WANTED = "the folder that holds v1.0-trainval or v1.0-mini, with scene.json and the other tables in it"
AGAIN = "unpack the metadata again"
CARD = bundled_card("vbbench_generators", "nuscenes")

RING, LIDAR = "CAM_", "LIDAR_TOP"
"""How the names of the cameras around the car begin, and the sensor at whose times the panorama is."""
WALKERS = tuple(f"human.pedestrian.{kind}" for kind in ("adult", "child", "construction_worker", "police_officer"))
NOT_UPRIGHT = "pedestrian.sitting_lying_down"
VISIBLE = {"v0-40": 0.0, "v40-60": 0.5, "v60-80": 0.7, "v80-100": 0.9}
"""Visible shares by level; in the lowest, people are hidden."""
FEWEST_POINTS = 1
"""Lidar points inside a person's cuboid; with fewer, the person is hidden."""
KEY_SECONDS, STEPS = 0.5, 5
"""Seconds from a key frame to the next, and frames."""
MOST_KEYS, LARGEST = 10_000, 1e12
TEXT, NUMBER, WHOLE = pa.string(), pa.float64(), pa.int64()
VECTOR, MATRIX = pa.list_(NUMBER), pa.list_(pa.list_(NUMBER))
POSE = {"translation": VECTOR, "rotation": VECTOR}
TABLES: dict[str, dict[str, pa.DataType]] = {
    "scene": {"token": TEXT, "name": TEXT},
    "sample": {"token": TEXT, "timestamp": WHOLE, "scene_token": TEXT},
    "sample_data": {
        "sample_token": TEXT,
        "ego_pose_token": TEXT,
        "calibrated_sensor_token": TEXT,
        "is_key_frame": pa.bool_(),
        "width": WHOLE,
        "height": WHOLE,
    },
    "sample_annotation": {
        "sample_token": TEXT,
        "instance_token": TEXT,
        "visibility_token": TEXT,
        "attribute_tokens": pa.list_(TEXT),
        "size": VECTOR,
        "num_lidar_pts": WHOLE,
        **POSE,
    },
    "ego_pose": {"token": TEXT, "timestamp": WHOLE, **POSE},
    "calibrated_sensor": {"token": TEXT, "sensor_token": TEXT, "camera_intrinsic": MATRIX, **POSE},
    "sensor": {"token": TEXT, "channel": TEXT},
    "instance": {"token": TEXT, "category_token": TEXT},
    "category": {"token": TEXT, "name": TEXT},
    "visibility": {"token": TEXT, "level": TEXT},
    "attribute": {"token": TEXT, "name": TEXT},
}
"""The columns that are read of each table."""
_BETWEEN = re.compile(rb"\}\s*,\s*\{")
_BLANKS = bytes.maketrans(b"\r\n", b"  ")


@dataclass(frozen=True, kw_only=True)
class NuscenesSplit(CuboidSplit):
    """Scenes at 10 frames a second, of which the key frames are kept; see `CuboidSplit`."""

    card: Card = CARD
    every: int = STEPS
    height_mean: float = 1.72
    height_std: float = 0.12

    def read(self, source: Path | None, names: tuple[str, ...] | None, cameras: tuple[str, ...]) -> list[CarRecording]:
        """See `CuboidSplit.read`."""
        folder = find_tables(source)
        scenes = Scenes(folder)
        digest = hashlib.sha256("".join(file_sha256(folder / f"{name}.json") for name in TABLES).encode()).hexdigest()
        return [
            scenes.read(name, cameras, digest) for name in chosen("nuscenes", names, dict.fromkeys(scenes.names, ""))
        ]


class JsonTable(ArrowTable):
    """A table of nuScenes, a list of objects."""

    again = AGAIN

    def __init__(self, folder: Path, name: str) -> None:
        """Read the columns of `TABLES`; raises FileError where something is missing or of another kind."""
        self.path = folder / f"{name}.json"
        schema = pa.schema(list(TABLES[name].items()))
        if not self.path.is_file():
            raise FileError(self.path, f"is missing; {AGAIN}, or name with --source {WANTED}")
        text = self.path.read_bytes().translate(_BLANKS).strip()
        rows = text[1:-1].strip()
        if not (text.startswith(b"[") and text.endswith(b"]")) or rows.startswith(b"null"):  # which would crash Arrow
            raise self.fault("is no list of objects in JSON from '[' to ']'")
        rows = rows.replace(b"}, {", b"} \n{")  # of the official layout; of any other:
        rows = _BETWEEN.sub(b"}\n{", rows) if rows.count(b"\n") + 1 < rows.count(b"{") else rows
        options = arrow_json.ParseOptions(explicit_schema=schema, unexpected_field_behavior="ignore")
        block = arrow_json.ReadOptions(block_size=1 << 24)
        try:
            table = arrow_json.read_json(pa.BufferReader(rows), block, options) if rows else schema.empty_table()
            table.validate(full=True)
        except (pa.ArrowException, ValueError) as error:
            raise self.fault(f"is no table of nuScenes ({error})") from error
        self.table = table.combine_chunks()
        for column in TABLES[name]:
            self.refuse(np.asarray(pc.is_null(self.table[column])), f"has no '{column}'")

    def values(self, column: str) -> FloatArray:
        """[N] numbers."""
        values: FloatArray = self.table[column].to_numpy()
        return values

    def texts(self, column: str) -> list[str]:
        """Texts, a row each."""
        return list(self.table[column].to_pylist())

    def vectors(self, column: str, width: int, rows: IntArray) -> FloatArray:
        """[N, width] vectors of these rows; a rotation's length must be 1 up to rounding."""
        lists = self.table[column].take(pa.array(rows)).combine_chunks()
        problem = f"'{column}' has not {width} numbers"
        self.refuse(np.not_equal(pc.list_value_length(lists), width), problem, rows)
        flat = np.asarray(pc.list_flatten(lists).to_numpy(zero_copy_only=False), np.float64).reshape(-1, width)
        self.refuse(np.asarray(~(np.abs(flat) < LARGEST).all(axis=1)), problem, rows)
        if column == "rotation":
            self.refuse_rotations(flat, "'rotation' (w, x, y, z) is", rows)
        return flat

    def rows_of(self, column: str, other: "JsonTable", needed: bool = True) -> IntArray:
        """Rows [N] of the table ``other`` by the tokens in ``column``; −1 where an optional token is missing."""
        found = pc.index_in(self.table[column], value_set=other.table["token"].combine_chunks())
        lost = np.asarray(pc.is_null(found)) & needed
        self.refuse(lost, f"'{column}' is no token of {other.path.name}")
        return np.asarray(found.fill_null(-1).to_numpy(), np.int64)


class Scenes:
    """All tables, joined by their tokens."""

    def __init__(self, folder: Path) -> None:
        """Read the tables of a folder."""
        tables = {name: JsonTable(folder, name) for name in TABLES}
        self.scene, self.sample, self.data = tables["scene"], tables["sample"], tables["sample_data"]
        self.labels, self.pose = tables["sample_annotation"], tables["ego_pose"]
        self.calibrated = tables["calibrated_sensor"]
        self.names = self.scene.texts("name")
        scenes = self.sample.rows_of("scene_token", self.scene)
        self.sample_of_data = self.data.rows_of("sample_token", self.sample)
        self.pose_of_data = self.data.rows_of("ego_pose_token", self.pose)
        self.mounted = self.data.rows_of("calibrated_sensor_token", self.calibrated)
        channels = np.array(tables["sensor"].texts("channel"), object)
        self.channel_of_data = channels[self.calibrated.rows_of("sensor_token", tables["sensor"])][self.mounted]
        self.sample_of_label = self.labels.rows_of("sample_token", self.sample)
        self.instance_of_label = self.labels.rows_of("instance_token", tables["instance"])
        self.rank_of_instance = np.argsort(np.argsort(np.array(tables["instance"].texts("token"), str)))
        walks = np.isin(np.array(tables["category"].texts("name"), object), WALKERS)
        counts = walks[tables["instance"].rows_of("category_token", tables["category"])][self.instance_of_label]
        shares = np.array([*(VISIBLE.get(level, 1.0) for level in tables["visibility"].texts("level")), 1.0])
        seen = shares[self.labels.rows_of("visibility_token", tables["visibility"], needed=False)]
        self.visible = np.where(self.labels.values("num_lidar_pts") >= FEWEST_POINTS, seen, 0.0)
        names = dict(zip(tables["attribute"].texts("name"), tables["attribute"].texts("token"), strict=True))
        attributes = self.labels.table["attribute_tokens"].combine_chunks()
        sits = np.asarray(pc.equal(pc.list_flatten(attributes), names.get(NOT_UPRIGHT, "")).fill_null(False))
        counts[np.asarray(pc.list_parent_indices(attributes))[sits]] = False
        groups = scenes, scenes[self.sample_of_data], np.where(counts, scenes[self.sample_of_label], len(self.names))
        self.samples, self.data_rows, self.label_rows = (rows_by_group(one, len(self.names)) for one in groups)

    def read(self, name: str, cameras: tuple[str, ...], digest: str) -> CarRecording:
        """One scene, seen by ``cameras``."""
        scene = self.names.index(name)
        samples = self.samples[scene]
        samples = samples[np.argsort(self.sample.values("timestamp")[samples], kind="stable")]
        keys = self._keys(name, samples)
        data = self.data_rows[scene]
        channels = {channel: data[self.channel_of_data[data] == channel] for channel in set(self.channel_of_data[data])}
        ring = [channel for channel in sorted(channels) if channel.startswith(RING)]
        sensors, motions, origin = {}, {}, None
        for camera in cameras:
            if camera != PANORAMA and camera not in ring:
                raise UnknownNameError(f"camera of {name}", camera, [PANORAMA, *ring])
            rows = channels.get(LIDAR if camera == PANORAMA else camera, np.zeros(0, np.int64))
            motion = self._motion(name, rows, samples, keys)
            origin = motion.origins[0] if origin is None else origin
            motions[camera] = CarMotion(rotations=motion.rotations, origins=motion.origins - origin)
            seen = rows[:1] if camera != PANORAMA else np.array([channels[one][0] for one in ring], np.int64)
            sensors[camera] = self._sensor(name, seen, panoramic=camera == PANORAMA)
        return CarRecording(
            name=name,
            sensors=sensors,
            motions=motions,
            cuboids=self._people(self.label_rows[scene], samples, keys, np.zeros(3) if origin is None else origin),
            digests={"tables": digest},
        )

    def _keys(self, name: str, samples: IntArray) -> IntArray:
        """The frame of each key frame."""
        if not len(samples):
            raise self.sample.fault(f"has no sample of {name}")
        apart = np.diff(self.sample.values("timestamp")[samples]) * 1e-6
        steps = np.round(apart / KEY_SECONDS)
        wrong = np.append(False, (steps < 1) | (steps > MOST_KEYS))
        self.sample.refuse(wrong, f"its time is not {KEY_SECONDS:g} s or more after that of the last", samples)
        keys = STEPS * np.append(0, np.cumsum(steps)).astype(np.int64)
        if keys[-1] > STEPS * MOST_KEYS:
            raise self.sample.fault(f"row {samples[-1]}: {name} would last {keys[-1] / 10:.0f} s")
        return keys

    def _motion(self, name: str, rows: IntArray, samples: IntArray, keys: IntArray) -> CarMotion:
        """The car's poses at the exposures of a sensor, whose data are in ``rows``."""
        key = rows[self.data.values("is_key_frame")[rows].astype(bool)] if len(rows) else rows
        order = np.argsort(self.sample_of_data[key], kind="stable")
        place = np.searchsorted(self.sample_of_data[key][order], samples).clip(max=max(len(key) - 1, 0))
        missing = np.ones(len(samples), bool)
        if len(key):
            missing = self.sample_of_data[key][order][place] != samples
        if missing.any():
            problem = f"has no key frame of the sample in row {samples[missing.argmax()]} of sample.json, of {name}"
            raise self.data.fault(problem)
        times = self.pose.values("timestamp")
        known, first = np.unique(times[self.pose_of_data[rows]], return_index=True)
        poses = self.pose_of_data[rows][first]
        start = int(known[0])
        at = np.interp(np.arange(keys[-1] + 1), keys, (times[self.pose_of_data[key[order][place]]] - start) * 1e-6)
        turned, placed = self.pose.vectors("rotation", 4, poses), self.pose.vectors("translation", 3, poses)
        return motion_at(at, (known - start) * 1e-6, turned, placed)

    def _sensor(self, name: str, rows: IntArray, panoramic: bool) -> Sensor:
        """The camera whose data begin in the first of ``rows``, or the panorama of all of them."""
        if not len(rows):
            raise self.data.fault(f"has no data of a camera of {name} ({RING}...)")
        mounted = self.mounted[rows]
        matrix = self.calibrated.table["camera_intrinsic"][int(mounted[0])].as_py()
        right = panoramic or (len(matrix) == 3 and all(len(line) == 3 and None not in line for line in matrix))
        self.calibrated.refuse(np.array([not right]), "'camera_intrinsic' has not 3 x 3 numbers", mounted)
        origins = self.calibrated.vectors("translation", 3, mounted)
        with self.calibrated.of_row(mounted[0]):
            if panoramic:
                return panorama(origins, 0.0)
            (fx, _, cx), (_, fy, cy), _ = matrix
            size = {side: float(self.data.values(side)[rows[0]]) for side in ("width", "height")}
            rotation = rotation_matrices(self.calibrated.vectors("rotation", 4, mounted))[0]
            return pinhole(rotation, origins[0], 0.0, {**size, "fx": fx, "fy": fy, "cx": cx, "cy": cy})

    def _people(self, rows: IntArray, samples: IntArray, keys: IntArray, origin: FloatArray) -> Cuboids:
        """People on foot in key frames, numbered in the order of their tokens, and between two of them."""
        order = np.argsort(samples)
        key = order[np.searchsorted(samples[order], self.sample_of_label[rows])]
        _, person = np.unique(self.rank_of_instance[self.instance_of_label[rows]], return_inverse=True)
        self.labels.refuse_twice("its 'instance_token' has another cuboid in the same sample", rows, key, person)
        both = np.lexsort((key, person))
        rows, key, person = rows[both], key[both], person[both]
        sizes = self.labels.vectors("size", 3, rows)[:, [1, 0, 2]]
        self.labels.refuse_sizes(sizes, rows)
        centres = self.labels.vectors("translation", 3, rows) - origin
        turned, visible, frame = self.labels.vectors("rotation", 4, rows), self.visible[rows], keys[key]
        first = np.flatnonzero((np.diff(person) == 0) & (np.diff(frame) == STEPS))
        parts = [(frame, person, centres, turned, sizes, visible)]
        for step in range(1, STEPS):
            share = np.full(len(first), step / STEPS)
            parts.append(
                (
                    frame[first] + step,
                    person[first],
                    centres[first] + share[:, None] * (centres[first + 1] - centres[first]),
                    between(turned[first], turned[first + 1], share),
                    sizes[first],
                    np.minimum(visible[first], visible[first + 1]),
                )
            )
        frame, person, centres, turned, sizes, visible = (np.concatenate(column) for column in zip(*parts, strict=True))
        return Cuboids(
            frame=frame,
            person=person,
            centres=centres,
            rotations=rotation_matrices(turned),
            sizes=sizes,
            visible=visible,
        )


def find_tables(source: Path | None) -> Path:
    """The folder with the tables: ``source``, or the only v1.0-… in it."""
    if source is None:
        raise SourceMissingError(f"nuscenes: name with --source {WANTED}; download it from {SITE}")
    if (source / "scene.json").is_file():
        return source
    found = sorted(path.parent for path in source.glob("v1.0-*/scene.json"))
    if not found:
        raise SourceMissingError(f"{source}: holds no scene.json; name {WANTED}")
    if len(found) > 1:
        raise FileError(source, f"holds {', '.join(path.name for path in found)}; name one of them")
    return found[0]


nuscenes = NuscenesSplit()
