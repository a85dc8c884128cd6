"""Every table and figure of the paper in one folder, with one page of them all; a study that is done is kept."""

import json
import time
import warnings
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from vbbench import __version__
from vbbench.errors import VbbenchError, VbbenchWarning, one_line
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically
from vbbench.parallel.parts import progress_bar
from vbbench.parsing.json_text import read_json
from vbbench.reproduction.making import Making
from vbbench.reproduction.page import Section, as_page
from vbbench.reproduction.report import write_report
from vbbench.reproduction.studies import Part
from vbbench.table import Table

PAGE = "index.html"
DONE = "done.json"
"""In a study's folder: what was measured, how long that took, and the report without its pictures."""


def reproduce_all(parts: Mapping[str, Part], out: Path | str, making: Making = Making()) -> Path:  # noqa: B008
    """Make every study in a folder of its own in ``out``, and the page; its path.

    A study that is done is kept, unless ``making`` overwrites, or part of it waits for a source. One that cannot be
    made, because its source is missing, is said to be missing, also on the page, and the others are made.

    Raises
    ------
    VbbenchError
        If another command writes there.
    """
    out, sections = Path(out), []
    with loose_files(out), progress_bar(len(parts), "reproduce all", unit="study") as bar:
        for name, part in parts.items():
            bar.set_postfix_str(name)
            sections.append(_section(name, part, out / name, making))
            bar.update()
        path = out / PAGE
        write_text_atomically(path, as_page(sections))
    return path


def _section(name: str, part: Part, folder: Path, making: Making) -> Section:
    done, wanted, seconds = folder / DONE, f"{__version__} {part.study!r}", 0.0
    if not making.overwrite and done.is_file():
        known = read_json(done)
        if known.get("measured") == wanted:
            if known.get("whole"):
                return _section_of(known, folder)
            seconds = known["seconds"]  # most is there already, and takes less time
    begun = time.perf_counter()
    try:
        report = part.make(folder, making)
    except VbbenchError as error:
        why = one_line(str(error))
        warnings.warn(f"{name} is not made: {why}", VbbenchWarning, stacklevel=2)
        return Section(name=name, title=name, missing=why)
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
    return _section_of(facts, folder)


def _section_of(known: Mapping[str, Any], folder: Path) -> Section:
    report = known["report"]
    return Section(
        name=report["name"],
        title=report["title"],
        facts=report["facts"],
        tables=[Table(**table) for table in report["tables"]],
        pictures=[folder / name for name in report["pictures"]],
        measured=known["measured"],
        seconds=known["seconds"],
    )
