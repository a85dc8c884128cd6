"""`SimStream`: tensors of simulated sequences, no sequence twice, whatever the number of workers."""

from typing import Any

import numpy as np
import pytest

from vbbench.generation.generator import Options, Simulation
from vbbench.generation.stream import stream

torch = pytest.importorskip("torch", reason="needs the extra torch")
pytestmark = pytest.mark.extra

OPTIONS = Options(simulation=Simulation(people=(5, 8)))


def loader(workers: int, **options: Any) -> Any:
    from torch.utils.data import DataLoader

    from vbbench.generation.torch import SimStream, collate

    return DataLoader(SimStream(OPTIONS, **options), batch_size=3, num_workers=workers, collate_fn=collate)


@pytest.mark.parametrize("workers", [0, 1, 2])
def test_every_sequence_comes_once_and_is_the_same(workers: int) -> None:
    got = {
        int(i): o
        for batch in loader(workers, stop=10)
        for i, o in zip(batch["index"], batch["observations"], strict=True)
    }
    assert sorted(got) == list(range(10))
    for data in stream("sim", OPTIONS, stop=10):
        people = data.sequence.observations.shape[1]
        found = got[data.sequence.index][:, :people].numpy()
        np.testing.assert_array_equal(found, data.sequence.observations.astype(np.float32))


def test_ranks_and_workers_do_not_overlap() -> None:
    indices = [
        int(index)
        for rank in range(2)
        for batch in loader(2, stop=9, rank=rank, world_size=2)
        for index in batch["index"]
    ]
    assert sorted(indices) == list(range(9))


def test_an_example_has_everything_in_tensors() -> None:
    from vbbench.generation.torch import SimStream

    example = next(iter(SimStream(OPTIONS, dtype=torch.float64)))
    data = next(stream("sim", OPTIONS))
    frames, people = data.sequence.observed.shape
    shapes = {name: tuple(values.shape) for name, values in example.items()}
    assert shapes == {
        "index": (),
        "tracks": (people,),
        "observations": (frames, people, 3),
        "given_poses": (frames, 3),
        "given_positions": (frames, people, 2),
        "poses": (frames, 3),
        "positions": (frames, people, 2),
        "heights": (people,),
    }
    np.testing.assert_array_equal(example["poses"].numpy(), data.truth.poses)


def test_collate_pads_people_with_nan() -> None:
    from vbbench.generation.torch import SimStream, collate

    examples = list(SimStream(OPTIONS, stop=4))
    batch = collate(examples)
    most = max(len(example["tracks"]) for example in examples)
    least = min(examples, key=lambda example: len(example["tracks"]))
    row, people = int(least["index"]), len(least["tracks"])
    assert batch["observations"].shape == (4, 20, most, 3)
    assert people < most
    assert torch.isnan(batch["positions"][row, :, people:]).all()
    assert (batch["tracks"][row, people:] == -1).all()
    torch.testing.assert_close(batch["positions"][row, :, :people], least["positions"], equal_nan=True)
