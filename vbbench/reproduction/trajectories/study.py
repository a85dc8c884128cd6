"""One sequence of every split that is here, solved."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.folders.locks import loose_files
from vbbench.generation.generator import Plan
from vbbench.generation.planning import single
from vbbench.pictures.replay import Replay, load_replay
from vbbench.registry import registered
from vbbench.reproduction.asked import check_names
from vbbench.reproduction.at_hand import AtHand, how_to_get
from vbbench.reproduction.making import Making, submission_folder
from vbbench.reproduction.simulated_recording import STAND_INS, stand_in_plan
from vbbench.reproduction.trajectories.choice import typical_sequence
from vbbench.scoring.scorecard import Score

USERS_OWN = ("custom", "own", "argoverse2", "nuscenes")
"""Splits that are not shown: the user's own recordings, and footage of cars that is like KITTI's."""
_ORDER = (
    *("sim", "hotel", "eth", "eth-15fps", "students", "students-resampled", "zara01", "zara02"),
    *("shibuya01", "shibuya02", "street", "motsynth", "kitti", "jrdb", "demo"),
)


@dataclass(frozen=True, kw_only=True)
class TrajectoriesStudy:
    """What to show.

    Parameters
    ----------
    splits : names; none for all that `vbbench splits` lists, but for the user's own recordings.
    solver : registered name or ``module:attribute``.
    protocol : which truth it is given, and when; footage whose truth is not known in full is solved from a cold start.
    at_hand : where the user's own downloads are.
    seed : of the datasets.
    """

    splits: tuple[str, ...] = ()
    solver: str = "vb-sf"
    protocol: str = "sequential"
    at_hand: AtHand = field(default_factory=AtHand)
    seed: int = 0

    def check(self) -> None:
        """Raise VbbenchError if a split, the solver or the protocol is unknown."""
        check_names([self.solver], [self.protocol])
        for split in self.splits:
            if split not in shown_splits():
                raise UnknownNameError("split with an example", split, shown_splits())


@dataclass(frozen=True, kw_only=True)
class Example:
    """One sequence of a split.

    Parameters
    ----------
    name : the split's, or what it is made from.
    number : of the sequence in its split.
    replay : the sequence with its truth, and the solver's answer.
    errors : metric → mean over the sequence's scored frames or person-frames; only those of which truth is known.
    """

    name: str
    number: int
    replay: Replay
    errors: Mapping[str, float]

    @property
    def protocol(self) -> str:
        """The protocol that it was solved under."""
        return "" if self.replay.answer is None else self.replay.answer.protocol.name

    @property
    def frames(self) -> int:
        """Number of frames T."""
        return self.replay.sequence.frames

    @property
    def seconds(self) -> float:
        """From the first frame to the last."""
        return (self.frames - 1) * self.replay.info.dt

    @property
    def people(self) -> int:
        """People seen at any time."""
        return int(self.replay.sequence.observed.any(axis=0).sum())


@dataclass(frozen=True, kw_only=True)
class Trajectories:
    """The results of a study: the examples, and how the sources of missing splits are got."""

    study: TrajectoriesStudy
    examples: tuple[Example, ...]
    missing: Mapping[str, str]


def shown_splits() -> list[str]:
    """Names of the splits that have an example, in the order of the sheet; those of other packages last."""
    names = set(registered("generator")) - set(USERS_OWN)
    return sorted(names, key=lambda name: (_ORDER.index(name) if name in _ORDER else len(_ORDER), name))


def measure_trajectories(study: TrajectoriesStudy, out: Path | str, making: Making = Making()) -> Trajectories:  # noqa: B008
    """Choose, make and solve a sequence of each split; datasets and submissions are kept in ``out`` and reused.

    Raises
    ------
    VbbenchError
        If the study is invalid, no split is here, a source cannot be read, or something else is in the way in ``out``.
    """
    study.check()
    out, examples, missing = Path(out), [], {}
    with loose_files(out):
        for split in study.splits or shown_splits():
            name, plan = split, study.at_hand.plan(split, study.seed)
            if plan is None:
                missing[split] = how_to_get(split)
                if split not in STAND_INS:
                    continue
                name, plan = f"like {split}, simulated", stand_in_plan(split, out / f"like-{split}", study.seed, making)
            folder = out / (split if name == split else f"like-{split}")
            examples.append(_example(name, plan, study, folder, making))
    if not examples:
        raise VbbenchError(
            f"nothing to show: the source of {', '.join(missing)} is not here; 'vbbench splits' says more"
        )
    return Trajectories(study=study, examples=tuple(examples), missing=missing)


def _example(name: str, plan: Plan, study: TrajectoriesStudy, folder: Path, making: Making) -> Example:
    number = typical_sequence(plan)
    dataset = making.planned(single(plan, number), folder / "dataset")
    protocol = study.protocol if dataset.info.truth == "whole" else "cold-start"
    ((_, score),) = making.scores(dataset, [study.solver], protocol)
    submission = submission_folder(dataset, study.solver, protocol)
    return Example(name=name, number=number, replay=load_replay(dataset, 0, [submission]), errors=_errors(score))


def _errors(score: Score) -> dict[str, float]:
    means = {name: float(summary.mean) for name, summary in score.summaries.items()}
    return {name: mean for name, mean in means.items() if np.isfinite(mean)}
