"""Commands that reproduce the paper's tables and figures, all of them at once, and a study that is not of it."""

from pathlib import Path
from typing import TYPE_CHECKING

from vbbench.cli.evaluation import ProtocolName
from vbbench.reproduction.work import Downloads, Work

if TYPE_CHECKING:
    from vbbench.reproduction.grid import Making, Study


def show(study: "Study", work: Work) -> None:
    """Run a study, write its report, and print what it found."""
    from vbbench.reproduction.report import shown, write_report

    out = work.out or Path(study.name)
    report = study.run(out, _making(work))
    print(shown(report, write_report(report, out), as_json=work.json))


def _making(work: Work) -> "Making":
    from vbbench.reproduction.grid import Making

    return Making(jobs=work.jobs, scheduler=work.scheduler, tls=work.tls, overwrite=work.overwrite)


def everything(
    study: tuple[str, ...] = (),
    every: int = 10,
    downloads: Downloads = Downloads(),  # noqa: B008  frozen
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make every table and figure of the paper, and one page that shows them all with what the paper prints.

    A study that is done is kept: run the command again after an interruption. The folder's default name is reproduced.

    Args:
        study: Names of studies, such as table2 figure-sigma; default: all.
        every: In tables of recordings, only every so-many-th sequence, of Shibuya every sixth of these.
        downloads: Your own.
        work: Where and how.
    """
    from vbbench.errors import VbbenchError
    from vbbench.reproduction.report import reproduce_all
    from vbbench.reproduction.studies import paper_studies

    if work.json:
        raise VbbenchError("--json is of one study, and 'reproduce all' writes that of each; remove it")
    studies = paper_studies(every=every, seed=work.seed, only=study, downloads=downloads)
    print(reproduce_all(studies, work.out or Path("reproduced"), _making(work)))


def transfer(
    kitti: Path,
    poses: Path | None = None,
    every: tuple[int, ...] = (4, 1),
    split: str = "eth-15fps",
    smooth: float = 0.0,
    protocol: tuple[ProtocolName, ...] = ("sequential", "one-step"),
    solver: tuple[str, ...] = (),
    limit: int = 60,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Compare how tier field and KITTI rank solvers: a table, every number as JSON, and a picture.

    Args:
        kitti: Folder of KITTI's tracking benchmark, as for 'vbbench generate kitti --source'.
        poses: Folder of the camera's poses, as for 'vbbench generate kitti --poses'.
        every: Every how many frames of KITTI: 4, 1, or both.
        split: Whose people tier field shows; where KITTI's frames lie between theirs, they follow smooth curves.
        smooth: Metres (root mean square) by which people may leave where they were recorded, so that walks are smooth.
        protocol: Which truth a solver is given, and when.
        solver: Further solvers to rank with the installed ones and their variants: names or module:attribute.
        limit: Most sequences of tier field.
        work: Where and how.
    """
    from vbbench.reproduction.transfer import TransferStudy
    from vbbench.reproduction.variants import Variant, registered_variants

    variants = registered_variants() | {name: Variant(solver=name) for name in solver}
    study = TransferStudy(
        kitti=kitti,
        poses=poses,
        variants=variants,
        every=every,
        split=split,
        smooth=smooth,
        protocols=protocol,
        limit=limit,
        seed=work.seed,
    )
    show(study, work)


def table1(
    split: tuple[str, ...] = ("sim", "hotel", "eth", "students", "shibuya01", "shibuya02", "street", "motsynth"),
    motsynth: Path | None = None,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make a table and a picture of sequences, frames and people of every split, and the paper's.

    Args:
        split: Of the paper's Table 1.
        motsynth: Folder or file of MOTSynth's annotations, as for 'vbbench generate motsynth --source'.
        work: Where and how.
    """
    from vbbench.reproduction.grid import named_folders
    from vbbench.reproduction.table1 import Table1Study

    study = Table1Study(splits=split, folders=named_folders(motsynth=motsynth), seed=work.seed)
    show(study, work)


def table2(
    split: tuple[str, ...] = ("hotel", "eth", "students"),
    solver: tuple[str, ...] = (),
    every: int = 1,
    source: Path | None = None,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make the paper's Table 2: every solver on Hotel, ETH and Students, under one-step and sequential.

    Args:
        split: Of the paper's Table 2; one whose source is missing is omitted.
        solver: Registered names or module:attribute; default: the paper's, here, and map-causal and map-batch.
        every: Only every so-many-th sequence of each split.
        source: Folder that holds the source files; default: the usual places.
        work: Where and how.
    """
    _show_solver_table(2, split, solver, every=every, source=source, work=work)


def table3(
    split: tuple[str, ...] = ("shibuya01", "shibuya02"),
    solver: tuple[str, ...] = (),
    every: int | None = None,
    source: Path | None = None,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make the paper's Table 3: every solver on Shibuya, or on simulated crowds where CroHD is missing.

    Args:
        split: Of the paper's Table 3; where its recording is missing, a simulated crowd is lifted in the same way.
        solver: Registered names or module:attribute; default: the paper's, here, and map-causal and map-batch.
        every: Only every so-many-th sequence of each split; default: every one of CroHD, few of a simulated crowd.
        source: CroHD, as for 'vbbench generate shibuya01 --source'; default: the usual places.
        work: Where and how.
    """
    _show_solver_table(3, split, solver, every=every, source=source, work=work)


def _show_solver_table(
    table: int,
    split: tuple[str, ...],
    solver: tuple[str, ...],
    *,
    every: int | None,
    source: Path | None,
    work: Work,
) -> None:
    from vbbench.reproduction.solver_tables import COUNTERPARTS, SolverTableStudy

    solvers = solver or tuple(COUNTERPARTS)
    study = SolverTableStudy(table=table, splits=split, solvers=solvers, every=every, seed=work.seed, source=source)
    show(study, work)


def table4(
    solver: tuple[str, ...] = ("vb-cv", "vb-sf", "vb-sf-literal", "map-causal"),
    sequences: int | None = None,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make tables and a picture of errors on split street with centre lines and with tracked boxes, and the paper's.

    Args:
        solver: Registered names or module:attribute.
        sequences: Number of sequences; default: the scenario's ten.
        work: Where and how.
    """
    from vbbench.reproduction.table4 import Table4Study

    study = Table4Study(solvers=solver, sequences=sequences, seed=work.seed)
    show(study, work)


def readings(
    every: int = 1,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make a table and a picture of the errors under every reading of the paper, and the paper's.

    Args:
        every: Only every so-many-th sequence of each split.
        work: Where and how.
    """
    from vbbench.reproduction.readings import ReadingsStudy

    study = ReadingsStudy(every=every, seed=work.seed)
    show(study, work)


def figure_sigma(
    solver: tuple[str, ...] = (),
    sequences: int = 500,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make a table and a picture of errors on split sim by number of people, for several spreads of heights.

    Args:
        solver: Registered names or module:attribute; default: vb-sf, vb-sf with heights from the prior only, and that
            without a prior of the observer's motion.
        sequences: Number of sequences at each spread of heights.
        work: Where and how.
    """
    from vbbench.reproduction.sigma import SigmaStudy, compared_solvers

    study = SigmaStudy(solvers=solver or tuple(compared_solvers()), sequences=sequences, seed=work.seed)
    show(study, work)


def figure_keypoints(
    trials: int = 100,
    every: int = 6,
    solver: tuple[str, ...] = ("map-causal", "vb-sf"),
    kitti: Path | None = None,
    poses: Path | None = None,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make tables and a picture of camera poses from static points at a distance, and of those from people.

    Args:
        trials: Number of trials of the five-point method at each distance.
        every: Only every so-many-th sequence of Hotel and ETH, in tier field a third of that.
        solver: Registered names or module:attribute; the picture shows the first.
        kitti: Folder of KITTI's tracking benchmark; default: searched in the usual places.
        poses: Folder of the poses of KITTI's camera, as for 'vbbench generate kitti --poses'.
        work: Where and how.
    """
    from vbbench.reproduction.keypoints import KeypointsStudy, People

    study = KeypointsStudy(
        trials=trials,
        people=People(solvers=solver, every=every, kitti=kitti, poses=poses, seed=work.seed),
        seed=work.seed,
    )
    show(study, work)


def figure_posterior(
    every: int = 1,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Draw posteriors of observer and people, and their entropy by number of people and directions.

    Args:
        every: Only every so-many-th sequence.
        work: Where and how.
    """
    from vbbench.reproduction.posterior import PosteriorStudy

    study = PosteriorStudy(every=every, seed=work.seed)
    show(study, work)


def figure_robot(
    jrdb: Path | None = None,
    bags: Path | None = None,
    kitti: Path | None = None,
    poses: Path | None = None,
    sequences: int = 6,
    solver: tuple[str, ...] = (),
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make tables and pictures of how far a camera drifts without known motion: of a simulated robot, KITTI, JRDB.

    Args:
        jrdb: Folder of JRDB, as for 'vbbench generate jrdb --source'.
        bags: Folder of JRDB's rosbags, which hold how the robot moved.
        kitti: Folder of KITTI's tracking benchmark, as for 'vbbench generate kitti --source'; default: kitti in
            $VBBENCH_DATA, then the cache folder.
        poses: Folder of the camera's poses, as for 'vbbench generate kitti --poses'; default: kitti/poses there.
        sequences: Number of sequences of the simulated robot, a minute each.
        solver: Further solvers, without odometry and with it: registered names or module:attribute.
        work: Where and how.
    """
    from vbbench.reproduction.robot import RobotStudy, default_entrants, with_and_without

    more = [entrant for name in solver for entrant in with_and_without(name)]
    study = RobotStudy(
        jrdb=jrdb,
        bags=bags,
        kitti=kitti,
        poses=poses,
        sequences=sequences,
        seed=work.seed,
        entrants=tuple(dict.fromkeys([*default_entrants(), *more])),
    )
    show(study, work)


def figure_trajectories(
    split: tuple[str, ...] = (),
    solver: str = "vb-sf",
    protocol: ProtocolName = "sequential",
    kitti: Path | None = None,
    jrdb: Path | None = None,
    motsynth: Path | None = None,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make one sheet with an example of every split: true and estimated trajectories of people and observer.

    Args:
        split: Only these splits; default: all whose source is here.
        solver: Registered name or module:attribute.
        protocol: Which truth the solver is given, and when.
        kitti: Folder of KITTI's tracking benchmark, as for 'vbbench generate kitti --source'.
        jrdb: Folder of JRDB, as for 'vbbench generate jrdb --source'.
        motsynth: Folder or file of MOTSynth's annotations, as for 'vbbench generate motsynth --source'.
        work: Where and how.
    """
    from vbbench.reproduction.grid import named_folders
    from vbbench.reproduction.trajectories import TrajectoriesStudy

    folders = named_folders(kitti=kitti, jrdb=jrdb, motsynth=motsynth)
    study = TrajectoriesStudy(splits=split, solver=solver, protocol=protocol, folders=folders, seed=work.seed)
    show(study, work)
