"""Commands that reproduce the paper's tables and figures, all of them at once, and a study that is not of it."""

from pathlib import Path
from typing import TYPE_CHECKING

from vbbench.cli.evaluation import ProtocolName
from vbbench.reproduction.work import Work

if TYPE_CHECKING:
    from vbbench.reproduction.grid import Study


def show(study: "Study", out: Path, work: Work, as_json: bool) -> None:
    """Run a study in the folder ``out``, write its report there, and print what it found."""
    from vbbench.reproduction.grid import Making
    from vbbench.reproduction.report import shown, write_report

    report = study.run(out, Making(**vars(work)))
    print(shown(report, write_report(report, out), as_json=as_json))


def everything(
    out: Path = Path("reproduced"),
    study: tuple[str, ...] = (),
    every: int = 10,
    kitti: Path | None = None,
    poses: Path | None = None,
    jrdb: Path | None = None,
    bags: Path | None = None,
    motsynth: Path | None = None,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make every table and figure of the paper, and one page that shows them all with what the paper prints.

    A study that is done is kept: run the command again after an interruption.

    Args:
        out: Folder for index.html, and a folder for each study.
        study: Names of studies, such as table2 figure-sigma; default: all.
        every: In tables of recordings, only every so-many-th sequence, of Shibuya every sixth of these.
        kitti: Folder of KITTI's tracking benchmark; default: searched in the usual places.
        poses: Folder of the poses of KITTI's camera, as for 'vbbench generate kitti --poses'.
        jrdb: Folder of JRDB, as for 'vbbench generate jrdb --source'.
        bags: Folder of JRDB's rosbags, which hold how the robot moved.
        motsynth: Folder or file of MOTSynth's annotations, as for 'vbbench generate motsynth --source'.
        seed: Seed of all random numbers.
        work: Where the work is done.
    """
    from vbbench.reproduction.grid import Making
    from vbbench.reproduction.report import reproduce_all
    from vbbench.reproduction.studies import Downloads, paper_studies

    downloads = Downloads(kitti=kitti, poses=poses, jrdb=jrdb, bags=bags, motsynth=motsynth)
    studies = paper_studies(every=every, seed=seed, only=study, downloads=downloads)
    print(reproduce_all(studies, out, Making(**vars(work))))


def transfer(
    kitti: Path,
    poses: Path | None = None,
    out: Path = Path("transfer"),
    every: tuple[int, ...] = (4, 1),
    split: str = "eth-15fps",
    smooth: float = 0.0,
    protocol: tuple[ProtocolName, ...] = ("sequential", "one-step"),
    solver: tuple[str, ...] = (),
    limit: int = 60,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Compare how tier field and KITTI rank solvers: a table, every number as JSON, and a picture.

    Args:
        kitti: Folder of KITTI's tracking benchmark, as for 'vbbench generate kitti --source'.
        poses: Folder of the camera's poses, as for 'vbbench generate kitti --poses'.
        out: Folder for transfer.md, .json and .png, and for datasets and submissions; what it holds is reused.
        every: Every how many frames of KITTI: 4, 1, or both.
        split: Whose people tier field shows; where KITTI's frames lie between theirs, they follow smooth curves.
        smooth: Metres (root mean square) by which people may leave where they were recorded, so that walks are smooth.
        protocol: Which truth a solver is given, and when.
        solver: Further solvers to rank with the installed ones and their variants: names or module:attribute.
        limit: Most sequences of tier field.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
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
        seed=seed,
    )
    show(study, out, work, json)


def table1(
    out: Path = Path("table1"),
    split: tuple[str, ...] = ("sim", "hotel", "eth", "students", "shibuya01", "shibuya02", "street", "motsynth"),
    motsynth: Path | None = None,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make a table and a picture of sequences, frames and people of every split, and the paper's.

    Args:
        out: Folder for table1.md, .json and .png; where the labels of Shibuya are missing, also for simulated
            recordings; what it holds is reused.
        split: Of the paper's Table 1.
        motsynth: Folder or file of MOTSynth's annotations, as for 'vbbench generate motsynth --source'.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.grid import named_folders
    from vbbench.reproduction.table1 import Table1Study

    study = Table1Study(splits=split, folders=named_folders(motsynth=motsynth), seed=seed)
    show(study, out, work, json)


def table2(
    out: Path = Path("table2"),
    split: tuple[str, ...] = ("hotel", "eth", "students"),
    solver: tuple[str, ...] = (),
    every: int = 1,
    seed: int = 0,
    source: Path | None = None,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make the paper's Table 2: every solver on Hotel, ETH and Students, under one-step and sequential.

    Args:
        out: Folder for table2.md, .json and .png, and for datasets and submissions; what it holds is reused.
        split: Of the paper's Table 2; one whose source is missing is omitted.
        solver: Registered names or module:attribute; default: the paper's, here, and map-causal and map-batch.
        every: Only every so-many-th sequence of each split.
        seed: Seed of all random numbers.
        source: Folder that holds the source files; default: the usual places.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    _show_solver_table(2, split, solver, every=every, seed=seed, source=source, out=out, work=work, json=json)


def table3(
    out: Path = Path("table3"),
    split: tuple[str, ...] = ("shibuya01", "shibuya02"),
    solver: tuple[str, ...] = (),
    every: int | None = None,
    seed: int = 0,
    source: Path | None = None,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make the paper's Table 3: every solver on Shibuya, or on simulated crowds where CroHD is missing.

    Args:
        out: Folder for table3.md, .json and .png, and for datasets and submissions; what it holds is reused.
        split: Of the paper's Table 3; where its recording is missing, a simulated crowd is lifted in the same way.
        solver: Registered names or module:attribute; default: the paper's, here, and map-causal and map-batch.
        every: Only every so-many-th sequence of each split; default: every one of CroHD, few of a simulated crowd.
        seed: Seed of all random numbers.
        source: CroHD, as for 'vbbench generate shibuya01 --source'; default: the usual places.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    _show_solver_table(3, split, solver, every=every, seed=seed, source=source, out=out, work=work, json=json)


def _show_solver_table(
    table: int,
    split: tuple[str, ...],
    solver: tuple[str, ...],
    *,
    every: int | None,
    seed: int,
    source: Path | None,
    out: Path,
    work: Work,
    json: bool,
) -> None:
    from vbbench.reproduction.solver_tables import COUNTERPARTS, SolverTableStudy

    solvers = solver or tuple(COUNTERPARTS)
    study = SolverTableStudy(table=table, splits=split, solvers=solvers, every=every, seed=seed, source=source)
    show(study, out, work, json)


def table4(
    out: Path = Path("table4"),
    solver: tuple[str, ...] = ("vb-cv", "vb-sf", "vb-sf-literal", "map-causal"),
    jitter: tuple[float, ...] = (0.0, 1.0, 2.0, 4.0),
    sequences: int | None = None,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make tables and a picture of errors on split street with centre lines and with tracked boxes, and the paper's.

    Args:
        out: Folder for table4.md, .json and .png, and for datasets and submissions; what it holds is reused.
        solver: Registered names or module:attribute.
        jitter: Standard deviations in px of the hands that draw centre lines; 0 draws them exactly.
        sequences: Number of sequences; default: the scenario's ten.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.table4 import Table4Study

    study = Table4Study(solvers=solver, jitter=jitter, sequences=sequences, seed=seed)
    show(study, out, work, json)


def readings(
    out: Path = Path("readings"),
    split: tuple[str, ...] = ("hotel", "eth", "students"),
    every: int = 1,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make a table and a picture of the errors under every reading of the paper, and the paper's.

    Args:
        out: Folder for readings.md, .json and .png, and for datasets and submissions; what it holds is reused.
        split: Of the paper's Table 2.
        every: Only every so-many-th sequence of each split.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.readings import ReadingsStudy

    study = ReadingsStudy(splits=split, every=every, seed=seed)
    show(study, out, work, json)


def figure_sigma(
    out: Path = Path("figure-sigma"),
    solver: tuple[str, ...] = (),
    protocol: ProtocolName = "one-step",
    camera: str | None = None,
    tier: str = "ideal",
    sequences: int = 500,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make a table and a picture of errors on split sim by number of people, for several spreads of heights.

    Args:
        out: Folder for figure-sigma.md, .csv and .png, and for datasets and submissions; what it holds is reused.
        solver: Registered names or module:attribute; default: vb-sf, vb-sf with heights from the prior only, and that
            without a prior of the observer's motion.
        protocol: Which truth the solver is given, and when.
        camera: Camera of the observer, as in 'vbbench generate'; default: that of split sim.
        tier: How boxes are corrupted; 'vbbench tiers' lists them.
        sequences: Number of sequences at each spread of heights.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.camera import make_camera
    from vbbench.reproduction.sigma import SigmaStudy, compared_solvers

    study = SigmaStudy(
        solvers=solver or tuple(compared_solvers()),
        protocol=protocol,
        camera=None if camera is None else make_camera(camera),
        tier=tier,
        sequences=sequences,
        seed=seed,
    )
    show(study, out, work, json)


def figure_keypoints(
    out: Path = Path("figure-keypoints"),
    trials: int = 100,
    split: tuple[str, ...] = ("hotel", "eth"),
    tier: tuple[str, ...] = ("tracked", "field"),
    every: int = 6,
    solver: tuple[str, ...] = ("map-causal", "vb-sf"),
    kitti: Path | None = None,
    poses: Path | None = None,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make tables and a picture of camera poses from static points at a distance, and of those from people.

    Args:
        out: Folder for figure-keypoints.md, .json, .csv and a picture, and for datasets and submissions; what it
            holds is reused.
        trials: Number of trials of the five-point method at each distance.
        split: Whose people are solved.
        tier: How their boxes are corrupted; 'vbbench tiers' lists them.
        every: Only every so-many-th sequence of each split, in tier field a third of that.
        solver: Registered names or module:attribute; the picture shows the first.
        kitti: Folder of KITTI's tracking benchmark; default: searched in the usual places.
        poses: Folder of the poses of KITTI's camera, as for 'vbbench generate kitti --poses'.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.keypoints import KeypointsStudy, People

    study = KeypointsStudy(
        trials=trials,
        people=People(splits=split, tiers=tier, solvers=solver, every=every, kitti=kitti, poses=poses, seed=seed),
        seed=seed,
    )
    show(study, out, work, json)


def figure_posterior(
    out: Path = Path("figure-posterior"),
    split: str = "eth",
    every: int = 1,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Draw posteriors of observer and people, and their entropy by number of people and directions.

    Args:
        out: Folder for figure-posterior.md, .json, .csv and pictures, and for a dataset; what it
            holds is reused.
        split: Of a recording; the paper's is eth.
        every: Only every so-many-th sequence.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.posterior import PosteriorStudy

    study = PosteriorStudy(split=split, every=every, seed=seed)
    show(study, out, work, json)


def figure_robot(
    out: Path = Path("figure-robot"),
    jrdb: Path | None = None,
    bags: Path | None = None,
    kitti: Path | None = None,
    poses: Path | None = None,
    sequences: int = 6,
    tier: str = "field",
    solver: tuple[str, ...] = (),
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make tables and pictures of how far a camera drifts without known motion: of a simulated robot, KITTI, JRDB.

    Args:
        out: Folder for figure-robot.md, .json and pictures, and for datasets and submissions; what it holds is reused.
        jrdb: Folder of JRDB, as for 'vbbench generate jrdb --source'.
        bags: Folder of JRDB's rosbags, which hold how the robot moved.
        kitti: Folder of KITTI's tracking benchmark, as for 'vbbench generate kitti --source'; default: kitti in
            $VBBENCH_DATA, then the cache folder.
        poses: Folder of the camera's poses, as for 'vbbench generate kitti --poses'; default: kitti/poses there.
        sequences: Number of sequences of the simulated robot, a minute each.
        tier: How the simulated robot's boxes are corrupted; 'vbbench tiers' lists them.
        solver: Further solvers, without odometry and with it: registered names or module:attribute.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.robot import RobotStudy, default_entrants, with_and_without

    more = [entrant for name in solver for entrant in with_and_without(name)]
    study = RobotStudy(
        jrdb=jrdb,
        bags=bags,
        kitti=kitti,
        poses=poses,
        sequences=sequences,
        tier=tier,
        seed=seed,
        entrants=tuple(dict.fromkeys([*default_entrants(), *more])),
    )
    show(study, out, work, json)


def figure_trajectories(
    out: Path = Path("figure-trajectories"),
    split: tuple[str, ...] = (),
    solver: str = "vb-sf",
    protocol: ProtocolName = "sequential",
    kitti: Path | None = None,
    jrdb: Path | None = None,
    motsynth: Path | None = None,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make one sheet with an example of every split: true and estimated trajectories of people and observer.

    Args:
        out: Folder for figure-trajectories.md, .json and .png, and for the examples' datasets and submissions; what it
            holds is reused.
        split: Only these splits; default: all whose source is here.
        solver: Registered name or module:attribute.
        protocol: Which truth the solver is given, and when.
        kitti: Folder of KITTI's tracking benchmark, as for 'vbbench generate kitti --source'.
        jrdb: Folder of JRDB, as for 'vbbench generate jrdb --source'.
        motsynth: Folder or file of MOTSynth's annotations, as for 'vbbench generate motsynth --source'.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.grid import named_folders
    from vbbench.reproduction.trajectories import TrajectoriesStudy

    folders = named_folders(kitti=kitti, jrdb=jrdb, motsynth=motsynth)
    study = TrajectoriesStudy(splits=split, solver=solver, protocol=protocol, folders=folders, seed=seed)
    show(study, out, work, json)
