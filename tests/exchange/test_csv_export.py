"""What a solver may see, as CSV for any language: the numbers of the dataset, and no truth."""

from pathlib import Path

import pandas as pd

from tests.lib.make_dataset import write_dataset
from vbbench.exchange.csv_export import TABLES, export_csv
from vbbench.files.dataset import Dataset


def test_csv_says_what_parquet_says_and_no_truth(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data")
    dataset = Dataset(tmp_path / "data")
    export_csv(dataset, tmp_path / "csv")
    assert sorted(path.stem for path in (tmp_path / "csv").iterdir()) == sorted(TABLES)
    for name in TABLES:
        text = (tmp_path / "csv" / f"{name}.csv").read_text("utf-8")
        assert '"' not in text
        assert "nan" not in text
        read = pd.read_csv(tmp_path / "csv" / f"{name}.csv")
        there = pd.read_parquet(dataset.table_path(name))
        pd.testing.assert_frame_equal(read, there, check_dtype=False, rtol=1e-7)
