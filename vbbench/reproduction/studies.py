"""All studies of the paper, as `vbbench reproduce all` makes them: of parts of the recordings, within half an hour."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vbbench.errors import UnknownNameError
from vbbench.paper import SPLITS
from vbbench.reproduction.at_hand import AtHand
from vbbench.reproduction.keypoints.figure import keypoints_report
from vbbench.reproduction.keypoints.people import People
from vbbench.reproduction.keypoints.study import KeypointsStudy, measure_keypoints
from vbbench.reproduction.making import Making
from vbbench.reproduction.posterior.figure import posterior_report
from vbbench.reproduction.posterior.study import PosteriorStudy, measure_posterior
from vbbench.reproduction.readings.figure import readings_report
from vbbench.reproduction.readings.study import ReadingsStudy, measure_readings
from vbbench.reproduction.report import Report
from vbbench.reproduction.robot.figure import robot_report
from vbbench.reproduction.robot.measuring import measure_robot
from vbbench.reproduction.robot.study import RobotStudy
from vbbench.reproduction.sigma.figure import sigma_report
from vbbench.reproduction.sigma.study import SigmaStudy, measure_sigma
from vbbench.reproduction.tables.solver_report import solver_table_report
from vbbench.reproduction.tables.solver_tables import SolverTableStudy, measure_solver_table
from vbbench.reproduction.tables.table1 import Table1Study, measure_table1, table1_report
from vbbench.reproduction.tables.table4.report import table4_report
from vbbench.reproduction.tables.table4.study import Table4Study, measure_table4
from vbbench.reproduction.trajectories.figure import trajectories_report
from vbbench.reproduction.trajectories.study import TrajectoriesStudy, measure_trajectories


@dataclass(frozen=True, kw_only=True)
class Part:
    """A study, and how its report is made in a folder."""

    study: Any
    make: Callable[[Path, Making], Report]


@dataclass(frozen=True, kw_only=True)
class Downloads:
    """Where the user's own downloads are, as the commands of the studies name them; ``None`` for the usual places."""

    kitti: Path | None = None
    poses: Path | None = None
    jrdb: Path | None = None
    bags: Path | None = None
    motsynth: Path | None = None

    @property
    def at_hand(self) -> AtHand:
        """By split."""
        return AtHand.of(kitti=self.kitti, jrdb=self.jrdb, motsynth=self.motsynth)


def the_parts(
    *,
    every: int = 10,
    seed: int = 0,
    only: Sequence[str] = (),
    downloads: Downloads = Downloads(),
) -> dict[str, Part]:
    """The studies by name, in the paper's order.

    Parameters
    ----------
    every : of the tables of recordings, only every so-many-th sequence (of Shibuya's, every sixth of these).
    seed : of all random numbers.
    only : names; none for all.

    Raises
    ------
    UnknownNameError
        If ``only`` names another.
    """
    at_hand, kitti, poses = downloads.at_hand, downloads.kitti, downloads.poses
    people = People(kitti=kitti, poses=poses, seed=seed)
    robot = RobotStudy(jrdb=downloads.jrdb, bags=downloads.bags, kitti=kitti, poses=poses, seed=seed)
    parts = {
        "table1": _part(Table1Study(at_hand=at_hand, seed=seed), measure_table1, table1_report),
        "table2": _part(_solver_table(2, every, seed), measure_solver_table, solver_table_report),
        "table3": _part(_solver_table(3, 6 * every, seed), measure_solver_table, solver_table_report),
        "table4": _part(Table4Study(seed=seed), measure_table4, table4_report),
        "figure-trajectories": _part(
            TrajectoriesStudy(at_hand=at_hand, seed=seed), measure_trajectories, trajectories_report
        ),
        "figure-sigma": _part(SigmaStudy(seed=seed), measure_sigma, sigma_report),
        "figure-keypoints": _part(KeypointsStudy(people=people, seed=seed), measure_keypoints, keypoints_report),
        "figure-posterior": _part(PosteriorStudy(seed=seed), measure_posterior, posterior_report),
        "figure-robot": _part(robot, measure_robot, robot_report),
        "readings": _part(ReadingsStudy(every=every, seed=seed), measure_readings, readings_report),
    }
    for name in only:
        if name not in parts:
            raise UnknownNameError("study", name, parts)
    return {name: part for name, part in parts.items() if name in only or not only}


def _solver_table(table: int, every: int, seed: int) -> SolverTableStudy:
    return SolverTableStudy(table=table, splits=SPLITS[table], every=every, seed=seed)


def _part(study: Any, measure: Callable[[Any, Path, Making], Any], report: Callable[[Any], Report]) -> Part:
    return Part(study=study, make=lambda out, making: report(measure(study, out, making)))
