"""People who are drawn: as tall as the camera model says, on feet that do not slide, each with a look of their own."""

import numpy as np
import pytest
import trimesh

from tests.lib.work import work_of
from vbbench.errors import VbbenchError
from vbbench.geometry import FloatArray
from vbbench.scene import Scene
from vbbench_renderers.people import Walkers
from vbbench_renderers.people.bodies import NAMES
from vbbench_renderers.people.gait import ROLL, SHIN, THIGH, UPPER_ARM, Bone
from vbbench_renderers.people.looks import make_look


def scene_of(positions: FloatArray, dt: float = 0.1, heights: FloatArray | None = None, first_id: int = 0) -> Scene:
    count = positions.shape[1]
    heights = np.full(count, 1.72) if heights is None else heights
    ids = np.arange(first_id, first_id + count)
    return Scene(name="walk", dt=dt, people=ids, positions=positions, heights=heights)


def straight(count: int = 1, speed: float = 1.3, frames: int = 60, dt: float = 0.1) -> FloatArray:
    time_s = dt * np.arange(frames)[:, None]
    aside = 2.0 * np.arange(count)
    return np.stack([speed * time_s + 0.0 * aside, 0.0 * time_s + aside], axis=-1)


def circle(radius: float = 3.0, speed: float = 1.2, frames: int = 100, dt: float = 0.1) -> FloatArray:
    angle = speed / radius * dt * np.arange(frames)
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)[:, None]


