"""The study: poses from static points at every distance, by three estimators, beside the errors of view birdification.

The length of a translation cannot be told from pixels: every estimate gets its direction from them and its length from
truth, except in one reading.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import starmap
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.folders.locks import loose_files
from vbbench.geometry import FloatArray
from vbbench.paper import the_paper
from vbbench.parallel.parts import in_parallel, progress_bar
from vbbench.reproduction.asked import check_every, check_names
from vbbench.reproduction.keypoints.crossing import Curve
from vbbench.reproduction.keypoints.five_point import ANY_DISTANCE, OPENCVS, Method, Poses, check_opencv, five_point
from vbbench.reproduction.keypoints.optimum import better_fit, bound, refined, truth
from vbbench.reproduction.keypoints.people import Line, People, measured_lines, paper_lines
from vbbench.reproduction.keypoints.readings import Reading, all_readings
from vbbench.reproduction.keypoints.views import Setting, Views, draw_views
from vbbench.reproduction.making import Making

FIVE_POINT, LEAST_SQUARES, FROM_TRUTH = "five-point", "least squares", "from truth"
"""OpenCV's answer; the best fit to all points; the fit next to the truth, which nobody would find."""
GOOD = 0.1
"""In m: what is taken for the paper's "good"."""


DISTANCES = tuple(float(distance) for distance in range(2, 41, 2))
"""In m, between the paper's bounds."""


