"""People labelled as cuboids: Argoverse 2 and nuScenes agree with the same drive as a recording of split ``own``."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from tests.lib.cars import EYES, FOCAL, HEIGHT, LOG, WIDTH, Drive, write_log, write_own, write_tables
from vbbench.boxes import rectangles
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation import generate, write_dataset
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_generators.footage.argoverse2 import argoverse2
from vbbench_generators.footage.cuboids import CuboidSplit, chosen, motion_at, part_of
from vbbench_generators.footage.nuscenes import nuscenes
from vbbench_generators.footage.own import own
from vbbench_generators.footage.split import RunRules

SPLITS = {"argoverse2": argoverse2, "nuscenes": nuscenes}
NOWHERE = "nowhere are there 16 frames in a row, 5 apart, with 3 people within 40 m"


class Car(NamedTuple):
    """A drive as the files of a split, and the name of its recording there."""

    name: str
    split: CuboidSplit
    drive: Drive
    source: Path
    recording: str


def written(name, folder, **changed):
    drive = Drive(ground=0.31 if name == "argoverse2" else 0.0, **changed)
    if name == "argoverse2":
        write_log(folder / "av2" / "sensor" / "val" / LOG, drive)
        return Car(name, argoverse2, drive, folder / "av2", LOG)
    write_tables(folder / "nu" / "v1.0-mini", {"scene-0001": drive})
    return Car(name, nuscenes, drive, folder / "nu", "scene-0001")


@pytest.fixture(scope="module", params=SPLITS)
def car(request, tmp_path_factory):
    return written(request.param, tmp_path_factory.mktemp("car"))


def asked(source, **footage):
    return Options(source=source, footage=FootageOptions(**{"every": 5, **footage}))


def test_every_error_agrees_with_the_same_drive_as_an_own_recording(car, tmp_path):
    people, av2 = car.drive.people, car.name == "argoverse2"
    ids = [people - 1 - n for n in range(people)] if av2 else list(range(people))
    prior = car.split.height_mean, car.split.height_std
    plans = (
        car.split.plan(asked(car.source)),
        own.plan(asked(write_own(tmp_path / "walk", car.drive, ids, prior, jitter=av2))),
    )
    cuboids, same = (write_dataset(plan, tmp_path / name) for name, plan in zip(("cuboids", "own"), plans, strict=True))
    assert errors_of(cuboids) == pytest.approx(errors_of(same), abs=0.01)
    first, second = cuboids.sequence(0), same.sequence(0)
    np.testing.assert_array_equal(first.tracks, second.tracks)
    np.testing.assert_allclose(first.observations, second.observations, atol=0.05)  # nuScenes' are interpolated
    verify(tmp_path / "cuboids")


def errors_of(dataset):
    """Every Δ of a solver under two protocols."""
    errors = []
    for protocol in ("sequential", "cold-start"):
        out = dataset.folder.parent / f"{dataset.folder.name}-{protocol}"
        values = score(solve(dataset, "map-causal", protocol, out), dataset.folder).values()["metrics"]
        errors += [figures["mean"] for name, figures in values.items() if name in ("dx", "dx_rel", "dt")]
    assert errors
    return errors


def test_cameras_and_panorama_see_the_same_people_and_who_is_hidden_has_a_place(car):
    names = [f"ring_{name}" if car.name == "argoverse2" else f"CAM_{name.upper()}" for name in EYES]
    anything = replace(car.split, rules=RunRules(fewest=0), lasting=0.0)
    found = anything.plan(asked(car.source, cameras=tuple(names))).footage
    (whole,) = car.split.plan(asked(car.source)).footage
    assert [one.name.split(".")[1] for one in found] == names
    assert all(one.camera.picture_size == (WIDTH, HEIGHT) for one in found)
    front = found[0]
    np.testing.assert_allclose(front.scene.positions, whole.scene.positions)
    assert set(front.tracks) <= set(whole.tracks)
    boxes = rectangles(front.boxes)[front.observed]
    assert (boxes[:, 3] < 2.2 * FOCAL / 5.0).all()
    assert front.camera.mount_height == pytest.approx(car.drive.eye_height + car.drive.ground)
    assert (front.camera.pitch, front.camera.roll) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert len(set(whole.scene.people) - set(whole.tracks)) == 1
    assert np.isfinite(whole.scene.positions).all()
    with pytest.raises(VbbenchError, match=r"no camera of .* is called 'CAM_TOP'"):
        car.split.plan(asked(car.source, cameras=("CAM_TOP",)))


@pytest.mark.parametrize(
    "changed", [{"frames": 71}, {"people": 3}, {"reach": (42.0, 50.0)}], ids=["short", "few", "far"]
)
@pytest.mark.parametrize("name", SPLITS)
def test_sequences_need_three_people_near_for_eight_seconds(tmp_path, name, changed):
    other = written(name, tmp_path, **changed)
    with pytest.raises(VbbenchError, match=NOWHERE):
        other.split.plan(asked(other.source))


def test_boxes_of_a_tracker_take_the_place_of_projections(car, tmp_path):
    (one,) = car.split.plan(asked(car.source, every=1)).footage
    rows = [
        f"{frame + 1},{one.tracks[track] + 50},{','.join(map(str, box))},1,-1,-1,-1"
        for frame, track in np.argwhere(one.observed).tolist()
        for box in [rectangles(one.boxes[frame, track]).tolist()]
    ]
    (tmp_path / f"{car.recording}.txt").write_text("\n".join(rows) + "\n")
    plan = car.split.plan(asked(car.source, boxes=tmp_path))
    assert (plan.info.pixel_std, plan.info.box_edge) == (5.0, None)
    assert (plan.footage[0].tracks >= 50).all()
    assert plan.info.calibration["recordings"][car.recording]["tracked"]["recall"] == 1.0


def test_the_command_makes_verifies_and_repeats_a_dataset(tmp_path, capsys):
    source = written("argoverse2", tmp_path).source
    command = ["generate", "argoverse2", "--source", str(source), "--camera", "ring_front,panorama"]
    assert main([*command, "--sequences", "test", "--out", str(tmp_path / "d")]) == 0
    assert f"--camera ring_front,panorama --sequences {LOG}" in (tmp_path / "d" / "README.md").read_text()
    recordings = Dataset(tmp_path / "d").info.calibration["recordings"]  # type: ignore[index]
    row = recordings[f"{LOG}.panorama"]
    assert (row["camera"], row["driven"]) == ("moves", pytest.approx(15.0, abs=0.3))
    assert (row["people"], row["speed"]) == (5.0, pytest.approx(1.5, abs=0.3))
    capsys.readouterr()
    assert main(["splits"]) == 0
    listed = capsys.readouterr().out
    assert listed.count("CC BY-NC-SA 4.0") == 2


def test_the_sign_of_a_quaternion_does_not_matter_between_two_poses():
    quaternions = np.array([[1.0, 0.0, 0.0, 0.0], [np.cos(0.1), 0.0, 0.0, np.sin(0.1)]])
    given = np.array([0.5]), np.array([0.0, 1.0])
    one, other = (motion_at(*given, sign * quaternions, np.zeros((2, 3))).rotations for sign in (1.0, [[1.0], [-1.0]]))
    np.testing.assert_allclose(one, other)
    assert np.arctan2(one[0, 1, 0], one[0, 0, 0]) == pytest.approx(0.1, abs=1e-3)


def test_parts_are_by_rule():
    assert part_of("argoverse2", "some log", "val") == "test"
    assert part_of("argoverse2", "adcf7d18-0510-35b0-a2fa-b4cea13a6d76", "val") == "tune"
    assert {part_of("argoverse2", f"log-{n}", "train") for n in range(50)} == {"train", "tune"}
    assert [part_of("nuscenes", f"scene-{n:04d}") for n in (3, 103, 552, 1073)] == ["test", "tune", "test", "test"]
    shares = [part_of("nuscenes", f"scene-{n:04d}") for n in range(111, 220)]
    assert "test" not in shares
    assert 1 <= shares.count("tune") <= 30
    with pytest.raises(VbbenchError, match="is in no part: its folder is 'elsewhere'"):
        part_of("argoverse2", "some log", "elsewhere")
    with pytest.raises(VbbenchError, match="none of the 1 recordings here is of the part 'test'"):
        chosen("nuscenes", ["test"], {"scene-0061": ""})


def test_a_fresh_log_is_a_dataset_by_its_name(tmp_path):
    write_log(tmp_path / LOG, Drive(), missing=40)
    with pytest.raises(VbbenchError, match="nowhere"):  # the missing sweep cuts the run
        generate("argoverse2", tmp_path / "d", Options(source=tmp_path / LOG, footage=FootageOptions(every=5)))
    made = generate("argoverse2", tmp_path / "d", Options(source=tmp_path / LOG, footage=FootageOptions(every=3)))
    assert made.info.dt == pytest.approx(0.3)
