"""What a split's generator must offer, and what a user may ask of it. It registers under ``vbbench.generators``."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill
from typing import Annotated, Literal, Protocol, runtime_checkable

from vbbench.camera import Camera
from vbbench.errors import VbbenchError, VbbenchWarning, user_mistakes
from vbbench.files.dataset_checks import ALWAYS
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation.footage import FootageOptions, Recordings
from vbbench.generation.sources import Source, fetch, is_here
from vbbench.geometry import BoolArray, IntArray
from vbbench.parsing.numbers import FRAME_TIME, Within, check_ranges
from vbbench.parsing.toml_text import bundled_table
from vbbench.registry import load, load_all
from vbbench.scene import Scene
from vbbench.sequence import SequenceData

MOST_PEOPLE = 10_000
"""People of the largest crowd."""


@dataclass(frozen=True, kw_only=True)
class Simulation:
    """What is asked of a simulated crowd; ``None`` leaves it to the scenario.

    Parameters
    ----------
    scenario : name of a scenario, or path of a scenario file.
    sequences : number of sequences.
    people : numbers of people K; the sequences take them in turn.
    """

    scenario: str | None = None
    sequences: int | None = None
    people: tuple[int, ...] | None = None


Look = Literal["motion", "wander", "natural", "follow", "ahead", "glance", "sway"]
"""How the camera turns: the last four are the laws that ``natural`` draws from, each alone."""
Observer = Literal["walker", "vehicle", "robot"]
"""Who carries the camera: one of the people, or a vehicle or a robot among them; a robot measures its own motion."""


@dataclass(frozen=True, kw_only=True)
class Options:
    """What the user asks of a generator.

    Raises VbbenchError if a number lies outside its range, or a choice is unknown.

    Parameters
    ----------
    camera : what everybody is seen with; ``None`` for the split's own.
    tier : how observations are corrupted: the name of a registered tier (`vbbench.generation.tier`).
    height_std : σ_h in m of the people's heights; ``None`` for the tier's own, or .07.
    seed : the one seed; 0 is a seed like any other.
    limit : only the first so many sequences; ``None`` for all.
    stride : of these, only every so many-th; ``None`` for all.
    look : how the camera turns: along its bearer's past motion, wandering about that, or as people's heads do;
        ``None`` for the tier's own.
    observer : who carries the camera; vehicles and robots look where they drive.
    detector : whether boxes are those of a detector, in tiers that leave the choice.
    noise : standard deviation in px of columns, tops and bottoms of boxes, in the tier `noisy`; ``None`` for its own.
    least_track : fewest frames of a track that counts, in tiers whose boxes are those of a tracker; ``None`` for the
        tracker's own. The paper's "more than three" is 4.
    source : file or folder that holds the source files; ``None`` to search the usual places.
    dt : seconds per frame of a user's own file.
    homography : file with the 3x3 image-to-ground homography of a user's own file in pixels.
    simulation : what is asked of a simulated crowd; ``None`` for the split's own.
    footage : what is asked of footage; ``None`` for the split's own.
    """

    camera: Camera | None = None
    tier: str = "ideal"
    height_std: Annotated[float, Within(0.0, 0.3, "m", "the spread of people's heights")] | None = None
    seed: Annotated[int, Within(0, 2**256)] = 0
    limit: Annotated[int, Within(1, 2**31)] | None = None
    stride: Annotated[int, Within(2, 10_000)] | None = None
    look: Look | None = None
    observer: Observer = "walker"
    detector: bool = True
    noise: Annotated[float, Within(0.001, 100.0, "px")] | None = None
    least_track: Annotated[int, Within(1, 10**6)] | None = None
    source: Path | None = None
    dt: Annotated[float, FRAME_TIME] | None = None
    homography: Path | None = None
    simulation: Simulation | None = None
    footage: FootageOptions | None = None

    def __post_init__(self) -> None:
        with user_mistakes():
            check_ranges(self)


@dataclass(frozen=True, kw_only=True)
class Card:
    """What a person wants to know of a split before making it.

    ``people`` are real ones who were filmed or measured, or nobody but a program's; with ``own_files`` users bring the
    files that it is made from.
    """

    name: str
    title: str
    licence: str
    citation: str
    sources: tuple[Source, ...]
    caution: str | None = None
    people: Literal["recorded", "simulated"] = "recorded"
    own_files: bool = False


def bundled_card(package: str, name: str) -> Card:
    """The card of a split in ``cards.toml`` of an installed package."""
    return Card(name=name, sources=(), **bundled_table(package, "cards.toml")[name])


def refuse_footage(options: Options, split: str) -> None:
    """Raise VbbenchError if something is asked that only footage has."""
    if options.footage is not None:
        raise VbbenchError(
            "`every`, `longest`, `poses`, `boxes`, `person_class`, `cameras`, `bags`, `cyclists` and `interpolated` "
            f"are for footage; {split} is not"
        )


class Plan(Protocol):
    """A dataset before it is made. Any sequence can be built on its own, in any process, in any order.

    A plan without shared scenes, unless it is of footage, is endless: it builds sequences of any number, and its length
    is a wish.
    """

    @property
    def info(self) -> DatasetInfo:
        """The published facts, without counts."""

    @property
    def scenes(self) -> tuple[Scene, ...]:
        """The scenes that sequences share, with heights; none where every sequence brings its own."""

    def __len__(self) -> int:
        """Number of sequences."""

    def build(self, index: int) -> SequenceData:
        """Make one sequence."""


@runtime_checkable
class ForesightedPlan(Plan, Protocol):
    """A plan that may know who is seen before any box is made: large splits are then counted in no time."""

    def seen(self, index: int) -> BoolArray | None:
        """[T, K] who is seen in each frame of a sequence; ``None`` where only building it decides."""


@runtime_checkable
class FootagePlan(Plan, Protocol):
    """A plan of footage: what is known of it decides which tables there are."""

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables of `vbbench.files.tables.SCHEMAS` that the dataset has."""


