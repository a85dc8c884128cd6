"""The extension module: sources in ``baselines/cpp``, built by ``CMakeLists.txt``."""

from typing import Any

from vbbench.geometry import BoolArray, FloatArray, IntArray
from vbbench_baselines.cascade import CrowdGraph, Factors
from vbbench_baselines.common.bearings import Sightings
from vbbench_baselines.common.motion import Spreads

class Estimator:
    """Sliding-window maximum a posteriori estimate of poses, calibration and people's paths.

    All arrays are of float64 in C order, or int32 where they count; NaN = absent. Anything else is a `VbbenchError`.
    """

    def __init__(self) -> None: ...
    def set(self, name: str, value: float) -> None:
        """Set one of the constants of ``constants.hpp``, or ``size``, ``rounds`` or ``least``."""

    def start(self, facts: dict[str, Any]) -> None:
        """Begin a recording."""

    def step(
        self,
        boxes: FloatArray,
        cut: IntArray,
        poses: FloatArray,
        positions: FloatArray,
        motion: FloatArray,
        motion_covariance: FloatArray,
        pose: FloatArray,
        pose_covariance: FloatArray,
        places: FloatArray,
        place_covariances: FloatArray,
        heights: FloatArray,
    ) -> bool:
        """Take a frame, and write its estimate into the last five arrays; whether it converged.

        Parameters
        ----------
        boxes : [K, 5] azimuth, foot, length, pixels, width, as `Bearings` has them.
        cut : [K] what the border cuts off.
        poses, positions : [3, 3] and [3, K, 2] given in the last three frames.
        motion, motion_covariance : [3] and [3, 3] of odometry.
        pose, pose_covariance : [3] and [3, 3].
        places, place_covariances : [K, 2] and [K, 2, 2].
        heights : [K] in m.
        """

    def smoothed(
        self,
        frame: int,
        pose: FloatArray,
        pose_covariance: FloatArray,
        places: FloatArray,
        place_covariances: FloatArray,
    ) -> None:
        """Write the estimate of a frame of the window, by all boxes so far, into the last four arrays."""

    def ages(self) -> list[int]:
        """Numbers of the window's frames, counted from the start."""

    def forget(self, columns: IntArray) -> None:
        """From the next frame on these columns [M] are new people."""

    def __getstate__(self) -> bytes:
        """The state for `__setstate__`; a copy gives the same answers as the original."""

    def __setstate__(self, state: bytes) -> None:
        """Restore a state; raises `VbbenchError` if it is of another version."""

    def cost(self, step: FloatArray | None = None) -> float:
        """Negative log posterior of the window, or of its state after a ``step`` [N], up to a constant."""

    def linear_system(self) -> dict[str, FloatArray]:
        """The window's rows and its Gaussian priors.

        ``residuals``, ``weights`` [R] and ``jacobian`` [R, N] of the rows, ``information`` [N, N] and ``gradient`` [N]
        of the priors, and which of the N variables are ``free``.
        """

    def eliminated_step(self) -> FloatArray:
        """The undamped Gauss–Newton step [N] of the window, by elimination; empty where there is none."""

    def calibration(self) -> list[float]:
        """Pitch, roll, mount height, column offset, edge, odometry's scale and turn."""

    def modes(self) -> list[float]:
        """Posterior of the motion modes in the newest step."""

