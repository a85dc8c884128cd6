"""PyTorch datasets: the same samples in the same order with any number of workers, and training that goes on."""

import re
import runpy
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vbbench import Dataset, PanoramaCamera, score, solve
from vbbench.errors import VbbenchError
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.training import FolderSamples, GeneratedSamples, Sample
from vbbench.training.sources import Source

torch = pytest.importorskip("torch", reason="needs the extra torch")
pytestmark = pytest.mark.extra

OPTIONS = Options(simulation=Simulation(people=(5, 8)))
DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def crowd(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    options = Options(camera=PanoramaCamera(), limit=9, seed=2)
    return generate("demo", tmp_path_factory.mktemp("torch") / "crowd", options)


@pytest.fixture(params=["folder", "generator"])
def source(request: pytest.FixtureRequest, crowd: Dataset) -> Source:
    """23 or so windows of a folder, or 11 simulated sequences."""
    return (
        FolderSamples(crowd.folder, frames=8)
        if request.param == "folder"
        else GeneratedSamples("sim", OPTIONS, stop=11)
    )


def places(batches: Any) -> list[tuple[int, int]]:
    """Which windows came, in their order."""
    return [place for b in batches for place in zip(b.index.tolist(), b.start.tolist(), strict=True)]


def feed(source: Source, **asked: Any) -> Any:
    from vbbench.training.torch import Feed

    return Feed(source, 4, **asked)


def test_any_number_of_workers_gives_every_sample_once_in_one_order(source: Source) -> None:
    assert source.size
    alone = places(feed(source, seed=3))
    assert sorted(alone) == sorted(places(feed(source, seed=None)))
    assert len(set(alone)) == source.size
    for workers in (1, 2):
        assert places(feed(source, seed=3, workers=workers)) == alone


def test_batches_hold_the_same_numbers_whoever_made_them(crowd: Dataset) -> None:
    source = FolderSamples(crowd.folder, frames=8)
    for a, b in zip(feed(source), feed(source, workers=2), strict=True):
        for name, values in vars(a).items():
            torch.testing.assert_close(values, getattr(b, name), rtol=0, atol=0)


@pytest.mark.slow
@pytest.mark.parametrize("start", ["spawn", "forkserver"])
def test_workers_may_be_started_anew(source: Source, start: str) -> None:
    assert places(feed(source, workers=2, start=start)) == places(feed(source))


def test_every_epoch_has_an_order_of_its_own_that_the_seed_decides(source: Source) -> None:
    first = feed(source)
    epochs = [places(first) for _ in range(3)]
    assert epochs[0] != epochs[1] != epochs[2]
    assert [sorted(epoch) for epoch in epochs] == [sorted(epochs[0])] * 3
    again, other = feed(source), feed(source, seed=1)
    assert [places(again) for _ in range(3)] == epochs
    assert places(other) != epochs[0]


@pytest.mark.parametrize("workers", [0, 2])
def test_a_feed_goes_on_where_it_stopped(source: Source, workers: int) -> None:
    whole, left = feed(source), feed(source, workers=workers)
    wanted = places(whole) + places(whole)
    loop = iter(left)
    had = places([next(loop), next(loop)])
    state = left.state_dict()
    assert state["batch"] == 2
    resumed = feed(source)
    resumed.load_state_dict(state)
    rest = [places(resumed) + places(resumed), places(left) + places(left)]
    assert [had + one for one in rest] == [wanted, wanted]
    with pytest.raises(VbbenchError, match="cannot go on with"):
        feed(source, seed=5).load_state_dict(state)


def test_an_endless_source_is_fed_for_ever() -> None:
    endless = GeneratedSamples("sim", OPTIONS)
    batches = zip(range(4), feed(endless, workers=2), strict=False)
    assert places(batch for _, batch in batches) == [(number, 0) for number in range(16)]
    with pytest.raises(TypeError, match="has no length"):
        len(feed(endless))


def test_ranks_share_an_epoch_in_equal_numbers_of_batches(source: Source) -> None:
    assert source.size
    shares = [places(feed(source, rank=rank, world_size=2, seed=1)) for rank in range(2)]
    assert not set(shares[0]) & set(shares[1])
    rounds = -(-source.size // 4) // 2
    assert [-(-len(share) // 4) for share in shares] == [rounds, rounds]
    assert sum(map(len, shares)) >= min(source.size, 8 * rounds - 3)
    with pytest.raises(VbbenchError, match="rank 2 of 2"):
        feed(source, rank=2, world_size=2)
    with pytest.raises(VbbenchError, match=rf"{source.size} samples are too few for {source.size} ranks with batches"):
        feed(source, rank=0, world_size=source.size)


def test_a_dataset_is_read_by_number_and_by_batch(crowd: Dataset) -> None:
    from torch.utils.data import DataLoader

    from vbbench.training.torch import SampleDataset, collate

    source = FolderSamples(crowd.folder)
    dataset = SampleDataset(source)
    assert len(dataset) == len(list(dataset)) == len(crowd)
    np.testing.assert_array_equal(dataset[-1].poses.numpy(), source[len(crowd) - 1].poses)
    batch = next(iter(DataLoader(dataset, 9, collate_fn=collate)))
    assert batch.boxes.shape == (9, *torch.tensor([one.seen.shape for one in dataset]).amax(0).tolist(), 3)
    assert batch.boxes.dtype == torch.float32
    with pytest.raises(VbbenchError, match="these samples have no end"):
        len(SampleDataset(GeneratedSamples("sim", OPTIONS)))


def test_a_batch_goes_to_a_device_as_a_whole(crowd: Dataset) -> None:
    batch = next(iter(feed(FolderSamples(crowd.folder))))
    moved = batch.to("meta", non_blocking=True)
    assert isinstance(moved, Sample)
    assert {values.device.type for values in vars(moved).values()} == {"meta"}


def test_the_pages_network_trains_and_solves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copyfile(DOCS / "examples" / "learn.py", tmp_path / "docs_learn.py")
    monkeypatch.syspath_prepend(str(tmp_path))
    module = runpy.run_path(str(tmp_path / "docs_learn.py"))
    module["train"](steps=8, batch_size=8, workers=0)
    said = [float(number) for number in re.findall(r"held out: camera ([.\d]+) m", capsys.readouterr().out)]
    assert said[-1] < said[0]
    dataset = generate("sim", tmp_path / "sim", Options(tier="noisy", limit=2))
    for protocol in ("sequential", "rollout"):
        answer = solve(dataset, "docs_learn:Learned", protocol, tmp_path / protocol)
        assert score(answer, dataset.folder).coverage == 1.0


def test_the_pages_short_examples_run(crowd: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hotel").symlink_to(crowd.folder)
    examples = re.findall(r"^```py\n(.*?)^```", (DOCS / "torch.md").read_text("utf-8"), flags=re.M | re.S)
    exec(compile("\n".join(examples), "torch.md", "exec"), {"__name__": "example"})  # noqa: S102