def expected_rows_of(plan: Plan) -> IntArray | None:
    """[N] about how many observations each sequence has, by which work is cut; ``None`` if the plan does not know."""
    return getattr(plan, "expected_rows", None)


def tables_of(plan: Plan) -> tuple[str, ...]:
    """Names of the tables of the dataset that a plan makes."""
    return plan.tables if isinstance(plan, FootagePlan) else ALWAYS


class Generator(Protocol):
    """The maker of one split."""

    @property
    def card(self) -> Card:
        """Source, licence and citation."""

    def plan(self, options: Options) -> Plan:
        """Read the sources and lay out the sequences; nothing is written."""


@runtime_checkable
class FootageGenerator(Generator, Protocol):
    """The maker of a split of footage: what is asked of it is `Options.footage`."""

    @property
    def height_mean(self) -> float:
        """Mean in m of the heights that solvers are given."""

    def lay_out(self, found: Recordings, options: Options) -> FootagePlan:
        """The sequences of recordings that were read, by this split or by another caller."""


def describe_splits() -> str:
    """All splits as text, sorted by name."""
    return "\n".join(_describe(generator.card) for _, generator in sorted(load_all("generator").items()))


def fetch_splits(names: Sequence[str]) -> list[Path]:
    """Download missing sources of splits; return the paths of all their sources."""
    if not names:
        raise VbbenchError("fetch what? name splits, such as hotel eth students; 'vbbench splits' lists them")
    found: list[Generator] = [load("generator", name) for name in names]
    for card in (generator.card for generator in found if not generator.card.sources):
        why = "it is made from your own files, which --source names" if card.own_files else "it has no source files"
        warnings.warn(VbbenchWarning(f"{card.name}: nothing to fetch; {why}"), stacklevel=2)
    wanted = {source.path: source for generator in found for source in generator.card.sources}
    return fetch(list(wanted.values()))


def _describe(card: Card) -> str:
    here = sum(map(is_here, card.sources))
    state = "files of your own, --source" if card.own_files else "no source files"
    if card.sources:
        state = f"source here ({here}/{len(card.sources)} files)"
    if here < len(card.sources):
        state = f"source missing: {here} of {len(card.sources)} files here; vbbench fetch {card.name}"
    notes = {"licence": card.licence, "cite": card.citation, "caution": card.caution}
    details = [
        fill(f"{what}: {text}", 110, initial_indent="    ", subsequent_indent="      ")
        for what, text in notes.items()
        if text
    ]
    return "\n".join([f"{card.name}: {card.title} [{state}]", *details])
