"""Plots, films and recordings with tilted cameras, and with a model that vbbench does not know."""

from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.extensions.fisheye import Fisheye
from tests.lib.flat_renderer import FlatRenderer
from tests.pictures.plotting.test_plotting import FOCUS, boxes, gids, make, part
from vbbench import registry
from vbbench.camera import Camera, EquirectangularCamera, PanoramaCamera, PerspectiveCamera
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.geometry import world_to_relative
from vbbench.pictures.film import TITLE_HEIGHT, Film
from vbbench.pictures.plotting import plot_sequence
from vbbench.pictures.rendering import Rendered, scene_of
from vbbench.pictures.replay import load_replay
from vbbench.pictures.viewer import record_to_file

CAMERAS = {
    "pinhole": PerspectiveCamera(pitch=-0.2, roll=0.12, vertical_focal=600.0),
    "panorama": PanoramaCamera(pitch=-0.15, roll=0.1),
    "equirectangular": EquirectangularCamera(pitch=-0.15, roll=0.1),
    "fisheye": Fisheye(pitch=-0.3, roll=0.1),
    "level-fisheye": Fisheye(),
}


@pytest.fixture(scope="module", params=CAMERAS)
def dataset(request: Any, tmp_path_factory: pytest.TempPathFactory) -> Any:
    point = EntryPoint("fisheye", "tests.extensions.fisheye:Fisheye", "vbbench.cameras")
    cameras, found = {**registry.registered("camera"), "fisheye": point}, registry.registered
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(registry, "registered", lambda kind: cameras if kind == "camera" else found(kind))
        folder = tmp_path_factory.mktemp(request.param) / "demo"
        yield generate("demo", folder, Options(camera=CAMERAS[request.param], height_std=0.0, limit=1))


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
def test_a_plot_has_horizon_and_boxes_and_a_field_of_view_where_there_are_borders(camera: Camera):
    figure = plot_sequence(make(camera), 0, frame=FOCUS)
    (line,) = (line for line in part(figure, "ego").lines if line.get_gid() == "horizon")
    shown = camera.to_level(camera.directions(line.get_xydata()))
    np.testing.assert_allclose(shown[:, 1] / np.hypot(shown[:, 0], shown[:, 2]), 0.0, atol=1e-5)
    assert camera.kind == "fisheye" or np.ptp(line.get_ydata()) > 40.0
    assert {"box-14", "box-3"} <= set(boxes(figure))
    assert ("field-of-view" in gids(part(figure, "bird"))) == (camera.period is None)
    low, high = sorted(part(figure, "ego").get_ylim())
    if camera.period is None:
        assert (low, high) == (0.0, camera.picture_size[1])
    else:
        assert low < camera.horizon(np.array([0.0, 700.0])).min()


def test_distances_are_those_of_people_of_mean_height(dataset: Dataset):
    replay = load_replay(dataset, 0)
    assert replay.truth is not None
    depth = dataset.info.camera.depth(world_to_relative(replay.truth.positions, replay.truth.poses))
    seen = replay.sequence.observed & (depth > 2.0)  # the box of somebody near is bent in a fisheye
    assert seen.sum() > 20
    np.testing.assert_allclose(replay.distances[seen], depth[seen], rtol=0.1)
    assert abs(np.median(replay.distances[seen] / depth[seen]) - 1.0) < 0.01


def test_a_film_has_the_map_beside_a_picture_with_borders_and_below_one_without(dataset: Dataset):
    replay, camera = load_replay(dataset, 0), dataset.info.camera
    film = Film(replay, Rendered(replay, FlatRenderer(scene_of(dataset, replay.sequence.scene))))
    width, height = camera.picture_size
    frame = next(film.frames([3]))
    assert frame.shape == (film.height, film.width, 3)
    assert (film.width > width) == (camera.period is None)
    assert (film.height > TITLE_HEIGHT + height + film.bird.height) == (camera.period is not None)


@pytest.mark.extra
def test_a_recording_hangs_pictures_of_pinholes_alone_on_a_camera(dataset: Dataset, tmp_path: Path):
    pytest.importorskip("rerun.chunk", reason="needs the extra viewer, new enough to read recordings")
    from tests.pictures.test_viewer import read

    camera = dataset.info.camera
    entities = read(record_to_file(dataset, 0, tmp_path / "x.rrd"))
    assert ("ego/boxes" in entities) == (camera.intrinsics is None)
    strips = entities["ego/horizon*" if camera.intrinsics is None else "world/observer/camera/horizon*"]
    points = np.reshape(strips["LineStrips2D:strips"][0], (-1, 2))
    np.testing.assert_allclose(camera.horizon(points[:, 0]), points[:, 1], atol=1e-2)
    if camera.intrinsics is None:
        return
    turned = np.reshape(entities["world/observer/camera*"]["Transform3D:mat3x3"][0], (3, 3))  # a column each
    ahead, left, up = turned @ (point := np.array([6.0, 1.0, -0.4]))
    right, down, _ = camera.intrinsics @ np.array([-left / ahead, -up / ahead, 1.0])
    expected = camera.pixels(camera.to_camera(np.array([-point[1], -point[2], point[0]])))
    np.testing.assert_allclose([right, down], expected, atol=1e-2)