def extents(walkers: Walkers, frame: float, eye: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest corner [K, 3] of everybody."""
    count = len(walkers.looks)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    limbs = walkers.limbs(frame, np.array(eye))
    for mesh, transform, k in zip(limbs.mesh, limbs.transform, limbs.person, strict=True):
        points = walkers.meshes[mesh].vertices @ transform[:, :3].T + transform[:, 3]
        low[k], high[k] = np.minimum(low[k], points.min(axis=0)), np.maximum(high[k], points.max(axis=0))
    return low, high


@pytest.mark.parametrize("away", [0.0, 14.0, 60.0])
@pytest.mark.parametrize("speed", [0.0, 0.3, 0.8, 1.4, 2.2])
def test_everybody_is_as_tall_as_the_scene_says_and_stands_on_the_ground(away: float, speed: float) -> None:
    heights = np.linspace(1.45, 2.0, 40)
    positions = straight(40, speed) * (1.0, 0.01)
    walkers = Walkers(scene_of(positions, heights=np.where(np.arange(40) == 9, np.nan, heights)), 3)
    heights[9] = 1.7  # of somebody whose height is not known
    for frame in (30.0, 33.5, 37.0):
        low, high = extents(walkers, frame, (1.0 + away, 0.0))
        np.testing.assert_allclose(high[:, 2], heights, atol=0.004)
        np.testing.assert_allclose(low[:, 2], 0.0, atol=0.01)


def test_head_and_hips_are_over_the_ground_point() -> None:
    positions = straight(30)
    walkers = Walkers(scene_of(positions), 1)
    for frame in range(10, 30):
        _, bones = walkers.bones(frame)
        np.testing.assert_allclose(bones[:, Bone.PELVIS, :2, 3], positions[frame], atol=1e-6)
        assert np.abs(bones[:, Bone.HEAD, :2, 3] - positions[frame]).max() < 0.16  # the old stoop
        low, high = extents(walkers, frame, (0.0, 0.0))
        centre = 0.5 * (low + high)[:, :2] - positions[frame]
        assert np.abs(np.median(centre, axis=0)).max() < 0.08


@pytest.mark.parametrize("positions", [straight(frames=100), circle()], ids=["straight", "circle"])
def test_planted_feet_do_not_slide(positions: FloatArray) -> None:
    walkers = Walkers(scene_of(positions), 0)
    frames = np.arange(15.0, 80.0, 0.125)
    feet = [walkers.feet(frame) for frame in frames]
    contact = np.array([f.contact[0] for f in feet])
    pitch = np.array([f.pitch[0] for f in feet])
    planted = np.array([f.planted[0] for f in feet])
    flat = planted & (np.abs(pitch) < 0.01)
    for held in (planted & (pitch < -0.001), planted & (pitch > ROLL)):  # on the heel, on the tip
        both = held[1:] & held[:-1]
        assert both.sum() > 10
        assert np.linalg.norm(np.diff(contact, axis=0)[both], axis=-1).max() < 0.001
    ankle = np.array([f.ankle[0] for f in feet])
    both = flat[1:] & flat[:-1]
    assert np.linalg.norm(np.diff(ankle, axis=0)[both], axis=-1).max() < 0.003
    assert planted.any(axis=1).all()
    swing = ~planted[1:] & ~planted[:-1]
    assert np.linalg.norm(np.diff(ankle, axis=0)[swing], axis=-1).mean() > 0.02


def test_legs_keep_their_length_and_knees_and_elbows_bend_the_right_way() -> None:
    walkers = Walkers(scene_of(straight(20)), 0)
    size = np.array([look.style["size"] for look in walkers.looks])[:, None]
    for frame in np.arange(20.0, 32.0, 0.5):
        _, bones = walkers.bones(frame)
        at = bones[..., 3]
        knee, hip, ankle = (at[:, bone : bone + 2] for bone in (Bone.SHIN, Bone.THIGH, Bone.FOOT))
        np.testing.assert_allclose(np.linalg.norm(hip - knee, axis=-1), THIGH * size + 0 * hip[..., 0], rtol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(ankle - knee, axis=-1), SHIN * size + 0 * hip[..., 0], rtol=1e-6)
        upper = np.linalg.norm(at[:, 4:6] - at[:, 6:8], axis=-1)
        np.testing.assert_allclose(upper, UPPER_ARM * size + 0 * upper, rtol=1e-6)
        share = ((hip - knee)[..., 2] / (hip - ankle)[..., 2])[..., None]
        assert (knee - (hip + share * (ankle - hip)))[..., 0].min() > -1e-6
        arm, forearm = bones[:, 4:6, :, 2], bones[:, 6:8, :, 2]  # both point up, towards the shoulder
        assert np.cross(forearm, arm)[..., 1].min() > -1e-6


def test_the_still_stand_with_their_feet_side_by_side() -> None:
    positions = np.tile((2.0, 1.0), (30, 1, 1))
    walkers = Walkers(scene_of(positions), 0)
    feet = [walkers.feet(frame) for frame in range(30)]
    assert all(f.planted.all() for f in feet)
    assert np.ptp([f.ankle for f in feet], axis=0).max() < 1e-9
    assert np.abs(feet[0].ankle[0, 0] - feet[0].ankle[0, 1]).max() < 0.25
    assert np.linalg.norm(feet[0].ankle[0].mean(axis=0)[:2] - (2.0, 1.0)) < 0.08


def test_who_stops_keeps_facing_the_same_way_and_comes_to_stand() -> None:
    x = np.concatenate([1.3 * 0.1 * np.arange(40), np.full(40, 1.3 * 0.1 * 39)])
    walkers = Walkers(scene_of(np.stack([0.0 * x, x], axis=-1)[:, None]), 5)
    _, bones = walkers.bones(75)
    np.testing.assert_allclose(
        bones[0, Bone.PELVIS, 1, 0] / np.linalg.norm(bones[0, Bone.PELVIS, :, 0]), 1.0, atol=0.01
    )
    assert walkers.feet(75).planted.all()


def test_looks_are_many_and_do_not_depend_on_who_else_is_there() -> None:
    looks = [make_look(0, person, 1.7) for person in range(200)]
    assert len({look.kind for look in looks}) >= 150
    assert len({tuple(look.parts["mesh"]) for look in looks}) >= 50
    colours = {tuple(np.round(look.parts["colour"][:6].ravel(), 2)) for look in looks}
    assert len(colours) >= 150
    crowd = Walkers(scene_of(straight(30)), 7)
    few = Walkers(scene_of(straight(3), first_id=20), 7)
    assert [look.kind for look in few.looks] == [look.kind for look in crowd.looks[20:23]]
    assert Walkers(scene_of(straight(3)), 8).looks[0].kind != crowd.looks[0].kind


@pytest.mark.parametrize("level", range(Walkers.levels))
def test_meshes_are_closed_and_their_normals_point_outwards(level: int) -> None:
    meshes = Walkers.meshes[len(NAMES) * level : len(NAMES) * (level + 1)]
    for name, mesh in zip(NAMES, meshes, strict=True):
        solid = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False)
        assert solid.is_watertight, name
        assert solid.volume > 0, name
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=-1), 1.0, atol=1e-3, err_msg=name)
        corners = mesh.vertices[mesh.triangles].astype(np.float64)
        face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        outward = np.einsum("fi,fi->f", face, mesh.normals[mesh.triangles].mean(axis=1))
        assert np.mean(outward > 0) > 0.95, name
        assert mesh.colours.min() >= 0.0, name


def test_the_level_of_detail_follows_the_distance() -> None:
    walkers = Walkers(scene_of(np.array([[[3.0, 0.0], [12.0, 0.0], [40.0, 0.0]]] * 3)), 0)
    for focal, levels in ((640.0, {(0, 0), (1, 1), (2, 2)}), (229.0, {(0, 1), (1, 2), (2, 2)})):
        limbs = walkers.limbs(1, np.zeros(2), focal)
        assert set(zip(limbs.person.tolist(), (limbs.mesh // len(NAMES)).tolist(), strict=True)) == levels


def test_the_absent_and_the_one_with_the_camera_are_not_drawn() -> None:
    positions = straight(4)
    positions[:20, 1] = np.nan
    positions[40:, 2] = np.nan
    walkers = Walkers(scene_of(positions), 0)
    drawn = [set(walkers.limbs(frame, np.zeros(2), without=0).person.tolist()) for frame in (10, 19.5, 30, 39.5, 50)]
    assert drawn == [{2, 3}, {2, 3}, {1, 2, 3}, {1, 3}, {1, 3}]
    for nobody in (np.empty((5, 0, 2)), np.full((5, 2, 2), np.nan)):
        assert len(Walkers(scene_of(nobody), 0).limbs(2, np.zeros(2)).mesh) == 0


@pytest.mark.parametrize("frame", [-1, 5, 5.5])
def test_a_frame_that_the_scene_has_not_is_refused(frame: float) -> None:
    with pytest.raises(VbbenchError, match=rf"no frame {frame:g}; its frames are 0 to 4"):
        Walkers(scene_of(straight(frames=5)), 0).limbs(frame, np.zeros(2))


def test_limbs_are_placed_all_at_once() -> None:
    few, many = (Walkers(scene_of(straight(count)), 0) for count in (25, 100))
    little, much = (work_of(lambda walkers=walkers: walkers.limbs(10, np.zeros(2))) for walkers in (few, many))
    assert much.calls == little.calls
    assert much.bytes < 5 * little.bytes
