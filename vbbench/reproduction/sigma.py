"""The paper's figure of Δr, Δt, Δx̃ and Δx over the number of people, for several spreads σ_h of their heights."""

from dataclasses import dataclass
from pathlib import Path

from vbbench.files.dataset_info import DatasetInfo
from vbbench.folders.locks import loose_files
from vbbench.protocol import get_protocol
from vbbench.reproduction.curves import Point, points_by_people
from vbbench.reproduction.reuse import ensure_dataset, ensure_submission
from vbbench.reproduction.study import SPLIT, SigmaStudy
from vbbench.scoring import score


@dataclass(frozen=True, kw_only=True)
class Curve:
    """What a solver scores at one σ_h.

    Parameters
    ----------
    solver : its name.
    sigma_h : in m.
    fallback_frames : scored frames in which the observer's own prior decided; ``None`` = not reported.
    points : one for each K, ascending.
    """

    solver: str
    sigma_h: float
    fallback_frames: int | None
    points: tuple[Point, ...]


@dataclass(frozen=True, kw_only=True)
class SigmaFigure:
    """What was measured.

    Parameters
    ----------
    study : what was asked for.
    camera : kind of camera.
    curves : one for each solver and σ_h.
    """

    study: SigmaStudy
    camera: str
    curves: tuple[Curve, ...]

    @property
    def conditions(self) -> str:
        """What the figures stand for, in words."""
        study, protocol = self.study, get_protocol(self.study.protocol)
        where = f"split {SPLIT} ({self.camera}, {study.tier}), {protocol.id}, seed {study.seed}"
        return f"{where}, {study.sequences} sequences at each σ_h"

    @property
    def solvers(self) -> dict[str, list[Curve]]:
        """The curves by solver."""
        names = dict.fromkeys(curve.solver for curve in self.curves)
        return {name: [curve for curve in self.curves if curve.solver == name] for name in names}


def measure_sigma(study: SigmaStudy, out: Path | str, *, jobs: int = 1, overwrite: bool = False) -> SigmaFigure:
    """Generate, solve and score for every σ_h and solver.

    Datasets and submissions are kept in ``out``; those that are there and complete are taken over.

    Raises
    ------
    VbbenchError
        If something asked for cannot be, or another dataset or submission is in the way.
    """
    study.check()
    out = Path(out)
    with loose_files(out):
        curves = [
            curve for sigma_h in dict.fromkeys(study.sigmas) for curve in _curves(study, sigma_h, out, jobs, overwrite)
        ]
    camera = DatasetInfo.read(dataset_folder(out, study.sigmas[0])).camera.kind
    return SigmaFigure(study=study, camera=camera, curves=tuple(curves))


def dataset_folder(out: Path, sigma_h: float) -> Path:
    """Where the dataset of one σ_h (m) lies; its submissions are beside it."""
    return out / f"sigma-{sigma_h:g}" / "dataset"


def _curves(study: SigmaStudy, sigma_h: float, out: Path, jobs: int, overwrite: bool) -> list[Curve]:
    folder = dataset_folder(out, sigma_h)
    dataset = ensure_dataset(SPLIT, folder, study.options(sigma_h), jobs=jobs, overwrite=overwrite)
    curves = []
    for solver in dict.fromkeys(study.solvers):
        answers = folder.with_name(f"{study.protocol}-{solver.replace(':', '-')}")
        ensure_submission(dataset, solver, study.protocol, answers, jobs=jobs, overwrite=overwrite)
        result = score(answers, folder)
        points = points_by_people(result, dataset)
        curves.append(Curve(solver=solver, sigma_h=sigma_h, fallback_frames=result.fallback_frames, points=points))
    return curves
