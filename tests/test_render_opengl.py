"""The OpenGL backend against cases whose answer is known without drawing."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.geometry import world_to_relative
from vbbench.pictures.rendering import Picture
from vbbench.scene import Scene
from vbbench.sequence import NOBODY
from vbbench_renderers._core import WIDEST, refine
from vbbench_renderers.drawing import Limbs, Pattern
from vbbench_renderers.mesh import Mesh
from vbbench_renderers.opengl import renderer as module
from vbbench_renderers.opengl import stage
from vbbench_renderers.opengl.probing import OpenGLError, find_device

SMALL = PerspectiveCamera(width=320, height=240, focal=160.0, cx=160.0, cy=120.0)
ROUND = PanoramaCamera(width=720, focal=720 / (2 * np.pi), cy=120.0)
NORTH = np.array((0.0, 0.0, np.pi / 2))  # looks along +y
SIDE = 0.4


@pytest.fixture(scope="module", autouse=True)
def needs_opengl() -> None:
    try:
        find_device()
    except OpenGLError as error:
        pytest.skip(f"no OpenGL here: {error.problem}")


def box() -> Mesh:
    """A cube with half side 1 whose faces have corners and normals of their own."""
    vertices, normals, triangles = [], [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            normal, a, b = np.roll((sign, 0, 0), axis), np.roll((0, 1, 0), axis), np.roll((0, 0, 1), axis)
            corners = [normal + i * a + j * b for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            start = len(vertices)
            vertices += corners if sign > 0 else corners[::-1]
            normals += [normal] * 4
            triangles += [(start, start + 1, start + 2), (start, start + 2, start + 3)]
    ones = np.ones((len(vertices), 3), np.float32)
    return Mesh(
        vertices=np.array(vertices, np.float32),
        normals=np.array(normals, np.float32),
        colours=ones,
        uv=ones[:, :2],
        layers=np.full(len(vertices), -1, np.int32),
        triangles=np.array(triangles, np.int32),
    )


class Boxes:
    """Stands in for `Walkers`: a box a person, as high as the person, whose looks a test may choose."""

    levels = 1
    pattern = Pattern.PLAIN
    colour, second_colour = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)

    def __init__(self, scene: Scene, seed: int) -> None:
        self.scene = scene

    def library(self, level: int) -> tuple[Mesh, ...]:
        return (box(),)

    def limbs(self, frame: int, eye: Any, focal: float, *, without: int | None = None) -> list[tuple[int, Limbs]]:
        people = np.array([k for k in np.nonzero(self.scene.present[frame])[0] if k != without], np.int32)
        transform = np.zeros((len(people), 3, 4), np.float32)
        transform[:, 0, 0] = transform[:, 1, 1] = SIDE / 2
        transform[:, 2, 2] = transform[:, 2, 3] = self.scene.heights[people] / 2
        transform[:, :2, 3] = self.scene.positions[frame, people]
        many = len(people)
        limbs = Limbs(
            mesh=np.zeros(many, np.int32),
            transform=transform,
            colour=np.tile(np.float32(self.colour), (many, 1)),
            second_colour=np.tile(np.float32(self.second_colour), (many, 1)),
            pattern=np.full(many, self.pattern, np.int32),
            gloss=np.zeros(many, np.float32),
            person=people,
        )
        return [(0, limbs)] if many else []


def people_at(*places: tuple[float, float], height: float = 1.8) -> Scene:
    many = len(places)
    positions = np.array(places, dtype=float).reshape(1, many, 2)
    people = 100 + 7 * np.arange(many)
    return Scene(name="boxes", dt=0.1, people=people, positions=positions, heights=np.full(many, height))


@pytest.fixture
def draw(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    monkeypatch.setattr(module, "Walkers", Boxes)
    opened = []

    def drawn(scene: Scene, camera: Any = SMALL, pose: Any = NORTH, **options: Any) -> Picture:
        opened.append(module.OpenGLRenderer(scene, surroundings=False))
        return opened[-1].render(0, camera, pose, **options)

    yield drawn
    for renderer in opened:
        renderer.close()


def span(mask: Any) -> tuple[int, int, int, int]:
    """First and last column and row."""
    rows, columns = np.nonzero(mask)
    return columns.min(), columns.max(), rows.min(), rows.max()


def test_a_box_stands_where_the_camera_model_says(draw: Any) -> None:
    picture = draw(people_at((1.0, 5.0)))
    near, f = 5.0 - SIDE / 2, SMALL.focal
    left, right, top, bottom = span(picture.ids == 100)
    # The front face: pixels whose centres lie inside of its projection.
    assert left == np.ceil(160 + f * (1.0 - SIDE / 2) / (5.0 + SIDE / 2) - 0.5)  # its left side shows too
    assert right == np.floor(160 + f * (1.0 + SIDE / 2) / near - 0.5)
    assert top == np.ceil(120 + f * (1.6 - 1.8) / near - 0.5)
    assert bottom == np.floor(120 + f * 1.6 / near - 0.5)
    front = picture.depth[(top + bottom) // 2, right - 2]
    assert front == pytest.approx(near, abs=1e-3)


def test_the_middle_of_a_box_is_where_project_says_in_both_cameras(draw: Any) -> None:
    scene = people_at((2.0, 6.0), (-1.5, 7.0), (0.3, 9.0))
    relative = world_to_relative(scene.positions[0], NORTH)
    for camera in (SMALL, ROUND):
        picture, boxes = draw(scene, camera), camera.project(relative, scene.heights)
        for person, (u, v, length) in zip(scene.people, boxes, strict=True):
            left, right, top, bottom = span(picture.ids == person)
            assert (left + right + 1) / 2 == pytest.approx(u, abs=1.0)
            assert (top + bottom + 1) / 2 == pytest.approx(v, abs=1.0)
            assert bottom - top + 1 == pytest.approx(length, rel=0.06, abs=1.0)


@pytest.mark.parametrize("camera", [SMALL, ROUND])
def test_ground_depth_follows_from_the_row(draw: Any, camera: Any) -> None:
    picture = draw(people_at((0.0, 0.0)), camera, observer=100)
    rows = np.arange(180, 240)  # ground where people walk, which is level
    expected = camera.focal * camera.mount_height / (rows + 0.5 - camera.cy)
    ground = picture.depth[rows]
    assert np.max(np.abs(ground / expected[:, None] - 1.0)) < 0.002
    assert np.all(picture.ids == NOBODY)
    assert np.all(np.isinf(picture.depth[:100]))


def test_ids_and_depth_are_sampled_and_not_blended(draw: Any) -> None:
    picture = draw(people_at((0.0, 4.0), (0.25, 8.0)))
    assert set(np.unique(picture.ids)) == {NOBODY, 100, 107}
    seen = picture.depth[picture.ids == 100]
    assert seen.min() > 3.79
    assert seen.max() < 4.21


def test_nearer_people_hide_those_behind(draw: Any) -> None:
    picture = draw(people_at((0.0, 8.0), (0.0, 3.0)))
    assert picture.ids[125, 160] == 107
    assert not np.any(picture.ids == 100)


def test_a_person_across_the_seam_shows_at_both_borders(draw: Any) -> None:
    picture = draw(people_at((0.05, -4.0)), ROUND)
    shown = (picture.ids == 100).any(axis=0)
    assert shown[0]
    assert shown[-1]
    assert shown.sum() == pytest.approx(2 * np.arctan(SIDE / 2 / (4.0 - SIDE / 2)) * ROUND.focal, abs=1.5)
    assert picture.depth[120, 0] == pytest.approx(4.0 - SIDE / 2, abs=0.01)  # large triangles bend a little
    moved = draw(people_at((0.05, -4.0)), ROUND, (0.0, 0.0, -np.pi / 2))
    assert (moved.ids == 100).sum() == pytest.approx((picture.ids == 100).sum(), abs=4)


def test_depth_of_a_panorama_is_the_horizontal_range(draw: Any) -> None:
    picture = draw(people_at((3.0, 0.0)), ROUND)
    column = round(ROUND.width * (np.pi / 2 + np.pi) / (2 * np.pi))
    assert picture.ids[120, column] == 100
    assert np.all(np.abs(picture.depth[115:130, column] - (3.0 - SIDE / 2)) < 0.01)


def test_the_observer_is_not_drawn_and_neither_is_anybody_absent(draw: Any) -> None:
    scene = people_at((0.0, 0.0), (0.0, 4.0), (np.nan, np.nan))
    assert set(np.unique(draw(scene, observer=100).ids)) == {NOBODY, 107}
    assert set(np.unique(draw(scene, ROUND, observer=107).ids)) >= {NOBODY}
    with pytest.raises(VbbenchError, match="no person 101"):
        draw(scene, observer=101)


def test_people_close_to_the_lens_are_cut_and_not_torn(draw: Any) -> None:
    for camera in (SMALL, ROUND):
        picture = draw(people_at((0.0, 0.35), (0.3, -0.2)), camera)
        assert (picture.ids == 100).mean() > 0.1
        assert np.nanmin(picture.depth) >= 0.09


def test_a_scene_without_anybody_is_drawn(draw: Any) -> None:
    picture = draw(people_at((np.nan, np.nan)))
    assert np.all(picture.ids == NOBODY)
    assert picture.rgb.std() > 1.0


def test_the_same_frame_is_the_same_picture_in_every_renderer(draw: Any) -> None:
    scene = people_at((0.5, 4.0), (-1.0, 6.0))
    first, second = draw(scene), draw(scene)
    for name in ("rgb", "depth", "ids"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_several_renderers_and_sizes_take_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "Walkers", Boxes)
    one = module.OpenGLRenderer(people_at((0.0, 4.0)), surroundings=False)
    other = module.OpenGLRenderer(people_at((0.0, 4.0), (1.0, 4.0)), surroundings=False)
    before = one.render(0, SMALL, NORTH)
    assert other.render(0, ROUND, NORTH).ids.max() == 107
    np.testing.assert_array_equal(one.render(0, SMALL, NORTH).rgb, before.rgb)
    one.close()
    one.close()
    with pytest.raises(VbbenchError, match="closed"):
        one.render(0, SMALL, NORTH)
    assert other.render(0, SMALL, NORTH).ids.max() == 107
    assert other.device
    other.close()


@pytest.mark.parametrize(
    ("pattern", "share"),
    [(Pattern.PLAIN, 0.0), (Pattern.LOWER_HALF, 0.5), (Pattern.CHECKS, 0.5), (Pattern.RINGS, 0.5)],
)
def test_patterns_show_the_second_colour_where_they_should(
    draw: Any, monkeypatch: pytest.MonkeyPatch, pattern: Pattern, share: float
) -> None:
    monkeypatch.setattr(Boxes, "pattern", pattern)
    picture = draw(people_at((0.0, 2.0)))
    body = picture.rgb[picture.ids == 100].astype(int)
    blue = body[:, 2] > body[:, 0]
    assert blue.mean() == pytest.approx(share, abs=0.15)
    if pattern == Pattern.LOWER_HALF:
        rows = np.nonzero(picture.ids == 100)[0]
        assert rows[blue].mean() > rows[~blue].mean()


def test_colour_is_antialiased_in_both_layers_of_people_and_place(draw: Any) -> None:
    picture = draw(people_at((0.3, 4.0)))
    red = picture.rgb[130].astype(int)
    steps = np.abs(np.diff(red[:, 0] - red[:, 2]))
    assert steps.max() < 0.9 * (red[:, 0] - red[:, 2]).max()


def test_refined_triangles_cover_the_same_ground_without_cracks() -> None:
    vertices = np.zeros((4, 12), np.float32)
    vertices[:, :2] = [(-20, -20), (20, -20), (20, 20), (-20, 20)]
    triangles = np.array([(0, 1, 2), (0, 2, 3)], np.int32)
    out = np.empty((60_000, 13), np.float32)
    corners = refine(vertices, triangles, np.array((0.3, -0.4, 1.6)), 0.7, -1.0, 1.0, out)
    assert corners <= len(out)
    cut = out[:corners].reshape(-1, 3, 13)
    right, forward = np.moveaxis(world_to_relative(cut[..., :2].astype(float), np.array((0.3, -0.4, 0.7))), -1, 0)
    azimuth = np.arctan2(right, forward)
    turn = np.abs(np.angle(np.exp(1j * (azimuth - np.roll(azimuth, 1, axis=1)))))
    assert turn.max() <= WIDEST + 1e-6
    once = cut[np.abs(cut[:, 0, 12]) <= np.pi + 1e-6][..., :2].astype(float)
    side_a, side_b = once[:, 1] - once[:, 0], once[:, 2] - once[:, 0]
    area = 0.5 * (side_a[:, 0] * side_b[:, 1] - side_a[:, 1] * side_b[:, 0])
    assert np.all(area > 0)
    assert 1600 - np.pi * 1.6**2 - 1e-3 <= area.sum() <= 1600 + 1e-3


@pytest.mark.slow
def test_a_gpu_samples_surroundings_finely_and_shows_the_same_surfaces(
    draw: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = people_at((0.5, 4.0), (-1.0, 6.0))
    for camera in (SMALL, ROUND):
        monkeypatch.setattr(stage, "is_software", lambda device: True)
        coarse = draw(scene, camera)
        monkeypatch.setattr(stage, "is_software", lambda device: False)
        fine = draw(scene, camera)
        np.testing.assert_array_equal(fine.ids, coarse.ids)
        near = coarse.depth < 8.0
        np.testing.assert_allclose(fine.depth[near], coarse.depth[near], rtol=2e-3)
        assert np.mean(np.abs(fine.rgb.astype(int) - coarse.rgb)) < 4.0
