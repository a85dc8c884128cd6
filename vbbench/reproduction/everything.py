"""Every table and figure of the paper in one folder, with one page of them all; a study that is done is kept."""

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from vbbench import __version__
from vbbench.errors import UnknownNameError, VbbenchError, one_line
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically
from vbbench.parallel.parts import progress_bar
from vbbench.parsing.json_text import read_json
from vbbench.reproduction.making import Making
from vbbench.reproduction.page import Section, as_page
from vbbench.reproduction.readings.figure import readings_report
from vbbench.reproduction.readings.study import ReadingsStudy, measure_readings
from vbbench.reproduction.report import Report, Table, write_report
from vbbench.reproduction.sigma.figure import sigma_report
from vbbench.reproduction.sigma.study import SigmaStudy, measure_sigma
from vbbench.reproduction.tables.simulated_recording import STAND_INS
from vbbench.reproduction.tables.solver_report import solver_table_report
from vbbench.reproduction.tables.solver_tables import SPLITS, SolverTableStudy, measure_solver_table
from vbbench.reproduction.tables.table1 import Table1Study, measure_table1, table1_report
from vbbench.reproduction.tables.table4.report import table4_report
from vbbench.reproduction.tables.table4.study import Table4Study, measure_table4
from vbbench.reproduction.trajectories.figure import trajectories_report
from vbbench.reproduction.trajectories.study import TrajectoriesStudy, measure_trajectories

PAGE = "index.html"
DONE = "done.json"
"""In a study's folder: what was measured, how long that took, and the report without its pictures."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A study, and how its report is made in a folder."""

    study: Any
    make: Callable[[Path, Making], Report]


def the_parts(*, every: int = 10, seed: int = 0, only: Sequence[str] = ()) -> dict[str, Part]:
    """The studies by name, in the paper's order.

    Parameters
    ----------
    every : only every so-many-th sequence of recordings; tables of whole recordings take hours.
    seed : of all random numbers.
    only : names; none for all.

    Raises
    ------
    UnknownNameError
        If ``only`` names another.
    """
    parts = {
        "table1": _part(Table1Study(seed=seed), measure_table1, table1_report),
        "table2": _part(_solver_table(2, every, seed), measure_solver_table, solver_table_report),
        "table3": _part(_solver_table(3, None, seed), measure_solver_table, solver_table_report),
        "table4": _part(Table4Study(seed=seed), measure_table4, table4_report),
        "figure-sigma": _part(SigmaStudy(seed=seed), measure_sigma, sigma_report),
        "readings": _part(ReadingsStudy(every=every, seed=seed), measure_readings, readings_report),
        "figure-trajectories": _part(TrajectoriesStudy(seed=seed), measure_trajectories, trajectories_report),
    }
    for name in only:
        if name not in parts:
            raise UnknownNameError("study", name, parts)
    return {name: part for name, part in parts.items() if name in only or not only}


def _solver_table(table: int, every: int | None, seed: int) -> SolverTableStudy:
    stand_ins = STAND_INS if table == 3 else {}
    return SolverTableStudy(table=table, splits=SPLITS[table], every=every, seed=seed, stand_ins=stand_ins)


def _part(study: Any, measure: Callable[[Any, Path, Making], Any], report: Callable[[Any], Report]) -> Part:
    return Part(study=study, make=lambda out, making: report(measure(study, out, making)))


def reproduce_all(parts: Mapping[str, Part], out: Path | str, making: Making = Making()) -> Path:  # noqa: B008
    """Make every study in a folder of its own in ``out``, and the page; its path.

    A study that is done is kept, unless ``making`` overwrites, or part of it waits for a source. One that cannot be
    made, because its source is missing, is said to be missing on the page, and the others are made.

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
    done, wanted = folder / DONE, f"{__version__} {part.study!r}"
    if not making.overwrite and done.is_file():
        known = read_json(done)
        if known.get("measured") == wanted and known.get("whole"):
            return _section_of(known, folder)
    begun = time.perf_counter()
    try:
        report = part.make(folder, making)
    except VbbenchError as error:
        return Section(name=name, title=name, missing=one_line(str(error)))
    write_report(report, folder)
    facts = {
        "measured": wanted,
        "whole": report.whole,
        "seconds": round(time.perf_counter() - begun, 1),
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
