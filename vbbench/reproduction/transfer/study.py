"""The study of transfer: whether datasets of tier `field` rank solvers as a real camera does, here KITTI's.

Solvers and variants of them answer both: KITTI's recordings, every 4th frame and every frame, and trajectories seen by
a vehicle's camera in tier `field` at the same frame times. `vbbench.reproduction.transfer.agreement` says how alike
they rank.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import starmap
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Generator, Options
from vbbench.geometry import BoolArray, FloatArray, runs_of_true
from vbbench.parallel.parts import in_parallel, progress_bar, without_bars
from vbbench.registry import load
from vbbench.reproduction.asked import check_names
from vbbench.reproduction.making import Making
from vbbench.reproduction.transfer.agreement import Agreement, Errors, agreement
from vbbench.reproduction.transfer.variants import Variant, registered_variants
from vbbench.scene import Scene
from vbbench.scoring.scorecard import Score

REAL = "kitti"
TIER = "field"
PROTOCOLS = ("sequential", "one-step")
METRICS = ("dx", "dt")
DT = 0.1
"""Seconds between KITTI's frames."""


@dataclass(frozen=True, kw_only=True)
class TransferStudy:
    """What to compare.

    Parameters
    ----------
    kitti : folder of KITTI's tracking benchmark, as split `kitti` reads it.
    poses : folder of the camera's poses that somebody found, which count where they keep parked cars in place better.
    variants : by name.
    every : every how many of KITTI's frames; the made datasets have the same seconds a frame.
    split : whose people the made datasets show; between their frames people follow smooth curves.
    smooth : m by which people may walk beside where they were recorded, root mean square, so that walks are smooth.
    protocols : names of protocols.
    limit : most sequences of a made dataset.
    seed : of the made datasets.
    """

    kitti: Path
    poses: Path | None = None
    variants: Mapping[str, Variant] = field(default_factory=registered_variants)
    every: Sequence[int] = (4, 1)
    split: str = "eth-15fps"
    smooth: float = 0.0
    protocols: Sequence[str] = PROTOCOLS
    limit: int | None = 60
    seed: int = 0

    def real(self, every: int) -> Options:
        """Options of KITTI's dataset."""
        return Options(source=self.kitti, footage=FootageOptions(every=every, poses=self.poses))

    @property
    def made(self) -> Options:
        """Options of the datasets beside it: a vehicle's camera, boxes as people draw them."""
        return Options(tier=TIER, observer="vehicle", detector=False, seed=self.seed, limit=self.limit)

    def check(self) -> None:
        """Find the mistakes that can be found before the work starts.

        Raises
        ------
        VbbenchError
            If a solver or a protocol is unknown, solvers are too few, or a number lies outside its range.
        """
        if not 0.0 <= self.smooth < np.inf:
            raise VbbenchError(f"people walk some m beside where they were recorded, or 0, not {self.smooth}")
        if len(self.variants) < 3:
            raise VbbenchError(f"{len(self.variants)} solvers have no ranks to compare; name at least three")
        for every in self.every:
            self.real(every)
        load("generator", self.split)
        check_names((variant.solver for variant in self.variants.values()), self.protocols)


class Case(NamedTuple):
    """One comparison: every how many frames, the protocol, and the metric."""

    every: int
    protocol: str
    metric: str


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """One case measured.

    Parameters
    ----------
    case : which.
    made, real : errors of the variants, in their order.
    agreement : how alike they rank.
    """

    case: Case
    made: Errors
    real: Errors
    agreement: Agreement


def measure_transfer(study: TransferStudy, out: Path | str, making: Making = Making()) -> list[Comparison]:  # noqa: B008
    """Generate, solve, score and compare every case.

    Datasets and submissions are kept in ``out``; complete ones are reused.

    Raises
    ------
    VbbenchError
        If the study is invalid, or another dataset or submission is in the way.
    """
    study.check()
    out = Path(out)
    with loose_files(out):
        return [found for every in study.every for found in _compare(study, every, out, making)]


