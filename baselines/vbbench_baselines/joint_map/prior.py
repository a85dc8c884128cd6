"""How people walk and heads turn, before any box is seen: the motion prior of the joint MAP solvers.

Second differences a_t = x_t − 2x_{t−1} + x_{t−2} of a walk follow an autoregression of order two,

    a_t = b_1 a_{t−1} + b_2 a_{t−2} + e_t,   e_t ~ Student-t_ν with scale σ_k, in the plane,

and persons differ: σ_k² ~ scaled inverse χ² with a_0 degrees of freedom about σ². Yaw increments are Cauchy. The values
are fitted by ``python -m vbbench_baselines.joint_map.fit`` and kept as TOML in ``priors/``.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from vbbench.errors import UnknownNameError
from vbbench.geometry import FloatArray
from vbbench.kernels import kernel
from vbbench.parsing.toml_text import read_bundled


class Start(NamedTuple):
    """The autoregression while the past is too short for it.

    Attributes
    ----------
    first : standard deviation of a track's first second difference, in units of that of the innovations e.
    b : coefficient of its second one on the first.
    second : standard deviation about that, in the same units.
    """

    first: float
    b: float
    second: float


@kernel
def start_of(b1: float, b2: float) -> Start:
    """How a stationary walk with these coefficients begins (Yule–Walker)."""
    rho = b1 / (1.0 - b2)
    variance = 1.0 / (1.0 - b1 * rho - b2 * (b1 * rho + b2))
    return Start(variance**0.5, rho, (variance * (1.0 - rho * rho)) ** 0.5)


def unbounded(b: tuple[float, float]) -> FloatArray:
    """[2] artanh of the partial autocorrelations of a stationary autoregression: any two numbers are those of one."""
    b1, b2 = b
    partials: FloatArray = np.arctanh(np.array((b1 / (1.0 - b2), b2)))
    return partials


def stationary(partials: FloatArray) -> tuple[float, float]:
    """b_1 and b_2 of these, see `unbounded`."""
    r1, r2 = np.tanh(partials)
    return float(r1 * (1.0 - r2)), float(r2)


@dataclass(frozen=True, kw_only=True)
class Prior:
    """The motion prior at frames of ``dt`` seconds.

    Parameters
    ----------
    dt : seconds per frame to which the other values belong.
    b : b_1 and b_2, without unit; stationary.
    sigma : σ in m: the typical scale of an innovation, each component.
    nu : ν, degrees of freedom of the innovations; inf = normal.
    a0 : a_0, how alike persons are: σ counts as much as so many squared innovation components; inf = all alike.
    yaw_scale : γ, scale in rad of the Cauchy distribution of the turns of a head that wanders; inf = no such prior.
    lag : in s; how soon a head that follows the path looks where its bearer walks, by each of two laws.
    follow_scale : γ_1 and γ_2, scales in rad of the Cauchy distributions of what such a head is off.
    following : p_1 and p_2, the shares of heads that follow so, together below 1; 0 = no such heads.
    speed : in m/s, standard deviation of a velocity component of somebody of whom nothing is known.
    b_std : s_b, how far another recording's b is from this one, each component.
    sigma_people : s_σ, number of people as which this σ counts in another recording.
    """

    dt: float = 0.4
    b: tuple[float, float] = (-0.35, -0.1)
    sigma: float = 0.08
    nu: float = 6.0
    a0: float = 8.0
    yaw_scale: float = 0.03
    lag: tuple[float, float] = (0.8, 0.05)
    follow_scale: tuple[float, float] = (0.02, 0.1)
    following: tuple[float, float] = (0.0, 0.0)
    speed: float = 0.9
    b_std: float = 0.3
    sigma_people: float = 0.3

    @property
    def start(self) -> Start:
        """How a walk begins: nothing to fit."""
        return start_of(*self.b)

    def at(self, dt: float) -> "Prior":
        """The prior at another frame rate: accelerations and turning speeds keep their size, b and ν their values."""
        ratio = dt / self.dt
        lagging, loose = self.follow_scale
        scales = (lagging * ratio, loose)  # the second is an angle to the path, not a turn in a frame
        return replace(self, dt=dt, sigma=self.sigma * ratio**2, yaw_scale=self.yaw_scale * ratio, follow_scale=scales)


@dataclass(frozen=True, kw_only=True)
class FittedOn:
    """A split that a prior was fitted on: its files with their SHA-256, laws of heads, and how much they say."""

    split: str
    files: tuple[tuple[str, ...], ...]
    seed: int
    people: int
    second_differences: int
    heads: tuple[str, ...]
    yaw_increments: int
    nats_per_second_difference: float


@dataclass(frozen=True, kw_only=True)
class PriorFile:
    """A file in ``priors/``."""

    prior: Prior
    fitted_on: tuple[FittedOn, ...]


PRIORS = ("default", "without-hotel", "without-eth")
"""Names of the fitted priors."""


@cache
def get_prior(name: str) -> Prior:
    """The fitted prior called ``name``.

    Raises
    ------
    UnknownNameError
        If there is none; the nearest name is suggested.
    """
    if name not in PRIORS:
        raise UnknownNameError("prior", name, PRIORS)
    return read_bundled("vbbench_baselines", f"joint_map/priors/{name}.toml", PriorFile, "top level").prior


_HOTEL = (
    "9caa771bb9153d6b809dd0916b6f86761b641e6bbb15e766c1de3133fbbb7fcf",  # biwi_hotel.txt
    "2b8577595204a6b780b80258fd50da35adb7293e3e06ad6f8e1b60965e7dde6e",  # seq_hotel/obsmat.txt
)
_ETH = (
    "cf8d3fd342a15f409ebc2a1fc76b91a0f06390bd21f1e11410f3859331ab082b",  # biwi_eth.txt
    "d452ae2185ecb1164c2fdf31e75f6236f4c2ffc02c751a6b2ae921740cbc60d1",  # seq_eth/obsmat.txt, read by eth-15fps
)
"""SHA-256 of every public file of the two recordings that the default prior was fitted on."""


def variants_held_out(kind: str) -> dict[str, str]:
    """For each file of a recording that the default prior was fitted on, the variant of ``kind`` that never saw it."""
    place = f"vbbench_baselines.joint_map.priors.left_out:{kind}"
    return dict.fromkeys(_HOTEL, f"{place}WithoutHotel") | dict.fromkeys(_ETH, f"{place}WithoutEth")
