"""People labelled as cuboids: Argoverse 2 and nuScenes agree with the same drive as a recording of split ``own``."""

from dataclasses import replace

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
from vbbench_generators.footage.cuboids import CuboidSplit, chosen, part_of
from vbbench_generators.footage.nuscenes import nuscenes
from vbbench_generators.footage.own import own
from vbbench_generators.footage.split import RunRules

SPLITS: dict[str, CuboidSplit] = {"argoverse2": argoverse2, "nuscenes": nuscenes}
EVERY = 5


def source_of(split, folder, drive):
    if split == "argoverse2":
        write_log(folder / "av2" / "sensor" / "val" / LOG, drive)
        return folder / "av2"
    write_tables(folder / "nu" / "v1.0-mini", {"scene-0001": drive})
    return folder / "nu"


def drive_of(split, **changed):
    return Drive(ground=0.31 if split == "argoverse2" else 0.0, **changed)  # type: ignore[arg-type]


def asked(source, **footage):
    return Options(source=source, footage=FootageOptions(**{"every": EVERY, **footage}))  # type: ignore[arg-type]


@pytest.mark.parametrize("split", SPLITS)
def test_every_error_agrees_with_the_same_drive_as_an_own_recording(tmp_path, split):
    drive = drive_of(split)
    ids = [drive.people - 1 - n for n in range(drive.people)] if split == "argoverse2" else list(range(drive.people))
    prior = SPLITS[split].height_mean, SPLITS[split].height_std
    folder = write_own(tmp_path / "walk", drive, ids, prior, jitter=split == "argoverse2")
    plans = SPLITS[split].plan(asked(source_of(split, tmp_path, drive))), own.plan(asked(folder))
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


@pytest.mark.parametrize("split", SPLITS)
def test_cameras_and_panorama_see_the_same_people(tmp_path, split):
    drive = drive_of(split)
    source = source_of(split, tmp_path, drive)
    names = [f"ring_{name}" if split == "argoverse2" else f"CAM_{name.upper()}" for name in EYES]
    found = replace(SPLITS[split], rules=RunRules(fewest=0), lasting=0.0).plan(asked(source, cameras=tuple(names)))
    whole = SPLITS[split].plan(asked(source))
    assert [one.name.split(".")[1] for one in found.footage] == names
    assert all(one.camera.picture_size == (WIDTH, HEIGHT) for one in found.footage)
    front = found.footage[0]
    ahead = whole.footage[0].scene
    np.testing.assert_allclose(front.scene.positions, ahead.positions)
    relative = [whole.footage[0].observed[:, whole.footage[0].tracks == track].any() for track in front.tracks]
    assert all(relative)
    boxes = rectangles(front.boxes)[front.observed]
    assert (boxes[:, 3] < 2.2 * FOCAL / 5.0).all()
    assert front.camera.mount_height == pytest.approx(drive.eye_height + drive.ground)
    assert (front.camera.pitch, front.camera.roll) == pytest.approx((0.0, 0.0), abs=1e-9)
    with pytest.raises(VbbenchError, match=r"no camera of .* is called 'CAM_TOP'"):
        SPLITS[split].plan(asked(source, cameras=("CAM_TOP",)))


@pytest.mark.parametrize("split", SPLITS)
def test_sequences_need_three_people_near_for_eight_seconds(tmp_path, split):
    drive = drive_of(split)
    assert len(SPLITS[split].plan(asked(source_of(split, tmp_path / "a", drive)))) == 1
    short = source_of(split, tmp_path / "b", replace(drive, frames=71))
    with pytest.raises(VbbenchError, match="nowhere are there 16 frames in a row, 5 apart, with 3 people within 40 m"):
        SPLITS[split].plan(asked(short))
    far = source_of(split, tmp_path / "c", drive_of(split, speed=6.0, people=3))
    with pytest.raises(VbbenchError, match="nowhere are there 16 frames in a row, 5 apart, with 3 people within 40 m"):
        SPLITS[split].plan(asked(far))


@pytest.mark.parametrize("split", SPLITS)
def test_hidden_people_have_no_box_but_a_place(tmp_path, split):
    drive = drive_of(split)
    footage = SPLITS[split].plan(asked(source_of(split, tmp_path, drive))).footage[0]
    hidden = set(footage.scene.people.tolist()) - set(footage.tracks.tolist())
    assert len(hidden) == 1
    assert np.isfinite(footage.scene.positions).all()


@pytest.mark.parametrize("split", SPLITS)
def test_boxes_of_a_tracker_take_the_place_of_projections(tmp_path, split):
    drive = drive_of(split)
    source = source_of(split, tmp_path, drive)
    footage = SPLITS[split].plan(asked(source, every=1)).footage[0]
    name = LOG if split == "argoverse2" else "scene-0001"
    rows = [
        f"{frame + 1},{footage.tracks[track] + 50},{','.join(map(str, box))},1,-1,-1,-1"
        for frame, track in np.argwhere(footage.observed).tolist()
        for box in [rectangles(footage.boxes[frame, track]).tolist()]
    ]
    (tmp_path / f"{name}.txt").write_text("\n".join(rows) + "\n")
    plan = SPLITS[split].plan(asked(source, boxes=tmp_path))
    assert plan.info.pixel_std == 5.0
    assert plan.info.box_edge is None
    assert (plan.footage[0].tracks >= 50).all()
    assert plan.info.calibration["recordings"][name]["tracked"]["recall"] == 1.0


def test_the_command_makes_verifies_and_repeats_a_dataset(tmp_path, capsys):
    source = source_of("argoverse2", tmp_path, drive_of("argoverse2"))
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
    write_log(tmp_path / LOG, drive_of("argoverse2"), missing=40)
    with pytest.raises(VbbenchError, match="nowhere"):  # the missing sweep cuts the run
        generate("argoverse2", tmp_path / "d", Options(source=tmp_path / LOG, footage=FootageOptions(every=5)))
    made = generate("argoverse2", tmp_path / "d", Options(source=tmp_path / LOG, footage=FootageOptions(every=3)))
    assert made.info.dt == pytest.approx(0.3)
