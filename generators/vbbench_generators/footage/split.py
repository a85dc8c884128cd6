"""A split of footage: a reader of recordings, and how they are cut into sequences."""

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass, field, fields, replace
from typing import ClassVar

from vbbench.errors import VbbenchError
from vbbench.files.dataset_info import DatasetInfo, Pictures
from vbbench.generation.footage import FOOTAGE, Footage, FootageOptions, Recordings
from vbbench.generation.generator import Card, Options
from vbbench.geometry import BoolArray
from vbbench_generators.footage.sequences import FootageSequences, Run, RunRules, find_runs, least_known

__all__ = ["READ_BY_ALL", "REVISION", "FootageSplit", "Recordings"]

REVISION = 3
"""Raised whenever the same recordings give other sequences, so that dataset ids differ too."""

READ_BY_ALL = frozenset({"source", "seed", "limit", "sequences", "every", "longest"})
"""Options, and options of footage, that every split of footage reads."""

_ELSEWHERE = frozenset({"footage", "stride"})
"""Options that are no split's: one holds others, and `vbbench.generation.planning` refuses the other for footage."""

_IN_PARTS = {"simulation": "`scenario` or `people`"}
"""Options that messages name by what they hold."""


@dataclass(frozen=True, kw_only=True)
class FootageSplit(ABC):
    """Base of the splits of footage: a subclass reads the recordings.

    ``reads`` names the options, and options of footage, that a split reads; any other is an error.

    Parameters
    ----------
    card : source, licence and citation.
    every : one of so many frames is kept by default.
    rules : the rules by which frames become sequences.
    height_mean, height_std : prior N(μ_h, σ_h²) in m of people's heights that solvers are given.
    pixel_std : noise in px of a box's column, top and bottom that solvers are given.
    tilt_std, mount_height_std : standard deviations in rad and m of momentary pitch, roll and mount height about the
        calibration, which solvers are given; measured on planes through people's feet in KITTI.
    """

    reads: ClassVar[frozenset[str]] = READ_BY_ALL

    card: Card
    every: int = 1
    rules: RunRules = field(default_factory=RunRules)
    height_mean: float = 1.72
    height_std: float = 0.09
    pixel_std: float = 2.0
    tilt_std: float = 0.03
    mount_height_std: float = 0.16

    @abstractmethod
    def recordings(self, options: Options) -> Recordings:
        """Read the chosen recordings.

        Raises VbbenchError if a file is missing or invalid, or a name is unknown.
        """

    def plan(self, options: Options) -> FootageSequences:
        """Read the recordings and lay out the sequences.

        Raises VbbenchError if an option is set that the split does not read, or there is nothing to read.
        """
        self._refuse_others(options)
        return self.lay_out(self.recordings(options), options)

    def lay_out(self, found: Recordings, options: Options) -> FootageSequences:
        """Lay out the sequences of recordings that this split, or another caller, has read."""
        asked = options.footage or FootageOptions()
        every = asked.every or self.every
        rules = self.rules if asked.longest is None else replace(self.rules, longest=asked.longest)
        footage = tuple(one.thinned(every) for one in found.footage)
        other = next((one for one in footage if round(one.dt, 6) != round(footage[0].dt, 6)), None)
        if other is not None:
            times = " but ".join(f"{one.name} takes {one.dt:.6g} s a frame" for one in (footage[0], other))
            raise VbbenchError(f"{self.card.name}: {times}; make a dataset of each, named by --sequences")
        runs = [run for n, one in enumerate(footage) for run in find_runs(n, self.counted(one), rules)]
        runs = runs[: options.limit]
        if not runs:
            wanted = f"{rules.shortest} frames in a row, {every} apart, with {rules.fewest} people{self.counted_where}"
            raise VbbenchError(f"{self.card.name}: nowhere are there {wanted}; try another `every`")
        return FootageSequences(self._info(options, found, footage, runs, every, rules), footage, tuple(runs))

    @property
    def counted_where(self) -> str:
        """The end of an error message that states which boxes count for the rules; empty where all count."""
        return ""

    def counted(self, one: Footage) -> BoolArray:
        """[T, K] mask of the boxes that count for the rules: all, unless a subclass limits them."""
        return one.observed

    def _refuse_others(self, options: Options) -> None:
        """Raise VbbenchError if an option is set that the split does not read."""
        known = [
            (option.name, getattr(values, option.name) == option.default)
            for values in (options, options.footage or FootageOptions())
            for option in fields(values)
            if option.name not in _ELSEWHERE
        ]
        other = next((name for name, unasked in known if not unasked and name not in self.reads), None)
        if other is not None:
            *most, last = (f"`{name}`" for name, _ in known if name in self.reads)
            named = _IN_PARTS.get(other, f"`{other}`")
            raise VbbenchError(
                f"{self.card.name} is footage and does not read {named}; it reads {', '.join(most)} and {last}"
            )

    def _info(
        self,
        options: Options,
        found: Recordings,
        footage: tuple[Footage, ...],
        runs: list[Run],
        every: int,
        rules: RunRules,
    ) -> DatasetInfo:
        pictures = tuple(_pictures(footage[run.recording], run) for run in runs)
        longest = (options.footage or FootageOptions()).longest
        return DatasetInfo(
            split=self.card.name,
            title=self.card.title,
            camera=footage[0].camera,
            cameras=tuple(one.camera for one in footage),
            tier=FOOTAGE,
            seed=options.seed,
            dt=footage[0].dt,
            height_mean=found.height_mean or self.height_mean,
            height_std=self.height_std if found.height_std is None else found.height_std,
            pixel_std=self.pixel_std if found.pixel_std is None else found.pixel_std,
            tilt_std=self.tilt_std,
            mount_height_std=self.mount_height_std,
            carried_by=found.carried_by,
            box_edge=found.box_edge,
            scenes=tuple(one.name for one in footage),
            definition={
                "generator": f"footage/{REVISION}",
                "every": every,
                "limit": options.limit,
                **({} if longest is None else {"longest": longest}),
                "count_observer": False,
                "rules": asdict(rules),
                **found.definition,
            },
            caution=found.caution or self.card.caution,
            calibration=found.calibration,
            truth=least_known(footage),
            pictures=pictures if any(pictures) else (),
        )


def _pictures(one: Footage, run: Run) -> Pictures | None:
    if one.pictures is None:
        return None
    first = one.pictures.first + run.first * one.pictures.step
    return Pictures(pattern=one.pictures.pattern, first=first, step=one.pictures.step)
