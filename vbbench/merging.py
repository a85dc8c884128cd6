"""Makes partitioned datasets and submissions whole: the same files, byte for byte, as one machine writes."""

import shutil
from dataclasses import replace
from pathlib import Path

from vbbench.dataset_info import INFO_FILE, DatasetInfo
from vbbench.generation import describe_tables
from vbbench.partitions import LAYOUT_FILE, Layout, PartitionedTable, read_layout
from vbbench.parts import progress_bar
from vbbench.tables import PARTITIONED, TableWriter, check_free, write_text_atomically
from vbbench.withholding import check_truth_free, truth_folder_beside, withhold


def merge(folder: Path | str, out: Path | str | None = None) -> Path:
    """Merge the partitions in ``folder`` into whole tables, there or in the folder ``out``; return where they are.

    Interrupted, it is made good by the same call: partitions go only when the whole is there.

    Raises
    ------
    VbbenchError
        If ``folder`` is not partitioned, a file of it is missing or damaged, or ``out`` is in the way.
    """
    folder = Path(folder)
    layout = read_layout(folder)
    if out is None:
        if not (folder / layout.marker).is_file():
            _write_whole(folder, layout, folder, folder)
        _remove_partitions(folder, layout)
        return folder
    out = Path(out)
    check_free(out, layout.marker, "merged folder", overwrite=False)
    draft = out.with_name(out.name + ".partial")
    shutil.rmtree(draft, ignore_errors=True)
    _write_whole(folder, layout, draft, out)
    draft.replace(out)
    return out


def _write_whole(folder: Path, layout: Layout, target: Path, final: Path) -> None:
    """Write tables and facts into ``target``, which is to be called ``final``; withheld truth goes beside that."""
    paths = {name: target / f"{name}.parquet" for name in layout.tables}
    if layout.withheld:
        truth = truth_folder_beside(final)
        check_truth_free(truth, overwrite=True)
        shutil.rmtree(truth, ignore_errors=True)
        paths |= {name: truth / path.name for name, path in paths.items() if name.startswith("truth/")}
    with progress_bar(len(paths) * len(layout.parts), "merge", unit="file") as bar:
        for name, path in paths.items():
            table = PartitionedTable(folder, name, layout.parts)
            with TableWriter(path, name, table.columns) as writer:
                for part in layout.parts:
                    for group in table.groups(part):
                        writer.add(group)
                    bar.update()
    text = (folder / PARTITIONED / layout.marker).read_text(encoding="utf-8")
    if layout.marker == INFO_FILE:
        info = replace(DatasetInfo.read(folder / PARTITIONED), tables=describe_tables(paths))
        text = (withhold(info, truth_folder_beside(final)) if layout.withheld else info).to_json()
    write_text_atomically(target / layout.marker, text)


def _remove_partitions(folder: Path, layout: Layout) -> None:
    """Remove what has been merged, the layout last: until then this can be done again."""
    for name in layout.tables:
        shutil.rmtree(folder / name, ignore_errors=True)
    if layout.withheld:
        shutil.rmtree(folder / "truth", ignore_errors=True)
    for path in (folder / PARTITIONED).iterdir():
        if path.name != LAYOUT_FILE:
            path.unlink()
    shutil.rmtree(folder / PARTITIONED)
