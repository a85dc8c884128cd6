"""Poses, odometry and people beside one's own boxes: what they become, and what is said of those that cannot be."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.lib.own_recording import CAMERA_TOML, Walk, make_walk, write_folder, write_mot, write_people, write_tum
from vbbench.boxes import rectangles
from vbbench.errors import FileError
from vbbench.exchange.box_rows import Timeline
from vbbench.exchange.own.recording import files_in, read_people, read_recording
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.footage import joined_odometry
from vbbench.generation.generator import Options
from vbbench.geometry import relative_to_world, world_to_relative
from vbbench.scoring import score
from vbbench.sequence import Odometry
from vbbench.solving import solve


def read(folder: Path):
    return read_recording(files_in(folder))


def test_poses_odometry_and_people_become_truth_and_measurements(folder, walk, tmp_path):
    write_tum(folder / "poses.txt", walk, every=0.5)
    write_tum(folder / "odometry.txt", walk, every=0.5)
    write_people(folder / "people.csv", walk)
    recording = read(folder)
    footage = recording.footage
    assert not recording.notes
    assert footage.known == "whole"
    assert footage.poses is not None
    np.testing.assert_allclose(footage.poses, walk.poses, atol=1e-6)
    places, persons = footage.positions()
    np.testing.assert_allclose(places, walk.people, atol=1e-5)
    assert persons.tolist()[0] == list(range(1, 9))
    assert footage.odometry is not None
    again = walk.poses.copy()
    for t in range(1, len(again)):
        forward, left, turn = footage.odometry.motions[t]
        again[t, :2] = relative_to_world(np.array([[-left, forward]]), again[t - 1])[0]
        again[t, 2] = again[t - 1, 2] + turn
    np.testing.assert_allclose(again, walk.poses, atol=1e-6)
    assert (np.linalg.eigvalsh(footage.odometry.covariances[1:]) > 0).all()
    dataset = generate("own", tmp_path / "d", Options(source=folder))
    assert "as written" in verify(tmp_path / "d")
    assert (dataset.info.truth, len(dataset), dataset.sequence(0).frames) == ("whole", 1, 60)
    figures = score(solve(dataset, "cv", "one-step", tmp_path / "a"), tmp_path / "d").values()["metrics"]
    assert figures["dx"]["mean"] < 1.0


def test_stated_covariances_of_odometry_are_added_up_over_a_frame(folder, walk):
    part, spread = np.array([0.3, 0.02, 0.2]), np.array([[4e-4, 1e-5, 2e-5], [1e-5, 1e-4, 0.0], [2e-5, 0.0, 9e-4]])
    pose, rows = np.zeros(3), []
    for line in range(4 * len(walk.poses)):
        x, y, yaw = pose
        place = f"{line * walk.dt / 4:.6f} {x:.12f} {y:.12f} 0 0 0 {np.sin(yaw / 2):.12f} {np.cos(yaw / 2):.12f}"
        rows.append(f"{place} 4e-4 1e-5 2e-5 1e-4 0 9e-4")
        pose = np.append(relative_to_world(np.array([[-part[1], part[0]]]), pose)[0], yaw + part[2])
    (folder / "odometry.txt").write_text("\n".join(rows) + "\n")
    odometry = read(folder).footage.odometry
    assert odometry is not None
    parts = Odometry(motions=np.tile(part, (5, 1)), covariances=np.tile(spread, (5, 1, 1)))
    np.testing.assert_allclose(odometry.motions[5], joined_odometry(parts, 4).motions[1], rtol=1e-6)
    np.testing.assert_allclose(odometry.covariances[5], 4.0 * spread, rtol=1e-6, atol=1e-12)
    small = [row.replace("4e-4 1e-5 2e-5 1e-4 0 9e-4", "4e-9 0 0 1e-9 0 9e-9") for row in rows]
    small[8] = small[8].replace("9e-9", "1e7")  # an error that is not known
    (folder / "odometry.txt").write_text("\n".join(small) + "\n")
    np.testing.assert_allclose(read(folder).footage.odometry.covariances[5, 2, 2], 4.0 * 9e-9, rtol=1e-6)
    (folder / "odometry.txt").write_text("\n".join(rows[::3]) + "\n")  # lines end within frames: parts in proportion
    sparse = read(folder).footage.odometry
    assert sparse is not None
    np.testing.assert_allclose(sparse.covariances[5:9, 2, 2], 4 / 3 * 9e-4, rtol=1e-6)
    assert (np.linalg.eigvalsh(sparse.covariances[1:]) > 0.0).all()
    (folder / "odometry.txt").write_text("\n".join([*rows[:3], rows[3].replace("4e-4", "-4e-4"), *rows[4:]]))
    with pytest.raises(FileError, match=r"line 4: the covariance .* is not positive definite"):
        read(folder)
    (folder / "odometry.txt").write_text("\n".join([*rows[:3], rows[3] + " 7"]))
    with pytest.raises(FileError, match="line 4: 15 columns with blanks between, wanted 14"):
        read(folder)


def test_lines_of_odometry_are_told_by_their_times(folder, walk):
    write_tum(folder / "odometry.txt", walk, every=0.5)
    rows = (folder / "odometry.txt").read_text().splitlines()
    rows = [f"{line} {1e-4 * (1 + n)} 0 0 1e-4 0 1e-6" for n, line in enumerate(rows)]
    odometry = []
    for order in (rows, rows[::-1]):
        (folder / "odometry.txt").write_text("\n".join(order) + "\n")
        odometry.append(read(folder).footage.odometry)
    np.testing.assert_array_equal(odometry[0].motions, odometry[1].motions)
    np.testing.assert_array_equal(odometry[0].covariances, odometry[1].covariances)


def test_no_motion_is_made_up_before_the_first_line_of_odometry_and_after_its_last(folder, walk):
    write_tum(folder / "odometry.txt", walk, every=2.0)
    whole = read(folder).footage.odometry
    rows = (folder / "odometry.txt").read_text().splitlines()
    (folder / "odometry.txt").write_text("\n".join(rows[1:-2]) + "\n")
    recording = read(folder)
    odometry = recording.footage.odometry
    first, last = 2, 2 * (len(rows) - 3)
    measured = np.isfinite(odometry.motions[:, 0])
    assert np.flatnonzero(measured).tolist() == list(range(first + 1, last + 1))
    np.testing.assert_allclose(odometry.motions[measured], whole.motions[measured], atol=1e-12)
    assert recording.notes == (f"{59 - int(measured.sum())} of 59 motions are not in odometry.txt",)


def test_poses_that_begin_half_a_frame_late_go_back_straight_and_not_by_their_noise(folder, walk):
    write_tum(folder / "poses.txt", walk, every=0.01)
    rows = [row.split() for row in (folder / "poses.txt").read_text().splitlines()[45:]]
    noise = np.random.default_rng(0).normal(0.0, 0.002, (len(rows), 2))
    noisy = [
        [t, f"{float(x) + dx:.6f}", f"{float(y) + dy:.6f}", *rest]
        for (t, x, y, *rest), (dx, dy) in zip(rows, noise, strict=True)
    ]
    (folder / "poses.txt").write_text("\n".join(" ".join(row) for row in noisy) + "\n")
    poses = read(folder).footage.poses
    assert np.abs(poses[:, :2] - walk.poses[:, :2]).max() < 0.012


def test_files_of_another_clock_or_frame_are_refused(folder, walk):
    write_tum(folder / "odometry.txt", walk, begin=1e5)
    with pytest.raises(FileError, match=r"no frame has a motion: .* write the time of each frame .*a column 'time'"):
        read(folder)
    rows = (folder / "odometry.txt").read_text().splitlines()
    in_ns = [",".join([f"{1e9 * float(t):.0f}", *rest]) for t, *rest in (row.split() for row in rows)]
    (folder / "odometry.txt").write_text("\n".join(["#timestamp [ns],x,y,z,qx,qy,qz,qw", *in_ns]) + "\n")
    with pytest.raises(FileError, match="subtract the time of frame 0 from the times here"):
        read(folder)
    rows = write_tum(folder / "odometry.txt", walk).read_text().splitlines()
    in_ms = [" ".join([f"{1e3 * float(row.split()[0]):g}", *row.split()[1:]]) for row in rows]
    (folder / "odometry.txt").write_text("\n".join(in_ms) + "\n")
    assert read(folder).notes == ("odometry.txt: timestamps are ms: so they reach over the time of the boxes",)
    (folder / "odometry.txt").unlink()
    write_tum(folder / "poses.txt", walk, begin=2.0)
    with pytest.raises(FileError, match="20 of 60 frames have no pose: frame 0 is at 0 s, the poses reach from 2 to"):
        read(folder)
    write_tum(folder / "poses.txt", walk, begin=0.5, every=10.0)
    with pytest.raises(FileError, match=r"frames have no pose: frame 0 is at 0 s, the poses reach from 0\.5 to"):
        read(folder)
    (folder / "poses.txt").write_text("0 0 0 1 0.5 0 0 0.8660254\n1 1 0 1 0.5 0 0 0.8660254\n")
    with pytest.raises(FileError, match="line 1: the body leans by"):
        read(folder)
    write_tum(folder / "poses.txt", walk)
    rows = write_people(folder / "people.csv", walk).read_text().splitlines()
    turned = [",".join([t, k, y, x, h]) for t, k, x, y, h in (row.split(",") for row in rows[1:])]
    (folder / "people.csv").write_text("\n".join(["frame,id,x,y,height", *turned]))
    with pytest.raises(FileError, match="0% of these are where that person's box would be: are these places in m"):
        read(folder)
    mixed = [turned[n] if n % 3 else row for n, row in enumerate(rows[1:])]
    (folder / "people.csv").write_text("\n".join(["frame,id,x,y,height", *mixed]))
    assert any(
        "% of these are where that person's box would be: are these places in m" in note for note in read(folder).notes
    )
    others = [",".join([t, f"{int(k) + 50}", *rest]) for t, k, *rest in (row.split(",") for row in rows[1:])]
    (folder / "people.csv").write_text("\n".join([rows[0], *others]))
    with pytest.raises(FileError, match="none of 480 boxes has the id of a person"):
        read(folder)
    (folder / "people.csv").write_text("\n".join([*rows, rows[-1]]))
    with pytest.raises(FileError, match="this id already has a place in this frame"):
        read(folder)


def test_people_without_ids_of_boxes_are_matched_by_overlap(folder, walk):
    (folder / "boxes.csv").unlink()
    write_mot(folder / "det.txt", walk, linked=False)
    write_tum(folder / "poses.txt", walk)
    write_people(folder / "people.csv", walk)
    places, _ = read(folder).footage.positions()
    assert np.isfinite(places[..., 0]).mean() > 0.8


def test_people_without_poses_are_relative(folder, walk, tmp_path):
    relative = world_to_relative(walk.people, walk.poses)
    places = ((t, k, *relative[t, k]) for t, k in np.ndindex(relative.shape[:2]))
    lines = [f"{t * 0.1:.3f},{k + 1},{right},{forward}\n" for t, k, right, forward in places]
    (folder / "people.csv").write_text("time,id,x,y\n" + "".join(lines))
    dataset = generate("own", tmp_path / "d", Options(source=folder))
    assert dataset.info.truth == "relative"
    sequence = dataset.sequence(0)
    people = dataset.track_persons(sequence)[-1] - 1  # ids of the file are from 1
    np.testing.assert_allclose(dataset.relative_truth(sequence), relative[:, people], atol=1e-6)


def edit_line(path, number, edit):
    lines = path.read_text().splitlines()
    lines[number - 1] = edit(lines[number - 1])
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("name", ["poses.txt", "odometry.txt"])
def test_nobody_is_as_fast_as_a_place_in_mm_says(folder, walk, name):
    write_tum(folder / name, walk)
    edit_line(folder / name, 31, lambda line: " ".join([line.split()[0], "5000", *line.split()[2:]]))
    with pytest.raises(
        FileError, match=rf"{name}, line 31: the place is \S+ m from the one 0.1 s before; are places in m"
    ):
        read(folder)
    write_tum(folder / name, walk)
    for number in range(1, 60):
        edit_line(
            folder / name,
            number,
            lambda line: " ".join(str(1000.0 * float(x)) if 0 < n < 4 else x for n, x in enumerate(line.split())),
        )
    with pytest.raises(FileError, match=rf"{name}, line \d+: the place is \S+ m from"):
        read(folder)


def test_places_in_mm_are_found_at_any_rate_and_only_where_boxes_are(folder, walk):
    times = np.arange(-10.0, 6.0, 0.005)
    lines = [f"{t:.4f} {1000.0 * t:.3f} 0 1.5 0 0 0 1" for t in times]  # 1 m/s at 200 Hz
    (folder / "odometry.txt").write_text("\n".join(lines) + "\n")
    with pytest.raises(FileError, match=r"odometry.txt, line \d+: the place is 1,?000 m from the one 1 s before"):
        read(folder)
    lines = [f"{t:.4f} {t + 1000.0 * (t > -5.0):.3f} 0 1.5 0 0 0 1" for t in times]  # it was moved before the film
    (folder / "odometry.txt").write_text("\n".join(lines) + "\n")
    assert read(folder).footage.odometry is not None


def test_people_seen_from_a_fast_camera_do_not_leap(tmp_path):
    """25 m/s, and their places are those beside the camera as long as nobody knows its poses."""
    path, timeline = tmp_path / "people.csv", Timeline(60, 0.1, 0.1 * np.arange(60))
    path.write_text("\n".join(["frame,id,x,y", *(f"{t},1,2.0,{200.0 - 2.5 * t}" for t in range(0, 60, 4))]) + "\n")
    assert read_people(path, "drive", timeline, posed=False)[1] == ()
    (note,) = read_people(path, "drive", timeline, posed=True)[1]
    assert "people.csv, line 3: id 1 is 10 m from its place before, as are 14 places" in note


def test_people_who_leap_are_told_of(folder, walk):
    write_tum(folder / "poses.txt", walk)
    edit_line(
        write_people(folder / "people.csv", walk), 100, lambda line: line.replace(",", ",9", 2).replace(",9", ",", 1)
    )
    (note,) = (note for note in read(folder).notes if note.startswith("people.csv"))
    assert re.match(r"people.csv, line \d+: id \d is \S+ m from its place before, as are [12] places", note)


def written(folder: Path, walk: Walk, change) -> Path:
    """``odometry.txt`` of the walk, each row of numbers changed."""
    rows = np.loadtxt(write_tum(folder / "odometry.txt", walk))
    np.savetxt(folder / "odometry.txt", change(rows), fmt="%.9f")
    return folder


def test_numbers_of_frames_and_nanoseconds_are_times(folder, walk):
    write_tum(folder / "odometry.txt", walk)
    wanted = read(folder).footage.odometry
    for scale, unit in ((10.0, "numbers of frames"), (1e9, "ns")):
        recording = read(written(folder, walk, lambda rows, scale=scale: rows * np.array([scale, *[1] * 7])))
        np.testing.assert_allclose(recording.footage.odometry.motions, wanted.motions, atol=1e-6)
        assert recording.notes == (f"odometry.txt: timestamps are {unit}: so they reach over the time of the boxes",)


@pytest.mark.parametrize(("frames", "when"), [(1, "later"), (-1, "earlier")])
def test_poses_that_count_from_another_number_are_named(folder, walk, frames, when):
    later = 0.1 * frames * np.eye(8)[0]
    (note,) = read(written(folder, walk, lambda rows: rows + later)).notes
    assert f"as many poses as there are frames, each 0.1 s {when}: do both count from one number" in note


def matrices(rows):
    half = 2.0 * np.arctan2(rows[:, 6], rows[:, 7])
    zero, cos, sin = 0.0 * half, np.cos(half), np.sin(half)  # x right, y down, z forward
    columns = [cos, zero, -sin, -rows[:, 2], zero, zero + 1.0, zero, zero, sin, zero, cos, rows[:, 1]]
    return np.stack(columns, axis=-1)


def test_matrices_without_timestamps_are_a_frame_each(folder, walk):
    write_tum(folder / "odometry.txt", walk)
    wanted = read(folder).footage.odometry
    recording = read(written(folder, walk, matrices))
    assert not recording.notes
    np.testing.assert_allclose(recording.footage.odometry.motions, wanted.motions, atol=1e-6)
    with pytest.raises(FileError, match="has 50 lines without timestamps, and the boxes 60 frames"):
        read(written(folder, walk, lambda rows: matrices(rows)[:50]))


def test_truth_is_read_in_its_axes(folder, walk):
    written(folder, walk, matrices).joinpath("odometry.txt").rename(folder / "poses.txt")
    poses = read(folder).footage.poses
    np.testing.assert_allclose(poses, walk.poses, atol=1e-6)


def test_odometry_of_a_base_is_carried_to_the_camera(folder, walk):
    forward, left, yaw = mount = (0.4, -0.2, 0.5)
    turn = walk.poses[:, 2] - yaw
    away = np.stack([np.cos(turn) * forward - np.sin(turn) * left, np.sin(turn) * forward + np.cos(turn) * left], -1)
    base = np.column_stack([walk.poses[:, :2] - away, turn])
    write_tum(folder / "odometry.txt", walk)
    wanted = read(folder).footage.odometry
    write_tum(folder / "odometry.txt", replace(walk, poses=base))
    camera = folder / "camera.toml"
    camera.write_text(camera.read_text() + f"[odometry]\nmount = {list(mount)}\nturn_floor = 0.1\n")
    found = read(folder).footage.odometry
    np.testing.assert_allclose(found.motions, wanted.motions, atol=1e-6)
    assert (found.covariances[1:, 1, 1] > wanted.covariances[1:, 1, 1] + (0.03 * 0.25) ** 2).all()  # by the lever
    camera.write_text(camera.read_text().replace("0.4", "400.0"))
    with pytest.raises(FileError, match=r"mount = .* must be"):
        read(folder)


def test_a_way_that_leads_sideways_is_a_note_with_figures(folder, walk):
    (note,) = read(
        written(folder, walk, lambda rows: rows[:, [0, 2, 1, 3, 4, 5, 6, 7]] * [1, -1, 1, 1, 1, 1, 1, 1])
    ).notes
    assert re.search(r"odometry.txt: 100% of the way leads 9\d° to the left of where the camera looks", note)


def turning(amount: float, at: float | None = None, frames: int = 60) -> Walk:
    """A camera that turns by ``amount`` rad among people who stand, all the time or within a second about ``at``."""
    walk = make_walk(frames)
    share = np.linspace(0.0, 1.0, len(walk.poses))
    share = share if at is None else np.clip(walk.dt * np.arange(len(walk.poses)) - at + 0.5, 0.0, 1.0)
    poses = np.column_stack([walk.poses[:, :2], amount * share])
    places = np.broadcast_to([[9.0, -2.0], [9.0, 1.0], [12.0, 3.0], [14.0, -3.0]], (len(poses), 4, 2))
    boxes = walk.camera.project(world_to_relative(places, poses), np.full((len(poses), 4), 1.72))
    return replace(walk, poses=poses, people=places, heights=np.full(4, 1.72), boxes=rectangles(boxes))


@pytest.mark.parametrize("frames", [20, 60])
def test_turns_are_those_that_boxes_show(tmp_path, frames):
    walk = turning(0.4, frames=frames)
    folder = write_folder(tmp_path / "turn", walk)
    assert not read(written(folder, walk, lambda rows: rows)).notes
    mirrored = np.array([1, 1, -1, 1, 1, 1, -1, 1])
    with pytest.raises(FileError, match=r"of 23° .* boxes show -\d+%, the other way: .*'ned'"):
        read(written(folder, walk, lambda rows: rows * mirrored))
    (folder / "camera.toml").write_text(CAMERA_TOML + '[odometry]\naxes = "ned"\n')
    assert read(written(folder, walk, lambda rows: rows * mirrored)).notes == ()
    still = write_folder(tmp_path / "still", turning(0.0, frames=frames))
    (note,) = read(written(still, walk, lambda rows: rows)).notes
    assert re.search(r"of 23° that the camera turns by it, boxes show ", note)


@pytest.mark.parametrize(("seconds", "when"), [(0.7, "7 frames earlier"), (-1.2, "12 frames later")])
def test_turns_of_another_clock_are_named(tmp_path, seconds, when):
    walk = turning(0.4, at=3.0)
    folder = write_folder(tmp_path / "turn", walk)
    assert not read(written(folder, walk, lambda rows: rows)).notes
    notes = read(written(folder, walk, lambda rows: rows + seconds * np.eye(8)[0])).notes
    assert any(f"boxes show its turns {when}: is its clock theirs?" in note for note in notes)


def test_a_small_yaw_in_degrees_is_named(tmp_path):
    walk = turning(0.1, at=3.0)
    folder = write_folder(tmp_path / "turn", walk)
    rows = np.column_stack([0.1 * np.arange(len(walk.poses)), walk.poses[:, :2], np.degrees(walk.poses[:, 2])])
    np.savetxt(folder / "odometry.txt", rows, delimiter=",", header="time,x,y,yaw", comments="")
    assert any("read as yaw in degrees" in note for note in read(folder).notes)


def test_odometry_that_was_reset_has_no_motion_there(folder, walk):
    def reset(rows):
        rows[30:, 1:3] -= rows[30, 1:3]
        return rows

    wanted = read(written(folder, walk, lambda rows: rows)).footage.odometry.motions
    recording = read(written(folder, walk, reset))
    found = recording.footage.odometry.motions
    assert np.flatnonzero(np.isnan(found[:, 0])).tolist() == [0, 30]
    np.testing.assert_allclose(np.delete(found, [0, 30], axis=0), np.delete(wanted, [0, 30], axis=0), atol=1e-6)
    assert re.search(r"odometry.txt, line 31: the pose leaps by [\d.]+ m .* one of 1 leaps", recording.notes[0])
    again = np.array([0.05, *[0] * 7])
    with pytest.raises(FileError, match=r"line 61: the clock goes back by 5\.85 s; of two recordings keep one"):
        read(written(folder, walk, lambda rows: np.concatenate([rows, rows + again])))


def test_a_pose_that_never_changes_is_said(folder, walk):
    notes = read(written(folder, walk, lambda rows: rows * np.array([1, 0, 0, 1, 0, 0, 0, 0]) + np.eye(8)[7])).notes
    assert "odometry.txt: its pose never changes: the camera is taken to stand" in notes


def test_turns_of_a_mirrored_world_are_not_late(tmp_path):
    walk = turning(0.0)
    poses = np.column_stack([0.1 * walk.poses[:, :2], 0.3 * np.sin(2.0 * walk.dt * np.arange(60))])
    boxes = walk.camera.project(world_to_relative(walk.people, poses), np.full((60, 4), 1.72))
    folder = write_folder(tmp_path / "sway", walk := replace(walk, poses=poses, boxes=rectangles(boxes)))
    with pytest.raises(FileError, match="the other way"):
        read(written(folder, walk, lambda rows: rows * np.array([1, 1, -1, 1, 1, 1, -1, 1])))


def test_people_may_have_times_in_ms_and_heights_in_cm_by_name(folder, walk):
    write_tum(folder / "poses.txt", walk)
    write_people(folder / "people.csv", walk)
    wanted = read(folder).footage.scene
    head, *rows = (folder / "people.csv").read_text().split()
    assert head == "frame,id,x,y,height"
    cells = [row.split(",") for row in rows]
    lines = [f"{100 * int(frame)},{name},{x},{y},{100 * float(height)}" for frame, name, x, y, height in cells]
    (folder / "people.csv").write_text("\n".join(["time,id,x,y,height_cm", *lines]))
    found = read(folder).footage.scene
    np.testing.assert_array_equal(found.positions, wanted.positions)
    np.testing.assert_allclose(found.heights, wanted.heights)
    (folder / "people.csv").write_text("\n".join(["time,id,x,y,height", *lines]))
    with pytest.raises(FileError, match=r"people.csv, line 2: height is 1\d\d.*; heights of people are in m"):
        read(folder)
