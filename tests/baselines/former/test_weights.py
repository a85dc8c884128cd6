"""The weights of the learned solver: only those of their recipe are read; PyTorch and NumPy answer alike."""

from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib.solver_runs import CAMERAS, problem_of, see, walk
from vbbench.errors import FileError
from vbbench_baselines.former.inference import bundled_weights, read_weights
from vbbench_baselines.former.layers import Network, first_weights
from vbbench_baselines.former.network import Birdifier
from vbbench_baselines.former.operations import Operations
from vbbench_baselines.former.pose_fit import Measured, Motion
from vbbench_baselines.former.scene import LocalGiven, sights_of
from vbbench_baselines.former.state import nothing_seen

ONE = np.float32(1.0)


def packed(folder: Path, *, told: str | None = None, **changes: Any) -> Path:
    """A file of weights with its recipe, in which its SHA-256 may be another."""
    path = folder / "some.npz"
    made = {name: values.astype(np.float32) for name, values in first_weights(np.random.default_rng(0)).items()}
    np.savez(path, **made | changes)  # type: ignore[arg-type]
    told = sha256(path.read_bytes()).hexdigest() if told is None else told
    path.with_suffix(".toml").write_text(f'sha256 = "{told}"\n[training]\nwindows = 3\n"one-step people" = 0.1\n')
    return path


def test_weights_are_those_of_their_recipe_and_bundled_ones_small_and_read_once(tmp_path: Path) -> None:
    weights = read_weights(packed(tmp_path))
    assert all(values.dtype == np.float32 and not values.flags.writeable for values in weights.values())
    weights = bundled_weights()
    assert weights is bundled_weights()
    assert sum(values.nbytes for values in weights.values()) < 1e6


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"told": "0" * 64}, r"some.npz: its SHA-256 is \w{64}, and its recipe says 0{64}; put there what"),
        ({"own_trust.bias": np.zeros(9)}, "'own_trust.bias' has the shape"),
    ],
)
def test_other_weights_are_one_clear_error(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    path = packed(tmp_path, **changes)
    with pytest.raises(FileError, match=message) as caught:
        read_weights(path)
    assert str(caught.value).count("\n") == 0
    path.unlink()
    with pytest.raises(FileError, match="cannot be read; put there what 'vbbench train vb-former' made, or install"):
        read_weights(path)


@pytest.mark.extra
@pytest.mark.parametrize("people", [0, 1, 5])
@pytest.mark.parametrize("sure", [None, 0.0, 1.0])
def test_pytorch_and_numpy_give_the_same_answers(people: int, sure: float | None) -> None:
    torch = pytest.importorskip("torch", reason="needs the extra torch")
    from vbbench_baselines.former.training.following import TensorOperations

    def tensor(values: Any) -> Any:
        if isinstance(values, tuple):
            return type(values)(*map(tensor, values))
        return None if values is None else torch.from_numpy(np.array(values))

    sequence = see(walk(0, people=people), CAMERAS[0], 1.0)
    weights = {name: values.astype(np.float32) for name, values in first_weights(np.random.default_rng(0)).items()}
    network = Birdifier(Network(Operations(), weights))
    tensors = Birdifier(Network(TensorOperations(), {name: tensor(values) for name, values in weights.items()}))
    state = nothing_seen(lambda *n: np.zeros(n, np.float32), lambda *n: np.zeros(n, np.complex64), people)
    other = tensor(state)
    problem, still = problem_of(sequence, CAMERAS[0], 1.0), Motion(np.complex64(0.0), np.float32(0.0))
    moved = Motion(np.complex64(0.1 + 0.01j), np.float32(0.02))
    measured = None if sure is None else Measured(moved, np.array([9.0, 16.0, 25.0], np.float32), np.float32(sure))
    for t, boxes in enumerate(sequence.observations):
        placed = ((np.arange(people) % 3 == 0) & (t == 2)).astype(np.float32)
        given = LocalGiven(np.full(people, 3.0 + 1.0j, np.complex64), placed, still, ONE * (t == 0), measured)
        frame = sights_of(problem, boxes), given, np.float32(0.4), np.float32(0.04)
        with np.errstate(all="ignore"):
            state, found = network.advance(state, *frame)
        other, same = tensors.advance(other, *map(tensor, frame))
        assert all(values.dtype in (np.float32, np.complex64) for part in state for values in part)
        np.testing.assert_allclose(found.places, same.places.numpy(), atol=1e-4)
        np.testing.assert_allclose(found.motion.step, same.motion.step.numpy(), atol=1e-4)
        np.testing.assert_allclose(found.pose_spread, same.pose_spread.numpy(), atol=1e-3)
        np.testing.assert_allclose(found.place_spread, same.place_spread.numpy(), atol=1e-3)
