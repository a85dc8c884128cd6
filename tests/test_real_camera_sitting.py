"""People who sit, and children, among people who stand: told by their feet, and where they are."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import logsumexp
from scipy.stats import norm

from tests.rough_crowd import Drive, drive, made_drive, made_window, photograph
from vbbench.geometry import FloatArray
from vbbench.sequence import Truth
from vbbench_baselines.common.bearings import each
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.real_camera.heights import SHORT_SHARE, SHORTER, SHORTER_STD, height_law
from vbbench_baselines.joint_map.real_camera.past import nothing_past
from vbbench_baselines.joint_map.real_camera.sitting import seated

MEAN, STD = np.log(1.7), 0.055
FRAMES, FAR, SITTING = 24, 16.0, 1.25


def deviance(height: FloatArray) -> FloatArray:
    """−ln of the mixture, by SciPy."""
    each = norm.logpdf(height[:, None], MEAN + np.array((0.0, SHORTER)), (STD, SHORTER_STD))
    return -np.asarray(logsumexp(each, axis=1, b=(1.0 - SHORT_SHARE, SHORT_SHARE)))


@given(st.floats(-1.5, 1.0))
def test_the_law_of_heights_is_the_mixture_and_its_parabola_touches_it_from_above(off: float) -> None:
    law, at = height_law(MEAN + off, MEAN, STD), MEAN + off
    elsewhere = np.linspace(MEAN - 1.0, MEAN + 0.7, 35)
    rises = deviance(elsewhere) - deviance(np.array((at,)))
    ours = [height_law(height, MEAN, STD).deviance - law.deviance for height in elsewhere]
    np.testing.assert_allclose(ours, rises, rtol=1e-9, atol=1e-9)
    parabola = 0.5 * ((elsewhere - law.mean) ** 2 - (at - law.mean) ** 2) / law.std**2
    assert (parabola >= rises - 1e-9).all()
    close = at + np.array((-1e-6, 1e-6))
    slope = np.diff(deviance(close))[0] / 2e-6
    assert (at - law.mean) / law.std**2 == pytest.approx(slope, rel=1e-4, abs=1e-3)


def distances(poses: FloatArray, places: FloatArray) -> FloatArray:
    """[T, K] in m from the camera."""
    return np.asarray(np.hypot(*np.moveaxis(places - poses[:, None, :2], -1, 0)))


@cache
def terrace(seed: int) -> Drive:
    """Every third person whom the vehicle comes by sits; nobody is seen who is farther than `FAR`."""
    truth = drive(seed, FRAMES, people=45, speed=3.0)
    positions, heights = truth.positions.copy(), truth.heights.copy()
    positions[:, ::3], heights[::3] = positions[FRAMES // 2, ::3], SITTING
    there = Truth(poses=truth.poses, positions=positions, heights=heights)
    boxes = photograph(there, seed=seed)
    boxes[distances(there.poses, positions) > FAR] = np.nan
    return made_drive(there, boxes)


@pytest.mark.slow
@pytest.mark.parametrize("solver", [MapCausal, MapBatch])
def test_newcomers_who_sit_are_where_they_are(solver: type[MapCausal] | type[MapBatch]) -> None:
    """Under `rollout` nobody's place is given who is not there at first."""
    sitting, standing, tall = [], [], []
    for seed in range(4):
        made = terrace(seed)
        estimate, truth = made.solved(solver, "rollout"), made.truth
        off = np.abs(distances(estimate.poses, estimate.positions) / distances(truth.poses, truth.positions) - 1.0)
        new = made.sequence.observed & ~made.sequence.observed[:2].any(axis=0)
        sits = truth.heights == SITTING
        sitting.append(off[new & sits])
        standing.append(off[new & ~sits])
        assert estimate.heights is not None
        heights = estimate.heights[-1] if estimate.heights.ndim > 1 else estimate.heights
        tall.append(heights[sits & (new.sum(axis=0) > 4)])
    assert np.median(np.concatenate(sitting)) < 0.04
    assert np.median(np.concatenate(standing)) < 0.04
    assert np.abs(np.concatenate(tall) - SITTING).mean() < 0.05


@pytest.mark.parametrize("known", [False, True])
def test_only_newcomers_are_tried_as_sitting(known: bool) -> None:
    """Of who was seen before the window began it is known where they were, though no box of the window says so."""
    window = made_window()
    point, seen = window.point, window.seen
    boxes = each(lambda rows: rows.copy(), seen.boxes)
    boxes.azimuth[:3, 0], boxes.length[-1, 0] = np.nan, 0.7 * boxes.length[-1, 0]
    first, past = seen.first.copy(), nothing_past(4)
    first[0] = 0 if known else 3
    past.information[0, 0, 0] = float(known)
    starts = seated(point, seen._replace(boxes=boxes, first=first, past=past), MEAN)
    assert len(starts) == (0 if known else 1)
    for start in starts:
        assert start.point.people[0, 0] == pytest.approx(MEAN + SHORTER)
        assert np.isfinite(start.point.places[3:, 0]).all()
