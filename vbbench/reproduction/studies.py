"""All studies by name, and those that a command names, with what its options set."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.paper import SPLITS
from vbbench.reproduction.grid import Study
from vbbench.reproduction.keypoints import KeypointsStudy
from vbbench.reproduction.posterior import PosteriorStudy
from vbbench.reproduction.readings import ReadingsStudy
from vbbench.reproduction.robot import RobotStudy
from vbbench.reproduction.sigma import SigmaStudy
from vbbench.reproduction.solver_tables import SolverTableStudy
from vbbench.reproduction.table1 import Table1Study
from vbbench.reproduction.table4 import Table4Study
from vbbench.reproduction.trajectories import TrajectoriesStudy
from vbbench.reproduction.transfer import TransferStudy

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

    Raises
    ------
    VbbenchError
        If a name is unknown, there is none, or no study has an option.
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
