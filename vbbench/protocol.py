"""Evaluation protocols: what a solver is given and when, and which rows are scored. Each is a named, frozen file."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from vbbench.errors import UnknownNameError
from vbbench.geometry import BoolArray, IntArray
from vbbench.parsing.toml_text import read_bundled
from vbbench.sequence import Given, Truth

START_FRAMES = 2
"""Frames 0 and 1 are never scored: most protocols give them."""

PROTOCOLS = ("one-step", "sequential", "rollout", "cold-start")


@dataclass(frozen=True, kw_only=True)
class Protocol:
    """One protocol file.

    Parameters
    ----------
    name, version, title, text : its name and description; name and version are printed with every score.
    given : ``arrivals`` = the first two frames and each track's first two visible frames; ``start`` = the former only;
        ``origin`` = the observer's pose in frame 0, and nobody's position.
    revealed_frames : frames of truth shown before each frame (one-step: 2), 0 for none.
    caps : metric → the mean error with which a sequence counts at most; a metric without one is not capped.
    failures : metric → the mean error above which a sequence has failed.
    """

    name: str
    version: int
    title: str
    text: str
    given: Literal["arrivals", "start", "origin"]
    revealed_frames: int
    caps: Mapping[str, float]
    failures: Mapping[str, float]

    @property
    def id(self) -> str:
        """Name and version, as printed with every score."""
        return f"{self.name}/{self.version}"

    @property
    def needs_truth(self) -> bool:
        """Whether the runner needs truth while solving."""
        return self.revealed_frames > 0

    def select_given(self, given: Given) -> Given:
        """The part that this protocol gives of the `sequential` given that a dataset stores."""
        if self.given == "origin":
            return given.keeping(np.arange(len(given.poses)) == 0, np.zeros(given.positions.shape[:2], bool))
        return given if self.given == "arrivals" else given.first_frames(START_FRAMES)

    def is_given_row(self, frame: IntArray, is_pose: BoolArray) -> BoolArray:
        """Which rows of ``given.parquet`` this protocol gives, by their frame [N] and whether they are poses [N]."""
        if self.given == "origin":
            origin: BoolArray = is_pose & (frame == 0)
            return origin
        return np.ones(len(frame), bool) if self.given == "arrivals" else frame < START_FRAMES


@cache
def get_protocol(name: str) -> Protocol:
    """The protocol called ``name``; raises UnknownNameError, which suggests the nearest name."""
    if name not in PROTOCOLS:
        raise UnknownNameError("protocol", name, PROTOCOLS)
    return read_bundled("vbbench", f"protocols/{name}.toml", Protocol, "protocol")


def arrivals_given(truth: Truth, observed: BoolArray) -> Given:
    """What `sequential` gives: the first two poses, and each track's first two frames observed [T, K].

    Only frames in which the track has a person count.
    """
    first_two = np.flatnonzero(observed & (np.cumsum(observed, axis=0) <= START_FRAMES))
    poses, positions = np.full(truth.poses.shape, np.nan), np.full((observed.size, 2), np.nan)
    poses[:START_FRAMES] = truth.poses[:START_FRAMES]
    positions[first_two] = truth.positions.reshape(-1, 2).take(first_two, axis=0)
    return Given(poses=poses, positions=positions.reshape(truth.positions.shape))


def scored_frames(observed: BoolArray) -> BoolArray:
    """[T] frames whose pose is scored: from the third on, if a person is observed ([T, K])."""
    return observed.any(axis=1) & (np.arange(len(observed)) >= START_FRAMES)


def scored_positions(observed: BoolArray, given: Given) -> BoolArray:
    """[T, K] positions that are scored: observed in a scored frame, and not given by the protocol."""
    return observed & scored_frames(observed)[:, None] & np.isnan(given.positions[..., 0])
