"""The cells of the benchmark: what each one measures, and which figures it tells."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.real_camera.measuring import Runs, Trial
from benchmarks.real_camera.scenes import (
    STRIDES,
    Company,
    Scenes,
    exact_boxes,
    has_gap,
    noisy_heights,
    stands,
    with_gap,
)
from vbbench.geometry import FloatArray
from vbbench.protocol import PROTOCOLS, get_protocol

Figures = dict[str, tuple[float, ...]]
"""The figures of a row by what they are called."""

KITTI = ("0019", "0015", "0017")


@dataclass(frozen=True, kw_only=True)
class Cell:
    """Something to measure.

    Parameters
    ----------
    name : what it is selected by.
    unit : what its figures are.
    trials : what solvers are measured on, by the name of the row, made when it is asked for.
    figures : of a solver's runs, and of those of ``cv``.
    beside_cv : whether ``cv`` is measured in any case.
    """

    name: str
    unit: str
    trials: Mapping[str, Callable[[Scenes], Trial]]
    figures: Callable[[Runs, Runs | None], Figures]
    beside_cv: bool = False


def errors(runs: Runs, _cv: Runs | None = None) -> Figures:
    """Means over runs, and the worst run's."""
    worst = (_most(runs.dx), _most(runs.dt))
    return {"mean": (_mean(runs.dx), _mean(runs.dt)), "worst run": worst}


def one_step(runs: Runs, _cv: Runs | None) -> Figures:
    """Errors, and those with everybody's first two visible frames, which the prototype's figures have in them."""
    return {**errors(runs), "mean, arrivals too": (_mean(runs.dx_arrivals), _mean(runs.dt))}


def cold_start(runs: Runs, _cv: Runs | None) -> Figures:
    """Errors, and what is known without any position."""
    drift, sure = float(np.nanmedian(runs.drift)), _mean(runs.pose_square)
    return {**errors(runs), "Δx̃; drift, m/s": (_mean(runs.dx_rel), drift), "last pose, normalised": (sure,)}


def beside_cv(runs: Runs, cv: Runs | None) -> Figures:
    """Errors, and by how much Δt is above that of ``cv``."""
    if cv is None:
        raise ValueError("cv was not measured")
    above = runs.dt - cv.dt
    return {**errors(runs), "Δt above cv's: mean, most": (_mean(above), _most(above))}


def on_board(protocol: str) -> Callable[[Runs, Runs | None], Figures]:
    """Capped means, and shares of sequences that failed."""
    rules = get_protocol(protocol)

    def figures(runs: Runs, _cv: Runs | None) -> Figures:
        known = {name: values[~np.isnan(values)] for name, values in (("dx", runs.dx), ("dt", runs.dt))}
        capped = tuple(_mean(np.minimum(values, rules.caps[name])) for name, values in known.items())
        failed = tuple(_mean((values > rules.failures[name]).astype(float)) for name, values in known.items())
        return {"capped": capped, "failed": failed}

    return figures


def gap(runs: Runs, _cv: Runs | None) -> Figures:
    """How far anybody ever was, and whether covariances and flags told it."""
    return {
        "farthest: pose, person": (_most(runs.farthest_pose), _most(runs.farthest_person)),
        "far poses; untold, unflagged": (
            np.nansum(runs.far_poses),
            _untold(runs.far_poses, runs.unsure_poses),
            _untold(runs.far_poses, runs.flagged_poses),
        ),
        "far people; untold": (np.nansum(runs.far_people), _untold(runs.far_people, runs.unsure_people)),
    }


def sureness(runs: Runs, _cv: Runs | None) -> Figures:
    """Normalised squared errors: their means, and medians over runs (of a correct pose: .79)."""
    pose, people = (values[~np.isnan(values)] for values in (runs.pose_square, runs.people_square))
    return {"mean": (_mean(pose), _mean(people)), "median": (_median(pose), _median(people))}


def cells() -> tuple[Cell, ...]:
    """Every cell."""
    return (
        *_kitti(),
        *_exact(),
        *_seated(),
        *_rough_heights(),
        *_found(),
        *_standing(),
        *_gaps(),
        *_boards(),
        *_calibration(),
    )


def _kitti() -> list[Cell]:
    return [
        Cell(
            name=f"kitti-{every}-{protocol}",
            unit="Δx / Δt, m",
            trials={name: _recording(name, every, protocol) for name in KITTI},
            figures={"cold-start": cold_start, "one-step": one_step}.get(protocol, errors),
        )
        for every in (4, 1)
        for protocol in PROTOCOLS
    ]


def _exact() -> list[Cell]:
    def trial(name: str, every: int, protocol: str) -> Callable[[Scenes], Trial]:
        def made(scenes: Scenes) -> Trial:
            dataset = scenes.footage(name, every)
            change = exact_boxes(dataset.problem(dataset.sequence(0)).camera)
            return Trial(dataset=dataset, protocol=protocol, change=change)

        return made

    return [
        Cell(
            name=f"exact-{every}-{protocol}",
            unit="Δx / Δt, m; boxes without any error",
            trials={name: trial(name, every, protocol) for name in KITTI},
            figures=errors,
        )
        for every in (4, 1)
        for protocol in ("sequential", "rollout")
    ]


