"""Streams of random numbers: no key is used twice, and all come from one place."""

import re
from pathlib import Path

import numpy as np

from vbbench.streams import Stream, random_stream

ROOT = Path(__file__).parents[1]
PRODUCT = [
    path for package in ("vbbench", "generators", "renderers", "baselines") for path in (ROOT / package).rglob("*.py")
]
JITTER = "generators/vbbench_generators/recordings/loading.py"
"""Draws from the seed alone, in committed datasets: its key is a scene's number."""


def test_no_key_is_used_twice() -> None:
    assert len(Stream) == len(Stream.__members__)


def test_no_other_file_spawns_a_stream() -> None:
    spawning = {str(path.relative_to(ROOT)) for path in PRODUCT if re.search(r"spawn_key\s*=", path.read_text())}
    assert spawning == {"vbbench/streams.py", JITTER}


def test_streams_of_one_sequence_differ() -> None:
    drawn = {tuple(random_stream(5, 7, stream).integers(2**32, size=4)) for stream in (None, *Stream)}
    assert len(drawn) == len(Stream) + 1


def test_a_stream_is_the_one_of_numpy() -> None:
    wanted = np.random.default_rng(np.random.SeedSequence([5, 7], spawn_key=(3,)))
    assert (random_stream(5, 7, Stream.GRID).random(3) == wanted.random(3)).all()
