"""Parquet tables: how rows are grouped, and that reading by sequence does not depend on it."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from vbbench.files import tables
from vbbench.files.sequence_tables import SequenceTable
from vbbench.files.tables import row_groups, to_arrow


def test_long_tables_share_row_groups(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "GROUPS_ALONE", 3)
    path = tmp_path / "truth/poses.parquet"
    with tables.TableWriter(path, "truth/poses") as writer:
        for sequence in range(20):
            rows = {"sequence": [sequence] * 2, "frame": [0, 1]} | {name: [0.0] * 2 for name in ("x", "y", "yaw")}
            writer.add(to_arrow("truth/poses", {name: np.array(values) for name, values in rows.items()}))
    read = pq.ParquetFile(path)
    sizes = [read.metadata.row_group(group).num_rows // 2 for group in range(read.num_row_groups)]
    assert sizes == [1, 1, 1, 2, 2, 2, 4, 4, 3]
    table = SequenceTable(path, "truth/poses")
    for sequence in (0, 4, 5, 19):
        assert table.read(sequence, sequence + 1)["sequence"].tolist() == [sequence] * 2


def test_rows_that_become_arrow_together_are_those_that_become_it_one_by_one() -> None:
    rng = np.random.default_rng(0)
    names = ("u", "v", "l", "visible")
    pieces = [
        {
            "sequence": np.full(rows, index),
            "frame": np.arange(rows),
            "track": np.arange(rows, dtype=np.int32),
            **{name: rng.random(rows) for name in names},
        }
        for index, rows in enumerate((3, 0, 5))
    ]
    for some in (pieces, pieces[:1]):
        assert row_groups("observations", some) == [to_arrow("observations", piece) for piece in some]
