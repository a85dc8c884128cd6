"""Files of one sequence each: their names and ``seqinfo.ini``; and a dataset's public tables as CSV."""

import re
from collections.abc import Mapping
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv as csv
import pyarrow.parquet as pq

from vbbench.errors import FileError
from vbbench.files.dataset import Dataset
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import replacing

_NAME = re.compile(r"sequence-(\d+)")


def sequence_name(number: int) -> str:
    """Name of the file or folder of a sequence."""
    return f"sequence-{number:06d}"


def files_by_sequence(named: Mapping[Path, str], sequences: int) -> dict[int, Path]:
    """The file of each sequence, by number, ascending.

    Parameters
    ----------
    named : each file with its `sequence_name`.
    sequences : how many the dataset has.

    Raises
    ------
    FileError
        At the first file that belongs to no sequence, or to the same sequence as another.
    """
    found: dict[int, Path] = {}
    for path, stem in named.items():
        name = _NAME.fullmatch(stem)
        if name is None or int(name[1]) >= sequences or int(name[1]) in found:
            known = f"sequences 0 to {sequences - 1}, one file each, are called {sequence_name(0)}.txt and so on"
            raise FileError(path, f"belongs to no sequence of the dataset; {known}")
        found[int(name[1])] = path
    return dict(sorted(found.items()))


def sequence_info(name: str, dt: float, frames: int, size: tuple[int, int], extension: str) -> str:
    """The text of ``seqinfo.ini``, as MOTChallenge has it: ``frames`` pictures of ``size`` px, one every ``dt`` s."""
    facts = {
        "name": name,
        "imDir": "img1",
        "frameRate": f"{1.0 / dt:.10g}",
        "seqLength": frames,
        "imWidth": size[0],
        "imHeight": size[1],
        "imExt": extension,
    }
    return "[Sequence]\n" + "".join(f"{key}={value}\n" for key, value in facts.items())


TABLES = ("sequences", "observations", "given")


def export_csv(dataset: Dataset, out: Path | str) -> Path:
    """Write ``sequences.csv``, ``observations.csv`` and ``given.csv`` into the folder ``out``, and return it.

    Columns and rows are those of the Parquet tables; NaN (the yaw of people) is an empty cell.

    Raises
    ------
    VbbenchError
        If ``out`` is not a folder, or is a dataset or submission.
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
                        writer.write_batch(_without_nan(batch))
    return out


def _without_nan(batch: pa.RecordBatch) -> pa.RecordBatch:
    columns = [
        pc.if_else(pc.is_nan(column), None, column) if pa.types.is_floating(column.type) else column
        for column in batch.columns
    ]
    return pa.RecordBatch.from_arrays(columns, schema=batch.schema)
