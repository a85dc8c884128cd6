"""A camera model from outside, one file and an entry point: it goes wherever the bundled ones go."""

import os
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.extensions import fisheye
from tests.lib.board_results import ABOUT
from tests.lib.flat_renderer import FlatRenderer
from tests.lib.installing import Installed
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera, camera_from_dict, camera_to_dict, make_camera
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.pictures.plotting import plot_to_file
from vbbench.pictures.rendering import Backend, render_to_file
from vbbench.registry import registered
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.site.player import FOLDER, Films, write_player

TIERS = ("ideal", "noisy", "occluded", "tracked")
LIKE = {
    "perspective": PerspectiveCamera(width=1280, height=960, focal=400.0, cx=640.0, cy=480.0),
    "panorama": PanoramaCamera(width=round(2 * np.pi * 400), focal=400.0, cy=480.0),
}
"""Bundled cameras with as many px per rad."""


@pytest.fixture(scope="module", autouse=True)
def outside(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A stranger's folder with the model's file and the metadata that name it, as an installed package has them."""
    folder = tmp_path_factory.mktemp("outside")
    shutil.copyfile(fisheye.__file__, folder / "strange_lens.py")
    with pytest.MonkeyPatch.context() as patch:
        Installed(patch, folder, "vbbench.cameras", "fisheye", "strange_lens:Fisheye")
        patch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")])))
        yield folder
    registered.cache_clear()


def options(camera: Camera, tier: str) -> Options:
    return Options(camera=camera, tier=tier, simulation=Simulation(sequences=4, people=(12,)))


@pytest.fixture(scope="module")
def datasets(outside: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Dataset]:
    """Split sim seen by the fisheye, by tier."""
    folder = tmp_path_factory.mktemp("sim")
    return {tier: generate("sim", folder / tier, options(make_camera("fisheye"), tier)) for tier in TIERS}


def test_it_is_registered_and_survives_files() -> None:
    camera = make_camera("fisheye", pitch=-0.2)
    assert type(camera).__module__ == "strange_lens"
    assert camera_from_dict(camera_to_dict(camera)) == camera


@pytest.mark.parametrize("tier", TIERS)
def test_every_tier_is_made_sound(datasets: dict[str, Dataset], tier: str) -> None:
    dataset = datasets[tier]
    verify(dataset.folder)
    assert dataset.info.camera == make_camera("fisheye")
    seen = np.concatenate([dataset.sequence(index).observed.ravel() for index in range(len(dataset))])
    assert 0.2 < seen.mean() < 1.0


def test_a_recording_is_seen_by_it(data_folder: Path, tmp_path: Path) -> None:
    dataset = generate("hotel", tmp_path / "hotel", Options(camera=make_camera("fisheye"), tier="occluded", limit=3))
    verify(dataset.folder)


@pytest.mark.slow
@pytest.mark.parametrize("solver", ["vb-sf", "map-causal"])
def test_solvers_err_as_with_bundled_cameras(datasets: dict[str, Dataset], solver: str, tmp_path: Path) -> None:
    def error(dataset: Dataset, name: str) -> float:
        return float(
            score(solve(dataset, solver, "sequential", tmp_path / name), dataset.folder).values()["metrics"]["dx"][
                "mean"
            ]
        )

    theirs = error(datasets["noisy"], "fisheye")
    ours = [
        error(generate("sim", tmp_path / f"of-{name}", options(camera, "noisy")), name) for name, camera in LIKE.items()
    ]
    assert theirs < 1.5 * max(ours)


@pytest.mark.parametrize("pitch", [0.0, -0.3])
def test_it_tells_where_people_are_by_their_feet(pitch: float) -> None:
    camera = make_camera("fisheye", pitch=pitch, roll=0.1, mount_height=1.2)
    rng = np.random.default_rng(5)
    azimuth, reach, heights = rng.uniform(-1.2, 1.2, 300), rng.uniform(2.0, 20.0, 300), rng.uniform(1.5, 1.9, 300)
    relative = reach[:, None] * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=-1)
    boxes = camera.project_unbounded(relative, heights)
    mount = np.full(300, camera.mount_height)
    np.testing.assert_allclose(camera.unproject(boxes, heights), relative, atol=0.005)
    np.testing.assert_allclose(camera.unproject(camera.to_horizon(boxes), mount), relative, atol=0.005)
    np.testing.assert_allclose(camera.statures(boxes)[1], heights, atol=0.005)


@pytest.mark.slow
def test_plots_films_and_the_player_show_it(datasets: dict[str, Dataset], tmp_path: Path) -> None:
    dataset, board = datasets["ideal"], Board(split="sim", tier="ideal", protocol="sequential")
    shutil.copytree(dataset.folder, tmp_path / "datasets" / "sim-ideal")
    answers = tmp_path / "submissions" / board.key / "vb-cv"
    answers.parent.mkdir(parents=True)
    solve(dataset, "vb-cv", "sequential", answers)
    assert plot_to_file(dataset, 0, tmp_path / "plot.png", submissions=[answers]).stat().st_size > 10_000
    backend = Backend(name=f"{FlatRenderer.__module__}:FlatRenderer")
    film = render_to_file(dataset, 0, tmp_path / "film", backend=backend, submission=answers)
    assert len(list(film.glob("*.png"))) == dataset.sequence(0).frames
    result = replace(Result.of(score(answers, dataset.folder), answers, ABOUT, name="vb-cv"), board=board)
    write_player(tmp_path / "site", {board: (result,)}, Films(work=tmp_path, sequences=1))
    clip = next((tmp_path / "site" / FOLDER / "sim" / "ideal").glob("*.js")).read_text(encoding="utf-8")
    width, height = dataset.info.camera.picture_size
    assert f'"picture":{{"width":{width},"top":0.0,"height":{height:.1f},"round":false' in clip.replace(" ", "")
    assert '"picture"' in clip
