"""Reports as one page of HTML that needs no other file: pictures are in it, and no script."""

import base64
import os
import platform
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from importlib.metadata import PackageNotFoundError, version
from importlib.resources import files
from pathlib import Path
from string import Template

from vbbench import __version__
from vbbench.paper import the_paper
from vbbench.table import Table, rewritten

PACKAGES = ("numpy", "scipy", "pyarrow", "matplotlib", "opencv-python-headless")
"""Packages whose versions the page states."""
LONG = 24
"""Rows of a table from which on it is folded."""


@dataclass(frozen=True, kw_only=True)
class Section:
    """One study on the page.

    Parameters
    ----------
    facts, tables : see `Report`.
    pictures : PNG files.
    measured : the version and the study's parameters.
    seconds : that making it took.
    missing : why it could not be made; "" if it was.
    """

    name: str
    title: str
    facts: Sequence[str] = ()
    tables: Sequence[Table] = ()
    pictures: Sequence[Path] = ()
    measured: str = ""
    seconds: float = 0.0
    missing: str = ""


def as_page(sections: Sequence[Section]) -> str:
    """The page: contents, a section a study, versions and times."""
    paper, template = the_paper(), files("vbbench.reproduction") / "page.html"
    return Template(template.read_text("utf-8")).substitute(
        source=escape(paper.source),
        link=escape(paper.link),
        contents="\n".join(_entry(one) for one in sections),
        sections="\n".join(part for one in sections for part in _section(one)),
        made="\n".join(_made(sections)),
    )


def _entry(one: Section) -> str:
    state = "missing" if one.missing else f"{one.seconds:.0f} s"
    return f'<li><a href="#{escape(one.name)}">{escape(one.title)}</a> <small>{state}</small></li>'


def _section(one: Section) -> Iterator[str]:
    yield f'<section id="{escape(one.name)}">'
    yield f"<h2>{_marked(one.title)}</h2>"
    yield f"<p><code>vbbench reproduce {escape(one.name)}</code></p>"
    if one.missing:
        yield f'<p class="missing">Not made: {escape(one.missing)}</p>'
    for picture in one.pictures:
        data = base64.b64encode(picture.read_bytes()).decode("ascii")
        yield f'<img src="data:image/png;base64,{data}" alt="{escape(f"{one.title}: {picture.stem}")}">'
    yield from map(_paragraph, one.facts)
    for table in one.tables:
        yield from _table(table)
    yield "</section>"


def _table(table: Table) -> Iterator[str]:
    if table.title:
        yield f"<h3>{_marked(table.title)}</h3>"
    yield from map(_paragraph, table.facts)
    folded = len(table.rows) >= LONG
    if folded:
        yield f"<details><summary>{len(table.rows)} rows</summary>"
    yield '<div class="wide"><table><thead><tr>'
    yield "".join(f"<th{_kind(n, table)}>{_marked(cell)}</th>" for n, cell in enumerate(table.head))
    yield "</tr></thead><tbody>"
    for row in table.rows:
        yield f"<tr>{''.join(f'<td{_kind(n, table)}>{_marked(cell)}</td>' for n, cell in enumerate(row))}</tr>"
    yield "</tbody></table></div>"
    if folded:
        yield "</details>"


def _kind(column: int, table: Table) -> str:
    return "" if column < table.names else ' class="figure"'


def _paragraph(text: str) -> str:
    """A paragraph, or a list if its lines begin with dashes."""
    lines = text.split("\n")
    if all(line.startswith("- ") for line in lines):
        return f"<ul>{''.join(f'<li>{_marked(line[2:])}</li>' for line in lines)}</ul>"
    return f"<p>{_marked(text)}</p>"


def _marked(text: str) -> str:
    """HTML of marked text."""
    return rewritten(text, plain=_plain, code=lambda name: f"<code>{_plain(name)}</code>", bold="<b>{}</b>".format)


def _plain(text: str) -> str:
    return escape(text, quote=False)


def _made(sections: Sequence[Section]) -> Iterator[str]:
    """With what the page was made: versions, processor, and each study's parameters."""
    packages = [f"{name} {found}" for name in PACKAGES if (found := _version(name))]
    seconds = sum(one.seconds for one in sections)
    yield f"<p>vbbench {__version__}, Python {platform.python_version()}, {', '.join(packages)}; "
    yield f"{platform.machine()}, {os.cpu_count()} processors; {seconds / 60:.1f} minutes of work.</p>"
    yield "<ul>"
    yield from (f"<li><code>{escape(one.measured)}</code></li>" for one in sections if one.measured)
    yield "</ul>"


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
