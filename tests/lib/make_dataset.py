"""A small dataset folder of random crowds, and the submission that answers it exactly."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from tests.lib.made_sequence import sequence_of
from vbbench.camera import PanoramaCamera
from vbbench.files.dataset_info import DatasetInfo, describe_tables
from vbbench.files.tables import TableWriter, to_arrow
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation.datasets import scene_rows, sequence_row, sequence_rows
from vbbench.geometry import FloatArray, world_to_relative
from vbbench.scene import Scene, World
from vbbench.sequence import NOBODY, SequenceData, Truth, held_persons

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
        for name, columns in _rows_of_scene(scene, positions).items():
            tables.setdefault(name, []).append(columns)
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
    people, poses = np.delete(np.arange(positions.shape[1]), observer), _poses(positions[frames, observer])
    others = positions[np.ix_(frames, people)]
    world = World(x=37.0 * np.cos(index), y=23.0 * np.sin(index), yaw=0.7 * index)
    boxes = CAMERA.project(world_to_relative(others, poses), np.full(others.shape[:2], 1.7))
    places, persons = world.positions(others), np.where(np.isnan(boxes[..., 2]), NOBODY, people)
    tracks = people + 30
    if tier == "tracked":
        boxes, places, persons = (_in_two_tracks(values) for values in (boxes, places, persons))
        tracks = np.concatenate([people + 100, people + 200, [FALSE_ALARM]])
        boxes[:, -1] = 100.0
    truth = Truth(poses=world.poses(poses), positions=places, heights=np.full(len(tracks), 1.7))
    facts = {"index": index, "scene": scene, "observer": observer, "first_frame": int(frames[0])}
    sequence = replace(sequence_of(truth, boxes, tracks), **facts)
    data = SequenceData(sequence=sequence, truth=truth, persons=held_persons(persons, sequence.observed), world=world)
    seen = len(np.unique(persons[persons != NOBODY]))
    row = {**sequence_row(data, "tiny"), "people": seen + 1}
    return {"sequences": {name: [value] for name, value in row.items()}, **sequence_rows(data)}


def _in_two_tracks(values: Any) -> Any:
    """[T, 2 K + 1, …] of [T, K, …]: tracks of the first half, of the second, and one of nobody."""
    none = np.full_like(values, NOBODY if values.ndim == 2 else np.nan)
    half = len(values) // 2
    early, late = (np.concatenate(parts) for parts in ((values[:half], none[half:]), (none[:half], values[half:])))
    return np.concatenate([early, late, none[:, :1]], axis=1)


def _poses(path: FloatArray) -> FloatArray:
    step = np.gradient(path, axis=0)
    return np.column_stack([path, np.arctan2(step[:, 1], step[:, 0])])


def _rows_of_scene(scene: int, positions: FloatArray) -> dict[str, Columns]:
    people = np.arange(positions.shape[1])
    made = Scene(name="made", dt=0.4, people=people, positions=positions, heights=np.full(len(people), 1.7))
    return scene_rows(made, scene)
