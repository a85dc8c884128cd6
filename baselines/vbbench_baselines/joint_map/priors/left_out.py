"""The joint solvers with priors that never saw the recording they are tested on.

A solver does not know what it runs on, so it cannot choose by itself. ``map-causal`` and ``map-batch`` take the prior
of all available recordings, and name in ``held_out`` what to run instead where data come from one of these files.
"""

from functools import partial

from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.prior import get_prior

CausalWithoutHotel = partial(MapCausal, prior=get_prior("without-hotel"))
BatchWithoutHotel = partial(MapBatch, prior=get_prior("without-hotel"))

CausalWithoutEth = partial(MapCausal, prior=get_prior("without-eth"))  # for ETH at either speed
BatchWithoutEth = partial(MapBatch, prior=get_prior("without-eth"))
