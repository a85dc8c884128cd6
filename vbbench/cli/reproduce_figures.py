"""Commands that reproduce the paper's figures."""

from pathlib import Path

from tyro.conf import OmitArgPrefixes

from vbbench.cli.evaluation import ProtocolName
from vbbench.cli.showing import making, show
from vbbench.reproduction.work import Work


def figure_sigma(
    out: Path = Path("figure-sigma"),
    solver: tuple[str, ...] = (),
    protocol: ProtocolName = "one-step",
    camera: str | None = None,
    tier: str = "ideal",
    sequences: int = 500,
    seed: int = 0,
    work: OmitArgPrefixes[Work] = Work(),  # noqa: B008  frozen
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
    from vbbench.reproduction.sigma.figure import sigma_report
    from vbbench.reproduction.sigma.study import SigmaStudy, compared_solvers, measure_sigma

    study = SigmaStudy(
        solvers=solver or tuple(compared_solvers()),
        protocol=protocol,
        camera=None if camera is None else make_camera(camera),
        tier=tier,
        sequences=sequences,
        seed=seed,
    )
    show(sigma_report(measure_sigma(study, out, making(work))), out, json)


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
    work: OmitArgPrefixes[Work] = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make tables and pictures of how far a camera drifts whose motion nobody tells: of a simulated robot, KITTI, JRDB.

    Args:
        out: Folder for figure-robot.md, .json and pictures, and for datasets and submissions; what it holds is reused.
        jrdb: Folder of JRDB, as for 'vbbench generate jrdb --source'.
        bags: Folder of JRDB's rosbags, which tell how the robot moved.
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
    from vbbench.reproduction.robot.figure import robot_report
    from vbbench.reproduction.robot.measuring import measure_robot
    from vbbench.reproduction.robot.study import RobotStudy, default_entrants, with_and_without

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
    show(robot_report(measure_robot(study, out, making(work))), out, json)
