"""Makes a dataset folder from a generator's plan."""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from vbbench.errors import VbbenchError
from vbbench.files.cards.writing import write_cards
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo, describe_tables, table_paths
from vbbench.files.sequence_tables import OBSERVER, part_ranges
from vbbench.files.tables import (
    CAMERA,
    FRAME_TABLE,
    MOTION,
    MOTION_COVARIANCE,
    ODOMETRY_TABLE,
    SCENE_TABLES,
    TRACK_TABLE,
    Columns,
    TableWriter,
    arrow_array,
    row_groups,
    table_schema,
    to_arrow,
)
from vbbench.files.withholding import GUESSABLE_BITS, check_truth_free, keep_seed, truth_folder_of
from vbbench.folders.replacing import write_text_atomically
from vbbench.folders.work_folder import WorkFolder, check_free
from vbbench.generation.generator import Generator, Options, Plan, expected_rows_of, tables_of
from vbbench.generation.planning import build_sequence, is_endless, planned
from vbbench.geometry import IntArray
from vbbench.parallel.parts import Part, check_jobs, write_in_parts
from vbbench.registry import load
from vbbench.scene import Scene, World
from vbbench.sequence import NOBODY, Odometry, SequenceData
from vbbench.version import __version__


def scene_rows(scene: Scene, number: int) -> dict[str, Columns]:
    """The scene in the tables of truth: one row per person and frame, by frame, and one row per person."""
    frame, column = np.nonzero(scene.present)
    x, y = scene.positions[frame, column].T
    people = {"scene": np.full(len(scene.people), number), "person": scene.people, "height": scene.heights}
    where = {"scene": np.full(len(frame), number), "frame": frame, "person": scene.people[column]}
    return {"truth/scenes": {**where, "x": x, "y": y}, "truth/people": people}


def sequence_row(data: SequenceData, split: str) -> dict[str, Any]:
    """The row of a sequence in ``sequences.parquet``."""
    s = data.sequence
    return {
        "sequence": s.index,
        "scene": s.scene,
        "observer": s.observer,
        "first_frame": s.first_frame,
        "frames": s.frames,
        "people": len(s.tracks),
        "split": split,
        CAMERA: s.camera,
    }


def observation_rows(data: SequenceData) -> Columns:
    """One row per box, by frame and track."""
    s = data.sequence
    boxes = np.flatnonzero(s.observed)
    frame, column = np.divmod(boxes.astype(np.int32), np.int32(max(len(s.tracks), 1)))
    u, v, length = s.observations.reshape(-1, 3).take(boxes, axis=0).T
    return {
        "sequence": np.full(len(frame), s.index, np.int32),
        "frame": frame,
        "track": s.tracks.astype(np.int32)[column],
        "u": u,
        "v": v,
        "l": length,
        "visible": s.visible.reshape(-1).take(boxes).astype(np.float32),
    }


def given_rows(data: SequenceData) -> Columns:
    """One row per given position, by frame; the observer, with its yaw, comes first."""
    s = data.sequence
    own = np.flatnonzero(~np.isnan(s.given.poses[:, 0]))
    frame, column = np.nonzero(~np.isnan(s.given.positions[..., 0]))
    order = np.argsort(np.concatenate([own, frame]), kind="stable")
    poses, positions = s.given.poses[own], s.given.positions[frame, column]
    return {
        "sequence": np.full(len(order), s.index, np.int32),
        "frame": np.concatenate([own, frame])[order],
        "track": np.concatenate([np.full(len(own), OBSERVER), s.tracks[column]])[order],
        "x": np.concatenate([poses[:, 0], positions[:, 0]])[order],
        "y": np.concatenate([poses[:, 1], positions[:, 1]])[order],
        "yaw": np.concatenate([poses[:, 2], np.full(len(frame), np.nan)])[order],
    }


def odometry_rows(sequence: int, odometry: Odometry) -> Columns:
    """One row per measured motion, by frame."""
    frame = np.flatnonzero(np.isfinite(odometry.motions).all(axis=1))
    i, j = np.triu_indices(3)
    columns = dict(zip(MOTION, odometry.motions[frame].T, strict=True))
    columns |= dict(zip(MOTION_COVARIANCE, odometry.covariances[frame][:, i, j].T, strict=True))
    return {"sequence": np.full(len(frame), sequence), "frame": frame, **columns}


