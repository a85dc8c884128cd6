"""A folder to begin a solver in: copies of the files that lie in ``template`` beside this module."""

from pathlib import Path

from vbbench.errors import VbbenchError
from vbbench.tables import check_not_ours, write_text_atomically

TEMPLATE = Path(__file__).parent / "template"


def copy_template(out: Path | str) -> list[Path]:
    """Copy the template into the folder ``out``, made if need be; return the paths of the copies.

    Raises
    ------
    VbbenchError
        If ``out`` is a file, a dataset or a submission, or a file of the template is there already.
    """
    out = Path(out)
    check_not_ours(out)
    texts = {path.name: path.read_text("utf-8") for path in sorted(TEMPLATE.iterdir()) if path.is_file()}
    there = [name for name in texts if (out / name).exists()]
    if there:
        raise VbbenchError(f"{out / there[0]} exists and may be yours; choose another folder")
    for name, text in texts.items():
        write_text_atomically(out / name, text)
    return [out / name for name in texts]
