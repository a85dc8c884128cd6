"""The training feed: the sequences that `generate` would write, shared out among workers without overlap."""

import subprocess
import sys
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from vbbench.errors import VbbenchError
from vbbench.generation import generate
from vbbench.generation.datasets import stream
from vbbench.generation.generator import Options, Simulation
from vbbench.training.sources import GeneratedSamples

OPTIONS = Options(simulation=Simulation(people=(5, 8)), tier="noisy")


def test_the_stream_holds_what_generate_writes(tmp_path: Path) -> None:
    written = generate("sim", tmp_path / "sim", Options(simulation=OPTIONS.simulation, tier="noisy", limit=4))
    for sequence, data in zip(written.sequences(), stream("sim", OPTIONS), strict=False):
        np.testing.assert_array_equal(sequence.observations, data.sequence.observations)
        np.testing.assert_array_equal(written.truth(sequence).poses, data.truth.poses)


def test_the_stream_does_not_end_with_the_split() -> None:
    short = Options(simulation=Simulation(people=(5,), sequences=2))
    assert [data.sequence.index for data in islice(stream("sim", short), 5)] == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("shards", [1, 2, 3, 7])
def test_shards_share_the_stream_out(shards: int) -> None:
    got = [[d.sequence.index for d in stream("sim", OPTIONS, stop=10, shard=n, shards=shards)] for n in range(shards)]
    assert sorted(index for part in got for index in part) == list(range(10))


def test_a_stream_goes_on_where_it_stopped() -> None:
    whole = [data.sequence.observations for data in stream("sim", OPTIONS, stop=6)]
    rest = [data.sequence.observations for data in stream("sim", OPTIONS, first=4, stop=6)]
    for a, b in zip(whole[4:], rest, strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_split_that_is_not_simulated_ends() -> None:
    assert sum(1 for _ in stream("demo", Options(limit=3))) == 3
    assert [d.sequence.index for d in stream("demo", Options(limit=3), stop=10, shard=1, shards=2)] == [1]


@pytest.mark.parametrize("split", ["demo", "sim"])
def test_a_stride_leaves_out_what_generate_leaves_out(tmp_path: Path, split: str) -> None:
    options = Options(limit=9, stride=3, tier="noisy")
    written = generate(split, tmp_path / split, options)
    assert len(written) == 3
    made = [data.sequence.observations for data in stream(split, options, stop=3 if split == "sim" else None)]
    samples = GeneratedSamples(split, options)
    assert samples.size == (None if split == "sim" else 3)
    for number, sequence in enumerate(written.sequences()):
        np.testing.assert_array_equal(made[number], sequence.observations)
        np.testing.assert_array_equal(samples[number].boxes, np.nan_to_num(sequence.observations).astype(np.float32))
    assert len(made) == 3


@pytest.mark.parametrize(("shard", "shards"), [(2, 2), (-1, 2), (0, 0)])
def test_a_shard_that_there_is_not(shard: int, shards: int) -> None:
    with pytest.raises(VbbenchError, match="shards are numbered from 0"):
        stream("sim", OPTIONS, shard=shard, shards=shards)


def test_a_stream_begins_at_a_sequence_that_there_is() -> None:
    with pytest.raises(VbbenchError, match="begins at sequence 0 or later"):
        stream("sim", OPTIONS, first=-1)


def test_without_torch_one_line_says_how_to_get_it() -> None:
    code = "import sys; sys.modules['torch'] = None\nimport vbbench.generation.datasets\nimport vbbench.training.torch"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.strip().endswith("vbbench.training.torch needs torch: python -m pip install 'vbbench[torch]'")


@pytest.mark.slow
def test_the_plain_stream_does_not_import_torch() -> None:
    code = (
        "import sys\nfrom vbbench.generation.datasets import stream\nnext(stream())\nsys.exit('torch' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
