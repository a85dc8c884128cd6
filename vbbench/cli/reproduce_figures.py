"""Commands that reproduce the paper's figures."""

from pathlib import Path

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


def figure_keypoints(
    out: Path = Path("figure-keypoints"),
    trials: int = 100,
    width: int = 1280,
    height: int = 720,
    focal: float = 640.0,
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
    """Make tables and pictures of camera poses from static points at a distance, beside those from people.

    Args:
        out: Folder for figure-keypoints.md, .json, .csv and two pictures, and for datasets and submissions; what it
            holds is reused.
        trials: Number of trials of the five-point method at each distance.
        width: Of the camera's picture, in px.
        height: Of the camera's picture, in px.
        focal: Focal length of the camera, in px.
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
    from vbbench.reproduction.keypoints.figure import keypoints_report
    from vbbench.reproduction.keypoints.people import People
    from vbbench.reproduction.keypoints.study import KeypointsStudy, measure_keypoints
    from vbbench.reproduction.keypoints.views import Setting, pinhole

    study = KeypointsStudy(
        setting=Setting(camera=pinhole(width, height, focal)),
        trials=trials,
        people=People(splits=split, tiers=tier, solvers=solver, every=every, kitti=kitti, poses=poses, seed=seed),
        seed=seed,
    )
    show(keypoints_report(measure_keypoints(study, out, making(work))), out, json)


def figure_posterior(
    out: Path = Path("figure-posterior"),
    split: str = "eth",
    every: int = 1,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Draw posteriors of observer and people, their entropy by number of people and directions, and the worst cases.

    Args:
        out: Folder for figure-posterior.md, .json, .csv and pictures, and for a dataset and a submission; what it
            holds is reused.
        split: Of a recording; the paper's is eth.
        every: Only every so-many-th sequence.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.posterior.figure import posterior_report
    from vbbench.reproduction.posterior.study import PosteriorStudy, measure_posterior

    study = PosteriorStudy(split=split, every=every, seed=seed)
    show(posterior_report(measure_posterior(study, out, making(work))), out, json)


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
    from vbbench.reproduction.at_hand import AtHand
    from vbbench.reproduction.trajectories.figure import trajectories_report
    from vbbench.reproduction.trajectories.study import TrajectoriesStudy, measure_trajectories

    at_hand = AtHand.of(kitti=kitti, jrdb=jrdb, motsynth=motsynth)
    study = TrajectoriesStudy(splits=split, solver=solver, protocol=protocol, at_hand=at_hand, seed=seed)
    show(trajectories_report(measure_trajectories(study, out, making(work))), out, json)
