"""What studies found, as files: tables as Markdown, every number as JSON, pictures, and one page of all studies."""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment
from markupsafe import Markup, escape
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vbbench.folders.replacing import write_text_atomically
from vbbench.parsing.json_text import without_nan
from vbbench.pictures.plotting.style import save_picture
from vbbench.scoring.scorecard import Summary
from vbbench.table import Table, environment, rewritten


@dataclass(frozen=True, kw_only=True)
class Report:
    """What a study found.

    Parameters
    ----------
    name : of its command and its files.
    title : one line.
    facts : what the paper states, what was done, what differs and why: a paragraph each.
    values : every number, for JSON, where ``null`` stands for NaN.
    pictures : by what follows ``name`` in the file's name; "" for the first.
    """

    name: str
    title: str
    facts: Sequence[str] = ()
    tables: Sequence[Table] = ()
    values: Mapping[str, Any]
    pictures: Mapping[str, Figure] = field(default_factory=dict)

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
        plain: dict[str, Any] = {"ensure_ascii": False, "allow_nan": False, "default": _plain}
        return json.dumps(without_nan(self.values), indent=1, **plain) + "\n"

    def picture_name(self, key: str) -> str:
        """The name of a picture's file."""
        return f"{self.name}{'-' if key else ''}{key}.png"


def _plain(value: Summary | NDArray[Any]) -> Any:
    """Figures and arrays as JSON has them."""
    return value.to_dict() if isinstance(value, Summary) else without_nan(value.tolist())


def write_report(report: Report, out: Path | str) -> list[Path]:
    """Write ``NAME.md``, ``NAME.json`` and pictures into ``out``; their paths."""
    out = Path(out)
    texts = {".md": report.markdown, ".json": report.json}
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


@cache
def templates() -> Environment:
    """Templates next to this file: the page, and the studies' paragraphs."""
    found = environment(Path(__file__).with_name("templates"))
    found.filters["marked"] = _marked
    return found


def paragraphs(block: str, **values: Any) -> list[str]:
    """The paragraphs of a block of ``templates/facts.md``, each on one line unless it is a list."""
    template = templates().get_template("facts.md")
    text = "".join(template.blocks[block](template.new_context(values)))
    return [one if one.startswith("- ") else " ".join(one.split()) for one in re.split(r"\n\s*\n", text.strip()) if one]


def _marked(text: str) -> Markup:
    """HTML of marked text."""
    bold = Markup("<b>{}</b>").format
    html = rewritten(
        text,
        plain=lambda part: str(escape(part)),
        code=lambda name: str(Markup("<code>{}</code>").format(name)),
        bold=lambda inner: str(bold(Markup(inner))),  # noqa: S704  escaped already
    )
    return Markup(html)  # noqa: S704  every part is escaped