def _seated() -> list[Cell]:
    return [
        Cell(
            name=f"seated-{every}-{protocol}",
            unit="Δx / Δt, m; with people who sit",
            trials={"0019": _recording("0019", every, protocol, seated=True)},
            figures=errors,
        )
        for every in (4, 1)
        for protocol in PROTOCOLS
        if protocol != "cold-start"
    ]


def _rough_heights() -> list[Cell]:
    def trial(foot: bool) -> Callable[[Scenes], Trial]:
        def made(scenes: Scenes) -> Trial:
            dataset = scenes.footage("0019", 4)
            change = noisy_heights(dataset.info.dt, foot)
            return Trial(dataset=dataset, protocol="sequential", change=change, seeds=5)

        return made

    trials = {"centre kept": trial(False), "bottom kept": trial(True)}
    return [
        Cell(name="heights-4-sequential", unit="Δx / Δt, m; 3 % on heights, 5 seeds", trials=trials, figures=errors)
    ]


def _found() -> list[Cell]:
    return [
        Cell(
            name=f"detector-4-{protocol}",
            unit="Δx / Δt, m; a detector's boxes",
            trials={"0019": _recording("0019", 4, protocol, found=True)},
            figures=errors,
        )
        for protocol in ("sequential", "rollout")
    ]


def _standing() -> list[Cell]:
    def kitti(name: str, every: int) -> Callable[[Scenes], Trial]:
        return lambda s: Trial(dataset=s.footage(name, every), protocol="sequential", chosen=stands)

    def field(split: str) -> Callable[[Scenes], Trial]:
        return lambda s: Trial(dataset=s.board(split, "field"), protocol="sequential", chosen=stands)

    real = {
        "0017, .4 s": kitti("0017", 4),
        **{f"{name}, .1 s": kitti(name, 1) for name in ("0017", "0015", "0019")},
    }
    made = {split: field(split) for split in STRIDES}
    unit = "Δx / Δt, m; the camera stands"
    return [
        Cell(name=name, unit=unit, trials=trials, figures=beside_cv, beside_cv=True)
        for name, trials in (("standing-kitti", real), ("standing-field", made))
    ]


def _gaps() -> list[Cell]:
    def trial(split: str, company: Company) -> Callable[[Scenes], Trial]:
        return lambda scenes: Trial(
            dataset=scenes.board(split, "noisy"),
            protocol="sequential",
            change=with_gap(company),
            chosen=has_gap,
            covariances=True,
        )

    companies: tuple[Company, ...] = ("everybody", "arrivals", "one")
    trials = {
        f"{split}, {company}": trial(split, company)
        for split in ("eth-15fps", "students-resampled")
        for company in companies
    }
    return [Cell(name="gap", unit="m; counts, and shares of them; 27 frames without a box", trials=trials, figures=gap)]


def _boards() -> list[Cell]:
    def trial(split: str, tier: str, protocol: str) -> Callable[[Scenes], Trial]:
        return lambda scenes: Trial(dataset=scenes.board(split, tier), protocol=protocol)

    wanted = [(tier, "sequential") for tier in ("noisy", "occluded", "field")]
    wanted += [("noisy", "rollout"), ("noisy", "one-step")]
    return [
        Cell(
            name=f"boards-{tier}-{protocol}",
            unit="Δx / Δt, m, at most the cap; shares above 1 m",
            trials={split: trial(split, tier, protocol) for split in STRIDES},
            figures=on_board(protocol),
        )
        for tier, protocol in wanted
    ]


def _calibration() -> list[Cell]:
    def board(split: str, tier: str) -> Callable[[Scenes], Trial]:
        return lambda s: Trial(dataset=s.board(split, tier), protocol="sequential", covariances=True)

    trials = {"sim, noisy": board("sim", "noisy"), "hotel, field": board("hotel", "field")}
    trials |= {name: _recording(name, 4, "sequential", covariances=True) for name in KITTI}
    unit = "squared errors by the covariances, per degree of freedom: last pose / people in it"
    return [Cell(name="calibration", unit=unit, trials=trials, figures=sureness)]


def _recording(
    name: str, every: int, protocol: str, *, seated: bool = False, found: bool = False, covariances: bool = False
) -> Callable[[Scenes], Trial]:
    def trial(scenes: Scenes) -> Trial:
        dataset = scenes.footage(name, every, seated=seated, found=found)
        return Trial(dataset=dataset, protocol=protocol, covariances=covariances or protocol == "cold-start")

    return trial


def _mean(values: FloatArray) -> float:
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else np.nan


def _median(values: FloatArray) -> float:
    return float(np.median(values)) if len(values) else np.nan


def _most(values: FloatArray) -> float:
    known = values[~np.isnan(values)]
    return float(known.max()) if len(known) else np.nan


def _untold(far: FloatArray, told: FloatArray) -> float:
    """The share of far answers that nothing tells; 0 without any."""
    count = np.nansum(far)
    return float(1.0 - np.nansum(told) / count) if count else 0.0
