"""What a study found, as files: tables as Markdown, every number as JSON, and pictures."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from vbbench.folders.replacing import write_text_atomically
from vbbench.parsing.json_text import without_nan
from vbbench.pictures.plotting.saving import save_picture
from vbbench.table import Table


@dataclass(frozen=True, kw_only=True)
class Report:
    """What a study found.

    Parameters
    ----------
    name : of its command and its files.
    title : one line.
    facts : what the paper says, what was done, what differs and why: a paragraph each.
    values : every number, for JSON, where ``null`` stands for NaN.
    pictures : by what follows ``name`` in the file's name; "" for the first.
    texts : further files by their ending, such as ``.csv``.
    whole : whether nothing was missing on this machine that more downloads would bring.
    """

    name: str
    title: str
    facts: Sequence[str] = ()
    tables: Sequence[Table] = ()
    values: Mapping[str, Any]
    pictures: Mapping[str, Figure] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)
    whole: bool = True

    @property
    def markdown(self) -> str:
        """Title, facts and tables."""
        lines = [f"# {self.title}", ""]
        for fact in self.facts:
            lines += [fact, ""]
        for table in self.tables:
            lines += table.markdown()
        return "\n".join(lines)

    @property
    def json(self) -> str:
        """Every number."""
        return json.dumps(without_nan(self.values), indent=1, ensure_ascii=False, allow_nan=False) + "\n"

    def picture_name(self, key: str) -> str:
        """The name of a picture's file."""
        return f"{self.name}{'-' if key else ''}{key}.png"


def write_report(report: Report, out: Path | str) -> list[Path]:
    """Write ``NAME.md``, ``NAME.json``, pictures and further texts into ``out``; their paths."""
    out = Path(out)
    texts = {".md": report.markdown, ".json": report.json, **report.texts}
    paths = [out / f"{report.name}{ending}" for ending in texts]
    for path, text in zip(paths, texts.values(), strict=True):
        write_text_atomically(path, text)
    for key, figure in report.pictures.items():
        paths.append(out / report.picture_name(key))
        save_picture(figure, paths[-1])
    return paths


def shown(report: Report, paths: Sequence[Path], *, as_json: bool = False) -> str:
    """What a command prints: the tables with the paths of their files, or every number as JSON."""
    return report.json.rstrip() if as_json else "\n".join([report.markdown, *map(str, paths)])
