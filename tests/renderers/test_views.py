"""Pictures that are assembled from perspective views."""

import numpy as np

from tests.lib.standing_people import AROUND
from vbbench.pictures.rendering import Picture
from vbbench_renderers.views import resample, views_of


def test_views_cover_the_panorama_once_and_hold_every_ray() -> None:
    height = AROUND.picture_size[1]
    count = np.zeros((height, AROUND.width), int)
    for view in views_of(AROUND):
        count[np.ix_(view.rows, view.columns)] += view.wanted
        assert view.x[view.wanted].min() >= 0
        assert view.x[view.wanted].max() <= view.camera.width - 1
        assert view.y[view.wanted].min() >= 0
        assert view.y[view.wanted].max() <= view.camera.height - 1
    assert (count == 1).all()


def test_depth_of_a_wall_becomes_its_range() -> None:
    view = views_of(AROUND)[0]
    assert (view.turn, view.camera.pitch) == (0.0, 0.0)
    shape = view.camera.height, view.camera.width
    blank = np.zeros(shape, np.int32)
    wall = Picture(rgb=np.zeros((*shape, 3), np.uint8), depth=np.full(shape, 5.0, np.float32), ids=blank)
    found = resample(view, wall)
    azimuth = np.broadcast_to(2 * np.pi * (view.columns + 0.5) / AROUND.width - np.pi, view.wanted.shape)
    assert np.allclose(found.depth[view.wanted], (5.0 / np.cos(azimuth))[view.wanted], rtol=1e-5)
    assert (found.ids == 0).all()
