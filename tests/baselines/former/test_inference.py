"""The learned solver's network in C++ computes what NumPy computes with the network that is trained."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from tests.lib.numpy_operations import NumpyOperations
from tests.lib.solver_runs import CAMERAS, problem_of, see, walk
from vbbench.errors import VbbenchError
from vbbench_baselines.former.inference import Inference, Remembered, nothing_remembered
from vbbench_baselines.former.layers import Network, first_weights
from vbbench_baselines.former.network import Answer, Birdifier
from vbbench_baselines.former.pose_fit import Measured, Motion
from vbbench_baselines.former.scene import Sights, Told, sights_of
from vbbench_baselines.former.solver import VbFormer, bundled_inference
from vbbench_baselines.former.state import State, nothing_seen

ONE = np.float32(1.0)


def some_weights(*, pure: bool) -> dict[str, Any]:
    return {name: values.astype(np.float32) for name, values in first_weights(np.random.default_rng(1), pure).items()}


def measured(sure: bool) -> Measured:
    motion, information = Motion(np.complex64(0.1 + 0.01j), np.float32(0.02)), np.array([9.0, 16.0, 25.0], np.float32)
    return Measured(motion, information, np.float32(sure))


def frames_of(people: int, said: Measured | None = None) -> Iterator[tuple[Sights, Told]]:
    """A walk of which nothing is given but the first pose, and some places in the third frame."""
    sequence = see(walk(0, people=people), CAMERAS[0], 1.0)
    problem, still = problem_of(sequence, CAMERAS[0], 1.0), Motion(np.complex64(0.0), np.float32(0.0))
    for t, boxes in enumerate(sequence.observations):
        placed = ((np.arange(people) % 3 == 0) & (t == 2)).astype(np.float32)
        told = Told(np.full(people, 3.0 + 1.0j, np.complex64), placed, still, ONE * (t == 0), said)
        yield sights_of(problem, boxes), told


def follow(network: Inference, people: int, said: Measured | None = None) -> Iterator[tuple[Remembered, Answer]]:
    """What is remembered, and the answer, after each frame of a walk."""
    remembered = nothing_remembered(people)
    for sights, told in frames_of(people, said):
        yield remembered, network.advance(remembered, sights, told, 0.4, 0.04)


def places(network: Inference, people: int) -> list[Any]:
    return [answer.places for _, answer in follow(network, people)]


def follow_with_numpy(network: Birdifier, people: int, said: Measured | None) -> Iterator[tuple[State, Answer]]:
    state = nothing_seen(lambda *n: np.zeros(n, np.float32), lambda *n: np.zeros(n, np.complex64), people)
    for sights, told in frames_of(people, said):
        with np.errstate(all="ignore"):
            state, answer = network.advance(state, sights, told, np.float32(0.4), np.float32(0.04))
        yield state, answer


def assert_alike(found: Any, wanted: Any) -> None:
    np.testing.assert_allclose(found, wanted, rtol=1e-3, atol=2e-4)


@pytest.mark.parametrize("pure", [False, True])
@pytest.mark.parametrize("people", [0, 1, 9])
@pytest.mark.parametrize("said", [None, measured(False), measured(True)], ids=["alone", "measured", "sure"])
def test_frames_are_numpys(pure: bool, people: int, said: Measured | None) -> None:
    weights = some_weights(pure=pure)
    plain = Birdifier(Network(NumpyOperations(), weights), pure)
    both = zip(follow(Inference(weights), people, said), follow_with_numpy(plain, people, said), strict=True)
    for (remembered, answer), (state, wanted) in both:
        for name in answer._fields[2:]:
            assert_alike(getattr(answer, name), getattr(wanted, name))
        for one, other in zip((*answer.motion, *answer.rough), (*wanted.motion, *wanted.rough), strict=True):
            assert_alike(one, other)
        for records, arrays in zip(remembered, state, strict=True):
            assert records.dtype.names == arrays._fields
            for name in arrays._fields:
                assert_alike(records[name], getattr(arrays, name))


def test_sequences_that_share_a_network_do_not_disturb_one_another() -> None:
    network = Inference(some_weights(pure=False))
    alone = places(network, 5)
    both = zip(follow(network, 5), follow(network, 7), strict=True)
    for (_, found), wanted in zip((one for one, _ in both), alone, strict=True):
        np.testing.assert_array_equal(found.places, wanted)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"trust.bias": None}, "the weights 'trust.bias' are missing"),
        ({"after.gain": np.ones(7, np.float32)}, "the weights 'after.gain' have not the shape of the network"),
    ],
)
def test_weights_of_another_network_are_refused(changes: dict[str, Any], message: str) -> None:
    weights = some_weights(pure=False) | changes
    with pytest.raises(VbbenchError, match=message):
        Inference({name: values for name, values in weights.items() if values is not None})


def test_a_solver_takes_other_weights_at_its_next_start() -> None:
    solver, problem = (
        VbFormer(weights=some_weights(pure=False)),
        problem_of(see(walk(0, people=2), CAMERAS[0], 1.0), CAMERAS[0], 1.0),
    )
    used = []
    for changes in ({}, {}, {"heads": False}, {"weights": some_weights(pure=True)}, {"weights": None}):
        for name, value in changes.items():
            setattr(solver, name, value)
        solver.start(problem)
        used.append(solver._network)
    assert used[0] is used[1]
    assert len({id(network) for network in used}) == 4
    assert used[-1] is bundled_inference("vb-former", False)
