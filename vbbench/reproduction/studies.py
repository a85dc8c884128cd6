"""All studies by name, those that a command names with what its options set, and one page of several."""

import base64
import json
import os
import platform
import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from vbbench.errors import UnknownNameError, VbbenchError, VbbenchWarning, one_line
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically
from vbbench.paper import SPLITS, the_paper
from vbbench.parallel.parts import progress_bar
from vbbench.parsing.json_text import read_json
from vbbench.reproduction.grid import Making, Study
from vbbench.reproduction.keypoints import KeypointsStudy
from vbbench.reproduction.posterior import PosteriorStudy
from vbbench.reproduction.readings import ReadingsStudy
from vbbench.reproduction.report import templates, write_report
from vbbench.reproduction.robot import RobotStudy
from vbbench.reproduction.sigma import SigmaStudy
from vbbench.reproduction.solver_tables import SolverTableStudy, Table4Study
from vbbench.reproduction.table1 import Table1Study
from vbbench.reproduction.trajectories import TrajectoriesStudy
from vbbench.reproduction.transfer import TransferStudy
from vbbench.version import __version__

PAGE = "index.html"
DONE = "done.json"
"""In a study's folder: what was measured, how long that took, and the report without its pictures."""
PACKAGES = ("numpy", "scipy", "pyarrow", "matplotlib")
"""Packages whose versions the page states."""
ALL = "all"
"""Stands for every study of the paper, of parts of the recordings, within half an hour."""
NOT_OF_THE_PAPER = "transfer"
FIELDS = {"split": "splits", "solver": "solvers", "protocol": "protocols"}
"""Options that studies have under other names."""
PARTS = {"table2": 10, "table3": 60, "readings": 10}
"""Every how many sequences `ALL` takes."""


def all_studies() -> dict[str, Any]:
    """Every study as it is by default, in the paper's order."""
    studies: list[Study] = [
        Table1Study(),
        SolverTableStudy(table=2, splits=SPLITS[2]),
        SolverTableStudy(table=3, splits=SPLITS[3]),
        Table4Study(),
        TrajectoriesStudy(),
        SigmaStudy(),
        KeypointsStudy(),
        PosteriorStudy(),
        RobotStudy(),
        ReadingsStudy(),
        TransferStudy(),
    ]
    return {study.name: study for study in studies}


def chosen_studies(names: Sequence[str], options: Mapping[str, Any]) -> dict[str, Study]:
    """The studies of these names, each with those of the options that it has.

    Raises VbbenchError if a name is unknown, there is none, or no study has an option.
    """
    known = all_studies()
    if not names:
        raise VbbenchError(f"which study? name some of {', '.join([ALL, *known])}")
    for name in names:
        if name not in (ALL, *known):
            raise UnknownNameError("study", name, (ALL, *known))
    if ALL in names:
        known = {
            name: replace(study, every=PARTS[name]) if name in PARTS else study
            for name, study in known.items()
            if name != NOT_OF_THE_PAPER
        }
        names = list(known)
    chosen, read = {}, set[str]()
    for name in names:
        has = {field.name for field in fields(known[name])}
        own = {option: field for option in options if (field := FIELDS.get(option, option)) in has}
        chosen[name] = replace(known[name], **{field: options[option] for option, field in own.items()})
        read |= set(own)
    for option in options:
        if option not in read:
            raise VbbenchError(f"{', '.join(names)}: `{option}` changes nothing here; remove it")
    return chosen


def reproduce_all(studies: Mapping[str, Study], out: Path | str, making: Making) -> Path:
    """Make every study in its own folder in ``out``, and the page; its path.

    A study that is done is kept, unless ``making`` overwrites, or part of it waits for a source. If one cannot be made
    because its source is missing, a warning and the page say so, and the others are made.

    Raises VbbenchError if another command writes there.
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


def _made_or_kept(name: str, study: Study, folder: Path, making: Making) -> dict[str, Any]:
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
    packages = [f"{name} {version(name)}" for name in PACKAGES]
    return (
        templates()
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
