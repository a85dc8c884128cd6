"""The recipe of a training, a TOML file: its data, phases and learning rate."""

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from typing import Annotated, Any

from vbbench.camera import make_camera
from vbbench.generation.generator import Look, Observer, Options, Simulation
from vbbench.parsing.numbers import Within, check_ranges
from vbbench.parsing.toml_text import read_bundled, read_toml
from vbbench.protocol import PROTOCOLS

PEOPLE, SHARE = Within(1, 10_000), Within(0.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class Stream:
    """Sequences of one kind; see `vbbench.generation.generator.Options`.

    Parameters
    ----------
    name : name of the stream.
    split, tier, camera, look, observer, detector : options of ``vbbench generate``.
    scenarios : scenarios of the split; the stream has ``sequences`` of each.
    fewest : sequences with fewer people are removed.
    share : weight of the stream among the training's windows.
    """

    name: str
    split: str
    scenarios: tuple[str, ...]
    sequences: Annotated[int, Within(1, 10**7)]
    share: Annotated[float, Within(0.0, 1e6)]
    tier: str = "noisy"
    camera: str | None = None
    look: Look | None = None
    observer: Observer = "walker"
    detector: bool = True
    fewest: Annotated[int, Within(0, 10**4)] = 0

    def __post_init__(self) -> None:
        check_ranges(self)
        if not self.scenarios:
            raise ValueError(f"the stream '{self.name}' names no scenarios; name one or more")

    def options(self, scenario: str, people: tuple[int, ...], seed: int) -> Options:
        """The generator's options for ``people`` in a ``scenario``."""
        crowd = Simulation(
            scenario=scenario if self.split == "sim" else None,
            people=tuple(number for number in people if number >= self.fewest),
        )
        return Options(
            seed=seed,
            tier=self.tier,
            camera=None if self.camera is None else make_camera(self.camera),
            look=self.look,
            observer=self.observer,
            detector=self.detector,
            simulation=crowd,
        )


@dataclass(frozen=True, kw_only=True)
class Size:
    """A class of windows with about the same number of people, which form batches.

    Parameters
    ----------
    least, most : least and greatest number of people of a window.
    windows : windows in a batch.
    share : weight among all batches.
    """

    least: Annotated[int, Within(1, 1000)]
    most: Annotated[int, Within(1, 1000)]
    windows: Annotated[int, Within(1, 10**5)]
    share: Annotated[float, SHARE]

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.least > self.most:
            raise ValueError(f"[[size]] is of {self.least} to {self.most} people; least must not exceed most")


@dataclass(frozen=True, kw_only=True)
class Phase:
    """A part of the training.

    Parameters
    ----------
    frames : length of its windows.
    share : weight of the phase in the training.
    """

    frames: Annotated[int, Within(4, 1000)]
    share: Annotated[float, SHARE]

    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """The whole recipe.

    Parameters
    ----------
    seed, held_out_seed : seeds of the training and validation crowds; seed 0 is the boards'.
    held_out : validation windows of each size.
    windows : number of training windows.
    rate, decay : the learning rate, and the share of the training after which it falls as a cosine.
    averaged : share of the training, at its end, whose weights are averaged.
    people : numbers of people in each scenario.
    protocols : weights of the protocols.
    phase, stream, size : see `Phase`, `Stream` and `Size`; phases follow each other.
    """

    seed: Annotated[int, Within(2, 2**31)]
    held_out_seed: Annotated[int, Within(1, 2**31)]
    held_out: Annotated[int, Within(1, 10**5)]
    windows: Annotated[int, Within(1, 10**9)]
    rate: Annotated[float, Within(1e-9, 1.0)]
    decay: Annotated[float, Within(0.0, 0.99)]
    averaged: Annotated[float, Within(0.001, 1.0)]
    people: Mapping[str, Any]
    protocols: Mapping[str, Any]
    stream: tuple[Stream, ...]
    size: tuple[Size, ...]
    phase: tuple[Phase, ...]

    def __post_init__(self) -> None:
        check_ranges(self)
        if self.seed == self.held_out_seed:
            raise ValueError(f"seed and held_out_seed are both {self.seed}; what is held out needs its own crowds")
        _check_shares("[[size]]", [size.share for size in self.size])
        _check_shares("[[stream]]", [stream.share for stream in self.stream])
        names = [stream.name for stream in self.stream]
        if len(set(names)) < len(names):
            again = next(name for name in names if names.count(name) > 1)
            raise ValueError(f"two [[stream]] are called '{again}'; give each its own name")
        _check_shares("[[phase]]", [phase.share for phase in self.phase])
        self._check_people()
        if set(self.protocols) != set(PROTOCOLS):
            raise ValueError(f"[protocols] names the shares of {', '.join(PROTOCOLS)}, and nothing else")
        for name, share in self.protocols.items():
            SHARE.check(f"[protocols] {name}", share)
        _check_shares("[protocols]", list(self.protocols.values()))

    def _check_people(self) -> None:
        for scenario, numbers in self.people.items():
            whole = isinstance(numbers, list | tuple) and all(isinstance(number, int) for number in numbers)
            if not whole or not numbers:
                raise ValueError(f"[people] {scenario} is a list of numbers of people, such as [5, 10]")
            for number in numbers:
                PEOPLE.check(f"[people] {scenario}", number)
        if not self.people:
            raise ValueError("[people] is missing; it has a list of numbers of people for each scenario")
        most, least = max(map(max, self.people.values())), min(size.least for size in self.size)
        if most < least:
            raise ValueError(f"[people] has crowds of at most {most}, and every [[size]] wants at least {least} people")
        for stream in self.stream:
            for scenario in stream.scenarios:
                if scenario not in self.people:
                    raise ValueError(f"[people] has no '{scenario}', which the stream '{stream.name}' needs")

    def phase_at(self, part: float) -> Phase:
        """The phase when the share ``part`` of the training is done."""
        ends = list(accumulate(phase.share for phase in self.phase))
        return self.phase[min(bisect_right(ends, part * ends[-1]), len(ends) - 1)]


def _check_shares(where: str, shares: list[float]) -> None:
    if sum(shares) <= 0.0:
        raise ValueError(f"{where} is missing, or all of its shares are 0")


def read_recipe(path: Path | None) -> Recipe:
    """The recipe in a file; ``None`` for the one that `vb-former` was trained by."""
    if path is None:
        return read_bundled("vbbench_baselines", "former/training/recipe.toml", Recipe, "recipe")
    return read_toml(path, Recipe, "recipe")
