"""Training vb-former with PyTorch: what is given, that it learns, and that it can be stopped."""

import shutil
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from tests.baselines.former.training.conftest import TINY
from vbbench.errors import VbbenchError
from vbbench.protocol import PROTOCOLS
from vbbench_baselines.former.inference import read_weights
from vbbench_baselines.former.solver import VbFormer
from vbbench_baselines.former.training.crowds import Crowds, make_crowds

torch = pytest.importorskip("torch", reason="needs the extra torch")
pytestmark = pytest.mark.extra

from vbbench_baselines.former.training.batches import batch_of  # noqa: E402
from vbbench_baselines.former.training.loop import Arrays, Asked, Training, draw_curve, held_out_batches, train  # noqa: E402
from vbbench_baselines.former.training.recipe import Phase  # noqa: E402


@pytest.fixture(scope="module")
def trained(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a training that has ended."""
    return train(tmp_path_factory.mktemp("former") / "whole", Asked(recipe=TINY), crowds=folder).parent


def test_what_is_given_and_counted_is_what_protocols_say(crowds: Crowds) -> None:
    rng = np.random.default_rng(5)
    for number, name in enumerate(PROTOCOLS):
        recipe = replace(TINY, protocols=dict.fromkeys(PROTOCOLS, 0.0) | {name: 1.0})
        batch = batch_of(rng, crowds, recipe, Phase(frames=8, share=1.0), TINY.size[1])
        seen, given, scored = (values.numpy() > 0.5 for values in (batch.sights.seen, batch.given, batch.scored))
        assert (batch.protocol.numpy() == number).all()
        assert not (given & ~seen).any()
        assert not (scored & given).any()
        assert not scored[:, :2].any()
        assert given[:, 2:].any() == (name == "sequential")
        assert given[:, :2].any() == (name != "cold-start")
        assert abs(batch.place.numpy()[:, 0]).max() < 1e-6
        assert abs(batch.yaw.numpy()[:, 0]).max() < 1e-6


def test_stopped_or_with_more_processes_a_training_ends_with_the_same_weights(
    folder: Path, trained: Path, tmp_path: Path
) -> None:
    whole = trained / "weights.npz"

    def stopped(self: Training, checkpoint: Path, tell: object) -> Arrays:
        for batch in islice(self._feed.drawn(0, 1), 2):
            self._learn(batch)
        self.save(checkpoint)
        raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Training, "run", stopped)
        with pytest.raises(KeyboardInterrupt):
            train(tmp_path / "stopped", Asked(recipe=TINY), crowds=folder)
    again = train(tmp_path / "stopped", Asked(recipe=TINY), crowds=folder)
    with np.load(whole) as a, np.load(again) as b:
        assert all(np.array_equal(a[name], b[name]) for name in a.files)
    ahead = train(tmp_path / "ahead", Asked(recipe=TINY), crowds=folder, jobs=3)
    assert ahead.read_bytes() == whole.read_bytes()
    other = train(tmp_path / "other", Asked(recipe=TINY, seed=1), crowds=folder)
    with np.load(whole) as a, np.load(other) as b:
        assert not np.array_equal(a["trust.weights"], b["trust.weights"])
    assert VbFormer(weights=read_weights(whole)).weights
    log = (trained / "log.csv").read_text().splitlines()
    assert log[0].startswith("batches,windows,")
    assert len(log) == 5  # each of its four batches; of long trainings every hundredth
    with Image.open(tmp_path / "stopped" / "curve.png") as curve:
        assert curve.size[0] > 500


def test_the_curve_shows_the_whole_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Losses and held-out errors of every row, those before a stop included."""
    figures: list[Figure] = []
    monkeypatch.setattr("vbbench_baselines.former.training.loop.save_picture", lambda figure, _: figures.append(figure))
    log = [
        {"windows": 100 * n, "seconds": 2.0 * n, "loss": 1.0 / n, "rollout people": 0.9 / n, "one-step people": 0.1}
        for n in range(1, 6)
    ]
    draw_curve(log, 740, tmp_path / "curve.png")
    loss, held_out = figures[0].axes
    assert loss.lines[0].get_xdata().tolist() == [100, 200, 300, 400, 500]
    assert loss.lines[0].get_ydata().tolist() == [row["loss"] for row in log]
    assert [text.get_text() for text in held_out.get_legend().get_texts()] == ["one-step", "rollout"]
    assert held_out.lines[1].get_ydata().tolist() == [row["rollout people"] for row in log]
    assert any("500 windows of 740 sequences, 10 s" in text.get_text() for text in figures[0].texts)


@pytest.mark.parametrize("device", ["cpu", *["cuda"] * torch.cuda.is_available()])
def test_every_device_learns_the_same_though_batches_there_have_room_for_more(crowds: Crowds, device: str) -> None:
    plain, other = Training(TINY, crowds, (), seed=0), Training(TINY, crowds, (), seed=0, device=device)
    for seed in range(2):
        for size in TINY.size:
            batch, filled = (
                batch_of(np.random.default_rng(seed), crowds, TINY, Phase(frames=6, share=1.0), size, filled=filled)
                for filled in (False, True)
            )
            assert filled.true.shape == (*batch.true.shape[:2], size.most)
            loss, same = other._gradients(filled).loss.detach(), plain._differentiate(batch).loss.detach()
            assert float(loss) == pytest.approx(float(same), 1e-4)
            for name, values in plain.weights.items():
                assert other.weights[name].grad.cpu().numpy() == pytest.approx(values.grad.numpy(), rel=1e-2, abs=1e-5)


@pytest.mark.slow
def test_training_learns(folder: Path, tmp_path: Path) -> None:
    crowds = make_crowds(TINY, folder, TINY.seed)
    protocols = dict.fromkeys(PROTOCOLS, 0.0) | {"one-step": 1.0}
    recipe = replace(TINY, windows=800, held_out=64, protocols=protocols)
    training = Training(recipe, crowds, held_out_batches(recipe, crowds), seed=0)
    before = training.look(training.weights)["one-step camera"]
    training.run(tmp_path / "checkpoint.pt", lambda row: None)
    assert training.look(training.mean)["one-step camera"] < 0.8 * before


def test_jobs_are_checked_before_anything_is_made(tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match="jobs is a number of processes"):
        train(tmp_path / "never", Asked(recipe=TINY), jobs=-2)
    assert not (tmp_path / "never").exists()


def test_a_folder_of_something_else_is_left_alone(folder: Path, trained: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    with pytest.raises(VbbenchError, match="not the folder of a training"):
        train(tmp_path / "mine", Asked(recipe=TINY), crowds=folder)
    shutil.copytree(trained, tmp_path / "run")
    with pytest.raises(VbbenchError, match="another seed"):
        train(tmp_path / "run", Asked(recipe=TINY, seed=3), crowds=folder)
    (tmp_path / "run" / "weights.npz").unlink()  # made again
    with np.load(train(tmp_path / "run", Asked(recipe=TINY), crowds=folder)) as weights:
        assert weights.files


def test_what_is_damaged_or_cannot_be_is_one_line(crowds: Crowds, folder: Path, tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match="PyTorch cannot use the device 'nosuch'"):
        train(tmp_path / "device", Asked(recipe=TINY), crowds=folder, device="nosuch")
    with pytest.raises(VbbenchError, match=r"hardly any sequence of the recipe has 900 frames"):
        batch_of(np.random.default_rng(0), crowds, TINY, Phase(frames=900, share=1.0), TINY.size[0])
    for name, mark in (
        ("checkpoint.pt", "is damaged; remove it, and the training begins again"),
        ("training.json", "is damaged"),
    ):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Training, "run", stop)
            with pytest.raises(KeyboardInterrupt):
                train(tmp_path / name, Asked(recipe=TINY), crowds=folder)
        (tmp_path / name / name).write_bytes(b'{"a')
        with pytest.raises(VbbenchError, match=mark):
            train(tmp_path / name, Asked(recipe=TINY), crowds=folder)
    copy = Path(shutil.copytree(folder, tmp_path / "crowds"))
    for file in copy.glob("*.npz"):
        file.write_bytes(file.read_bytes()[:500])
    with pytest.raises(VbbenchError, match="is damaged; remove it, and it is regenerated"):
        make_crowds(TINY, copy, TINY.seed)


def stop(self: Training, checkpoint: Path, tell: object) -> Arrays:
    raise KeyboardInterrupt
