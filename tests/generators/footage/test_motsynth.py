"""The split motsynth, on made recordings in the layout of its annotations."""

import numpy as np
import pytest

import tests.lib.motsynth_recording
from tests.lib.motsynth_recording import (
    FOCAL,
    GROUND,
    MOUNT_HEIGHT,
    PITCH,
    as_published,
    camera_track,
    heights,
    recording,
    walkers,
    write,
)
from vbbench.errors import FileError, SourceMissingError, VbbenchError, VbbenchWarning
from vbbench.files.verification import verify
from vbbench.generation.datasets import write_dataset
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.geometry import world_to_relative
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_generators.footage.motsynth import motsynth
from vbbench_generators.footage.motsynth_video import find_camera_path, read_annotations


def options(folder, **asked):
    return Options(source=folder, footage=FootageOptions(**{"every": 1, **asked}))


def written(folder, values):
    return write(folder, values) / "annotations" / "000.json"


def camera_of(folder, values):
    return find_camera_path(read_annotations(written(folder, values)))


def edited(folder, edit):
    values = recording(frames=40)
    edit(values)
    return written(folder, values)


def joints_of(row):
    """[22, 4] right, down, forward and mark of a person's joints."""
    return np.reshape(row["keypoints_3d"], (-1, 4))


def move_joints(values, change):
    """Change the joints [22, 4] of every person."""
    for row in values["annotations"]:
        row["keypoints_3d"] = np.ravel(change(joints_of(row), row)).tolist()


def test_poses_places_heights_and_camera_are_the_games(tmp_path):
    dataset = write_dataset(motsynth.plan(options(write(tmp_path / "s", recording()))), tmp_path / "d")
    assert "are as written" in verify(tmp_path / "d")
    camera = dataset.info.camera
    assert camera.focal == pytest.approx(FOCAL) == pytest.approx(1158.03, abs=0.01)
    assert (camera.mount_height, camera.pitch) == pytest.approx((MOUNT_HEIGHT, np.radians(PITCH)), abs=0.005)
    assert (dataset.info.truth, dataset.info.dt) == ("whole", pytest.approx(0.05))
    positions, angles = camera_track(80)
    world = walkers(80, 6)
    for sequence in dataset.sequences():
        truth, own = dataset.truth(sequence), dataset.world(sequence)
        frames = 10 + sequence.first_frame + np.arange(sequence.frames)
        true_poses = own.poses(np.column_stack([positions[frames, :2], np.radians(angles[frames, 2] + 90.0)]))
        np.testing.assert_allclose(truth.poses[:, :2], true_poses[:, :2], atol=1e-6)
        np.testing.assert_allclose(np.cos(truth.poses[:, 2] - true_poses[:, 2]), 1.0, atol=1e-9)
        people = dataset.track_persons(sequence)[-1] // 10
        seen = sequence.observed
        np.testing.assert_allclose(truth.positions[seen], own.positions(world[frames][:, people])[seen], atol=1e-6)
        np.testing.assert_allclose(truth.heights, heights(6)[people], atol=1e-6)
        again = dataset.camera(sequence).project(
            world_to_relative(truth.positions, truth.poses), np.broadcast_to(truth.heights, seen.shape)
        )
        off = np.abs(again - sequence.observations)[seen] / sequence.observations[seen][:, 2:]
        assert np.median(off, axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=0.05)
    score(solve(dataset, "cv", "sequential", tmp_path / "a"), tmp_path / "d")


