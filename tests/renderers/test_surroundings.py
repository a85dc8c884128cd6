"""What the surroundings must be: the same by seed, out of people's way, sound as a mesh, and fit for a panorama."""

import numpy as np
import pytest

from vbbench.scene import Scene
from vbbench_renderers.meshes import Mesh
from vbbench_renderers.surroundings import build_surroundings, plain_surroundings, walking_area
from vbbench_renderers.surroundings.site import Area

STREET = (-11.0, -21.0, 11.0, 21.0)
AREAS = [STREET, (2.0, -3.0, 18.0, 6.0), (-1.0, 0.0, 3.0, 4.0), (-60.0, -40.0, 60.0, 40.0)]


def same(one: Mesh, other: Mesh) -> bool:
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in vars(one))


@pytest.mark.slow
def test_the_same_seed_gives_the_same_place_and_another_seed_another() -> None:
    first = build_surroundings(STREET, 0)
    build_surroundings.cache_clear()
    again = build_surroundings(STREET, 0)
    assert first is not again
    assert same(first.mesh, again.mesh)
    assert np.array_equal(first.sky.sun_direction, again.sky.sun_direction)
    other = build_surroundings(STREET, 1)
    assert first.mesh.vertices.shape != other.mesh.vertices.shape or not same(first.mesh, other.mesh)


@pytest.mark.slow
@pytest.mark.parametrize("area", AREAS)
@pytest.mark.parametrize("seed", [0, 3])
def test_nothing_stands_where_people_walk_and_the_mesh_is_sound(area: Area, seed: int) -> None:
    place = build_surroundings(area, seed)
    mesh = place.mesh
    corners = mesh.vertices[mesh.triangles].astype(float)
    high = corners[corners[..., 2].max(axis=1) > 0.05]
    low, top = high[..., :2].min(axis=1), high[..., :2].max(axis=1)
    inside = (low < area[2:]).all(axis=1) & (top > area[:2]).all(axis=1)
    assert not inside.any()
    assert mesh.triangles.min() >= 0
    assert mesh.triangles.max() < len(mesh.vertices)
    layers = mesh.layers[mesh.triangles]
    assert (layers == layers[:, :1]).all()
    assert layers.max() < len(place.textures)
    assert all(np.isfinite(getattr(mesh, name)).all() for name in ("vertices", "normals", "colours", "uv"))
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-4)
    assert mesh.colours.min() >= 0.0
    assert mesh.colours.max() <= 1.0
    assert np.isclose(np.linalg.norm(place.sky.sun_direction), 1.0, atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("area", AREAS)
def test_the_ground_lies_under_everybody(area: Area) -> None:
    mesh = plain_surroundings(area).mesh
    points = np.random.default_rng(0).uniform(area[:2], area[2:], (50, 2))
    a, b, c = (mesh.vertices[mesh.triangles[:, n], :2].astype(float) for n in range(3))
    for point in points:
        sides = [np.cross(np.pad(q - p, ((0, 0), (0, 1))), np.pad(point - p, ((0, 0), (0, 1))))[:, 2]
                 for p, q in ((a, b), (b, c), (c, a))]  # fmt: skip
        under = (np.array(sides) >= -1e-6).all(axis=0)
        assert under.any()
        assert np.allclose(mesh.vertices[mesh.triangles[under], 2], 0.0)


def test_plain_surroundings_are_ground_only() -> None:
    place = plain_surroundings(STREET)
    assert place.mesh.vertices[:, 2].max() <= 0.0
    assert place.textures.shape[1:] == (512, 512, 3)


def test_the_walking_area_holds_everybody_with_a_margin() -> None:
    positions = np.array([[[0.0, 1.0], [np.nan, np.nan]], [[8.0, 1.0], [3.0, -6.0]]])
    scene = Scene(name="s", dt=0.1, people=np.arange(2), positions=positions, heights=np.full(2, 1.7))
    assert walking_area(scene) == (-1.0, -7.0, 9.0, 2.0)
    alone = Scene(name="s", dt=0.1, people=np.arange(1), positions=np.zeros((1, 1, 2)), heights=np.full(1, 1.7))
    assert walking_area(alone) == (-2.0, -2.0, 2.0, 2.0)