@dataclass(frozen=True, kw_only=True)
class KeypointsStudy:
    """What to measure.

    Parameters
    ----------
    setting : what is drawn.
    distances : in m, ascending.
    trials : at each distance.
    people : whose errors are set beside it.
    seed : of the trials.
    """

    setting: Setting = field(default_factory=Setting)
    distances: Sequence[float] = DISTANCES
    trials: int = the_paper().keypoints.trials
    people: People = field(default_factory=People)
    seed: int = 0

    @property
    def trials_of_reading(self) -> int:
        """Trials of every other reading, at every second distance."""
        return max(2, self.trials // 2)

    def check(self) -> None:
        """Find the mistakes that can be found before the work starts.

        Raises
        ------
        VbbenchError
            If distances do not rise from above 0, there is no trial, a solver is unknown, or OpenCV is missing.
        """
        steps = np.diff([0.0, *self.distances])
        if len(self.distances) < 2 or not np.all(steps > 0.0):
            raise VbbenchError("distances are two or more lengths above 0 m, ascending")
        if self.trials < 2:
            raise VbbenchError(f"trials must be 2 or more at each distance, not {self.trials}")
        check_every(self.people.every)
        check_names(self.people.solvers, self.people.protocols)
        check_opencv()


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Errors of an estimator: translation in m and rotation in rad, [D, N] of trials at every distance."""

    translation: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, kw_only=True)
class MeasuredReading:
    """A reading, and the five-point method's errors [D, N] of translation in m."""

    reading: Reading
    curve: Curve

    def mean_at(self, distance: float) -> float:
        """Mean error in m at the measured distance that is nearest."""
        return float(self.curve.errors[np.argmin(np.abs(self.curve.distances - distance))].mean())

    def mean_from(self, distance: float) -> float:
        """Mean error in m over the measured distances from one on."""
        return float(self.curve.errors[self.curve.distances >= distance].mean())


@dataclass(frozen=True, kw_only=True)
class Keypoints:
    """The results of a study.

    Parameters
    ----------
    distances : [D] in m.
    errors : by estimator.
    bounds : [D] Cramér–Rao bound of the RMS error of translation, in m.
    unanswered : trials without an answer of OpenCV.
    lines : errors of view birdification: the paper's, then ours.
    missing : what of ours could not be measured, and why.
    readings : the other readings, the first as the main one.
    """

    study: KeypointsStudy
    distances: FloatArray
    errors: Mapping[str, Errors]
    bounds: FloatArray
    unanswered: int
    lines: tuple[Line, ...]
    missing: tuple[str, ...]
    readings: tuple[MeasuredReading, ...]

    @cached_property
    def curves(self) -> dict[str, Curve]:
        """Errors of translation over distance, by estimator."""
        return {
            name: Curve(distances=self.distances, errors=errors.translation, seed=self.study.seed)
            for name, errors in self.errors.items()
        }


def measure_keypoints(study: KeypointsStudy, out: Path | str, making: Making = Making()) -> Keypoints:  # noqa: B008
    """Draw and solve all trials; generate, solve and score the people beside them, whose files are kept in ``out``.

    Raises
    ------
    MissingExtraError
        If OpenCV is not installed.
    VbbenchError
        If the study is invalid, or another dataset or submission is in the way.
    """
    study.check()
    out, distances = Path(out), np.asarray(study.distances, dtype=float)
    readings = all_readings(study.setting)
    with loose_files(out):
        lines, missing = measured_lines(study.people, out, making)
    main = list(_done(partial(_main, study), [(one,) for one in study.distances], making.jobs, "distance"))
    others = list(_done(partial(_reading, study), [(one,) for one in readings], making.jobs, "reading"))
    return Keypoints(
        study=study,
        distances=distances,
        errors={
            name: Errors(
                **{kind: np.stack([one[0][name][kind] for one in main]) for kind in ("translation", "rotation")}
            )
            for name in (FIVE_POINT, LEAST_SQUARES, FROM_TRUTH)
        },
        bounds=np.array([one[1] for one in main]),
        unanswered=sum(one[2] for one in main),
        lines=(*paper_lines(), *lines),
        missing=tuple(missing),
        readings=tuple(
            MeasuredReading(reading=one, curve=Curve(distances=distances[::2], errors=found, seed=study.seed))
            for one, found in zip(readings, others, strict=True)
        ),
    )


def _done(function: Any, calls: list[tuple[Any, ...]], jobs: int, unit: str) -> Iterator[Any]:
    """The results in order, with a progress bar."""
    with progress_bar(len(calls), "five-point", unit=unit) as bar:
        results: Iterable[Any] = starmap(function, calls) if jobs == 1 else in_parallel(function, calls, jobs)
        for one in results:
            yield one
            bar.update()


def _main(study: KeypointsStudy, distance: float) -> tuple[dict[str, dict[str, FloatArray]], float, int]:
    """At one distance: errors by estimator and kind, the bound in m, and how many trials have no answer."""
    setting = study.setting
    views = draw_views(setting, distance, study.trials, study.seed)
    answer = five_point(views, OPENCVS, study.seed)
    # With every point in the choice among four poses, so that least squares has no wrong turn to begin with.
    found = refined(views, five_point(views, Method(reach=ANY_DISTANCE), study.seed))
    near = refined(views, truth(views))
    estimates = {FIVE_POINT: answer, LEAST_SQUARES: better_fit(views, found, near), FROM_TRUTH: near}
    clean = draw_views(setting.without_noise, distance, study.trials, study.seed)
    rms = float(np.sqrt(np.mean(bound(clean, setting.noise) ** 2)))
    errors = {
        name: {"translation": translation_errors(views, one, views.lengths), "rotation": rotation_errors(views, one)}
        for name, one in estimates.items()
    }
    return errors, rms, int(np.sum(~answer.answered))


def _reading(study: KeypointsStudy, reading: Reading) -> FloatArray:
    """[D, N] errors of translation in m of the five-point method, at every second distance."""
    found = []
    for distance in study.distances[::2]:
        views = draw_views(reading.setting, distance, study.trials_of_reading, study.seed)
        poses = five_point(views, reading.method, study.seed)
        length = np.full(len(views.centre), reading.setting.translation) if reading.unit_length else views.lengths
        found.append(translation_errors(views, poses, length))
    return np.stack(found)


def translation_errors(views: Views, poses: Poses, lengths: FloatArray) -> FloatArray:
    """[N] in m, where translations are taken to have these lengths [N]."""
    return np.asarray(np.linalg.norm(lengths[:, None] * poses.direction - views.centre, axis=-1))


def rotation_errors(views: Views, poses: Poses) -> FloatArray:
    """[N] angles in rad between estimated and true rotations."""
    between = poses.rotation @ views.rotation.transpose(0, 2, 1)
    twist = np.stack([between[:, i, j] - between[:, j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=-1)
    return np.asarray(np.arctan2(np.linalg.norm(twist, axis=-1), np.trace(between, axis1=1, axis2=2) - 1.0))
