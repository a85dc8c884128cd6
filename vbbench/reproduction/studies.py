"""All studies of the paper, as `vbbench reproduce all` makes them: of parts of the recordings, within half an hour."""

from collections.abc import Sequence

from vbbench.errors import UnknownNameError
from vbbench.paper import SPLITS
from vbbench.reproduction.grid import Study, named_folders
from vbbench.reproduction.keypoints import KeypointsStudy, People
from vbbench.reproduction.posterior import PosteriorStudy
from vbbench.reproduction.readings import ReadingsStudy
from vbbench.reproduction.robot import RobotStudy
from vbbench.reproduction.sigma import SigmaStudy
from vbbench.reproduction.solver_tables import SolverTableStudy
from vbbench.reproduction.table1 import Table1Study
from vbbench.reproduction.table4 import Table4Study
from vbbench.reproduction.trajectories import TrajectoriesStudy
from vbbench.reproduction.work import Downloads


def paper_studies(
    *,
    every: int = 10,
    seed: int = 0,
    only: Sequence[str] = (),
    downloads: Downloads = Downloads(),  # noqa: B008  frozen
) -> dict[str, Study]:
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
    kitti, poses = downloads.kitti, downloads.poses
    folders = named_folders(kitti=kitti, jrdb=downloads.jrdb, motsynth=downloads.motsynth)
    studies: list[Study] = [
        Table1Study(folders=folders, seed=seed),
        SolverTableStudy(table=2, splits=SPLITS[2], every=every, seed=seed),
        SolverTableStudy(table=3, splits=SPLITS[3], every=6 * every, seed=seed),
        Table4Study(seed=seed),
        TrajectoriesStudy(folders=folders, seed=seed),
        SigmaStudy(seed=seed),
        KeypointsStudy(people=People(kitti=kitti, poses=poses, seed=seed), seed=seed),
        PosteriorStudy(seed=seed),
        RobotStudy(jrdb=downloads.jrdb, bags=downloads.bags, kitti=kitti, poses=poses, seed=seed),
        ReadingsStudy(every=every, seed=seed),
    ]
    found = {study.name: study for study in studies}
    for name in only:
        if name not in found:
            raise UnknownNameError("study", name, found)
    return {name: study for name, study in found.items() if name in only or not only}
