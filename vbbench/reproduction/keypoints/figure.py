"""The five-point study as a report: what the paper says beside what was found, tables, every number, and pictures."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from vbbench.camera import camera_to_dict
from vbbench.paper import the_paper
from vbbench.parsing.json_text import finite_or_none
from vbbench.reproduction.keypoints.crossing import Crossing, Curve
from vbbench.reproduction.keypoints.people import Line
from vbbench.reproduction.keypoints.picture import plot_keypoints, plot_readings
from vbbench.reproduction.keypoints.study import (
    FIVE_POINT,
    FROM_TRUTH,
    GOOD,
    LEAST_SQUARES,
    Keypoints,
    MeasuredReading,
)
from vbbench.reproduction.report import Report
from vbbench.table import Table, csv_text

NAME = "figure-keypoints"
LOST = 1.0
"""In rad: a rotation that is farther off belongs to another of the four poses of a matrix."""
PAPER_LINE = ("street", "tracked")
"""Split and tier of the paper's error that other readings are held against: boxes of a tracker, as a robot has them."""


def keypoints_report(found: Keypoints) -> Report:
    """Tables by distance, by line and by reading; every error of every trial as CSV."""
    return Report(
        name=NAME,
        title="Poses from static points by the five-point method, beside those from people",
        facts=[
            _what_the_paper_says(),
            _what_was_done(found),
            _what_was_found(found),
            _what_matches(found),
            *_what_is_missing(found),
        ],
        tables=[_by_distance(found), _by_line(found), _by_reading(found)],
        values=keypoints_values(found),
        pictures={"": plot_keypoints(found), "readings": plot_readings(found)},
        texts={".csv": keypoints_csv(found)},
        whole=not found.missing,
    )


def _what_the_paper_says() -> str:
    paper = the_paper().keypoints
    sides = " × ".join(f"{side:g}" for side in paper.voxel)
    return (
        f"The paper draws {paper.points} static points in a voxel of {sides} m at {paper.distances[0]:g} to "
        f"{paper.distances[1]:g} m, sees them with two cameras that are turned by up to {paper.rotation:.2f} rad and "
        f"moved by up to {paper.translation:g} m, adds uniform noise of ±{paper.noise:g} px, and finds the pose by the "
        f"five-point method, {paper.trials} times at each distance. It is good to {paper.good_to:g} m; from "
        f"{paper.poor_from:g} m on the mean error of translation is at least {paper.poor_error:.2f} m. Not "
        "known here are its camera, which side of the voxel is which, and how long translations are taken to be."
    )


def _what_was_done(found: Keypoints) -> str:
    setting = found.study.setting
    right, down, forward = setting.voxel
    return (
        f"Here: {found.study.trials} trials at each distance, seed {found.study.seed}; a camera of "
        f"{setting.camera.width} × {setting.camera.height} px and f = {setting.camera.focal:g} px; a voxel {right:g} m "
        f"wide, {forward:g} m deep and {down:g} m high, whose near side is at the distance; points that both cameras "
        "see; motions on the ground plane, uniform up to their bounds; OpenCV's findEssentialMat (RANSAC, 1 px) and "
        "recoverPose as they are. The direction of a translation is the method's, its length is true: pixels do not "
        "tell it, and view birdification does not need it. The other readings are in the last table."
    )


def _what_was_found(found: Keypoints) -> str:
    paper, main = the_paper().keypoints, found.curves[FIVE_POINT]
    near, far = (_mean_at(main, distance) for distance in (paper.good_to, paper.poor_from))
    beyond = float(main.errors[main.distances >= paper.poor_from].mean())
    floor = [_mean_at(found.curves[LEAST_SQUARES], one) for one in (paper.poor_from, main.distances[-1])]
    length = found.study.setting.translation * (1.0 if found.study.setting.at_bound else 0.5)
    over = main.rises_over(paper.poor_error)
    return (
        f"Found: a mean error of {near:.3f} m at {paper.good_to:g} m (wanted: at most {GOOD:g}), {far:.3f} m at "
        f"{paper.poor_from:g} m and {beyond:.3f} m over all distances from there on (wanted: at least "
        f"{paper.poor_error:.2f}); it reaches {paper.poor_error:.2f} m {_from(over, main)}. Least squares over all "
        f"points has {floor[0]:.3f} m at {paper.poor_from:g} m and {floor[1]:.3f} m at {main.distances[-1]:g} m: so "
        "much is geometry, and the rest is that OpenCV's answer is that of the best five points. Saying that the "
        f"camera stands is off by {length:.2f} m on average."
    )


