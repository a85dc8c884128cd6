"""The paper's figure of Δr, Δt, Δx̃ and Δx over the number of people K, for several spreads σ_h of their heights."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.sequence_tables import SequenceTable
from vbbench.folders.locks import loose_files
from vbbench.generation.generator import Generator, Options, Simulation
from vbbench.geometry import FloatArray, IntArray
from vbbench.protocol import get_protocol
from vbbench.registry import load
from vbbench.reproduction.asked import check_names
from vbbench.reproduction.making import Making
from vbbench.scoring.block_bootstrap import block_means
from vbbench.scoring.scorecard import PerSequence, Score, known

SPLIT = "sim"
SIGMAS = (0.0, 0.01, 0.03, 0.05, 0.07)
"""σ_h in m of the paper's figure."""
PEOPLE = (10, 20, 30, 40, 50)
"""K of the paper's figure."""

SOLVER = "vb-sf"
"""The solver of the figure; its class may name variants to compare it with."""
PANELS = ("dr", "dt", "dx_rel", "dx")
"""The metrics of the paper's figure, in its order."""


def compared_solvers() -> dict[str, str]:
    """The solvers of the figure and their titles, from the class attribute ``variants`` of `SOLVER`."""
    return dict(getattr(load("solver", SOLVER), "variants", {SOLVER: SOLVER}))


def title_of(solver: str) -> str:
    """A solver's title."""
    return compared_solvers().get(solver, solver)


@dataclass(frozen=True, kw_only=True)
class SigmaStudy:
    """What to measure.

    Parameters
    ----------
    solvers : registered names or ``module:attribute``.
    protocol, tier, seed : of solvers and datasets.
    camera : ``None`` for the split's own.
    sequences : at each σ_h; they take the numbers of people in turn.
    sigmas : σ_h in m.
    people : numbers of people K.
    """

    solvers: Sequence[str] = field(default_factory=lambda: tuple(compared_solvers()))
    protocol: str = "one-step"
    camera: Camera | None = None
    tier: str = "ideal"
    sequences: int = 500
    seed: int = 0
    sigmas: Sequence[float] = SIGMAS
    people: Sequence[int] = PEOPLE

    def options(self, sigma_h: float) -> Options:
        """Options of the generator at one σ_h (m)."""
        simulation = Simulation(sequences=self.sequences, people=tuple(self.people))
        return Options(camera=self.camera, tier=self.tier, height_std=sigma_h, seed=self.seed, simulation=simulation)

    def check(self) -> None:
        """Find the mistakes that can be found before the work starts.

        Raises
        ------
        VbbenchError
            If a solver, the protocol or an option of the split is invalid.
        """
        if not self.solvers or not self.sigmas:
            raise VbbenchError("nothing to measure: name a solver and a σ_h")
        check_names(self.solvers, [self.protocol])
        generator: Generator = load("generator", SPLIT)
        for sigma_h in self.sigmas:
            generator.plan(self.options(sigma_h))


@dataclass(frozen=True, kw_only=True)
class Statistic:
    """One metric over some sequences.

    Parameters
    ----------
    mean, median : of the sequences' figures.
    low, high : ends of the 95 % interval of the mean over sequences.
    """

    mean: float
    low: float
    high: float
    median: float


