"""Which boards are published, which of them lead, and how much of each dataset they are made on.

The rule of subsets: everything is regenerated in 45 minutes on two cores. Recordings are solved from every so many-th
observer, because neighbouring observers see the same people at the same time. Simulated crowds are cut short, because
each differs from all others.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vbbench.errors import VbbenchError
from vbbench.generation.footage import FOOTAGE, FootageOptions
from vbbench.generation.generator import Observer, Options
from vbbench.generation.sources import data_folders
from vbbench.protocol import PROTOCOLS
from vbbench.registry import load
from vbbench_leaderboards.results.result import About, Board

LEADING_SPLITS = ("sim", "street", "hotel", "eth-15fps", "students-resampled")
"""Splits made from trajectories, in the order of the page."""

REAL_SPLITS = ("kitti",)
"""Splits that a real camera saw: their figures can be published, their data cannot."""

FILM_SPLITS = ("street-film",)
"""Splits of rendered people whose boxes a real detector found; their data come with the generators."""

REAL, REAL_FAMILIES = "real", ("kitti", "argoverse2", "nuscenes", "jrdb")
"""All families of real recordings, by one name: whoever has the data can regenerate boards on them."""

PAPER_SPLITS = ("eth", "students")
"""Splits of the paper whose recordings are too smooth to separate solvers."""

SPLITS = (*LEADING_SPLITS, *REAL_SPLITS, *FILM_SPLITS, *PAPER_SPLITS)

HEADLINE_TIER, HEADLINE_PROTOCOL = "field", "sequential"
HEADLINE_METRIC = "dx"
"""By which the rows of a table are ordered, and which a narrow page shows."""
LEADING_TIERS = ("noisy", "occluded", "tracked", HEADLINE_TIER)
PAPER_TIER = "ideal"
"""The paper's exact boxes, which no camera can give."""

KITTI_RECORDINGS = ("0015", "0017", "0019")
"""The solvers that come with vbbench were tuned on them."""
_RECORDINGS = {"kitti": KITTI_RECORDINGS, "argoverse2": ("test",), "nuscenes": ("test",)}
_OF_CARS: tuple[str, ...] = ("sequential", "rollout", "cold-start")
_OF_FILMS = dict.fromkeys(FILM_SPLITS, ("sequential", "cold-start"))
_PROTOCOLS = {"argoverse2": _OF_CARS, "nuscenes": _OF_CARS, "jrdb": _OF_CARS[-1:], **_OF_FILMS}
"""Those of the boards of a family; where the robot was is not known in all recordings of JRDB."""


@dataclass(frozen=True, kw_only=True)
class BoardSource:
    """A dataset that four boards stand on, one a protocol.

    Parameters
    ----------
    split, tier : its names.
    limit, stride : which of its sequences are made; ``None`` for all.
    observer : who carries the camera.
    """

    split: str
    tier: str
    limit: int | None = None
    stride: int | None = None
    observer: Observer = "walker"

    def options(self, seed: int, root: Path | None = None) -> Options:
        """The options of the generator.

        Parameters
        ----------
        root : folder that holds folders of real recordings, called like their splits; ``None`` for the usual places.
        """
        if self.tier != FOOTAGE:
            return Options(tier=self.tier, seed=seed, limit=self.limit, stride=self.stride, observer=self.observer)
        places = [folder / self.split for folder in (data_folders() if root is None else [root])]
        source = next((place for place in places if place.is_dir()), None)
        poses = next((place / "poses" for place in places if (place / "poses").is_dir()), None)  # of KITTI, and better
        footage = FootageOptions(sequences=_RECORDINGS.get(self.split), poses=poses if self.split == "kitti" else None)
        return Options(source=source, seed=seed, footage=footage)

    @property
    def boards(self) -> tuple[Board, ...]:
        """The boards that stand on it."""
        protocols = _PROTOCOLS.get(self.split, PROTOCOLS)
        return tuple(Board(split=self.split, tier=self.tier, protocol=protocol) for protocol in protocols)


_LIMITS = {"sim": 150, "street": 6}
_STRIDES = {"hotel": 3, "eth": 3, "eth-15fps": 3, "students": 16, "students-resampled": 16}
_FIELD_LIMITS = {"sim": 150}
_FIELD_STRIDES = {"students-resampled": 2}
"""Of windows of time, which a vehicle watches, there are fewer than observers."""


def source(split: str, tier: str) -> BoardSource:
    """The dataset behind the boards of a split and tier, by the rule of subsets; whole where no rule is known.

    In tier `field` a vehicle carries the camera, as on the footage that the tier was measured on and held against: in
    the midst of a crowd a walker's camera with borders hardly sees a whole person.
    """
    if tier == HEADLINE_TIER:
        limit, stride = _FIELD_LIMITS.get(split), _FIELD_STRIDES.get(split)
        return BoardSource(split=split, tier=tier, limit=limit, stride=stride, observer="vehicle")
    return BoardSource(split=split, tier=tier, limit=_LIMITS.get(split), stride=_STRIDES.get(split))


