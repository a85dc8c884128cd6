"""A dataset's public tables as CSV: what a program in any language needs, and no truth."""

from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv as csv
import pyarrow.parquet as pq

from vbbench.files.dataset import Dataset
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import replacing

TABLES = ("sequences", "observations", "given")


def export_csv(dataset: Dataset, out: Path | str) -> Path:
    """Write ``sequences.csv``, ``observations.csv`` and ``given.csv`` into the folder ``out``, and return it.

    Columns and rows are those of the Parquet tables; NaN (the yaw of people) is an empty cell.
    """
    out = Path(out)
    options = csv.WriteOptions(include_header=False, quoting_style="none")
    with loose_files(out):
        for name in TABLES:
            table = pq.ParquetFile(dataset.table_path(name))
            with replacing(out / f"{name}.csv") as temporary, temporary.open("wb") as file:
                file.write((",".join(table.schema_arrow.names) + "\n").encode())
                with csv.CSVWriter(file, table.schema_arrow, write_options=options) as writer:
                    for batch in table.iter_batches():
                        columns = [
                            pc.if_else(pc.is_nan(column), None, column) if pa.types.is_floating(column.type) else column
                            for column in batch.columns
                        ]
                        writer.write_batch(pa.RecordBatch.from_arrays(columns, schema=batch.schema))
    return out
