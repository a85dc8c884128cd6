"""Errors of boxes that are alike from frame to frame: what a box adds, and how noisy boxes are found to be."""

import numpy as np
import pytest

from tests.rough_crowd import made_window
from vbbench.geometry import FloatArray
from vbbench_baselines.joint_map.motion.walks import REACH
from vbbench_baselines.joint_map.real_camera.cues import CUES, FRAME, PERSON, Noise, Residuals, whiten
from vbbench_baselines.joint_map.real_camera.joint import boxes_of
from vbbench_baselines.joint_map.real_camera.noise import SIGMAS, TAUS, NoiseLearner, densities, residual_densities

DT = 0.4
NORMAL = 1e9
"""Degrees of freedom of a normal distribution."""

GRID = np.log(SIGMAS[1] / SIGMAS[0])
"""By how much each σ that is weighed is larger than the one before, as a logarithm."""


def found(frame: list[int], value: FloatArray) -> Residuals:
    """Residuals [m, 3] in these frames, of boxes that all count."""
    m = len(frame)
    parts = (np.zeros((m, CUES, n)) for n in (2, FRAME, PERSON))
    return Residuals(np.array(frame), np.array(value), np.ones((m, CUES)), np.ones((m, CUES)), *parts)


def noise(nu: float, *tau: float) -> Noise:
    return Noise(np.full(CUES, 0.05), np.array(tau), np.full(CUES, nu))


def omega(boxes: Residuals, believed: Noise, cue: int) -> FloatArray:
    """[m, m] of one cue."""
    white = whiten(boxes, believed, DT)
    beside = white.beside[1:, cue]
    return np.diag(white.diagonal[:, cue]) + np.diag(beside, 1) + np.diag(beside, -1)


@pytest.mark.parametrize("frame", [[0, 1, 2, 3, 4], [0, 2, 3, 6, 7], [5]])
def test_it_is_the_information_of_errors_that_fade(frame: list[int]) -> None:
    """Ω is the inverse of the covariance exp(−|t − s|/τ)."""
    boxes = found(frame, np.random.default_rng(0).normal(size=(len(frame), CUES)))
    believed = noise(NORMAL, 0.4, 2.0, 20.0)
    for cue, tau in enumerate(believed.tau):
        covariance = np.exp(-np.abs(np.subtract.outer(frame, frame)) * DT / tau)
        information = np.linalg.inv(covariance)
        np.testing.assert_allclose(omega(boxes, believed, cue), information, rtol=1e-6, atol=1e-6)
        force = whiten(boxes, believed, DT).force[:, cue]
        np.testing.assert_allclose(force, information @ boxes.value[:, cue], rtol=1e-6, atol=1e-6)


def test_boxes_far_apart_know_nothing_of_each_other() -> None:
    boxes = found([0, 1, 1 + REACH, 2 + REACH], np.ones((4, CUES)))
    matrix = omega(boxes, noise(NORMAL, 20.0, 20.0, 20.0), 0)
    assert np.all(matrix[:2, 2:] == 0.0)
    np.testing.assert_allclose(matrix[:2, :2], matrix[2:, 2:])


def test_what_does_not_count_neither_pulls_nor_links() -> None:
    """A cut box's feet say nothing: those after them begin anew."""
    boxes = found([0, 1, 2], np.random.default_rng(1).normal(size=(3, CUES)))
    boxes.counts[1, 2] = 0.0
    white = whiten(boxes, noise(NORMAL, 20.0, 20.0, 20.0), DT)
    np.testing.assert_allclose(white.diagonal[:, 2], (1.0, 0.0, 1.0), rtol=1e-6)
    assert white.force[1, 2] == 0.0
    assert np.all(white.beside[:, 2] == 0.0)
    assert np.all(white.beside[1:, :2] != 0.0)


