"""A study as files: its table as Markdown, its numbers as JSON or CSV, and its picture."""

from pathlib import Path

from matplotlib.figure import Figure

from vbbench.folders.replacing import write_text_atomically
from vbbench.pictures.plotting.style import save_png


def write_report(out: Path | str, name: str, table: str, numbers: tuple[str, str], picture: Figure) -> str:
    """Write ``NAME.md``, the numbers and ``NAME.png`` into ``out``; the table with the paths of the files below it.

    Parameters
    ----------
    numbers : the ending of their file, such as ``.json``, and its text.
    """
    ending, text = numbers
    files = [Path(out) / f"{name}{suffix}" for suffix in (".md", ending, ".png")]
    write_text_atomically(files[0], table)
    write_text_atomically(files[1], text)
    save_png(picture, files[2])
    return "\n".join([table, *map(str, files)])
