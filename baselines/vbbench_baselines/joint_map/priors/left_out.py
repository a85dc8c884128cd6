"""The joint solvers with priors that never saw the split they are tested on.

A solver is not told which split it has, so that it cannot choose for itself. ``map-causal`` and ``map-batch`` take the
prior of all recordings at hand, and name (``held_out``) what is to be run on these recordings instead.
"""

from functools import partial

from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.prior import get_prior

CausalWithoutHotel = partial(MapCausal, prior=get_prior("without-hotel"))
BatchWithoutHotel = partial(MapBatch, prior=get_prior("without-hotel"))

CausalWithoutEth = partial(MapCausal, prior=get_prior("without-eth"))  # for ETH at either speed
BatchWithoutEth = partial(MapBatch, prior=get_prior("without-eth"))
