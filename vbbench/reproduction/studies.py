"""All studies by name, those that a command names with what its options set, and one page of several."""

import base64
import os
import platform
import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

from vbbench.errors import UnknownNameError, VbbenchError, VbbenchWarning, one_line
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically
from vbbench.paper import SPLITS, the_paper
from vbbench.parallel.parts import progress_bar
from vbbench.reproduction.grid import Making, Study
from vbbench.reproduction.keypoints import KeypointsStudy
from vbbench.reproduction.posterior import PosteriorStudy
from vbbench.reproduction.readings import ReadingsStudy
from vbbench.reproduction.report import Report, templates, write_report
from vbbench.reproduction.robot import RobotStudy
from vbbench.reproduction.sigma import SigmaStudy
from vbbench.reproduction.solver_tables import SolverTableStudy, Table4Study
from vbbench.reproduction.table1 import Table1Study
from vbbench.reproduction.trajectories import TrajectoriesStudy
from vbbench.reproduction.transfer import TransferStudy
from vbbench.version import __version__

PAGE = "index.html"
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

    If one cannot be made because its source is missing, a warning and the page say so, and the others are made.
    Datasets and submissions that exist are reused.

    Raises VbbenchError if another command writes there.
    """
    out, found = Path(out), list[Made]()
    with loose_files(out), progress_bar(len(studies), "reproduce all", unit="study") as bar:
        for name, study in studies.items():
            bar.set_postfix_str(name)
            begun, report, missing = time.perf_counter(), None, ""
            try:
                report = study.run(out / name, making)
                write_report(report, out / name)
            except VbbenchError as error:
                missing = one_line(str(error))
                warnings.warn(f"{name} is not made: {missing}", VbbenchWarning, stacklevel=2)
            found.append(Made(name, repr(study), report, missing, time.perf_counter() - begun))
            bar.update()
        path = out / PAGE
        write_text_atomically(path, as_page(found, out))
    return path


class Made(NamedTuple):
    """A study on the page: its name, what it measured, its report or why there is none, and seconds."""

    name: str
    measured: str
    report: Report | None
    missing: str
    seconds: float


def as_page(studies: Sequence[Made], out: Path) -> str:
    """One page of HTML that needs no other file: contents, a section a study with its pictures, versions and times."""
    packages = [f"{name} {version(name)}" for name in PACKAGES]
    return (
        templates()
        .get_template("page.html")
        .render(
            paper=the_paper(),
            studies=studies,
            picture=lambda study, name: base64.b64encode((out / study.name / name).read_bytes()).decode(),
            made_with=[f"vbbench {__version__}", f"Python {platform.python_version()}", *packages],
            machine=f"{platform.machine()}, {os.cpu_count()} processors",
            minutes=sum(one.seconds for one in studies) / 60,
        )
    )
