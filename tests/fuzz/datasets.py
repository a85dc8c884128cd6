"""Kinds of files of datasets, submissions and leaderboards."""

import hashlib
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from io import BytesIO
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from tests.fuzz.kind import Kind
from tests.fuzz.mutations import JSON, TEXT
from tests.fuzz.parquet_mutations import PARQUET
from tests.lib.answers import submit, submit_csv, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from tests.lib.tiny_board import FILE, tiny_board, tiny_dataset
from vbbench.files.cards.writing import card_texts
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo, describe
from vbbench.files.verification import verify
from vbbench.parsing.json_text import canonical_digest
from vbbench.scoring import score
from vbbench_leaderboards.results.folder import read_results
from vbbench_leaderboards.results.sealed_json import digest

SMALL = Crowd(scenes=1, frames=8, people=4, stay=(4, 8), sequences=3)
TRACKED = Crowd(scenes=1, frames=8, people=4, stay=(4, 8), sequences=3, tier="tracked")


@cache
def _made(what: str) -> Path:
    """A folder made once, of which every kind has a copy."""
    folder = Path(mkdtemp(prefix="vbbench-fuzz-"))
    (tiny_board if what == "board" else _write)(folder / "made")
    return folder / "made"


def _write(folder: Path) -> None:
    tiny_dataset(folder / "described", SMALL)
    write_dataset(folder / "small", SMALL)
    write_dataset(folder / "tracked", TRACKED)
    tables = true_answers(folder / "small", 0.1)
    submit(folder / "parquet", folder / "small", tables)
    submit_csv(folder / "csv", folder / "small", tables)


def _copy(what: str) -> Callable[[Path], object]:
    return lambda folder: shutil.copytree(_made(what), folder, dirs_exist_ok=True)


def _read_dataset(folder: Path) -> None:
    """Everything that a dataset holds."""
    dataset = Dataset(folder)
    for sequence in dataset.sequences():
        dataset.truth(sequence)


def _read_described(folder: Path) -> None:
    """The facts of a dataset, its cards, and whether its tables belong to them."""
    describe(DatasetInfo.read(folder))
    card_texts(folder)
    verify(folder)


def _sealed(file: str, seal: Callable[[dict[str, Any]], str]) -> dict[str, Any]:
    """With a digest that fits, wherever there can be one."""

    def finish(folder: Path) -> None:
        try:
            values = json.loads((folder / file).read_bytes())
            text = json.dumps({**values, "digest": seal({k: v for k, v in values.items() if k != "digest"})})
            (folder / file).write_text(text, encoding="utf-8")
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError, OverflowError):
            pass

    return {"finish": finish}


def _told(crowd: str, name: str) -> Callable[[Path], None]:
    """``dataset.json`` tells size, rows and SHA-256 of the table as it is now."""

    def finish(folder: Path) -> None:
        info, content = DatasetInfo.read(folder / crowd), (folder / crowd / f"{name}.parquet").read_bytes()
        try:
            rows = pq.ParquetFile(BytesIO(content)).metadata.num_rows
        except (pa.ArrowException, OSError, ValueError):
            rows = 0
        facts = {"rows": rows, "bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
        told = replace(info, tables={**info.tables, name: facts})
        (folder / crowd / "dataset.json").write_text(told.to_json(), encoding="utf-8")

    return finish


def _table(crowd: str, name: str, weight: int = 1) -> Kind:
    return Kind(
        name=f"{crowd}-{name.replace('/', '-')}",
        make=_copy("dataset"),
        target=f"{crowd}/{name}.parquet",
        mutations=PARQUET,
        read=lambda folder: _read_dataset(folder / crowd),
        finish=_told(crowd, name),
        also=(f"{crowd}/dataset.json",),
        weight=weight,
    )


def _answer(kind: str, file: str, weight: int = 2) -> Kind:
    mutations = {".json": JSON, ".csv": TEXT, ".parquet": PARQUET}[Path(file).suffix]
    return Kind(
        name=f"submission-{kind}-{Path(file).stem}",
        make=_copy("dataset"),
        target=f"{kind}/{file}",
        mutations=mutations,
        read=lambda folder: score(folder / kind, folder / "small").table(),
        lists_faults=True,
        weight=weight,
    )


def _board(name: str, file: str, **more: object) -> Kind:
    return Kind(
        name=name,
        make=_copy("board"),
        target=f"results/{file}",
        mutations=JSON,
        read=lambda folder: read_results(folder / "results"),
        weight=1,
        **more,
    )


def _described(name: str, **more: object) -> Kind:
    return Kind(
        name=name,
        make=_copy("dataset"),
        target="described/dataset.json",
        mutations=JSON,
        read=lambda folder: _read_described(folder / "described"),
        weight=4,
        **more,
    )


KINDS = (
    _described("dataset-json"),
    _described("dataset-json-sealed", **_sealed("described/dataset.json", canonical_digest)),
    *(_table("small", name) for name in ("sequences", "observations", "given")),
    *(_table("small", f"truth/{name}") for name in ("poses", "scenes", "people")),
    _table("tracked", "truth/tracks"),
    _answer("parquet", "submission.json"),
    _answer("parquet", "poses.parquet"),
    _answer("parquet", "positions.parquet"),
    _answer("csv", "poses.csv"),
    _answer("csv", "positions.csv"),
    _board("result", str(FILE)),
    _board("result-sealed", str(FILE), **_sealed(f"results/{FILE}", digest)),
    _board("record", "tiny/ideal.json"),
    _board("record-sealed", "tiny/ideal.json", **_sealed("results/tiny/ideal.json", digest)),
)
"""Datasets, submissions and boards."""
