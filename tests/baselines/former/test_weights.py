"""The weights of the learned solver: only those of their recipe are read; PyTorch and C++ answer alike."""

from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib.solver_runs import CAMERAS, problem_of, see, walk
from vbbench.errors import FileError
from vbbench_baselines.former.inference import Inference, bundled_weights, nothing_remembered, read_weights
from vbbench_baselines.former.layers import Network, first_weights
from vbbench_baselines.former.network import Birdifier
from vbbench_baselines.former.pose_fit import Motion
from vbbench_baselines.former.scene import Sights, Told, sights_of
from vbbench_baselines.former.state import nothing_seen

ONE = np.float32(1.0)


def packed(folder: Path, *, pure: bool = False, told: str | None = None) -> Path:
    """A file of weights with its recipe, in which its SHA-256 may be another."""
    path = folder / "some.npz"
    made = {name: values.astype(np.float32) for name, values in first_weights(np.random.default_rng(0), False).items()}
    np.savez(path, **made)  # type: ignore[arg-type]
    told = sha256(path.read_bytes()).hexdigest() if told is None else told
    text = f'sha256 = "{told}"\npure = {str(pure).lower()}\n[training]\nwindows = 3\n"one-step people" = 0.1\n'
    path.with_suffix(".toml").write_text(text)
    return path


def test_weights_are_those_of_their_recipe(tmp_path: Path) -> None:
    weights = read_weights(packed(tmp_path))
    assert all(values.dtype == np.float32 and not values.flags.writeable for values in weights.values())


@pytest.mark.parametrize("solver", ["vb-former", "vb-former-pure"])
def test_bundled_weights_are_small_and_are_read_once(solver: str) -> None:
    weights = bundled_weights(solver)
    assert weights is bundled_weights(solver)
    assert sum(values.nbytes for values in weights.values()) < 1e6


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"told": "0" * 64}, r"some.npz: its SHA-256 is \w{64}, and its recipe says 0{64}; put there what"),
        ({"pure": True}, "'own_trust.bias' has the shape"),
    ],
)
def test_other_weights_are_one_clear_error(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(FileError, match=message) as caught:
        read_weights(packed(tmp_path, **changes))
    assert str(caught.value).count("\n") == 0


def test_missing_weights_are_one_clear_error(tmp_path: Path) -> None:
    path = packed(tmp_path)
    path.unlink()
    with pytest.raises(FileError, match="cannot be read; put there what 'vbbench train vb-former' made, or install"):
        read_weights(path)


@pytest.mark.extra
@pytest.mark.parametrize("pure", [False, True])
def test_pytorch_and_cpp_give_the_same_answers(pure: bool) -> None:
    torch = pytest.importorskip("torch", reason="needs the extra torch")
    from vbbench_baselines.former.training.following import TensorOperations

    def tensor(values: Any) -> Any:
        return torch.from_numpy(np.array(values))

    truth = walk(0, people=5)
    sequence = see(truth, CAMERAS[0], 1.0)
    weights = {
        name: values.astype(np.float32) for name, values in first_weights(np.random.default_rng(0), pure).items()
    }
    network = Inference(weights)
    tensors = Birdifier(Network(TensorOperations(), {name: tensor(values) for name, values in weights.items()}), pure)
    remembered = nothing_remembered(5)
    other = nothing_seen(lambda *n: torch.zeros(n), lambda *n: torch.zeros(n, dtype=torch.complex64), 5)
    problem, still = problem_of(sequence, CAMERAS[0], 1.0), Motion(np.complex64(0.0), np.float32(0.0))
    for t, boxes in enumerate(sequence.observations):
        sights = sights_of(problem, boxes)
        told = Told(np.zeros(5, np.complex64), np.zeros(5, np.float32), still, ONE * (t == 0))
        as_tensors = Told(tensor(told.places), tensor(told.placed), Motion(*map(tensor, still)), tensor(told.moved))
        found = network.advance(remembered, sights, told, 0.4, 0.04)
        seen = Sights(*map(tensor, sights))
        other, same = tensors.advance(other, seen, as_tensors, tensor(np.float32(0.4)), tensor(np.float32(0.04)))
        np.testing.assert_allclose(found.places, same.places.numpy(), atol=1e-4)
        np.testing.assert_allclose(found.motion.step, same.motion.step.numpy(), atol=1e-4)
        np.testing.assert_allclose(found.pose_spread, same.pose_spread.numpy(), atol=1e-3)
        np.testing.assert_allclose(found.place_spread, same.place_spread.numpy(), atol=1e-3)
