"""Makes a dataset folder from a generator's plan."""

import shutil
from collections import defaultdict
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from vbbench import __version__
from vbbench.dataset import Dataset
from vbbench.dataset_info import INFO_FILE, DatasetInfo
from vbbench.errors import VbbenchError
from vbbench.generator import Generator, Options, Plan
from vbbench.parts import Part, prepare_parts, write_in_parts
from vbbench.registry import load
from vbbench.rows import ROWS, SCENE_TABLES, scene_rows, sequence_row, sequence_rows
from vbbench.scene import Scene
from vbbench.schemas import SCHEMAS, to_arrow
from vbbench.tables import TableWriter, check_free, file_sha256, write_text_atomically


def generate(
    split: str,
    out: Path | str,
    options: Options,
    *,
    jobs: int = 1,
    withhold_truth: bool = False,
    overwrite: bool = False,
) -> Dataset:
    """Make the dataset ``split`` in the folder ``out``; its bytes do not depend on ``jobs``.

    Interrupted work goes on where it stopped when the same call is made again. With ``withhold_truth`` the truth
    tables go to the folder ``<out>.truth`` beside it.

    Raises
    ------
    VbbenchError
        If the split is unknown, its sources are missing or bad, or ``out`` is in the way.
    """
    out = Path(out)
    check_free(out, INFO_FILE, "dataset", overwrite)
    generator: Generator = load("generator", split)
    plan = generator.plan(options)
    if not len(plan):
        raise VbbenchError(f"{split}: no person of the source is seen with enough others to make a sequence")
    draft = out.with_name(out.name + ".partial")
    prepare_parts(draft / "parts", plan.info.id)
    info = _write_tables(plan, draft, jobs)
    write_text_atomically(draft / INFO_FILE, info.to_json())
    _put_in_place(draft, out, withhold_truth)
    return Dataset(out, truth_folder_beside(out) if withhold_truth else None)


def truth_folder_beside(out: Path) -> Path:
    """Where withheld truth is kept."""
    return out.with_name(out.name + ".truth")


def _write_tables(plan: Plan, draft: Path, jobs: int) -> DatasetInfo:
    names = ["sequences", *ROWS, *(() if plan.scenes else SCENE_TABLES)]
    tables = {name: draft / f"{name}.parquet" for name in names}
    facts = write_in_parts(
        partial(_build_part, plan), len(plan), draft / "parts", tables, jobs=jobs, label=plan.info.split
    )
    if plan.scenes:
        _write_shared_scenes(plan.scenes, draft)
    return replace(plan.info, counts=_total(facts), tables=describe_tables(draft), package_version=__version__)


def _build_part(plan: Plan, first: int, last: int) -> Part:
    """The row groups of some sequences, and the sums that `vbbench info` is made from."""
    built = [plan.build(index) for index in range(first, last)]
    groups: dict[str, list[pa.Table]] = defaultdict(list)
    rows = [sequence_row(data, plan.info.split) for data in built]
    groups["sequences"].append(pa.Table.from_pylist(rows, schema=SCHEMAS["sequences"]))
    for data in built:
        for name, columns in sequence_rows(data).items():
            groups[name].append(to_arrow(name, columns))
    people = np.concatenate([data.sequence.observed.sum(axis=1) for data in built])
    people = people[people > 0]
    facts = {"sequences": len(built), "frames": len(people), "observations": int(people.sum())}
    facts |= {"least": int(people.min(initial=1 << 30)), "most": int(people.max(initial=0))}
    return Part(groups=dict(groups), facts=facts)


def _total(facts: list[dict[str, Any]]) -> dict[str, float]:
    """Counts over the frames in which anybody is observed; the observer is not counted among the people."""
    return {
        "sequences": sum(part["sequences"] for part in facts),
        "frames": sum(part["frames"] for part in facts),
        "observations": sum(part["observations"] for part in facts),
        "people_min": min(part["least"] for part in facts),
        "people_max": max(part["most"] for part in facts),
    }


def _write_shared_scenes(scenes: tuple[Scene, ...], draft: Path) -> None:
    with ExitStack() as stack:
        writers = {name: stack.enter_context(TableWriter(draft / f"{name}.parquet", name)) for name in SCENE_TABLES}
        for number, scene in enumerate(scenes):
            for name, columns in scene_rows(scene, number).items():
                writers[name].add(to_arrow(name, columns))


def describe_tables(folder: Path) -> dict[str, dict[str, Any]]:
    """Size and SHA-256 of every table of a dataset folder."""
    found = sorted(path.relative_to(folder) for path in folder.rglob("*.parquet"))
    return {
        path.with_suffix("").as_posix(): {
            "bytes": (folder / path).stat().st_size,
            "rows": pq.read_metadata(folder / path).num_rows,
            "sha256": file_sha256(folder / path),
        }
        for path in found
    }


def _put_in_place(draft: Path, out: Path, withhold_truth: bool) -> None:
    if withhold_truth:
        kept = truth_folder_beside(out)
        shutil.rmtree(kept, ignore_errors=True)
        (draft / "truth").replace(kept)
    if out.exists():
        old = out.with_name(out.name + ".old")
        out.replace(old)
        draft.replace(out)
        shutil.rmtree(old)
    else:
        draft.replace(out)
