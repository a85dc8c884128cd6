"""The raster backend: near plane, seam, nobody, observer, threads."""

from dataclasses import replace

import numpy as np
import pytest

from tests.lib.standing_people import AHEAD, AROUND, ORIGIN, standing
from vbbench.camera import Camera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.pictures.rendering import Picture
from vbbench.sequence import NOBODY
from vbbench_renderers._core import Meshes, cast_shadows
from vbbench_renderers.meshes import (
    PLAIN,
    Float32,
    Limbs,
    Mesh,
    join_meshes,
    linear_to_srgb,
    split_mesh,
    srgb_to_linear,
)
from vbbench_renderers.raster import Drawer, RasterRenderer, halved_sizes
from vbbench_renderers.surroundings import build_surroundings, plain_surroundings

CAMERAS = [pytest.param(AHEAD, id="perspective"), pytest.param(AROUND, id="panorama")]


def triangle_mesh(corners: Float32) -> Mesh:
    count = len(corners) // 3
    return Mesh(
        vertices=np.asarray(corners, np.float32),
        normals=np.tile(np.float32([0, 0, 1]), (3 * count, 1)),
        colours=np.ones((3 * count, 3), np.float32),
        uv=np.zeros((3 * count, 2), np.float32),
        layers=np.full(3 * count, PLAIN, np.int32),
        triangles=np.arange(3 * count, dtype=np.int32).reshape(-1, 3),
    )


class Solids:
    """One mesh, in the world as it is, for the first person."""

    levels = 1

    def __init__(self, mesh: Mesh) -> None:
        self.meshes = (mesh,)

    def limbs(self, frame: int, eye: object, focal: float, *, without: int | None = None) -> Limbs:
        colour, number = np.ones((1, 3), np.float32), np.zeros(1, np.int32)
        return Limbs(
            mesh=number,
            transform=np.eye(3, 4, dtype=np.float32)[None],
            colour=colour,
            second_colour=colour,
            pattern=number,
            gloss=np.zeros(1, np.float32),
            person=number,
        )


def draw(corners: list[list[float]], camera: Camera, pose: np.ndarray = ORIGIN) -> Picture:
    """Triangles that belong to person 3, over a plain ground."""
    scene = standing([(0.0, 0.0)])
    drawer = Drawer(scene, Solids(triangle_mesh(np.array(corners))), plain_surroundings((-2.0, -2.0, 2.0, 2.0)))
    return drawer.render(0, camera, pose)


@pytest.mark.slow
@pytest.mark.parametrize("camera", CAMERAS)
def test_shared_edges_leave_no_hole_and_sides_are_culled(camera: Camera) -> None:
    rng = np.random.default_rng(4)
    grid = np.stack(np.meshgrid(np.linspace(-1.2, 1.2, 9), np.linspace(0.4, 2.8, 9), indexing="ij"), axis=-1)
    grid[1:-1, 1:-1] += rng.uniform(-0.1, 0.1, (7, 7, 2))
    corners = [
        [2.0, float(y), float(z)]
        for i in range(8)
        for j in range(8)
        for a, b in ((0, 0), (1, 1), (1, 0), (0, 0), (0, 1), (1, 1))
        for y, z in (grid[i + a, j + b],)
    ]
    seen = draw(corners, camera).ids == 3
    assert seen.sum() > 2000
    rows = [np.flatnonzero(row) for row in seen if row.any()]
    assert all(len(found) == found[-1] - found[0] + 1 for found in rows)
    assert not (draw(corners[::-1], camera).ids == 3).any()


def test_edges_are_curved_in_the_panorama_and_depth_is_range() -> None:
    corners = [[2.0, 6.0, 0.0], [2.0, -6.0, 0.0], [2.0, -6.0, 3.0], [2.0, 6.0, 0.0], [2.0, -6.0, 3.0], [2.0, 6.0, 3.0]]
    picture = draw(corners, AROUND)
    azimuth = 2 * np.pi * (np.arange(AROUND.width) + 0.5) / AROUND.width - np.pi
    reach = 2.0 / np.cos(azimuth)
    wide = np.abs(azimuth) < 1.2
    top = np.argmax(picture.ids[:, wide] == 3, axis=0)
    expected = np.maximum(AROUND.cy + AROUND.focal * (AROUND.mount_height - 3.0) / reach[wide], 0.0)
    assert np.array_equal(top, np.ceil(expected - 0.5))
    assert np.allclose(picture.depth[60, wide], reach[wide], rtol=1e-5)


def test_the_seam_shows_what_is_behind() -> None:
    corners = [[-3.0, -1.0, 0.0], [-3.0, 1.0, 0.0], [-3.0, 0.0, 2.5]]
    seen = draw(corners, AROUND).ids == 3
    assert seen[:, 0].any()
    assert seen[:, -1].any()
    assert abs(int(seen[:, :180].sum()) - int(seen[:, 180:].sum())) <= 2


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_triangle_under_and_behind_the_camera_is_whole(camera: Camera) -> None:
    picture = draw([[50.0, 40.0, 0.5], [-50.0, 0.0, 0.5], [50.0, -40.0, 0.5]], camera)
    down = np.arange(picture.ids.shape[0]) + 0.5 - 60.0
    focal = camera.focal
    inside = slice(75, 85) if isinstance(camera, PerspectiveCamera) else slice(175, 185)
    steep = down > 20.0
    assert (picture.ids[steep, inside] == 3).all()
    expected = focal * 1.1 / down[steep]
    assert np.allclose(picture.depth[steep, inside], expected[:, None], rtol=1e-5)


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_person_at_arms_length_is_drawn(camera: Camera) -> None:
    scene = standing([(0.3, 0.0), (6.0, 1.0)])
    picture = RasterRenderer(scene, surroundings=False).render(0, camera, ORIGIN)
    near = picture.ids == 3
    assert near.sum() > 500
    assert picture.depth[near].min() >= 0.1
    assert picture.depth[near].min() < 0.45


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_observer_and_absent_people_are_left_out(camera: Camera) -> None:
    scene = standing([(3.0, 0.0), (4.0, 1.0), (np.nan, np.nan)])
    renderer = RasterRenderer(scene, surroundings=False)
    assert set(np.unique(renderer.render(0, camera, ORIGIN).ids)) == {NOBODY, 3, 10}
    assert set(np.unique(renderer.render(0, camera, ORIGIN, observer=3).ids)) == {NOBODY, 10}
    with pytest.raises(VbbenchError, match="no person 4"):
        renderer.render(0, camera, ORIGIN, observer=4)