@pytest.mark.parametrize("scale", [0.1, 1.0, 10.0])
def test_the_force_is_the_slope_of_the_deviance(scale: float) -> None:
    """Of Student-t terms, with one cue that counts in part."""
    boxes = found([0, 1, 3, 4], scale * np.random.default_rng(2).normal(size=(4, CUES)))
    boxes.counts[2, 1] = 1e-3
    believed, step = noise(6.0, 0.4, 2.0, 20.0), 1e-6
    force, slope = whiten(boxes, believed, DT).force, np.zeros((4, CUES))
    for i, j in np.ndindex(4, CUES):
        for sign in (1.0, -1.0):
            moved = boxes.value.copy()
            moved[i, j] += sign * step
            slope[i, j] += sign * whiten(boxes._replace(value=moved), believed, DT).deviance / (2.0 * step)
    np.testing.assert_allclose(force, slope, rtol=1e-5, atol=1e-6)


def alike(rng: np.random.Generator, frames: int, sigma: float, tau: float, nu: float) -> FloatArray:
    """Errors [frames] that fade within ``tau``, as the model draws them."""
    rho, errors = np.exp(-DT / tau), np.empty(frames)
    drawn = sigma * rng.standard_t(nu, frames)
    errors[0] = drawn[0]
    for t in range(1, frames):
        errors[t] = rho * errors[t - 1] + np.sqrt(1.0 - rho * rho) * drawn[t]
    return errors


def learner_of(sigma: tuple[float, ...], tau: tuple[float, ...]) -> NoiseLearner:
    return NoiseLearner(Noise(np.array(sigma), np.array(tau), np.full(CUES, 6.0)), 0.7, 4.0)


def test_noise_is_found_from_errors() -> None:
    """However wrong the first belief; far boxes' edges are noisier, which is taken into account."""
    rng, sigma, tau, size = np.random.default_rng(0), (0.02, 0.05, 0.1), (0.1, 1.5, 6.0), 60.0
    learner = learner_of((0.08, 0.012, 0.03), (20.0, 20.0, 0.1))
    for _ in range(60):
        shares = np.hypot(sigma, 0.5 / size)
        errors = np.stack([alike(rng, 30, *numbers, 6.0) for numbers in zip(shares, tau, strict=True)], axis=1)
        boxes, told = found(list(range(30)), errors / shares), np.zeros((CUES, len(SIGMAS), len(TAUS)))
        boxes.scale[:] = shares
        for i in range(30):
            densities(boxes, i, size, size, learner.noise.nu, DT, told)
        learner.learn(told)
    np.testing.assert_allclose(np.log(learner.noise.sigma), np.log(sigma), atol=0.6 * GRID)
    assert learner.noise.tau.tolist() == list(tau)


def test_nothing_told_is_what_was_believed() -> None:
    learner = learner_of((0.04, 0.02, 0.05), (0.4, 20.0, 6.0))
    learner.learn(np.zeros((CUES, len(SIGMAS), len(TAUS))))
    np.testing.assert_allclose(np.log(learner.noise.sigma), np.log((0.04, 0.02, 0.05)), atol=0.6 * GRID)
    assert learner.noise.tau.tolist() == [0.4, 20.0, 6.0]


def test_cut_boxes_teach_nothing() -> None:
    boxes, told = found([0, 1], np.ones((2, CUES))), np.zeros((CUES, len(SIGMAS), len(TAUS)))
    boxes.counts[1] = (1.0, 1e-3, 0.0)
    densities(boxes, 1, 100.0, 100.0, np.full(CUES, 6.0), DT, told)
    assert np.all(told[0] != 0.0)
    assert np.all(told[1:] == 0.0)


def test_a_frame_teaches_by_its_boxes_and_those_before_them() -> None:
    window = made_window()
    point, seen, model = window.point, window.seen, window.model
    frame, told = 4, np.zeros((CUES, len(SIGMAS), len(TAUS)))
    for k in np.flatnonzero(~np.isnan(seen.boxes.azimuth[frame])).tolist():
        _, residuals = boxes_of(k, point, seen, model)
        i = residuals.frame.tolist().index(frame - seen.first[k])
        assert i > 0
        own, before = (seen.boxes.size[seen.first[k] + residuals.frame[j], k] for j in (i, i - 1))
        densities(residuals, i, own, before, model.noise.nu, model.dt, told)
    assert np.all(told != 0.0)
    np.testing.assert_allclose(residual_densities(point, seen, model, frame), told, rtol=1e-12)
    assert np.all(residual_densities(point, seen, model, -1) == 0.0)
