"""The streams of random numbers of a dataset: one enum of every key that follows ``[seed, index]``."""

from enum import IntEnum

import numpy as np


class Stream(IntEnum):
    """What a stream of random numbers draws, by its spawn key after ``[seed, index]``; a key is used once.

    A new stream takes a new number. A changed number changes datasets: raise the `REVISION` of their generator.
    """

    HEIGHTS = 1
    """People's heights in a recorded scene."""
    WORLD = 2
    """The world that a sequence is turned and shifted to, and the numbers of its tracks."""
    GRID = 3
    """Places within the cells of the grid that a recording was rounded to."""
    LOOK = 5
    """How a walker's head turns."""
    WINDOW = 6
    """The window of a longer sequence that a training sample shows."""


def random_stream(seed: int, index: int, stream: Stream | None = None) -> np.random.Generator:
    """A generator of random numbers that follow from the seed, an index and the stream alone.

    Parameters
    ----------
    seed : the dataset's seed.
    index : number of a sequence, or of a scene.
    stream : what is drawn; ``None`` for the sequence's own stream.
    """
    key = () if stream is None else (int(stream),)
    return np.random.default_rng(np.random.SeedSequence([seed, index], spawn_key=key))
