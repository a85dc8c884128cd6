"""The constants of the joint problem of a real camera, and what they become at a frame rate.

They were chosen on the KITTI recordings 0015, 0017 and 0019 together, on tier field of Hotel and ETH, and on made
drives, not by recording; docs/real-cameras.md says what each is worth.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from vbbench.solver import Problem
from vbbench_baselines.common.cold_start import FADE
from vbbench_baselines.joint_map.motion.pace import pace_of
from vbbench_baselines.joint_map.motion.walks import Walk, walk_of
from vbbench_baselines.joint_map.prior import Prior, get_prior, stationary, unbounded
from vbbench_baselines.joint_map.real_camera.cues import Noise
from vbbench_baselines.joint_map.real_camera.drift import Drift
from vbbench_baselines.joint_map.real_camera.elimination import PeoplePrior
from vbbench_baselines.joint_map.real_camera.noise import NoiseLearner
from vbbench_baselines.joint_map.real_camera.observer import Observer, normaliser

REFERENCE = 0.4
"""In s: the constants are those of frames so far apart."""

TOLD_MEMORY = 0.1
"""In s: τ where the noise is told, which then is a detector's."""


LEAST_NU, STEADY = 1.0, 1.8
"""However close together frames are, ν of people's walks is not less, nor artanh of a partial autocorrelation more."""


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Standard deviations at frames of `REFERENCE` seconds, unless it says otherwise.

    Parameters
    ----------
    window : frames that are solved together; of those before them people keep what they told (`real_camera.past`).
    noise, memory, noise_nu : σ, as a share of the box, and τ in s of column, length and foot, and ν of all.
    noise_spread, noise_staying : how firmly these are believed, see `joint_map.real_camera.noise.NoiseLearner`.
    noise_growth : what a frame tells of them grows with dt to this power: frames close together tell much alike.
    edge, edge_std : δ in m.
    height_std : of ln height at least, since a box is not exactly as high as its person.
    tilt_std : in rad, of pitch and roll at the start, where `Problem` does not tell.
    mount_std : in m, of the camera's height over the ground that people stand on.
    offset_std : in rad, of the columns' offset.
    pitch_step, roll_step, mount_step, offset_step : by how much these change in a frame, with ν = ``drift_nu``.
    walk_std, walk_nu, walk_people : σ in m, ν and a_0 of people's second differences (`joint_map.prior`).
    walk_growth, walk_nu_growth : σ and ν grow with dt to this power.
    walk_b : b_1 and b_2 of these: people come back to the way they were on (`joint_map.prior`).
    walk_b_growth : artanh of their partial autocorrelations grows with dt to this power: within a stride people sway
        more than they change their way.
    cold_walk_std, cold_walk_growth : σ and its power after a cold start; b and ν are those above at any frame rate.
    first_speed : in m/s, of a velocity component of somebody new.
    pace, cold_pace : how much it counts how fast people walk (`joint_map.motion.pace`), and after a cold start, where
        nothing else tells how fast all move.
    surge, sway, swerve : in m, m and rad: changes of a vehicle's velocity forward, to the right, and of its turning.
    cold_surge : the first after a cold start, where less tells who changes speed.
    vehicle_nu : degrees of freedom of these.
    slip, turn, slow : scales in m, rad and m of the Cauchy laws of velocity to the right, of turning, which counts in
        proportion to dt, and of speed.
    drag, cold_drag : the weight of the last, as it is told anew in every frame that shows anybody, growing as dt^.75;
        and after a cold start, where people's pace tells more.
    reverse : in m/s, of a velocity backwards after a cold start.
    vehicle_speed : in m/s, of a first velocity.
    still : in m and rad, at any frame rate: by how much a vehicle that stands seems to move and to turn; at most half
        of ``slow`` and ``turn``.
    stay : in s, mean time for which a vehicle moves or stands before it does the other.
    heads : how a pedestrian's head turns; nothing else of this prior counts.
    laws : how probable a vehicle is at first, and a pedestrian whose head follows by the first and the second law.
    """

    window: int = 20
    noise: tuple[float, float, float] = (0.04, 0.012, 0.05)
    memory: tuple[float, float, float] = (0.4, 6.0, 6.0)
    noise_nu: float = 6.0
    noise_spread: float = 0.7
    noise_staying: float = 4.0
    noise_growth: float = 0.5
    edge: float = 0.45
    edge_std: float = 0.12
    height_std: float = 0.055
    tilt_std: float = 0.03
    mount_std: float = 0.2
    offset_std: float = 0.005
    pitch_step: float = 0.004
    roll_step: float = 0.004
    mount_step: float = 0.05
    offset_step: float = 0.0005
    drift_nu: float = 4.0
    walk_std: float = 0.055
    walk_nu: float = 4.0
    walk_people: float = 20.0
    walk_growth: float = 1.05
    walk_nu_growth: float = 0.5
    cold_walk_std: float = 0.07
    cold_walk_growth: float = 1.5
    walk_b: tuple[float, float] = (-0.35, -0.1)
    walk_b_growth: float = -0.7
    first_speed: float = 1.4
    pace: float = 0.3
    cold_pace: float = 1.0
    surge: float = 0.18
    cold_surge: float = 0.15
    sway: float = 0.012
    swerve: float = 0.01
    vehicle_nu: tuple[float, float, float] = (4.0, 4.0, 2.0)
    slip: float = 0.05
    turn: float = 0.011
    slow: float = 0.05
    drag: float = 0.3
    cold_drag: float = 0.09
    reverse: float = 0.3
    vehicle_speed: float = 4.0
    still: tuple[float, float] = (0.004, 0.0006)
    stay: float = 30.0
    laws: tuple[float, float, float] = (0.05, 0.25, 0.4)
    heads: Prior = field(default_factory=lambda: get_prior("default"))

    def noise_learner(self, problem: Problem) -> NoiseLearner:
        """What is believed of the boxes' noise before any was seen, and learns it from them."""
        sigma, tau = np.array(self.noise), np.array(self.memory)
        if problem.box_std > 0.0:
            sigma, tau = np.full(3, problem.box_std), np.full(3, TOLD_MEMORY)
        first, telling = Noise(sigma, tau, np.full(3, self.noise_nu)), (problem.dt / REFERENCE) ** self.noise_growth
        return NoiseLearner(first, self.noise_spread, self.noise_staying, telling)

    def people(self, problem: Problem) -> PeoplePrior:
        """What is known of people before they are seen."""
        mean = np.array((np.log(problem.height_mean), self.edge))
        spread = max(problem.height_std / problem.height_mean, self.height_std)
        return PeoplePrior(mean, np.array((spread, self.edge_std)))

    def drift(self, problem: Problem) -> Drift:
        """What is known of the camera."""
        tilt = problem.tilt_std or self.tilt_std
        ratio = np.sqrt(problem.dt / REFERENCE)
        mean = np.array((0.0, 0.0, problem.camera.mount_height, 0.0))
        std = np.array((tilt, tilt, self.mount_std, self.offset_std))
        step = ratio * np.array((self.pitch_step, self.roll_step, self.mount_step, self.offset_step))
        return Drift(mean, std, step, self.drift_nu)

    def walk(self, dt: float, cold: bool) -> Walk:
        """How people walk."""
        base, ratio = self.heads, dt / REFERENCE
        b, sigma, nu = self.walk_b, self.cold_walk_std * ratio**self.cold_walk_growth, self.walk_nu
        if not cold:
            b = stationary(np.clip(ratio**self.walk_b_growth * unbounded(b), -STEADY, STEADY))
            sigma, nu = self.walk_std * ratio**self.walk_growth, max(nu * ratio**self.walk_nu_growth, LEAST_NU)
        prior = Prior(
            dt=dt,
            b=b,
            sigma=sigma,
            nu=nu,
            a0=self.walk_people,
            yaw_scale=base.yaw_scale * ratio,
            lag=base.lag,
            follow_scale=(base.follow_scale[0] * ratio, base.follow_scale[1]),
            following=base.following,
            speed=self.first_speed,
        )
        return walk_of(prior, dt, cold=cold)._replace(rest=0.0, pace=pace_of(dt, self.cold_pace if cold else self.pace))

    def observer(self, dt: float, walk: Walk, cold: bool) -> Observer:
        """How the camera moves; a pedestrian who carries it walks as others do."""
        ratio = dt / REFERENCE
        share = np.array((*self.laws, 1.0 - sum(self.laws)))
        level = np.array((self.slip, self.turn, self.slow)) * ratio
        return Observer(
            change=np.array((self.cold_surge if cold else self.surge, self.sway, self.swerve)) * ratio**1.5,
            nu=np.array(self.vehicle_nu),
            normalisers=np.array([normaliser(nu) for nu in self.vehicle_nu]),
            level=level,
            swing=ratio,
            drag=(self.cold_drag if cold else self.drag) * ratio**0.75,
            pace=self.vehicle_speed * dt,
            walk=walk,
            odds=np.log(share),
            still=np.minimum(self.still, 0.5 * level[[2, 1]]),
            leaving=1.0 - float(np.exp(-dt / self.stay)),
            backing=dt / FADE / (self.reverse * dt) ** 2 if cold else 0.0,
            going=0,
        )


def settings_of(real: Settings | None, prior: Prior, *, promised: bool) -> Settings | None:
    """What a solver with this ``prior`` assumes; nothing if it is ``promised`` that every camera is exact."""
    return None if real is None or promised else replace(real, heads=prior)