def _compare(study: TransferStudy, every: int, out: Path, making: Making) -> Iterator[Comparison]:
    folders = {name: out / f"{name}-{every}" / "dataset" for name in (REAL, TIER)}
    real = making.dataset(REAL, folders[REAL], study.real(every))
    split, options = _people(study, every, out)
    made = making.dataset(split, folders[TIER], options)
    feet = np.array([variant.feet for variant in study.variants.values()])
    solvers = [variant.solver for variant in study.variants.values()]
    for protocol in study.protocols:
        scores = [_scores(dataset, solvers, protocol, making) for dataset in (made, real)]
        for metric in METRICS:
            mine, theirs = (errors_of(found, metric) for found in scores)
            found = agreement(mine, theirs, feet)
            yield Comparison(case=Case(every, protocol, metric), made=mine, real=theirs, agreement=found)


def _scores(dataset: Dataset, solvers: list[str], protocol: str, making: Making) -> list[Score]:
    """The solvers' scores in their order; as many solvers as there are ``jobs`` run side by side."""
    scored, calls = partial(_score, dataset, protocol, making.here), [(solver,) for solver in solvers]
    found: list[Score] = []
    with progress_bar(len(calls), f"{dataset.info.split} {dataset.info.dt:g} s {protocol}", unit="solver") as bar:
        for one in starmap(scored, calls) if making.jobs == 1 else in_parallel(scored, calls, making.jobs):
            found.append(one)
            bar.update()
    return found


def _score(dataset: Dataset, protocol: str, making: Making, solver: str) -> Score:
    """One solver's score, without a progress bar of its own."""
    with without_bars():
        ((_, found),) = making.scores(dataset, [solver], protocol)
    return found


def _people(study: TransferStudy, every: int, out: Path) -> tuple[str, Options]:
    """The split and the options of a made dataset; of a file made of the split if frames or walks are to differ."""
    generator: Generator = load("generator", study.split)
    scene, dt = generator.plan(Options(seed=study.seed)).scenes[0], every * DT
    if abs(scene.dt - dt) < 1e-6 and not study.smooth:
        return study.split, study.made
    path, text = out / f"{study.split}-{every}.txt", people_as_text(scene, dt, study.smooth)
    if not path.is_file() or path.read_text("utf-8") != text:
        write_text_atomically(path, text)
    return "custom", replace(study.made, source=path, dt=dt)


def people_as_text(scene: Scene, dt: float, smooth: float = 0.0) -> str:
    """A scene at frames of ``dt`` s, a line ``frame id x y`` for each person, on cubic splines through their places.

    With ``smooth`` the splines may leave x and y by so many m, root mean square, where five places or more are known.
    """
    times = np.asarray(scene.dt * np.arange(scene.frames), np.float64)
    lines = []
    for column, person in enumerate(scene.people.tolist()):
        for run in runs_of(scene.present[:, column]):
            wanted = np.arange(np.ceil(times[run][0] / dt - 1e-9), times[run][-1] / dt + 1e-9)
            places = _on_splines(times[run], scene.positions[run, column], wanted * dt, smooth)
            lines += [f"{frame:.0f} {person} {x:.4f} {y:.4f}" for frame, (x, y) in zip(wanted, places, strict=True)]
    return "\n".join(lines) + "\n"


def _on_splines(times: FloatArray, places: FloatArray, wanted: FloatArray, smooth: float) -> FloatArray:
    """Where somebody is at the ``wanted`` times [W], of ``places`` [N, 2] at ``times`` [N]: [W, 2]."""
    from scipy.interpolate import CubicSpline, UnivariateSpline

    if not smooth or len(times) < 5:
        return np.asarray(CubicSpline(times, places)(wanted))
    beside = len(times) * smooth**2
    return np.stack([UnivariateSpline(times, one, s=beside)(wanted) for one in places.T], axis=-1)


def runs_of(present: BoolArray) -> list[slice]:
    """The runs of two frames or more in which somebody is ``present`` [T]."""
    return [slice(first, last) for first, last in runs_of_true(present).tolist() if last - first > 1]


def errors_of(scores: Sequence[Score], metric: str) -> Errors:
    """The errors of ``scores`` on one dataset, sequences without any left out; what is NaN else counts as the cap."""
    values = np.stack([one.per_sequence.figures[metric] for one in scores])
    known: BoolArray = np.asarray(~np.isnan(values).all(axis=0))
    capped = np.fmin(values[:, known], scores[0].protocol.caps[metric])
    return Errors(values=capped, timeline=scores[0].per_sequence.select(known).timeline)
