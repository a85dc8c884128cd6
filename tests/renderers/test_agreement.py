"""Backends against ray casting with Embree (a test-only dependency), and against one another."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from tests.extensions.fisheye import Fisheye
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.pictures.rendering import Picture, Renderer
from vbbench.scene import Scene
from vbbench.sequence import NOBODY
from vbbench_renderers.people import Walkers
from vbbench_renderers.raster import RasterRenderer
from vbbench_renderers.surroundings import build_surroundings, walking_area

CAMERAS: dict[str, Camera] = {
    "perspective": PerspectiveCamera(width=640, height=480, focal=320.0, cx=320.0, cy=240.0),
    "panorama": PanoramaCamera(width=720, focal=720 / (2 * np.pi), cy=120.0),
    "tilted": PerspectiveCamera(
        width=640, height=480, focal=320.0, cx=300.0, cy=200.0, pitch=-0.25, roll=0.15, vertical_focal=280.0
    ),
    "tilted panorama": PanoramaCamera(width=720, focal=720 / (2 * np.pi), cy=120.0, pitch=-0.1, roll=0.15),
    "fisheye": Fisheye(width=640, height=480, focal=200.0, pitch=-0.3, roll=0.1),
}
RESAMPLED = ("tilted panorama", "fisheye")
POSES = {"middle": np.array([0.3, -0.2, 0.7]), "edge": np.array([-9.0, 4.0, -0.4])}


@pytest.fixture(scope="module")
def scene() -> Scene:
    rng = np.random.default_rng(11)
    places = rng.uniform(-10.0, 10.0, (30, 2))
    places = places[[min(np.hypot(*(place - pose[:2])) for pose in POSES.values()) > 1.0 for place in places]]
    paths = places + np.arange(8)[:, None, None] * rng.normal(0.0, 0.1, places.shape)
    heights = rng.uniform(1.5, 1.95, len(places))
    return Scene(name="t", dt=0.1, people=np.arange(len(places)) * 2 + 5, positions=paths, heights=heights)


def world_triangles(scene: Scene, frame: int, eye: Any, focal: float) -> tuple[Any, Any]:
    """Corners [F, 3, 3] in the world, and the person of each triangle."""
    walkers, corners, owners = Walkers(scene, 0), [], []
    limbs = walkers.limbs(frame, eye, focal)
    for mesh, transform, person in zip(limbs.mesh, limbs.transform.astype(np.float64), limbs.person, strict=True):
        placed = walkers.meshes[mesh].vertices @ transform[:, :3].T + transform[:, 3]
        corners.append(placed[walkers.meshes[mesh].triangles])
        owners.append(np.full(len(corners[-1]), scene.people[person]))
    static = build_surroundings(walking_area(scene), 0).mesh
    corners.append(static.vertices[static.triangles])
    owners.append(np.full(len(static.triangles), NOBODY))
    return np.concatenate(corners), np.concatenate(owners)


def cast_rays(corners: Any, owners: Any, camera: Camera, pose: Any) -> tuple[Any, Any]:
    """Ids and depth of the first surface along every ray."""
    import trimesh
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    solid = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3), process=False)
    width, height = camera.picture_size
    pixels = np.stack(np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5), axis=-1)
    ways = camera.directions(pixels)
    if camera.intrinsics is None:
        level = camera.to_level(ways)
        ways = ways / np.hypot(level[..., 0], level[..., 2])[..., None]
    right, down, forward = np.moveaxis(camera.to_level(ways), -1, 0)
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    ways = np.stack([forward * cos + right * sin, forward * sin - right * cos, -down], axis=-1).reshape(-1, 3)
    origin, shape = np.array([*pose[:2], camera.mount_height]), (height, width)
    hit = RayMeshIntersector(solid).intersects_first(np.tile(origin, (len(ways), 1)), ways)
    sides = corners[:, 1:] - corners[:, :1]
    normal = np.cross(sides[:, 0], sides[:, 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = np.sum(normal * (corners[:, 0] - origin), axis=1)[hit] / np.sum(normal[hit] * ways, axis=1)
    depth[hit < 0] = np.inf
    return np.where(hit < 0, NOBODY, owners[hit]).reshape(shape), depth.reshape(shape)


def interior(*ids: Any) -> Any:
    """Pixels inside the border whose 3 x 3 neighbourhoods show one and the same id in all pictures."""
    same = np.ones(np.array(ids[0].shape) - 2, bool)
    for picture in ids:
        for row in range(3):
            for column in range(3):
                part = picture[row : picture.shape[0] - 2 + row, column : picture.shape[1] - 2 + column]
                same &= part == ids[0][1:-1, 1:-1]
    return np.pad(same, 1)


def compare(picture: Picture, ids: Any, depth: Any, resampled: bool) -> None:
    """Ids agree at 99.5 % of all pixels; depth is within 1 cm inside of people.

    A picture ``resampled`` from other views has ids half a pixel of theirs off, and with them which limb is in front.
    """
    people = (ids >= 0) | (picture.ids >= 0)
    assert people.mean() > 0.01
    assert (picture.ids == ids).mean() >= 0.995
    assert (picture.ids == ids)[people].mean() >= (0.9 if resampled else 0.995)
    inside = interior(picture.ids, ids) & people
    apart = np.abs(picture.depth[inside] - depth[inside])
    assert inside.sum() > 1000
    assert np.mean(apart < 0.01) >= (0.9 if resampled else 0.999)


@pytest.fixture(scope="module")
def rays(scene: Scene) -> Callable[[str, str], tuple[Any, Any]]:
    done: dict[tuple[str, str], tuple[Any, Any]] = {}

    def cast(camera: str, pose: str) -> tuple[Any, Any]:
        if (camera, pose) not in done:
            triangles = world_triangles(scene, 2, POSES[pose][:2], CAMERAS[camera].focal)
            done[camera, pose] = cast_rays(*triangles, CAMERAS[camera], POSES[pose])
        return done[camera, pose]

    return cast


def open_backend(name: str, scene: Scene) -> Renderer:
    if name == "raster":
        return RasterRenderer(scene)
    try:
        from vbbench_renderers.pyrender_backend import PyrenderRenderer

        return PyrenderRenderer(scene)
    except VbbenchError as error:
        pytest.skip(f"{name} does not work here: {error}")
    except ImportError as error:
        pytest.skip(f"{name} cannot be imported: {error}")


@pytest.fixture(scope="module", params=["raster", pytest.param("pyrender", marks=pytest.mark.extra("pyrender"))])
def backend(request: Any, scene: Scene) -> Iterator[Renderer]:
    renderer = open_backend(request.param, scene)
    yield renderer
    renderer.close()


@pytest.mark.slow
@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("camera", CAMERAS)
def test_ids_and_depth_are_those_of_ray_casting(
    backend: Renderer, scene: Scene, rays: Any, camera: str, pose: str
) -> None:
    ids, depth = rays(camera, pose)
    resampled = camera in RESAMPLED or (camera == "panorama" and type(backend).__name__ == "PyrenderRenderer")
    compare(backend.render(2, CAMERAS[camera], POSES[pose]), ids, depth, resampled)


@pytest.mark.slow
@pytest.mark.parametrize("camera", CAMERAS)
def test_feet_and_heads_are_where_the_camera_projects_them(camera: str) -> None:
    azimuth, reach, heights = np.array([-0.5, -0.05, 0.6]), np.array([5.0, 7.0, 6.0]), np.array([1.6, 1.75, 1.9])
    relative = reach[:, None] * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=-1)
    pose = np.array([3.0, -2.0, 1.1])
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    places = pose[:2] + relative @ np.array([[sin, -cos], [cos, sin]])
    standing = Scene(name="t", dt=0.1, people=np.arange(3), positions=np.tile(places, (2, 1, 1)), heights=heights)
    renderer, lens = RasterRenderer(standing, surroundings=False), CAMERAS[camera]
    ids = renderer.render(0, lens, pose).ids
    for person, (u, v, length) in enumerate(lens.project(relative, heights)):
        rows, columns = np.nonzero(ids == person)
        assert rows.min() == pytest.approx(v - 0.5 * length, abs=2.0 + 0.02 * length)
        assert rows.max() + 1 == pytest.approx(v + 0.5 * length, abs=2.0 + 0.04 * length)
        assert columns.mean() + 0.5 == pytest.approx(u, abs=1.5 + 0.04 * length)
