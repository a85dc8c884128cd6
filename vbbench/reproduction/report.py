"""What studies found, as files: tables as Markdown, every number as JSON, pictures, and one page of all studies."""

import base64
import json
import os
import platform
import re
import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Protocol

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vbbench.errors import VbbenchError, VbbenchWarning, one_line
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically
from vbbench.paper import the_paper
from vbbench.parallel.parts import progress_bar
from vbbench.parsing.json_text import read_json, without_nan
from vbbench.pictures.plotting import save_picture
from vbbench.scoring.scorecard import Summary
from vbbench.table import Table, rewritten
from vbbench.version import __version__

PAGE = "index.html"
DONE = "done.json"
"""In a study's folder: what was measured, how long that took, and the report without its pictures."""
PACKAGES = ("numpy", "scipy", "pyarrow", "matplotlib", "opencv-python-headless")
"""Packages whose versions the page states."""


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
    whole : whether nothing is missing on this machine that more downloads would bring.
    """

    name: str
    title: str
    facts: Sequence[str] = ()
    tables: Sequence[Table] = ()
    values: Mapping[str, Any]
    pictures: Mapping[str, Figure] = field(default_factory=dict)
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
def _templates() -> Environment:
    """Templates next to this file: the page, and the studies' paragraphs."""
    loader = PackageLoader("vbbench.reproduction", "templates")
    found = Environment(
        loader=loader,
        autoescape=select_autoescape(("html",)),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters["marked"] = _marked
    return found


def paragraphs(block: str, **values: Any) -> list[str]:
    """The paragraphs of a block of ``templates/facts.md``, each on one line unless it is a list."""
    template = _templates().get_template("facts.md")
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


class _Making(Protocol):
    """See `vbbench.reproduction.grid.Making`."""

    @property
    def overwrite(self) -> bool: ...


class _Study(Protocol):
    """See `vbbench.reproduction.grid.Study`."""

    def run(self, out: Path | str, making: Any) -> Report: ...


def reproduce_all(studies: Mapping[str, _Study], out: Path | str, making: _Making) -> Path:
    """Make every study in its own folder in ``out``, and the page; its path.

    A study that is done is kept, unless ``making`` overwrites, or part of it waits for a source. If one cannot be made
    because its source is missing, a warning and the page say so, and the others are made.

    Raises
    ------
    VbbenchError
        If another command writes there.
    """
    out, found = Path(out), []
    with loose_files(out), progress_bar(len(studies), "reproduce all", unit="study") as bar:
        for name, study in studies.items():
            bar.set_postfix_str(name)
            found.append(_made_or_kept(name, study, out / name, making))
            bar.update()
        path = out / PAGE
        write_text_atomically(path, as_page(found, out))
    return path


def _made_or_kept(name: str, study: _Study, folder: Path, making: _Making) -> dict[str, Any]:
    """The content of `DONE`, or why the study is missing."""
    done, wanted, seconds = folder / DONE, f"{__version__} {study!r}", 0.0
    if not making.overwrite and done.is_file():
        kept: dict[str, Any] = read_json(done)
        if kept.get("measured") == wanted:
            if kept.get("whole"):
                return kept
            seconds = kept["seconds"]  # most exists already, and takes less time
    begun = time.perf_counter()
    try:
        report = study.run(folder, making)
    except VbbenchError as error:
        why = one_line(str(error))
        warnings.warn(f"{name} is not made: {why}", VbbenchWarning, stacklevel=2)
        return {"missing": why, "report": {"name": name, "title": name}}
    write_report(report, folder)
    facts = {
        "measured": wanted,
        "whole": report.whole,
        "seconds": max(seconds, round(time.perf_counter() - begun, 1)),
        "report": {
            "name": report.name,
            "title": report.title,
            "facts": list(report.facts),
            "tables": [asdict(table) for table in report.tables],
            "pictures": [report.picture_name(key) for key in report.pictures],
        },
    }
    write_text_atomically(done, json.dumps(facts, indent=1, ensure_ascii=False) + "\n")
    return facts


def as_page(studies: Sequence[Mapping[str, Any]], out: Path) -> str:
    """One page of HTML that needs no other file: contents, a section a study with its pictures, versions and times."""
    packages = [f"{name} {found}" for name in PACKAGES if (found := _version(name))]
    return (
        _templates()
        .get_template("page.html")
        .render(
            paper=the_paper(),
            studies=studies,
            picture=lambda study, name: base64.b64encode((out / study["report"]["name"] / name).read_bytes()).decode(),
            made_with=[f"vbbench {__version__}", f"Python {platform.python_version()}", *packages],
            machine=f"{platform.machine()}, {os.cpu_count()} processors",
            minutes=sum(one.get("seconds", 0.0) for one in studies) / 60,
        )
    )


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
