"""The observer's location posterior: least at the estimate, equal to a search over yaws, drawn where it belongs."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from vbbench.camera import make_camera
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.geometry import world_to_relative
from vbbench.pictures.plotting import plot_posterior
from vbbench.pictures.plotting.posterior import density_level, spread
from vbbench.protocol import PROTOCOLS
from vbbench.solving.posterior import Posterior, find_posterior
from vbbench_baselines._core import location_energies
from vbbench_baselines.cascade.factors import Factors

SEQUENCE = 3
"""One of some twenty frames."""


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    folder = tmp_path_factory.mktemp("posterior") / "demo"
    return generate("demo", folder, Options(camera=make_camera("panorama"), tier="noisy", limit=8))


def posterior(dataset: Dataset, protocol: str = "one-step", frame: int = 5, solver: str = "vb-cv") -> Posterior:
    return find_posterior(dataset, SEQUENCE, frame, solver=solver, protocol=protocol)


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("frame", [2, 5])
@pytest.mark.parametrize("solver", ["vb-cv", "vb-sf"])
def test_the_posterior_is_finite_and_least_at_the_estimate(
    dataset: Dataset, protocol: str, frame: int, solver: str
) -> None:
    found = posterior(dataset, protocol, frame, solver)
    steps = np.concatenate([np.linspace(-5, 5, 20), np.linspace(-1e-3, 1e-3, 20)])
    excess = found.excess(found.pose[0] + steps, found.pose[1] + steps)
    assert np.isfinite(excess).all()
    assert excess.min() > -1e-6
    least = minimize(lambda place: float(found.excess(place[:1], place[1:])[0, 0]), found.pose[:2] + 0.02, tol=1e-10)
    np.testing.assert_allclose(least.x, found.pose[:2], atol=1e-5)


def test_the_energy_is_half_the_weighted_squares_at_the_best_yaw() -> None:
    random = np.random.default_rng(0)
    walk, ego_std, people = np.array([1.0, 2.0, 0.3]), 0.2, 5
    expected, std = random.uniform(-6, 6, (people, 2)), random.uniform(0.05, 0.3, people)
    relative = world_to_relative(expected, walk) + random.normal(0, 0.1, (people, 2))
    covariance = np.array([[0.02, 0.005, 0.03]] * people)
    relative[3], std[4] = np.nan, np.nan  # not observed; of unknown past

    def energy(place: np.ndarray, yaw: float) -> float:
        axes = np.array([[np.sin(yaw), -np.cos(yaw)], [np.cos(yaw), np.sin(yaw)]])  # rows: right, forward
        total = np.sum((place - walk[:2]) ** 2) / ego_std**2
        for k in range(3):
            (rr, rf, ff), v = covariance[k], std[k] ** 2
            r = relative[k] - axes @ (expected[k] - place)
            total += r @ np.linalg.solve([[rr + v, rf], [rf, ff + v]], r)
        return 0.5 * float(total)

    def slow(place: np.ndarray) -> float:
        yaws = np.linspace(-np.pi, np.pi, 721)
        start = yaws[np.argmin([energy(place, yaw) for yaw in yaws])]
        return float(minimize(lambda yaw: energy(place, yaw[0]), [start], tol=1e-12).fun)

    places = walk[:2] + np.array([[0.0, 0.0], [0.05, 0.0], [-0.3, 0.8], [2.0, -3.0]])
    found = location_energies(places, Factors(relative, covariance, expected, std, walk, ego_std))
    want = np.array([slow(place) for place in places])
    np.testing.assert_allclose(found - found[0], want - want[0], rtol=1e-5, atol=1e-4)


def test_the_answers_are_those_of_the_runner(dataset: Dataset) -> None:
    found = posterior(dataset, "sequential", 4)
    assert np.isfinite(found.estimate.poses[:5]).all()
    assert np.isnan(found.estimate.poses[5:]).all()
    assert len(found.estimate.poses) == dataset.sequence(SEQUENCE).frames


@pytest.mark.parametrize(
    ("frame", "solver", "message"),
    [
        (1, "vb-cv", "posteriors in frames 2 to"),
        (999, "vb-cv", "not in 999"),
        (5, "cv", "no location_energy"),
        (5, "vb-vc", "did you mean 'vb-cv'"),
    ],
)
def test_what_has_no_posterior_says_so(dataset: Dataset, frame: int, solver: str, message: str) -> None:
    with pytest.raises(VbbenchError, match=message):
        find_posterior(dataset, SEQUENCE, frame, solver=solver, protocol="one-step")


def test_contours_and_spread_of_a_normal_density() -> None:
    x, y = np.linspace(-1.0, 1.0, 301), np.linspace(-0.5, 0.5, 301)
    density = np.exp(-0.5 * ((x / 0.1) ** 2 + (y[:, None] / 0.05) ** 2))
    assert spread(density, x, y) == pytest.approx((0.1, 0.05), rel=1e-3)
    for share in (0.5, 0.95):
        assert density_level(density, share) == pytest.approx(1.0 - share, rel=0.02)  # p = 1 − exp(−r²/2)


def test_the_picture_shows_the_landscape_and_the_close_up(dataset: Dataset) -> None:
    figure = plot_posterior(dataset, SEQUENCE, frame=5)
    parts: dict[Any, Any] = {axes.get_label(): axes for axes in figure.axes}
    images = {image.get_gid() for axes in figure.axes for image in axes.images}
    assert {"landscape", "density"} <= images
    places = {line.get_gid(): line.get_xydata()[0] for line in parts["close"].lines}
    truth = dataset.truth(dataset.sequence(SEQUENCE)).poses[5, :2]
    np.testing.assert_allclose(places["place-truth"], truth)
    assert parts["close"].viewLim.contains(*places["place-truth"])
    assert parts["close"].viewLim.contains(*places["place-estimate"])
    words = " ".join(text.get_text() for text in parts["legend"].get_legend().get_texts())
    assert "95% of the posterior" in words
    assert "σ =" in parts["close"].get_title(loc="left")


def test_the_command_line_draws_it(dataset: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = [
        "plot",
        str(dataset.folder),
        "--sequence",
        str(SEQUENCE),
        "--posterior",
        "--out",
        str(tmp_path / "p.png"),
    ]
    assert main([*command, "--protocol", "sequential", "--frame", "4"]) == 0
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    assert main([*command, "--estimate", "nowhere"]) == 2
    assert "remove --estimate" in capsys.readouterr().err