@pytest.mark.parametrize("shift", [0, 3, -2])
@pytest.mark.parametrize("shaken", [False, True])
def test_a_shift_of_frames_is_found_and_mended_though_people_bob_and_joints_shake(tmp_path, shift, shaken):
    values, rng = recording(pose_shift=shift), np.random.default_rng(0)

    def shake(joints, row):
        bob = 0.03 * np.sin(2.0 * np.pi * 2.0 * row["image_id"] / 20 + row["ped_id"])
        return joints + np.insert(rng.normal(0.0, 0.005, (22, 3)) + np.array([0.0, bob, 0.0]), 3, 0.0, axis=1)

    if shaken:
        move_joints(values, shake)
    mended = camera_of(tmp_path, values)
    assert mended.report["pose_shift"] == shift
    assert (0.0 if shaken else -1.0) < mended.report["pose_error"] < 0.05
    found, world, (way, _) = mended.annotations, walkers(80, 6), camera_track(80)
    real = 10 + found.first + found.frame
    np.testing.assert_allclose(mended.people, world[real, found.person // 10], atol=0.05 if shaken else 1e-6)
    np.testing.assert_allclose(mended.poses[found.frame, :2], way[real, :2], atol=1e-6, err_msg="of another frame")


@pytest.mark.parametrize("shift", [0, -2])
def test_published_files_are_read_like_those_with_the_games_own_axes(tmp_path, shift):
    values = recording(pose_shift=shift)
    own, published = camera_of(tmp_path / "a", values), camera_of(tmp_path / "b", as_published(values))
    assert (own.report["places"], own.report["angles"]) == ("x, y, height", "pitch, roll, yaw")
    assert (published.report["places"], published.report["angles"]) == ("x, -height, y", "pitch, -yaw, roll")
    assert published.report["pose_shift"] == own.report["pose_shift"] == shift
    assert published.annotations.first == own.annotations.first + 1
    assert (published.pitch, published.mount_height) == pytest.approx((own.pitch, own.mount_height), abs=1e-4)
    np.testing.assert_allclose(published.poses[:, :2], own.poses[:, :2], atol=1e-3)
    np.testing.assert_allclose(np.cos(published.poses[:, 2] - own.poses[:, 2]), 1.0, atol=1e-9)
    np.testing.assert_allclose(published.people, own.people, atol=1e-2)
    assert motsynth.plan(options(tmp_path / "b")).info.dt == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("speed", "turn", "tilt"),
    [(0.0, 0.0, (-2.0, 0.0)), (1.2, 0.0, (-2.0, 1.5)), (1.2, 4.0, (-0.5, 1.5)), (0.0, 8.0, (-15.0, -1.0))],
)
def test_poses_are_right_however_the_camera_moves(tmp_path, monkeypatch, speed, turn, tilt):
    """A camera that stands, goes straight on, or turns; who stands and who walks must not move with it."""
    rng = np.random.default_rng(5)
    start, walk = rng.uniform([7.0, -3.0], [18.0, 3.0], (12, 2)), rng.normal(0.0, 1.0, (12, 2))
    walk *= rng.choice([0.0, 1.3], (12, 1)) / np.linalg.norm(walk, axis=1, keepdims=True)

    def track(frames):
        time = np.arange(frames) / 20
        positions = GROUND + time[:, None] * [0.8 * speed, 0.6 * speed, 0.0] + [0.0, 0.0, MOUNT_HEIGHT]
        return positions, np.column_stack([np.tile(tilt, (frames, 1)), turn * np.sin(0.8 * time) - 80.0])

    def crowd(frames, people):
        return GROUND[:2] + start + np.arange(frames)[:, None, None] / 20 * walk

    monkeypatch.setattr(tests.lib.motsynth_recording, "camera_track", track)
    monkeypatch.setattr(tests.lib.motsynth_recording, "walkers", crowd)
    values = as_published(recording(frames=80, people=12))
    move_joints(values, lambda joints, row: joints + rng.normal(0.0, 0.01, joints.shape))
    found = camera_of(tmp_path, values)
    assert (found.pitch, found.roll) == pytest.approx(np.radians(tilt), abs=1e-3)
    positions, angles = (known[10:90] for known in track(100))
    real = np.column_stack([positions[:, :2], np.radians(angles[:, 2] + 90.0)])
    frame, person = found.annotations.frame, found.annotations.person // 10
    expected = crowd(100, 12)[frame + 10, person]
    np.testing.assert_allclose(
        world_to_relative(found.people[:, None], np.tile(found.poses[:1], (len(person), 1))),
        world_to_relative(expected[:, None], np.tile(real[:1], (len(person), 1))),
        atol=0.1,
    )
    np.testing.assert_allclose(found.poses[:, 2] - found.poses[0, 2], real[:, 2] - real[0, 2], atol=1e-3)


def _other_axes(values):
    move_joints(values, lambda joints, row: joints[:, [0, 2, 1, 3]])


def _y_up(values):
    for image in values["images"]:
        image["cam_world_rot"] = [90.0, *image["cam_world_rot"][1:]]


def _other_video(values):
    rng = np.random.default_rng(0)
    for image in values["images"]:
        image["cam_world_rot"][2] += rng.normal(0.0, 4.0)


def _nodding(values):
    """The camera looks up ever more, and joints and boxes are those that it sees."""
    lift = {image["id"]: np.radians(0.6 * n) for n, image in enumerate(values["images"])}
    for image in values["images"]:
        image["cam_world_rot"] = [
            image["cam_world_rot"][0] + np.degrees(lift[image["id"]]),
            *image["cam_world_rot"][1:],
        ]

    def turned(joints, row):
        c, s = np.cos(lift[row["image_id"]]), np.sin(lift[row["image_id"]])
        joints = np.column_stack([joints[:, 0], joints[:, 1:3] @ np.array([[c, -s], [s, c]]), joints[:, 3]])
        flat = 1158.03 * joints[:, :2] / joints[:, 2:3] + [960, 540]
        row["keypoints"] = np.hstack([flat, joints[:, 3:]]).reshape(-1).tolist()
        row["bbox"] = [*flat.min(axis=0), *np.ptp(flat, axis=0)]
        return joints

    move_joints(values, turned)


def every(values, **changes):
    for row in values["annotations"]:
        row |= changes


def _move(values, first, last, metres):
    """The camera of some frames, in the file alone."""
    for image in values["images"][first:last]:
        image["cam_world_pos"][0] += metres


def _cut(values):
    """Another shot from the middle on: the camera looks elsewhere."""
    for image in values["images"][30:]:
        image["cam_world_rot"][2] += 90.0


def _in_feet(values):
    """Places of camera and people."""
    for image in values["images"]:
        image["cam_world_pos"] = [3.28 * metres for metres in image["cam_world_pos"]]
    move_joints(values, lambda joints, row: joints * (3.28, 3.28, 3.28, 1.0))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (_other_axes, r"joints project \d+ px from those in the picture: keypoints_3d must be \(right, down"),
        (_y_up, r"people do not stand upright however cam_world_rot is read: they lean"),
        (_other_video, r"people jump by \d+% of their height, at best .*poses are not those of these boxes"),
        (_nodding, r"the camera's pitch changes by 0\.\d+ rad; a sequence has one pitch"),
        (lambda v: every(v, bbox=[5.0, 5.0, 20.0, 60.0]), r"boxes lie \d+% of their height from their people"),
        (
            lambda v: v["images"][0].pop("cam_world_pos"),
            r"field `cam_world_pos` - at `\$\.images\[0\]`; wanted: the COCO",
        ),
        (lambda v: [image.pop("cam_fov") for image in [*v["images"], v["info"]]], "has the key 'cam_fov'"),
        (lambda v: v["info"].update(fx=900), r"fx is 900 px, but a vertical field of view of 50 degrees is 1158 px"),
        (lambda v: v["images"][3].update(cam_fov=40.0), "the camera zooms: cam_fov is 40 to 50 degrees"),
        (
            lambda v: [v["images"][n].update(seq_name=f"{n:03d}") for n in (0, 1)],
            r"holds 2 videos \(000, 001 …",
        ),
        (lambda v: v["images"].pop(5), "frame 6 follows frame 4; frames must not be missing"),
        (lambda v: v["annotations"][0].update(image_id=7), "an annotation is of image 7, and there is no such image"),
        (lambda v: v["images"][2].update(id=1000), "has 40 images of 39 ids: an id stands there twice"),
        (lambda v: v["info"].update(fps=10**400), r"Number out of range - at `\$\.info\.fps`"),
        (lambda v: every(v, keypoints_3d=[0.0] * 88), "person 0, frame 0: all joints of keypoints_3d are in one place"),
        (lambda v: move_joints(v, lambda joints, row: -joints), "no joint of keypoints_3d lies before the camera"),
        (lambda v: every(v, iscrowd=1), "nobody is seen: all annotations are of crowds"),
        (lambda v: _move(v, 30, 31, 5000.0), r"frame 30: the camera moves 5,0\d\d\.\d m and turns \d degrees"),
        (lambda v: _move(v, 31, 60, 50.0), r"frame 31: the camera moves \d+\.\d m"),
        (_cut, r"frame 30: the camera moves .* and turns \d\d degrees from the frame before; a video is one shot"),
        (_in_feet, r"people by keypoints_3d: their median height must be 0\.5 to 2\.5 m, not 5\.\d+; it must be in m"),
        (lambda v: v["annotations"][0].update(bbox=[1, 2, 3]), r"length >= 4 - at `\$\.annotations\[0\]\.bbox`"),
        (
            lambda v: v["annotations"][0].update(ped_id="x"),
            r"Expected `int`, got `str` - at `\$\.annotations\[0\]\.ped",
        ),
        (lambda v: v["annotations"].append(v["annotations"][0]), "person 0 has two boxes in frame 0"),
        (lambda v: v.update(annotations=v["annotations"][:60]), "nobody is seen for 1 s: the camera's poses cannot be"),
        (lambda v: v.pop("images"), "missing required field `images`"),
        (lambda v: v["annotations"].clear(), r"length >= 1 - at `\$\.annotations`"),
    ],
)
def test_what_does_not_fit_is_one_clear_line(tmp_path, edit, message):
    path = edited(tmp_path, edit)
    with pytest.raises(FileError, match=message) as caught:
        find_camera_path(read_annotations(path))
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_numbers_and_ids_may_be_text(tmp_path):
    def edit(values):
        for row in values["annotations"]:
            row |= {"image_id": str(row["image_id"]), "ped_id": str(row["ped_id"]), "bbox": [*map(str, row["bbox"])]}
        for image in values["images"]:
            image |= {"frame_n": str(image["frame_n"]), "width": "1920", "cam_fov": "50.0"}

    plain, text = (read_annotations(edited(tmp_path / name, how)) for name, how in (("a", len), ("b", edit)))
    for name in ("person", "frame", "boxes"):
        np.testing.assert_array_equal(getattr(text, name), getattr(plain, name))
    assert (text.first, text.focal, text.width) == (plain.first, plain.focal, 1920)


