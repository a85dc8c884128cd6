"""The joint solvers with priors that never saw the split they are tested on.

A solver is not told which split it has, so that it cannot choose for itself. ``map-causal`` and ``map-batch`` take the
prior of all recordings at hand, and name (``held_out``) what is to be run on these recordings instead.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.prior import Prior, get_prior


@dataclass(kw_only=True)
class CausalWithoutHotel(MapCausal):
    """`MapCausal` for Hotel."""

    held_out: ClassVar[Mapping[str, str]] = {}
    prior: Prior = field(default_factory=lambda: get_prior("without-hotel"))


@dataclass(kw_only=True)
class CausalWithoutEth(MapCausal):
    """`MapCausal` for ETH, at either speed."""

    held_out: ClassVar[Mapping[str, str]] = {}
    prior: Prior = field(default_factory=lambda: get_prior("without-eth"))


@dataclass(kw_only=True)
class BatchWithoutHotel(MapBatch):
    """`MapBatch` for Hotel."""

    held_out: ClassVar[Mapping[str, str]] = {}
    prior: Prior = field(default_factory=lambda: get_prior("without-hotel"))


@dataclass(kw_only=True)
class BatchWithoutEth(MapBatch):
    """`MapBatch` for ETH, at either speed."""

    held_out: ClassVar[Mapping[str, str]] = {}
    prior: Prior = field(default_factory=lambda: get_prior("without-eth"))