@pytest.mark.parametrize("camera", CAMERAS)
def test_nobody_at_all(camera: Camera) -> None:
    scene = standing([])
    picture = RasterRenderer(scene, surroundings=False).render(0, camera, ORIGIN)
    assert (picture.ids == NOBODY).all()
    assert np.isinf(picture.depth[0]).all()
    assert np.isfinite(picture.depth[-1]).all()


@pytest.mark.slow
@pytest.mark.parametrize("camera", CAMERAS)
def test_pictures_do_not_depend_on_threads_or_on_what_was_drawn_before(
    camera: Camera, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(2)
    scene = standing([tuple(place) for place in rng.uniform(-6, 6, (12, 2))])
    pose = np.array([0.1, 0.2, 0.4])
    renderer = RasterRenderer(scene, seed=5)
    first = renderer.render(0, camera, pose)
    for threads in (1, 3):
        monkeypatch.setattr("vbbench_renderers._core.available_threads", lambda threads=threads: threads)
        renderer.render(1, camera, -pose)
        second = renderer.render(0, camera, pose)
        for name in ("rgb", "depth", "ids"):
            assert np.array_equal(getattr(first, name), getattr(second, name))


def test_a_pose_turned_by_a_pixel_turns_the_panorama_by_a_pixel() -> None:
    scene = standing([(3.0, 0.5), (-2.0, 2.0), (1.0, -4.0), (-4.0, -0.1)])
    renderer = RasterRenderer(scene, surroundings=False)
    first = renderer.render(0, AROUND, ORIGIN).ids
    turned = renderer.render(0, AROUND, np.array([0.0, 0.0, 90 * 2 * np.pi / AROUND.width])).ids
    assert (np.roll(first, 90, axis=1) == turned).mean() > 0.9999


def test_pieces_of_a_mesh_hold_every_triangle_once() -> None:
    mesh = build_surroundings((-4.0, -4.0, 4.0, 4.0), 0).mesh
    pieces = split_mesh(mesh)
    whole = join_meshes(pieces)
    corners = np.sort(whole.vertices[whole.triangles].reshape(-1, 9), axis=0)
    assert np.array_equal(corners, np.sort(mesh.vertices[mesh.triangles].reshape(-1, 9), axis=0))
    assert max(len(piece.triangles) for piece in pieces) <= 256


def test_smaller_textures_keep_the_light() -> None:
    layers = np.random.default_rng(0).integers(0, 256, (2, 16, 16, 3)).astype(np.uint8)
    linear = srgb_to_linear(np.arange(256, dtype=np.float32) / 255.0)
    sizes = halved_sizes(layers)
    assert [level.shape for level in sizes] == [(2, size, size, 3) for size in (16, 8, 4, 2, 1)]
    assert np.allclose(linear[sizes[-1][:, 0, 0]], linear[layers].mean(axis=(1, 2)), atol=0.01)
    values = np.linspace(0, 1, 50, dtype=np.float32)
    assert np.allclose(srgb_to_linear(linear_to_srgb(values)), values, atol=1e-5)


@pytest.mark.parametrize(
    ("name", "values", "problem"),
    [
        ("vertices", np.zeros((3, 3)), "vertices must be an array of float32 in C order"),
        ("normals", np.zeros((2, 3), np.float32), r"normals must have the shape \[3, 3\], not \[2, 3\]"),
        ("triangles", np.array([[0, 1, 3]], np.int32), "triangles must be from 0 to below 3"),
    ],
)
def test_meshes_that_do_not_fit_are_refused(name: str, values: np.ndarray, problem: str) -> None:
    with pytest.raises(VbbenchError, match=problem):
        Meshes([replace(triangle_mesh(np.eye(3, dtype=np.float32)), **{name: values})])


def test_limbs_of_no_mesh_are_refused() -> None:
    meshes = Meshes([triangle_mesh(np.eye(3, dtype=np.float32))])
    with pytest.raises(VbbenchError, match="mesh must be from 0 to below 1"):
        cast_shadows(meshes, np.ones(1, np.int32), np.zeros((1, 3, 4)), 8, 1)


def test_textures_that_do_not_fit_are_refused() -> None:
    around = plain_surroundings((-2.0, -2.0, 2.0, 2.0))
    drawer = Drawer(standing([]), Solids(triangle_mesh(np.eye(3))), replace(around, textures=around.textures[:1]))
    with pytest.raises(VbbenchError, match="textures must have squares of every layer"):
        drawer.render(0, AHEAD, ORIGIN)
