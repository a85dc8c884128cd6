"""What a submission says: its observer and people, how far off they are, how sure it is, and its errors over time."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.pictures.viewer import palette
from vbbench.pictures.viewer.ground import GIRTH, Ground, People
from vbbench.pictures.viewer.palette import Colour
from vbbench.pictures.viewer.take import Answer, Take
from vbbench.pictures.viewer.world import OBSERVER_FRAMES, TRAIL_FRAMES

ERRORS = "errors"
CONFIDENCE = 2.4477
"""Standard deviations of an ellipse that holds 95 % of a Gaussian of the plane, √(−2 ln 0.05)."""


def record_estimate(ground: Ground, take: Take, number: int) -> None:
    """Record the answer of submission ``number``, in a tree and a colour of its own."""
    answer, colour = take.estimates[number], palette.solver_colour(number)
    name = ground.tape.rr.escape_entity_path_part(answer.name)
    tree = f"estimates/{name}"
    _record_people(ground, take, answer, tree, colour)
    _record_observer(ground, answer, tree, colour)
    if take.truth is not None:
        _record_error_lines(ground, take, answer, tree)
        _record_error_series(ground, answer, name, colour)


def _record_people(ground: Ground, take: Take, answer: Answer, tree: str, colour: Colour) -> None:
    places, tracks = answer.estimate.positions, take.sequence.tracks
    labels = [f"{track} {answer.name}" for track in tracks]
    look = People(np.tile(np.array(colour, np.uint8), (len(tracks), 1)), labels, shown=take.truth is None)
    ground.bodies(f"{tree}/people", places, _heights(take), look, solid=False)
    ground.dots(f"{tree}/people", places, look, 3.0)
    ground.trails(f"{tree}/trails", places, take.sequence.observed, colour, TRAIL_FRAMES)
    ground.rings(f"{tree}/given", answer.given.positions, palette.GIVEN, 1.5 * GIRTH)
    if answer.estimate.position_covariances is not None:
        spread = answer.estimate.position_covariances
        ground.ellipses(f"{tree}/95-percent", places, spread, colour, reach=CONFIDENCE)


def _record_observer(ground: Ground, answer: Answer, tree: str, colour: Colour) -> None:
    poses = answer.estimate.poses
    ground.arrows(f"{tree}/observer", poses, colour, 1.2, 0.05)
    ground.trails(
        f"{tree}/observer-trail", poses[:, None, :2], np.ones((len(poses), 1), np.bool_), colour, OBSERVER_FRAMES
    )
    if answer.estimate.pose_covariances is not None:
        spread = answer.estimate.pose_covariances[:, None, :2, :2]
        ground.ellipses(f"{tree}/observer-95-percent", poses[:, None, :2], spread, colour, reach=CONFIDENCE)


def _record_error_lines(ground: Ground, take: Take, answer: Answer, tree: str) -> None:
    """From where people and the observer are to where they are said to be."""
    if take.truth is None:
        return
    truth = np.concatenate([take.truth.positions, take.truth.poses[:, None, :2]], axis=1)
    said = np.concatenate([answer.estimate.positions, answer.estimate.poses[:, None, :2]], axis=1)
    ground.lines(f"{tree}/{ERRORS}", truth, said, palette.ERROR, 0.03)


def _record_error_series(ground: Ground, answer: Answer, name: str, colour: Colour) -> None:
    tape = ground.tape
    for key, values in answer.errors.items():
        path, frames = f"{ERRORS}/{key}/{name}", np.flatnonzero(np.isfinite(values))
        tape.always(path, tape.rr.SeriesLines(colors=[colour], names=[answer.name], widths=[1.5]))
        tape.each(path, tape.rr.Scalars, frames, scalars=values[frames])


def _heights(take: Take) -> FloatArray:
    """[K] true heights in m where they are known, the prior's mean elsewhere."""
    mean = take.dataset.info.height_mean
    if take.truth is None:
        return np.full(len(take.sequence.tracks), mean)
    return np.where(np.isfinite(take.truth.heights), take.truth.heights, mean)
