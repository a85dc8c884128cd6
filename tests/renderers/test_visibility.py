"""Boxes, visible fractions and truncation, against projection and against counting by hand."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from benchmarks.visibility import Onlooker, Seen
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.pictures.rendering import Picture
from vbbench.scene import Scene
from vbbench_renderers.people import Walkers
from vbbench_renderers.raster import RasterRenderer

LARGE = PerspectiveCamera()
SMALL = PerspectiveCamera(width=320, height=240, focal=160.0, cx=160.0, cy=120.0)
AROUND = PanoramaCamera(width=720, focal=720 / (2 * np.pi), cy=120.0)
ORIGIN = np.zeros(3)
SOLE = 0.32
"""How far (m) a foot may reach out from the place where its owner stands, in a stride."""

Look = Callable[..., tuple[Picture, Seen]]


def crowd(places: Any, walk: float = 0.0) -> Scene:
    start = np.asarray(places, dtype=np.float64).reshape(-1, 2)
    paths = start + np.arange(6)[:, None, None] * np.array([walk, 0.3 * walk])
    count = len(start)
    heights = np.linspace(1.5, 1.95, count) if count else np.empty(0)
    return Scene(name="t", dt=0.1, people=np.arange(count) * 3 + 2, positions=paths, heights=heights)


def look(
    scene: Scene, camera: Camera, pose: Any = ORIGIN, frame: int = 2, observer: int | None = None
) -> tuple[Picture, Seen]:
    picture = RasterRenderer(scene, surroundings=False).render(frame, camera, pose, observer=observer)
    return picture, Onlooker(scene, Walkers(scene, 0)).look(picture, frame, camera, pose, observer=observer)


def test_boxes_are_those_of_the_observation_model() -> None:
    reach, bearing = np.array([4.0, 6.0, 9.0, 13.0, 18.0, 25.0]), np.radians([-30.0, -12.0, 3.0, 14.0, 24.0, 34.0])
    scene = crowd(np.stack([reach * np.cos(bearing), reach * np.sin(bearing)], axis=-1))
    _, seen = look(scene, LARGE)
    relative = np.stack([-scene.positions[2, :, 1], scene.positions[2, :, 0]], axis=-1)
    boxes = LARGE.project(relative, scene.heights)
    bottom, top = boxes[:, 1] + 0.5 * boxes[:, 2], boxes[:, 1] - 0.5 * boxes[:, 2]
    # A sole in front of the body's place is seen lower than that place, by no more than this.
    lower = LARGE.focal * LARGE.mount_height * SOLE / (relative[:, 1] * (relative[:, 1] - SOLE))
    over = LARGE.focal * np.abs(LARGE.mount_height - scene.heights) * SOLE / (relative[:, 1] * (relative[:, 1] - SOLE))
    assert (np.abs(seen.box[:, 1] - top) <= 1.0 + over).all()
    assert (seen.box[:, 3] - bottom <= 1.0 + lower).all()
    assert (seen.box[:, 3] - bottom >= -1.0).all()
    assert (np.abs(seen.observations(LARGE)[:, 0] - boxes[:, 0]) <= 1.0 + 0.45 * LARGE.focal / relative[:, 1]).all()


@pytest.mark.slow
def test_visible_fraction_is_counted_against_the_picture_of_a_person_alone() -> None:
    scene = crowd([(3.0, 0.1), (5.0, 0.0), (7.0, -0.3), (9.0, 4.0)])
    picture, seen = look(scene, SMALL)
    for person, visible in zip(scene.people, seen.visible, strict=True):
        alone = Scene(
            name="t", dt=scene.dt, people=scene.people, heights=scene.heights,
            positions=np.where((scene.people == person)[:, None], scene.positions, np.nan),
        )  # fmt: skip
        by_hand = look(alone, SMALL)[0].ids == person
        assert visible == pytest.approx((picture.ids == person).sum() / by_hand.sum(), abs=1e-12)
    assert seen.visible[0] == 1.0
    assert 0.0 < seen.visible[2] < 1.0


def test_people_hidden_or_cut_off() -> None:
    scene = crowd([(12.0, 0.0), (4.0, 4.0), (-5.0, 0.0), (0.4, 0.0), (1.2, 0.0)])
    _, seen = look(scene, SMALL, observer=11)
    assert seen.person.tolist() == [2, 5, 14]
    assert seen.visible[0] == 0.0
    assert np.isnan(seen.box[0]).all()
    assert np.isnan(seen.observations(SMALL)[0]).all()
    assert seen.truncated[0] == 0.0
    assert 0.2 < seen.truncated[1] < 0.8
    assert seen.box[1, 0] == 0.0
    near = look(crowd([(0.5, 0.0)]), SMALL)[1]
    assert 0.3 < near.truncated[0] < 1.0


def test_a_box_over_the_seam_is_whole() -> None:
    scene = crowd([(-4.0, 0.02), (4.0, 0.0)])
    picture, seen = look(scene, AROUND)
    assert (picture.ids[:, 0] == 2).any()
    assert (picture.ids[:, -1] == 2).any()
    left, _, right, _ = seen.box[0]
    assert 0 <= left < AROUND.width < right
    assert right - left < 40
    u = float(seen.observations(AROUND)[0, 0])
    assert min(u, AROUND.width - u) < 10
    assert seen.visible.tolist() == [1.0, 1.0]
