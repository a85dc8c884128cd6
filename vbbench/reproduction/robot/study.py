"""The paper's experiment with a robot: nothing is known of how the camera moves, and odometry is the reference.

Recordings: a simulated robot that sees all around, as JRDB's does, whose true way is known, so that drift of its
odometry is measured, too; KITTI's car; and JRDB. Solvers: `vb-sf` with nothing expected of the observer, as in the
paper, and one that has a model of real cameras, by the camera alone and with odometry.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options, Simulation
from vbbench.generation.sources import data_folders
from vbbench.registry import load
from vbbench.reproduction.asked import check_names
from vbbench.reproduction.transfer.variants import registered_variants

PAPER_VARIANT, SOLVER = "vb-sf-free", "map-causal"
"""The paper's solver with nothing expected of the observer, as a registered variant; and one that uses odometry."""
PROTOCOLS = ("sequential", "cold-start")
SCENARIO = "concourse"
"""Whom the simulated robot drives among."""
LONGEST = 400
"""Frames after which a recording is cut: splits cut earlier, within less than 40 m."""


@dataclass(frozen=True, kw_only=True)
class Entrant:
    """A solver, by the camera alone or with odometry.

    Parameters
    ----------
    solver : a registered name or ``module:attribute``.
    title : what it is called.
    odometry : whether it gets odometry, where there is any.
    """

    solver: str
    title: str
    odometry: bool = False


def default_entrants() -> tuple[Entrant, ...]:
    """The paper's, and one more without odometry and with it."""
    paper = Entrant(solver=registered_variants()[PAPER_VARIANT].solver, title="vb-sf, observer free")
    return (paper, *with_and_without(SOLVER))


def with_and_without(solver: str) -> tuple[Entrant, Entrant]:
    """A solver by the camera alone, and with odometry."""
    return (
        Entrant(solver=solver, title=solver),
        Entrant(solver=solver, title=f"{solver} with odometry", odometry=True),
    )


@dataclass(frozen=True, kw_only=True)
class RobotStudy:
    """What to measure.

    Parameters
    ----------
    jrdb, bags : JRDB's folder, and that of its rosbags, which tell how the robot moved.
    kitti, poses : KITTI's folder, and that of the camera's poses as somebody else found them; both are looked for in
        the data folders where no ``kitti`` is named.
    sequences : of the simulated robot, a minute each.
    tier : of its boxes; in tier `field` they are drawn by hand, as JRDB's are.
    seed : of all random numbers.
    entrants : the solvers.
    protocols : names of protocols; maps show the first.
    """

    jrdb: Path | None = None
    bags: Path | None = None
    kitti: Path | None = None
    poses: Path | None = None
    sequences: int = 6
    tier: str = "field"
    seed: int = 0
    entrants: Sequence[Entrant] = field(default_factory=default_entrants)
    protocols: Sequence[str] = PROTOCOLS

    def check(self) -> None:
        """Find the mistakes that can be found before the work starts.

        Raises
        ------
        VbbenchError
            If a solver or a protocol is unknown, or JRDB is named without bags.
        """
        if self.jrdb is not None and self.bags is None:
            raise VbbenchError(f"{self.jrdb}: only its rosbags tell how JRDB's robot moved; name their folder (--bags)")
        if not self.entrants or not self.protocols:
            raise VbbenchError("nothing to measure: name a solver and a protocol")
        self.recordings()
        check_names((entrant.solver for entrant in self.entrants), self.protocols)

    def recordings(self) -> tuple["Recording", ...]:
        """Those that are measured, if their files are here."""
        jrdb = () if self.jrdb is None else (self._jrdb,)
        return self._simulated, self._kitti, *jrdb

    @property
    def _simulated(self) -> "Recording":
        options = Options(
            camera=robot_camera(),
            tier=self.tier,
            observer="robot",
            detector=self.tier != "field",
            seed=self.seed,
            simulation=Simulation(scenario=SCENARIO, sequences=self.sequences),
        )
        return Recording(
            name="simulated",
            title="A simulated robot in a hall",
            split="sim",
            options=options,
            reference="odometry of wheels and gyro, filtered",
            about="The true way is known; wheels slip by 1 % of the speed and 5 % of the turning rate, and spin at "
            "times. Odometry is what an extended Kalman filter makes of wheels and gyro.",
        )

    @property
    def _kitti(self) -> "Recording":
        poses = self.poses
        if self.kitti is None and poses is None:
            beside = (folder / "kitti" / "poses" for folder in data_folders())
            poses = next((folder for folder in beside if folder.is_dir()), None)
        footage = FootageOptions(longest=LONGEST, poses=poses)
        other = None if poses is None else replace(footage, poses=None)
        return Recording(
            name="kitti",
            title="KITTI's car",
            split="kitti",
            options=Options(source=self.kitti, footage=footage),
            reference="GPS and IMU against stereo SLAM",
            other=None if other is None else Options(source=self.kitti, footage=other),
            about="KITTI has no odometry. Truth is what keeps parked cars in place better, GPS and IMU or, where poses "
            "are named, stereo SLAM; how far the two drift apart bounds what can be measured. The model of real "
            f"cameras in `{SOLVER}` was fitted on recordings 0015, 0017 and 0019.",
        )

    @property
    def _jrdb(self) -> "Recording":
        return Recording(
            name="jrdb",
            title="JRDB's robot",
            split="jrdb",
            options=Options(source=self.jrdb, footage=FootageOptions(longest=LONGEST, bags=self.bags)),
            reference="odometry of the wheels alone",
            about="Truth is what an extended Kalman filter makes of wheels and gyro, with an error of its own of about "
            "1 % of the way; odometry comes from the same wheels, so that its drift shows turns alone.",
        )


@dataclass(frozen=True, kw_only=True)
class Recording:
    """A recording to be measured.

    Parameters
    ----------
    name, title : of it.
    split, options : what makes it.
    reference : what a way is called that somebody measured without people.
    other : options with which truth comes from another source, whose drift against the first is the reference's;
        ``None`` where odometry is the reference.
    about : what it is, as sentences.
    """

    name: str
    title: str
    split: str
    options: Options
    reference: str
    about: str
    other: Options | None = None


def robot_camera() -> Camera:
    """JRDB's, which split `jrdb` knows."""
    camera: Camera = load("generator", "jrdb").camera
    return camera