def pose_rows(data: SequenceData) -> Columns:
    """One row per frame: the true pose."""
    x, y, yaw = data.truth.poses.T
    where = {"sequence": np.full(len(x), data.sequence.index, np.int32), "frame": np.arange(len(x), dtype=np.int32)}
    return {**where, "x": x, "y": y, "yaw": yaw}


def track_rows(data: SequenceData, persons: IntArray) -> Columns:
    """One row where a track begins to stand for a person, or for nobody after one, by frame and track.

    Parameters
    ----------
    persons : [T, K] the person behind each track, `NOBODY` before its first box.
    """
    begins = np.empty(persons.shape, bool)
    begins[:1] = persons[:1] != NOBODY
    np.not_equal(persons[1:], persons[:-1], out=begins[1:])
    frame, column = np.nonzero(begins)
    return {
        "sequence": np.full(len(frame), data.sequence.index, np.int32),
        "frame": frame,
        "track": data.sequence.tracks[column],
        "person": persons[frame, column],
    }


def frame_rows(sequence: int, world: World) -> Columns:
    """One row: where the scene lies in the sequence's own world."""
    return {"sequence": np.array([sequence]), **{name: np.array([value]) for name, value in vars(world).items()}}


def sequence_rows(data: SequenceData) -> dict[str, Columns]:
    """Everything that is written of a sequence, by table."""
    tables = {"observations": observation_rows(data), "given": given_rows(data), "truth/poses": pose_rows(data)}
    if data.sequence.given.odometry is not None:
        tables[ODOMETRY_TABLE] = odometry_rows(data.sequence.index, data.sequence.given.odometry)
    if data.persons is not None:
        tables[TRACK_TABLE] = track_rows(data, data.persons)
    if data.world is not None:
        tables[FRAME_TABLE] = frame_rows(data.sequence.index, data.world)
    return tables if data.scene is None else tables | scene_rows(data.scene, data.sequence.scene)


def generate(
    split: str,
    out: Path | str,
    options: Options,
    *,
    jobs: int = 1,
    scheduler: str | None = None,
    withhold_truth: bool = False,
    overwrite: bool = False,
) -> Dataset:
    """Make the dataset ``split`` in the folder ``out``, by ``jobs`` processes or the Dask cluster at ``scheduler``.

    Its bytes do not depend on either. The same call continues interrupted work. With ``withhold_truth`` the truth
    tables and the seed are written to the folder ``<out>.truth``.

    Raises VbbenchError if the split is unknown, its sources are missing or wrong, or ``out`` exists and may not be
    replaced.
    """
    check_jobs(jobs)
    out = Path(out)
    load("generator", split)  # a name that is unknown is no reason to begin a folder
    with WorkFolder(out, partial(_check, out, overwrite, withhold_truth)) as work:
        _write(planned(split, options), work, withhold_truth, jobs=jobs, scheduler=scheduler)
    return Dataset(out, truth_folder_of(out) if withhold_truth else None)


def write_dataset(plan: Plan, out: Path, *, jobs: int = 1, overwrite: bool = False) -> Dataset:
    """Make every sequence of a plan and write them to the folder ``out``; see `generate`."""
    with WorkFolder(out, partial(_check, out, overwrite, withhold_truth=False)) as work:
        _write(plan, work, withhold_truth=False, jobs=jobs)
    return Dataset(out)


def _write(plan: Plan, work: WorkFolder, withhold_truth: bool, *, jobs: int, scheduler: str | None = None) -> None:
    if not work.begin(f"{plan.info.id} {__version__} {withhold_truth}"):
        return
    if withhold_truth:
        keep_seed(plan.info, work.new_truth)  # before the work, so that an interruption does not lose a secret seed
    tables = table_paths(tables_of(plan), work, withhold_truth)
    streamed = {name: path for name, path in tables.items() if not (plan.scenes and name in SCENE_TABLES)}
    ranges = part_ranges(len(plan), expected_rows_of(plan))
    where: dict[str, Any] = {"jobs": jobs, "scheduler": scheduler, "label": plan.info.split}
    facts = write_in_parts(partial(_build_part, plan), ranges, work.parts, streamed, **where)
    for name, groups in _shared_scenes(plan.scenes).items():
        with TableWriter(tables[name], name) as writer:
            for group in groups:
                writer.add(group)
    info = replace(_counted(plan, facts), tables=describe_tables(tables))
    published = replace(info, seed=None, withheld_id=info.id) if withhold_truth else info
    write_text_atomically(work.new / INFO_FILE, published.to_json())
    write_cards(work.new)
    work.publish()