@dataclass(frozen=True, kw_only=True)
class Point:
    """The figure's metrics over the sequences with the same number of people.

    Parameters
    ----------
    people : K, people of the scene, the observer included.
    sequences : scored sequences.
    seen : mean number of people scored per frame, over sequences.
    coverage : share of scored rows that were submitted: of poses or of positions, whichever is smaller.
    statistics : by metric.
    """

    people: int
    sequences: int
    seen: float
    coverage: float
    statistics: dict[str, Statistic]


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A solver's scores at one σ_h (m).

    Parameters
    ----------
    fallback_frames : scored frames in which the observer's own prior decided; ``None`` = not reported.
    points : one for each K, ascending.
    """

    solver: str
    sigma_h: float
    fallback_frames: int | None
    points: tuple[Point, ...]


@dataclass(frozen=True, kw_only=True)
class SigmaFigure:
    """The results of a study: the kind of camera, and a curve for each solver and σ_h."""

    study: SigmaStudy
    camera: str
    curves: tuple[Curve, ...]

    @property
    def conditions(self) -> str:
        """The conditions of the study as text."""
        study, protocol = self.study, get_protocol(self.study.protocol)
        where = f"split {SPLIT} ({self.camera}, {study.tier}), {protocol.id}, seed {study.seed}"
        return f"{where}, {study.sequences} sequences at each σ_h"

    @property
    def solvers(self) -> dict[str, list[Curve]]:
        """The curves by solver."""
        names = dict.fromkeys(curve.solver for curve in self.curves)
        return {name: [curve for curve in self.curves if curve.solver == name] for name in names}


def measure_sigma(study: SigmaStudy, out: Path | str, making: Making = Making()) -> SigmaFigure:  # noqa: B008
    """Generate, solve and score for every σ_h and solver.

    Datasets and submissions are kept in ``out``; complete ones are reused.

    Raises
    ------
    VbbenchError
        If the study is invalid, or another dataset or submission is in the way.
    """
    study.check()
    out = Path(out)
    with loose_files(out):
        curves = [curve for sigma_h in dict.fromkeys(study.sigmas) for curve in _curves(study, sigma_h, out, making)]
    camera = DatasetInfo.read(dataset_folder(out, study.sigmas[0])).camera.kind
    return SigmaFigure(study=study, camera=camera, curves=tuple(curves))


def dataset_folder(out: Path, sigma_h: float) -> Path:
    """Folder of the dataset of one σ_h (m); its submissions are beside it."""
    return out / f"sigma-{sigma_h:g}" / "dataset"


def _curves(study: SigmaStudy, sigma_h: float, out: Path, making: Making) -> list[Curve]:
    folder = dataset_folder(out, sigma_h)
    dataset = making.dataset(SPLIT, folder, study.options(sigma_h))
    scores = making.scores(dataset, study.solvers, study.protocol)
    return [
        Curve(solver=solver, sigma_h=sigma_h, fallback_frames=found.fallback_frames, points=_points(found, dataset))
        for solver, found in scores
    ]


def _points(score: Score, dataset: Dataset) -> tuple[Point, ...]:
    """A point for every number of people K, in ascending order; only the truth says K."""
    own = score.per_sequence
    people = _scene_people(dataset)[own.sequence]
    return tuple(_point(int(count), own.select(people == count)) for count in np.unique(people))


def _scene_people(dataset: Dataset) -> IntArray:
    """[N] number of people in the scene of each sequence, the observer included, seen or not."""
    scenes = dataset.rows["scene"]
    table = SequenceTable(dataset.table_path("truth/people"), "truth/people", "scene")
    rows = table.read(0, int(scenes.max()) + 1, ["scene"])
    return np.asarray(np.bincount(rows["scene"])[scenes])


def _point(people: int, own: PerSequence) -> Point:
    figures = np.stack([own.figures[name] for name in PANELS], axis=1)
    low, high = block_means(own.timeline, figures).interval().T.tolist()
    columns = zip(PANELS, figures.T, low, high, strict=True)
    return Point(
        people=people,
        sequences=len(figures),
        seen=float(np.mean(own.positions / own.frames)),
        coverage=own.total_coverage,
        statistics={name: _statistic(known(values), *interval) for name, values, *interval in columns},
    )


def _statistic(values: FloatArray, low: float, high: float) -> Statistic:
    mean, median = (np.mean(values), np.median(values)) if len(values) else (np.nan, np.nan)
    return Statistic(mean=float(mean), low=low, high=high, median=float(median))
