"""Parquet tables: how rows are grouped, and that reading by sequence does not depend on it."""

from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from vbbench.files import tables
from vbbench.files.sequence_tables import SequenceTable
from vbbench.files.tables import to_arrow
from vbbench.parallel.parts import Part, write_in_parts


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


def test_a_table_gets_a_column_that_only_a_later_part_has_and_is_begun_before_that_part_is_made(tmp_path: Path) -> None:
    begun: list[int] = []

    def work(first: int, _last: int) -> Part:
        begun.append(len(list(tmp_path.glob(".positions*"))))
        rows = {"sequence": np.array([first]), "frame": np.array([2]), "track": np.array([0])}
        rows |= {name: np.array([1.5]) for name in ("x", "y", *(("xx", "xy", "yy") if first == 2 else ()))}
        return Part(groups={"positions": [to_arrow("positions", rows)]}, facts={"first": first})

    path = tmp_path / "positions.parquet"
    facts = write_in_parts(work, [(0, 1), (1, 2), (2, 3)], tmp_path, {"positions": path}, label="test")
    assert facts == [{"first": 0}, {"first": 1}, {"first": 2}]
    assert begun == [0, 1, 1]
    table = pq.read_table(path)
    assert table["sequence"].to_pylist() == [0, 1, 2]
    np.testing.assert_array_equal(table["xx"].to_pylist(), [np.nan, np.nan, 1.5])
