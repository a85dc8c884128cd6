"""A folder to begin a solver in: copies of the files that lie in ``template`` beside this module."""

from pathlib import Path

from vbbench.errors import VbbenchError
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically

TEMPLATE = Path(__file__).parent / "template"


def copy_template(out: Path | str) -> list[Path]:
    """Copy the template into the folder ``out``, made if need be; return the paths of the copies.

    Raises
    ------
    VbbenchError
        If ``out`` is a file, a dataset or a submission, or a file of the template is there already.
    """
    out = Path(out)
    texts = {path.name: path.read_text("utf-8") for path in sorted(TEMPLATE.iterdir()) if path.is_file()}
    with loose_files(out):
        there = [name for name, text in texts.items() if not _is_free(out / name, text)]
        if there:
            raise VbbenchError(f"{out / there[0]} exists and may be yours; choose another folder")
        for name, text in texts.items():
            write_text_atomically(out / name, text)
    return [out / name for name in texts]


def _is_free(path: Path, text: str) -> bool:
    """Whether nothing is there, or the very copy, of a command that was stopped."""
    return not path.exists() or (path.is_file() and path.read_bytes() == text.encode())
