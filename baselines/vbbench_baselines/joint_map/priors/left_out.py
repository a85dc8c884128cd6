"""The joint solvers with priors that never saw the recording they are tested on.

A solver does not know what it runs on, so it cannot choose by itself. ``map-causal`` and ``map-batch`` take the prior
of all available recordings, and name in ``held_out`` what to run instead where data come from one of these files.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

from vbbench_baselines.common.facts import FITTED
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.prior import Prior, get_prior

_APART = ", by the variant that never saw the recording of the board"
_ON_ETH: Mapping[str, str] = {**FITTED, "trained_on": f"ETH{_APART}"}
_ON_HOTEL: Mapping[str, str] = {**FITTED, "trained_on": f"Hotel{_APART}"}
_without_hotel, _without_eth = (partial(get_prior, f"without-{name}") for name in ("hotel", "eth"))


@dataclass(kw_only=True)
class CausalWithoutHotel(MapCausal):
    """``map-causal`` with the prior of ETH alone."""

    facts: ClassVar[Mapping[str, str]] = _ON_ETH
    prior: Prior = field(default_factory=_without_hotel)


@dataclass(kw_only=True)
class BatchWithoutHotel(MapBatch):
    """``map-batch`` with the prior of ETH alone."""

    facts: ClassVar[Mapping[str, str]] = _ON_ETH
    prior: Prior = field(default_factory=_without_hotel)


@dataclass(kw_only=True)
class CausalWithoutEth(MapCausal):
    """``map-causal`` with the prior of Hotel alone, for ETH at either speed."""

    facts: ClassVar[Mapping[str, str]] = _ON_HOTEL
    prior: Prior = field(default_factory=_without_eth)


@dataclass(kw_only=True)
class BatchWithoutEth(MapBatch):
    """``map-batch`` with the prior of Hotel alone, for ETH at either speed."""

    facts: ClassVar[Mapping[str, str]] = _ON_HOTEL
    prior: Prior = field(default_factory=_without_eth)
