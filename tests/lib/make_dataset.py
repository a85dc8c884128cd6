"""A small dataset folder of random crowds, and the submission that answers it exactly."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.camera import PanoramaCamera
from vbbench.files.dataset_info import DatasetInfo, describe_tables
from vbbench.files.tables import TableWriter, to_arrow
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import FloatArray, IntArray, world_to_relative
from vbbench.world import World

CAMERA = PanoramaCamera()
FALSE_ALARM = 900
Columns = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Crowd:
    """What to make: people who enter, walk straight with a wobble for ``stay`` frames, and leave."""

    scenes: int = 2
    frames: int = 16
    people: int = 6
    stay: tuple[int, int] = (5, 14)
    seed: int = 0
    tier: str = "ideal"
    caution: str | None = None
    dt: float = 0.4
    sequences: int | None = None


def write_dataset(folder: Path, crowd: Crowd | None = None) -> DatasetInfo:
    """Write the dataset folder; everybody who stays three frames observes one sequence."""
    crowd = crowd or Crowd()
    random = np.random.default_rng(crowd.seed)
    scenes = [_walk(random, crowd) for _ in range(crowd.scenes)]
    plans = [(s, k) for s, scene in enumerate(scenes) for k in range(crowd.people) if _present(scene)[:, k].sum() > 2]
    plans = plans[: crowd.sequences]
    tables: dict[str, list[Columns]] = {}
    for index, (scene, observer) in enumerate(plans):
        for name, columns in _sequence(index, scene, observer, scenes[scene], crowd.tier).items():
            tables.setdefault(name, []).append(columns)
    for scene, positions in enumerate(scenes):
        tables.setdefault("truth/scenes", []).append(_scene_rows(scene, positions))
        tables.setdefault("truth/people", []).append(_people_rows(scene, crowd.people))
    paths = {name: folder / f"{name}.parquet" for name in tables}
    for name, groups in tables.items():
        with TableWriter(paths[name], name) as writer:
            for group in groups:
                writer.add(to_arrow(name, group))
    info = replace(_info(crowd), tables=describe_tables(paths), counts=_counts(len(plans), tables["observations"]))
    write_text_atomically(folder / "dataset.json", info.to_json())
    return info


def _counts(sequences: int, boxes: list[Columns]) -> dict[str, float]:
    people = np.concatenate([np.unique(rows["frame"], return_counts=True)[1] for rows in boxes])
    counts = {"sequences": sequences, "frames": len(people), "observations": int(people.sum())}
    return {**counts, "people_min": int(people.min(initial=1 << 30)), "people_max": int(people.max(initial=0))}


def _info(crowd: Crowd) -> DatasetInfo:
    return DatasetInfo(
        split="tiny",
        title="Tiny random crowds",
        camera=CAMERA,
        tier=crowd.tier,
        seed=crowd.seed,
        dt=crowd.dt,
        height_mean=1.7,
        height_std=0.0,
        pixel_std=0.0,
        scenes=tuple(f"scene{n}" for n in range(crowd.scenes)),
        definition={"people": crowd.people, "frames": crowd.frames},
        caution=crowd.caution,
    )


def _walk(random: np.random.Generator, crowd: Crowd) -> FloatArray:
    """[T, K, 2] positions, NaN where absent."""
    entry = random.integers(-crowd.stay[0], crowd.frames - 2, crowd.people)
    stay = random.integers(*crowd.stay, crowd.people)
    start, velocity = random.uniform(-8, 8, (crowd.people, 2)), random.normal(0, 0.4, (crowd.people, 2))
    time = np.arange(crowd.frames)[:, None]
    positions = start + velocity * time[..., None] + random.normal(0, 0.02, (crowd.frames, crowd.people, 2))
    positions[(time < entry) | (time >= entry + stay)] = np.nan
    return positions


def _present(positions: FloatArray) -> Any:
    return ~np.isnan(positions[..., 0])


def _sequence(index: int, scene: int, observer: int, positions: FloatArray, tier: str) -> dict[str, Columns]:
    frames = np.flatnonzero(_present(positions)[:, observer])
    first, count = int(frames[0]), len(frames)
    poses = _poses(positions[frames, observer])
    others = np.delete(positions[frames], observer, axis=1)
    people = np.delete(np.arange(positions.shape[1]), observer)
    world = World(x=37.0 * np.cos(index), y=23.0 * np.sin(index), yaw=0.7 * index)
    boxes = CAMERA.project(world_to_relative(others, poses), np.full(others.shape[:2], 1.7))
    frame, column = np.nonzero(~np.isnan(boxes[..., 2]))
    track = _track_ids(people[column], frame, count, tier)
    rows = {"sequence": np.full(len(frame), index), "frame": frame, "track": track, "visible": np.ones(len(frame))}
    rows |= dict(zip("uvl", boxes[frame, column].T, strict=True))
    tables = {
        "sequences": {
            "sequence": [index],
            "scene": [scene],
            "observer": [observer],
            "first_frame": [first],
            "frames": [count],
            "people": [len(np.unique(column)) + 1],
            "split": ["tiny"],
        },
        "truth/poses": {"sequence": np.full(count, index), "frame": np.arange(count), **_xyyaw(world.poses(poses))},
        "truth/frames": {"sequence": [index], "x": [world.x], "y": [world.y], "yaw": [world.yaw]},
        "truth/tracks": _begun(index, frame, track, people[column]),
        "given": _given(index, frame, track, world.positions(others[frame, column]), world.poses(poses)),
        "observations": rows,
    }
    if tier == "tracked":
        tables["observations"] = _with_false_alarms(rows, index, count)
    return tables


def _begun(index: int, frame: IntArray, track: IntArray, person: IntArray) -> Columns:
    """One row where a track begins; its person stays the same."""
    _, first = np.unique(track, return_index=True)
    first = np.sort(first)
    return {
        "sequence": np.full(len(first), index),
        "frame": frame[first],
        "track": track[first],
        "person": person[first],
    }


def _poses(path: FloatArray) -> FloatArray:
    step = np.gradient(path, axis=0)
    return np.column_stack([path, np.arctan2(step[:, 1], step[:, 0])])


def _xyyaw(poses: FloatArray) -> Columns:
    return {"x": poses[:, 0], "y": poses[:, 1], "yaw": poses[:, 2]}


def _track_ids(person: IntArray, frame: IntArray, count: int, tier: str) -> IntArray:
    """Another number than the person's; in the tier `tracked` it switches half-way."""
    return person + (30 if tier != "tracked" else np.where(frame < count // 2, 100, 200))


def _with_false_alarms(rows: Columns, index: int, count: int) -> Columns:
    alarm = {"sequence": np.full(count, index), "frame": np.arange(count), "track": np.full(count, FALSE_ALARM)}
    alarm |= {name: np.full(count, 100.0) for name in ("u", "v", "l")} | {"visible": np.ones(count)}
    merged = {name: np.concatenate([rows[name], alarm[name]]) for name in rows}
    order = np.lexsort([merged["track"], merged["frame"]])
    return {name: values[order] for name, values in merged.items()}


def _given(index: int, frame: IntArray, track: IntArray, xy: FloatArray, poses: FloatArray) -> Columns:
    """The observer's first two frames, the first two frames, and everybody's first two visible frames."""
    seen = np.array([np.sum(track[:row] == track[row]) for row in range(len(track))], dtype=int)
    keep = (seen < 2) | (frame < 2)
    start = min(2, len(poses))
    return {
        "sequence": np.full(start + keep.sum(), index),
        "frame": np.concatenate([np.arange(start), frame[keep]]),
        "track": np.concatenate([np.full(start, -1), track[keep]]),
        "x": np.concatenate([poses[:start, 0], xy[keep, 0]]),
        "y": np.concatenate([poses[:start, 1], xy[keep, 1]]),
        "yaw": np.concatenate([poses[:start, 2], np.full(keep.sum(), np.nan)]),
    }


def _scene_rows(scene: int, positions: FloatArray) -> Columns:
    frame, person = np.nonzero(_present(positions))
    x, y = positions[frame, person].T
    return {"scene": np.full(len(frame), scene), "frame": frame, "person": person, "x": x, "y": y}


def _people_rows(scene: int, people: int) -> Columns:
    return {"scene": np.full(people, scene), "person": np.arange(people), "height": np.full(people, 1.7)}