def published_sources() -> tuple[BoardSource, ...]:
    """Every dataset that boards are published on: those that lead, real footage and films, then the paper's."""
    leading = [source(split, tier) for split in LEADING_SPLITS for tier in LEADING_TIERS]
    real = [source(split, FOOTAGE) for split in (*REAL_SPLITS, *FILM_SPLITS)]
    papers = [source(split, tier) for split in PAPER_SPLITS for tier in (PAPER_TIER, "noisy")]
    exact = [source(split, PAPER_TIER) for split in ("sim", "hotel")]
    return (*leading, *real, *exact, *papers)


def chosen_sources(splits: Sequence[str] = (), tiers: Sequence[str] = ()) -> tuple[BoardSource, ...]:
    """The datasets of some splits and tiers; without names, of all that is published.

    `REAL` stands for the `REAL_FAMILIES`, published or not. Footage has no other tier than its own.

    Raises VbbenchError if a split is unknown, or no board is published on what is named, and one of both is not named.
    """
    splits = [one for split in splits for one in (REAL_FAMILIES if split == REAL else (split,))]
    for split in splits:
        load("generator", split)
    published = published_sources()
    if splits and (tiers or set(splits) <= set(REAL_FAMILIES)):
        pairs = [(split, FOOTAGE if split in REAL_FAMILIES else tier) for split in splits for tier in tiers or ("",)]
        return tuple(source(split, tier) for split, tier in dict.fromkeys(pairs))
    found = tuple(one for one in published if (not splits or one.split in splits) and (not tiers or one.tier in tiers))
    if not found:
        raise VbbenchError("no board is published there; name splits and tiers, both")
    return found


def is_real(board: Board) -> bool:
    """Whether a real camera saw it."""
    return board.tier == FOOTAGE and board.split not in FILM_SPLITS


def is_diagnostic(board: Board) -> bool:
    """Whether a board is kept for the paper's sake and for finding faults, not to compare solvers."""
    return board.tier == PAPER_TIER or board.split in PAPER_SPLITS


def is_headline(board: Board) -> bool:
    """Whether the front page leads with a board: sequential, in the tier like a real camera, or of a real one."""
    return board.protocol == HEADLINE_PROTOCOL and (
        is_real(board) or (board.tier == HEADLINE_TIER and not is_diagnostic(board))
    )


REFERENCES = {
    "cv": "Constant-velocity extrapolation, bundled with vbbench (baseline CV of arXiv 2111.05060)",
    "sf": "Social-force extrapolation, bundled with vbbench (baseline SF of arXiv 2111.05060)",
    "vb-cv": "View birdification with constant velocity, bundled with vbbench "
    "(VB-CV of arXiv 2111.05060, with changes)",
    "vb-sf": "View birdification with the social force, bundled with vbbench (VB-SF of arXiv 2111.05060, with changes)",
    "ground-plane": "Distances by the heights of boxes, a rigid fit and Kalman filters, bundled with vbbench",
    "map-causal": "Joint maximum a posteriori over a sliding window, causal, bundled with vbbench",
    "map-batch": "Joint maximum a posteriori over whole sequences, bundled with vbbench",
    "vb-former": "Recurrent attention about a pose fit, learned from simulated crowds, bundled with vbbench",
}

SINGLE_PRECISION = ("vb-former",)
"""Solvers that count with 24 bits."""


SIMULATED = ("sim", "street", "demo")
"""Splits that are made of no recording."""

_UNNAMED = ("custom", "own")
"""Splits of a user's own files, whose recordings have no name that a fact could give."""

_ELSEWHERE = r"(?<!logs of )(?<!scenes of )(?:{})(?!\W*(?:train|tune))"
_NAMES = {
    "hotel": r"hotel|biwi|ewap|eth\W+ucy",
    "eth": "eth|biwi|ewap",
    "eth-15fps": "eth|biwi|ewap",
    "students": "students?|ucy",
    "students-resampled": "students?|ucy",
    "zara01": "zara|ucy",
    "zara02": "zara|ucy",
    "argoverse2": _ELSEWHERE.format(r"argoverse[ -]?2"),
    "nuscenes": _ELSEWHERE.format("nuscenes"),
}
"""Names of a split's recordings and of data sets that contain them, where they are not the split's own.

Boards of argoverse2 and nuscenes stand on the official part `test`. Facts that name the other parts, or count the logs
and scenes that were looked at while solvers were written, name none of it: those tune.
"""

_FACTS = {"trained": "trained_on", "tuned": "tuned_on"}


def seen_by(about: About, split: str) -> str:
    """How a solver saw recordings of a split: "trained", "tuned", "trained and tuned", or "" if not at all.

    It saw them if a declared fact has their name as a separate word, whatever numbers follow it.
    """
    if split in (*SIMULATED, *_UNNAMED):
        return ""
    name = re.compile(rf"(?<![a-z0-9])(?:{_NAMES.get(split, re.escape(split))})(?![a-z])")
    return " and ".join(how for how, fact in _FACTS.items() if name.search(getattr(about, fact).casefold()))