def _what_matches(found: Keypoints) -> str:
    """Which readings have the paper's errors."""
    paper = the_paper().keypoints
    good = [one for one in found.readings if one.mean_at(paper.good_to) <= GOOD]
    there = [one.reading.name for one in good if one.mean_at(paper.poor_from) >= paper.poor_error]
    beyond = [one.reading.name for one in good if one.mean_from(paper.poor_from) >= paper.poor_error]
    unit = next(one for one in found.readings if one.reading.unit_length).mean_at(paper.good_to)
    return (
        f"Readings that are good at {paper.good_to:g} m and have {paper.poor_error:.2f} m at {paper.poor_from:g} m: "
        f"{'; '.join(there) or 'none'}. On average over all distances from there on: {'; '.join(beyond) or 'none'}. "
        f"With every translation taken to be as long as its bound the error at {paper.good_to:g} m is {unit:.3f} m, so "
        "the paper's lengths must be true as well."
    )


def _what_is_missing(found: Keypoints) -> Iterator[str]:
    if found.missing:
        yield "\n".join(f"- missing: {one}" for one in found.missing)


def _mean_at(curve: Curve, distance: float) -> float:
    return float(curve.errors[np.argmin(np.abs(curve.distances - distance))].mean())


def _from(distance: float, curve: Curve) -> str:
    return f"from {distance:.1f} m on" if np.isfinite(distance) else f"nowhere up to {curve.distances[-1]:g} m"


def _by_distance(found: Keypoints) -> Table:
    best, squares, near = (found.errors[name] for name in (FIVE_POINT, LEAST_SQUARES, FROM_TRUTH))
    rows = []
    for n, distance in enumerate(found.distances):
        quarter, middle, three = np.quantile(best.translation[n], (0.25, 0.5, 0.75))
        means = [errors.translation[n].mean() for errors in (best, squares, near)]
        turned = [float(np.median(errors.rotation[n])) for errors in (best, squares)]
        lost = float(np.mean(best.rotation[n] > LOST))
        rows.append(
            [
                f"{distance:g}",
                f"{means[0]:.3f}",
                f"{middle:.3f} ({quarter:.3f} to {three:.3f})",
                *(f"{mean:.3f}" for mean in means[1:]),
                f"{np.sqrt(np.mean(near.translation[n] ** 2)):.3f} / {found.bounds[n]:.3f}",
                *(f"{angle:.4f}" for angle in turned),
                f"{lost:.0%}",
            ]
        )
    fact = (
        "Errors of translation in m and rotation in rad. Least squares: the lower minimum of Sampson's distances, "
        "found from OpenCV's answer and from truth. Next to the truth: the minimum found from truth, which nobody else "
        "could tell from the others; beside its RMS error the Cramér–Rao bound for normal noise of the same variance, "
        "which is no bound far away, where errors stop growing. Lost: rotations off by more than a radian, another of "
        "a matrix's four poses; OpenCV leaves points beyond 50 lengths of the translation out of that choice."
    )
    head = ["distance (m)", "mean", "median (quartiles)", "least squares, mean", "next to the truth, mean"]
    head += ["its RMS / bound", "rotation, median", "least squares", "lost"]
    return Table(title="By distance", facts=[fact], head=head, rows=rows)


def _by_line(found: Keypoints) -> Table:
    main, squares = found.curves[FIVE_POINT], found.curves[LEAST_SQUARES]
    rows = []
    for line in found.lines:
        who = ["the paper", line.solver] if line.is_papers else [f"here, {line.protocol}", f"`{line.solver}`"]
        crossings = (curve.crossing(line.translation) for curve in (main, squares))
        rows.append(
            [
                *who,
                f"{line.split}, {line.tier}",
                str(line.sequences or ""),
                _with_interval(line),
                *(shown(crossing, main) for crossing in crossings),
                f"{line.rotation.value:.3f}",
            ]
        )
    fact = (
        "From which distance on the mean error of translation from points is larger than that from people; 95 % "
        "intervals by a bootstrap over trials and, of ours, over blocks of time. One-step is a motion from one frame "
        "to the next, as the points' is; a sequential error has grown since the sequence began. Ours are means of "
        "min(error, cap), the cap of the protocol. Rotation: mean Δr in rad."
    )
    head = ["", "solver", "boxes", "sequences", "Δt (m)", "beats five points from (m)", "least squares from (m)", "Δr"]
    return Table(title="From where on people tell more than points", facts=[fact], head=head, rows=rows, names=3)


def _with_interval(line: Line) -> str:
    level = line.translation
    return f"{level.value:.3f}" if np.isnan(level.low) else f"{level.value:.3f} [{level.low:.3f}, {level.high:.3f}]"