def measure(sightings: Sightings, heights: FloatArray, variances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Places of people of known or uncertain height by their boxes: mean and variance [K] in m and m².

    Returns
    -------
    [K, 2] (right, forward) in m, and [K, 3] covariance N as (rr, rf, ff) in m².
    """

def learn_heights(
    mean: FloatArray,
    variance: FloatArray,
    pose: FloatArray,
    positions: FloatArray,
    spread: FloatArray,
    sightings: Sightings,
    pose_std: float,
    lowest: float,
    highest: float,
) -> None:
    """Update the posterior ``mean`` and ``variance`` [K] of heights, see `Heights`.

    Parameters
    ----------
    pose, positions : [3] and [K, 2] of the frame whose boxes are the ``sightings``.
    spread : [K] standard deviations in m of the positions; NaN = not to be learned from.
    pose_std : standard deviation in m of distances from the pose.
    lowest, highest : limits of the mean in m.
    """

def continue_people(
    positions: FloatArray, given: BoolArray, spreads: Spreads, kept: float
) -> tuple[FloatArray, FloatArray]:
    """Constant velocity, as far as the past is known.

    Parameters
    ----------
    positions : [3, K, 2] at t−2, t−1 and t in m, NaN = unknown. Row t is where people are, if known.
    given : [3, K] whether the position was given.
    kept : κ, the share of velocities that is kept.

    Returns
    -------
    [K, 2] expected positions in m and [K] their standard deviations in m, NaN for people with no known position.
    """

def continue_observer(poses: FloatArray, given: BoolArray, spreads: Spreads, kept: float) -> tuple[FloatArray, float]:
    """The observer at constant velocity and yaw: [3] pose, and the standard deviation of its place in m.

    Poses [3, 3] at t−2, t−1, t, given [3] and the rest as for people. No known pose at all: the world's origin.
    """

def adapt_velocities(positions: FloatArray, velocities: FloatArray, radius: float, rate: float) -> FloatArray:
    """Change of velocity rate·(w_k − v_k), w_k the mean velocity of everyone within ``radius``, including k.

    Parameters
    ----------
    positions, velocities : [K, 2] in m and m/s; people of unknown velocity (NaN) do not count and do not change.
    radius : in m.
    rate : dt/η; above 1 the mean would be overshot, so it is cut there.

    Returns
    -------
    [K, 2] in m/s.
    """

def fit_pose(factors: Factors, facing: float = ...) -> FloatArray:
    """The pose (x, y, yaw) of least energy.

    ``facing`` in 1/rad² is the information on the predicted yaw; as 2(1 − cos d) for d², a multiple of the polynomial's
    own terms.
    """

def localise(pose: FloatArray, factors: Factors) -> FloatArray:
    """World positions [K, 2] in m of least energy given the pose [3], a Kalman update; NaN = not observed."""

def pose_covariance(pose: FloatArray, factors: Factors, facing: float = ...) -> FloatArray:
    """Covariance [3, 3] of (x, y, yaw) in m², m·rad, rad², at the pose [3] found by `fit_pose` with ``facing``."""

def position_covariances(pose: FloatArray, sigma: FloatArray, factors: Factors) -> FloatArray:
    """Covariances [K, 2, 2] in m², in the world; ``sigma`` [3, 3] is the pose's. NaN for people not observed."""

def minimise(
    factors: Factors, pose: FloatArray, softness: float, rounds: int, tolerance: float, facing: float = ...
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Minimise E_c over the pose, unless it is known, and the people.

    Parameters
    ----------
    pose : [3] the known pose, or NaN.
    softness : ε, in standard deviations.
    rounds, tolerance : stop after this number of rounds, or when no place (m) and no pose (m, rad) moved further.
    facing : information in 1/rad² on the yaw of ``factors.walk``.

    Returns
    -------
    Pose [3], positions [K, 2] in m (NaN = not observed) and the weights [K] of the people's terms.
    """

def link(positions: FloatArray, reach: float, most: int) -> IntArray:
    """Edges [E, 2], i < j, where j is among i's ``most`` nearest within ``reach`` m, or i among j's.

    Positions [K, 2] in m; NaN has no neighbours. At most K·``most`` edges, so that what follows is linear in K.
    """

def potential(squared: float, sigma: float) -> float:
    """V at the squared distance d² in m²."""

def sample_rays(
    yaw: float,
    positions: FloatArray,
    weights: FloatArray,
    rays: FloatArray,
    factors: Factors,
    softness: float,
    most: int,
    spacing: float,
) -> tuple[FloatArray, FloatArray]:
    """Everyone's samples along the viewing rays; people without expectation stay where they are.

    Parameters
    ----------
    yaw : of the observer, in rad.
    positions, weights : [K, 2] optima in m and [K] weights there, as `minimise` gives them.
    rays : [K, 2] place in m of a person one metre tall.
    softness : as in `minimise`.
    most, spacing : S, odd, and δ in m of height.

    Returns
    -------
    Places [K, S, 2] in the world in m, sample 0 the person's own optimum, and energies [K, S] less that at the optimum;
    inf = unused.
    """

def tabulate(places: FloatArray, energies: FloatArray, graph: CrowdGraph) -> tuple[IntArray, FloatArray]:
    """The edges [E', 2] along which a choice among samples makes a difference, and λV there, [E', S, S]."""

def pass_messages(
    energies: FloatArray, edges: IntArray, pair: FloatArray, rounds: int, damping: float, tolerance: float
) -> tuple[IntArray, int]:
    """The choice [K] of each node, by its min-marginal, and the number of rounds.

    Parameters
    ----------
    energies : [K, S] energies U, inf = no such choice.
    edges, pair : [E, 2] nodes (i, j) and [E, S, S] energies V_ij(s_i, s_j), finite.
    rounds, tolerance : stop after this number of rounds, or when no message changed by more; all are passed at once.
    damping : share of the last round's message that is kept, in [0, 1).
    """

def ray_beliefs(
    energies: FloatArray, edges: IntArray, pair: FloatArray, rounds: int, damping: float, tolerance: float
) -> FloatArray:
    """Probability [K, S] of each person's samples by the messages: exp(−belief), of sum 1; the rest as `pass_messages`.

    Beliefs are min-marginals: a sample has the probability of the best joint choice that contains it.
    """

def descend(
    pose: FloatArray,
    positions: FloatArray,
    factors: Factors,
    softness: float,
    graph: CrowdGraph,
    rounds: int,
    tolerance: float,
) -> FloatArray:
    """Positions [K, 2] of least energy E_p near ``positions``; the rest as in `minimise`."""

def pose_energies(poses: FloatArray, factors: Factors, softness: float, facing: float) -> FloatArray:
    """−ln p [N] of the observer's poses [N, 3] in m and rad, up to a constant, people's places minimised out.

    Parameters
    ----------
    softness : ε, in standard deviations.
    facing : information in 1/rad² on the yaw of ``factors.walk``.
    """
