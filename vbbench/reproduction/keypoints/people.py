"""The errors of view birdification beside those from static points: the paper's and ours, on several kinds of boxes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from vbbench.errors import SourceMissingError
from vbbench.generation.footage import FOOTAGE, FootageOptions
from vbbench.generation.generator import Observer, Options
from vbbench.paper import the_paper
from vbbench.reproduction.asked import stride_of
from vbbench.reproduction.keypoints.crossing import Level
from vbbench.reproduction.making import Making
from vbbench.scoring.scorecard import Score

KITTI, FIELD = "kitti", "field"
PAPER_PROTOCOL = ""
"""Of the paper's rows; which protocol they are of is open."""


@dataclass(frozen=True, kw_only=True)
class People:
    """Whose boxes, and who answers.

    Parameters
    ----------
    splits, tiers, solvers, protocols : names; every combination is measured.
    every : only every so-many-th observer of a split, and in tier `field` a third of that: every so-many-th window of
        the time of a vehicle among them, of which there are fewer. KITTI is whole.
    kitti : folder of KITTI's tracking benchmark; ``None`` to search the usual places, where it may be missing.
    poses : folder of the poses of KITTI's camera.
    seed : of the datasets.
    """

    splits: Sequence[str] = ("hotel", "eth")
    tiers: Sequence[str] = ("tracked", FIELD)
    solvers: Sequence[str] = ("map-causal", "vb-sf")
    protocols: Sequence[str] = ("one-step", "sequential")
    every: int = 6
    kitti: Path | None = None
    poses: Path | None = None
    seed: int = 0

    def options(self) -> Iterator[tuple[str, str, Options]]:
        """Every split and tier, and what to ask of its generator."""
        for split in self.splits:
            for tier in self.tiers:
                yield split, tier, self._asked(tier)
        yield KITTI, FOOTAGE, Options(source=self.kitti, footage=FootageOptions(poses=self.poses))

    def _asked(self, tier: str) -> Options:
        """Boards of tier `field` are of a vehicle, too: a walker's camera with borders hardly sees anybody whole."""
        stride = max(1, self.every // 3) if tier == FIELD else self.every
        observer: Observer = "vehicle" if tier == FIELD else "walker"
        return Options(tier=tier, seed=self.seed, stride=stride_of(stride), observer=observer)


@dataclass(frozen=True, kw_only=True)
class Line:
    """One error of view birdification.

    Parameters
    ----------
    split, tier, solver, protocol : what it is of.
    sequences : how many it is a mean over; 0 for the paper's.
    translation, rotation : mean over sequences of min(error, cap) in m and rad; the paper's as printed.
    """

    split: str
    tier: str
    solver: str
    protocol: str
    sequences: int = 0
    translation: Level
    rotation: Level

    @property
    def is_papers(self) -> bool:
        """Whether the paper prints it."""
        return self.protocol == PAPER_PROTOCOL


def paper_lines() -> list[Line]:
    """Rows of the paper's Tables 2 to 4 that have an error of the camera, of the better of two solvers."""
    return [
        Line(
            split=row.split,
            tier=row.tier,
            solver=row.solver,
            protocol=PAPER_PROTOCOL,
            translation=Level(value=row.figures["dt"]),
            rotation=Level(value=row.figures["dr"]),
        )
        for row in the_paper().rows
        if "dt" in row.figures and row.solver != "VB-CV"
    ]


def measured_lines(people: People, out: Path, making: Making) -> tuple[list[Line], list[str]]:
    """Lines of every combination whose source is here, and what is missing.

    Raises
    ------
    VbbenchError
        As of `Making.dataset` and `Making.submission`; if ``people.kitti`` holds no recordings.
    """
    lines, missing = [], []
    for split, tier, options in people.options():
        try:
            dataset = making.dataset(split, out / f"{split}-{tier}" / "dataset", options)
        except SourceMissingError as error:
            if options.source is not None:
                raise
            missing.append(f"{split}, {tier}: {error}")
            continue
        for protocol in people.protocols:
            for solver, score in making.scores(dataset, people.solvers, protocol):
                lines.append(_line(split, tier, solver, protocol, score))
    return lines, missing


def _line(split: str, tier: str, solver: str, protocol: str, score: Score) -> Line:
    levels = {
        name: Level(value=score.summaries[name].capped, low=low, high=high)
        for name in ("dt", "dr")
        for low, high in [score.summaries[name].capped_ci95]
    }
    return Line(
        split=split,
        tier=tier,
        solver=solver,
        protocol=protocol,
        sequences=len(score.per_sequence.sequence),
        translation=levels["dt"],
        rotation=levels["dr"],
    )