def shown(crossing: Crossing, curve: Curve) -> str:
    """A crossing as text: with its interval, and ≤ and > where it is not among the distances of the curve."""
    first, last = curve.distances[[0, -1]]

    def one(distance: float) -> str:
        return f"≤ {first:g}" if distance <= first else f"> {last:g}" if np.isinf(distance) else f"{distance:.1f}"

    return f"{one(crossing.distance)} [{one(crossing.low)}, {one(crossing.high)}]"


def _by_reading(found: Keypoints) -> Table:
    paper = the_paper().keypoints
    line = paper_line(found)
    rows = [
        [
            "the paper",
            f"≤ {GOOD:g}",
            f"≥ {paper.poor_error:.2f}",
            f"≥ {paper.poor_error:.2f}",
            f"{paper.poor_from:g}",
            "",
        ]
    ]
    rows += [_reading_row(one, line) for one in found.readings]
    fact = (
        f"Mean errors of translation in m, {found.study.trials_of_reading} trials at every second distance, the same "
        "points for all where they can be. Each reading changes one thing of the first, the last ones several."
    )
    near, far = f"{paper.good_to:g} m", f"{paper.poor_from:g} m"
    head = ["reading", f"at {near}", f"at {far}", f"from {far} on", f"{paper.poor_error:.2f} m from (m)"]
    head.append(f"the paper's {line.translation.value:.3f} m beats it from (m)")
    return Table(title="What the text leaves open", facts=[fact], head=head, rows=rows)


def paper_line(found: Keypoints) -> Line:
    """The paper's line of `PAPER_LINE`."""
    return next(line for line in found.lines if line.is_papers and (line.split, line.tier) == PAPER_LINE)


def _reading_row(one: MeasuredReading, line: Line) -> list[str]:
    paper, curve = the_paper().keypoints, one.curve
    poor = curve.rises_over(paper.poor_error)
    means = [one.mean_at(paper.good_to), one.mean_at(paper.poor_from), one.mean_from(paper.poor_from)]
    crossing = shown(curve.crossing(line.translation), curve)
    last = f"{poor:.1f}" if np.isfinite(poor) else f"> {curve.distances[-1]:g}"
    return [one.reading.name, *(f"{mean:.3f}" for mean in means), last, crossing]


def keypoints_values(found: Keypoints) -> dict[str, Any]:
    """Every figure of the tables."""
    main = found.curves[FIVE_POINT]
    return {
        "seed": found.study.seed,
        "trials": found.study.trials,
        "camera": camera_to_dict(found.study.setting.camera),
        "unanswered": found.unanswered,
        "missing": list(found.missing),
        "distances": found.distances.tolist(),
        "bounds": found.bounds.tolist(),
        "estimators": {
            name: {kind: _statistics(values) for kind, values in vars(errors).items()}
            for name, errors in found.errors.items()
        },
        "lines": [
            {
                **{name: value for name, value in vars(line).items() if name not in ("translation", "rotation")},
                "dt": _finite(line.translation),
                "dr": _finite(line.rotation),
                "crossing": {name: _finite(curve.crossing(line.translation)) for name, curve in found.curves.items()},
            }
            for line in found.lines
        ],
        "readings": [
            {"name": one.reading.name, "means": one.curve.errors.mean(axis=1).tolist()} for one in found.readings
        ],
        "poor_from": finite_or_none(main.rises_over(the_paper().keypoints.poor_error)),
    }


def _statistics(values: Any) -> dict[str, list[float]]:
    """Of errors [D, N]: mean, quartiles and the 95th percentile at every distance."""
    shares = {"q25": 0.25, "median": 0.5, "q75": 0.75, "p95": 0.95}
    quantiles = {name: np.quantile(values, share, axis=1).tolist() for name, share in shares.items()}
    return {"mean": values.mean(axis=1).tolist(), **quantiles}


def _finite(values: Any) -> dict[str, float | None]:
    """Its numbers, with ``None`` for what is not finite, as JSON needs it."""
    return {name: finite_or_none(value) for name, value in vars(values).items()}


def keypoints_csv(found: Keypoints) -> str:
    """Errors of every trial: a row for each distance (m), trial and estimator."""
    return csv_text(("distance", "trial", "estimator", "translation", "rotation"), _trials(found))


def _trials(found: Keypoints) -> Iterator[list[object]]:
    for n, distance in enumerate(found.distances.tolist()):
        for name, errors in found.errors.items():
            for trial, pair in enumerate(zip(errors.translation[n].tolist(), errors.rotation[n].tolist(), strict=True)):
                yield [distance, trial, name, *(f"{value:.6g}" for value in pair)]