def _check(out: Path, overwrite: bool, withhold_truth: bool) -> None:
    check_free(out, INFO_FILE, "dataset", overwrite)
    if withhold_truth:
        check_truth_free(truth_folder_of(out), overwrite)


def _build_part(plan: Plan, first: int, last: int) -> Part:
    """The row groups of some sequences, and the counts for `vbbench info`."""
    made: dict[str, list[Columns]] = defaultdict(list)
    rows, seen, tables = [], [], tables_of(plan)
    for index in range(first, last):
        data = build_sequence(plan, index)
        for name, columns in sequence_rows(data).items():
            if name in tables:
                made[name].append(columns)
        rows.append(sequence_row(data, plan.info.split))
        seen.append(data.sequence.observed.sum(axis=1))
    schema = table_schema("sequences", [CAMERA] if plan.info.cameras else [])
    cells = [arrow_array([row[field.name] for row in rows], field.type) for field in schema]
    groups = {name: row_groups(name, pieces) for name, pieces in made.items()}
    groups["sequences"] = [pa.Table.from_arrays(cells, schema=schema)]
    people = np.concatenate(seen)
    people = people[people > 0]
    facts = {"sequences": len(rows), "frames": len(people), "observations": int(people.sum())}
    facts |= {"people_min": int(people.min(initial=1 << 30)), "people_max": int(people.max(initial=0))}
    return Part(groups=groups, facts=facts)


def _counted(plan: Plan, facts: list[dict[str, Any]]) -> DatasetInfo:
    """The plan's info with counts over the frames in which people are observed; the observer is not counted."""
    how: dict[str, Any] = {"sequences": sum, "frames": sum, "observations": sum, "people_min": min, "people_max": max}
    counts = {name: combine([part[name] for part in facts]) for name, combine in how.items()}
    return replace(plan.info, counts=counts, package_version=__version__)


def _shared_scenes(scenes: tuple[Scene, ...]) -> dict[str, list[pa.Table]]:
    """Row groups of the scenes that sequences share, by table."""
    groups: dict[str, list[pa.Table]] = defaultdict(list)
    for number, scene in enumerate(scenes):
        for name, columns in scene_rows(scene, number).items():
            groups[name].append(to_arrow(name, columns))
    return dict(groups)


def who_knows(split: str, seed: int) -> str | None:
    """Why withholding the truth of a dataset would not keep it secret; ``None`` if it would."""
    generator: Generator = load("generator", split)
    if generator.card.sources:
        known = f"{split} is a public recording, and everyone who has it knows its truth"
        return f"{known}; withhold sim, street or a recording of your own (custom), with a secret seed"
    if seed.bit_length() <= GUESSABLE_BITS:
        return f"seed {seed} can be guessed, and this truth generated from it; use a secret seed"
    return None


def stream(
    split: str = "sim",
    options: Options | None = None,
    *,
    first: int = 0,
    stop: int | None = None,
    shard: int = 0,
    shards: int = 1,
) -> Iterator[SequenceData]:
    """Sequences first + shard, first + shard + shards, … of a split: those that `generate` would write.

    Raises VbbenchError if the split or an option is wrong, or there is no such shard.

    Parameters
    ----------
    split, options : what to make; splits made of recordings end with their last sequence, ``sim`` never does.
    first : the first sequence, for example to continue an earlier run.
    stop : the sequence to stop before; ``None`` for none.
    shard, shards : this worker's number, from 0, and the number of workers that share the stream without overlap.
    """
    if not 0 <= shard < shards:
        raise VbbenchError(f"shard {shard} of {shards}: shards are numbered from 0 to one less than their number")
    if first < 0:
        raise VbbenchError(f"the stream begins at sequence 0 or later, not {first}")
    plan = planned(split, options or Options())
    if not is_endless(plan):
        stop = len(plan) if stop is None else min(stop, len(plan))
    wanted = count(first + shard, shards) if stop is None else range(first + shard, stop, shards)
    return map(partial(build_sequence, plan), wanted)
