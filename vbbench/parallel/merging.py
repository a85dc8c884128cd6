"""Makes partitioned datasets and submissions whole: the same files, byte for byte, as one machine writes."""

from dataclasses import replace
from functools import partial
from pathlib import Path

from vbbench.files.dataset_info import INFO_FILE, DatasetInfo, describe_tables, table_paths
from vbbench.files.submission import SubmissionInfo
from vbbench.files.tables import TableWriter
from vbbench.files.withholding import check_truth_free, truth_folder_beside, withhold
from vbbench.folders.replacing import write_text_atomically
from vbbench.folders.swapping import real
from vbbench.folders.work_folder import PARTITIONED, WorkFolder, check_free
from vbbench.parallel.partitions import Layout, PartitionedTable, read_layout
from vbbench.parallel.parts import progress_bar


def merge(folder: Path | str, out: Path | str | None = None, *, overwrite: bool = False) -> Path:
    """Merge the partitions in ``folder`` into whole tables, there or in the folder ``out``; return where they are.

    Interrupted, it is made good by the same call: partitions go only when the whole is there.

    Parameters
    ----------
    overwrite : replace the dataset or submission that is in ``out``, and the truth beside it.

    Raises
    ------
    VbbenchError
        If ``folder`` is not partitioned, a file of it is missing or damaged, or ``out`` or the truth that is to be
        kept beside it is in the way.
    """
    folder = Path(folder)
    target = folder if out is None else Path(out)
    in_place = real(target) == real(folder)
    with WorkFolder(target, partial(_check, folder, target, overwrite or in_place, overwrite)) as work:
        if work.begin(f"merge {real(folder)}"):
            layout = read_layout(folder)
            _write_whole(folder, layout, work)
            work.publish(_strangers(folder, layout) if in_place else ())
    return target


def _check(folder: Path, target: Path, overwrite: bool, overwrite_truth: bool) -> None:
    layout = read_layout(folder)
    check_free(target, layout.marker, "merged folder", overwrite)
    if layout.withheld:
        check_truth_free(truth_folder_beside(target), overwrite_truth)


def _write_whole(folder: Path, layout: Layout, work: WorkFolder) -> None:
    paths = table_paths(layout.tables, work, layout.withheld)
    with progress_bar(len(paths) * len(layout.parts), "merge", unit="file") as bar:
        for name, path in paths.items():
            table = PartitionedTable(folder, name, layout.parts)
            with TableWriter(path, name, table.columns) as writer:
                for part in layout.parts:
                    for group in table.groups(part):
                        writer.add(group)
                    bar.update()
    write_text_atomically(work.new / layout.marker, _facts(folder, layout, paths, work))


def _facts(folder: Path, layout: Layout, paths: dict[str, Path], work: WorkFolder) -> str:
    """The text of the merged ``dataset.json`` or ``submission.json``."""
    if layout.marker != INFO_FILE:
        return SubmissionInfo.read(folder / PARTITIONED).to_json()
    info = replace(DatasetInfo.read(folder / PARTITIONED), tables=describe_tables(paths))
    return (withhold(info, work.new_truth) if layout.withheld else info).to_json()


def _strangers(folder: Path, layout: Layout) -> set[str]:
    """Names of what lies in a partitioned folder and is no part of it."""
    return {path.name for path in folder.iterdir()} - {Path(name).parts[0] for name in layout.tables} - {PARTITIONED}