def test_crowds_and_people_whom_nobody_sees_are_left_out(tmp_path):
    def edit(values):
        values["annotations"][0]["iscrowd"] = 1
        values["annotations"][1]["keypoints"][2::3] = [1] * 22
        values["annotations"][2]["keypoints"][2::3] = [2] * 11 + [1] * 11

    whole = read_annotations(edited(tmp_path / "a", lambda v: None))
    found = read_annotations(edited(tmp_path / "b", edit))
    assert len(found.frame) == len(whole.frame) - 2
    assert sorted(set(found.visible)) == [0.5, 1.0]


def test_videos_are_chosen_by_name_and_unusable_ones_left_out_loudly(tmp_path):
    write(tmp_path, recording(frames=40))
    write(tmp_path, {"images": [], "annotations": []}, "001")
    with pytest.warns(VbbenchWarning, match="skipped: .*001.json"):
        assert motsynth.plan(options(tmp_path)).info.scenes == ("000",)
    assert len(motsynth.plan(options(tmp_path, sequences=("000",)))) > 0
    with pytest.raises(FileError, match=r"001\.json"):
        motsynth.plan(options(tmp_path, sequences=("001",)))
    with pytest.raises(VbbenchError, match="is called '01'; did you mean '001'"):
        motsynth.plan(options(tmp_path, sequences=("01",)))
    with pytest.raises(VbbenchError, match="is called '001'; did you mean '000'"):
        motsynth.plan(options(tmp_path / "annotations" / "000.json", sequences=("001",)))


def test_without_a_source_it_says_where_to_get_it(tmp_path):
    with pytest.raises(SourceMissingError, match=r"motsynth needs --source: unpack MOTSynth_coco_annotations\.zip"):
        motsynth.plan(Options())
    with pytest.raises(SourceMissingError, match="no annotation files of MOTSynth here"):
        motsynth.plan(options(tmp_path))


def test_a_folder_may_have_braces_in_its_name_and_a_video_is_read_once(tmp_path):
    root = tmp_path / "{x}"
    write(root, recording())
    (root / "frames" / "000" / "rgb").mkdir(parents=True)
    (footage,) = motsynth.recordings(options(root, sequences=("000", "000"))).footage
    assert footage.pictures.path(0).parent == root / "frames" / "000" / "rgb"
