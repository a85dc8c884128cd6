"""Footage: recordings of real cameras as datasets, whatever is known of their truth."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.lib.made_footage import FRAMES, KINDS, PEOPLE, known_as, made, recording, relative
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import Pictures
from vbbench.files.verification import verify
from vbbench.generation.footage import FootageOptions, joined_odometry
from vbbench.generation.generator import Options
from vbbench.geometry import motion_between, moved_as_one, world_to_relative
from vbbench.registry import load
from vbbench.scoring import score
from vbbench.sequence import NOBODY, Odometry
from vbbench.solving import solve

LIB = "tests.lib.made_footage"


def scored(dataset, solver="Still", protocol="cold-start"):
    answer = solve(dataset, f"{LIB}:{solver}", protocol, dataset.folder.with_name(f"{dataset.folder.name}-{solver}"))
    return score(answer, dataset.folder)


def test_cameras_may_differ_from_sequence_to_sequence(tmp_path):
    dataset = made(tmp_path / "d", recording("one", 1.5), recording("two", 1.2))
    assert [camera.mount_height for camera in dataset.info.cameras] == [1.5, 1.2]
    assert [dataset.problem(sequence).camera.mount_height for sequence in dataset.sequences()] == [1.5, 1.2]
    assert "are as written" in verify(tmp_path / "d")
    for sequence in dataset.sequences():
        truth = dataset.truth(sequence)
        nobody = (dataset.track_persons(sequence) == NOBODY).all(axis=0)
        assert nobody.sum() == 1
        assert np.isnan(truth.positions[:, nobody]).all()
        assert sequence.observed[:, nobody].any()
        relative = world_to_relative(truth.positions[:, ~nobody], truth.poses)
        heights = np.broadcast_to(truth.heights[~nobody], relative.shape[:2])
        again, seen = dataset.camera(sequence).project(relative, heights), sequence.observed[:, ~nobody]
        np.testing.assert_allclose(again[seen], sequence.observations[:, ~nobody][seen])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("known", "missing"),
    [("whole", set()), ("poses", {"dx", "dx_rel"}), ("relative", {"dx", "dr", "dt"}), ("none", None)],
)
def test_what_is_not_known_is_not_scored_and_said(tmp_path, known, missing):
    dataset = made(tmp_path / "d", known_as(known))
    assert (dataset.info.truth, Dataset(tmp_path / "d").info.id) == (known, dataset.info.id)
    verify(tmp_path / "d")
    if known != "whole":
        with pytest.raises(VbbenchError, match="use cold-start"):
            solve(dataset, "cv", "sequential", tmp_path / "no")
    if known == "none":
        with pytest.raises(VbbenchError, match="has no true poses"):
            scored(dataset)
        return
    result = scored(dataset)
    assert {name for name, figure in result.values()["metrics"].items() if figure["mean"] is None} == missing
    assert ("not known" in result.table()) == (known != "whole")
    assert result.values().get("truth", "whole") == known


def test_relative_errors_without_poses_are_those_with_them_up_to_the_turn(tmp_path):
    whole = recording(poses=np.zeros((FRAMES, 3)))
    found = [
        scored(made(tmp_path / str(n), one)).summaries["dx_rel"].mean for n, one in enumerate([whole, relative(whole)])
    ]
    np.testing.assert_allclose(*found)
    assert found[0] > 0.01


@pytest.mark.slow
def test_odometry_reaches_solvers_frame_by_frame(tmp_path):
    motions = np.full((FRAMES, 3), np.nan)
    motions[1:] = np.arange(3 * (FRAMES - 1)).reshape(-1, 3)
    covariances = np.einsum("t,ij->tij", np.arange(FRAMES), np.array([[3.0, 1, 0.5], [1, 2, 0.25], [0.5, 0.25, 1]]))
    dataset = made(tmp_path / "d", recording(odometry=Odometry(motions=motions, covariances=covariances)))
    (sequence,) = dataset.sequences()
    odometry, first = sequence.given.odometry, FRAMES - sequence.frames
    np.testing.assert_array_equal(odometry.motions, motions[first:])
    np.testing.assert_array_equal(odometry.covariances[1:], covariances[first + 1 :])
    for isolate in (False, True):
        solve(dataset, f"{LIB}:Watcher", "cold-start", tmp_path / f"a{isolate}", isolate=isolate)


def test_thinned_odometry_is_the_motion_between_the_kept_frames():
    rng, spread = np.random.default_rng(0), np.diag([0.01, 0.02, 1e-3])
    motions = rng.normal(0.0, 0.3, (9, 3))
    joined = joined_odometry(Odometry(motions=motions, covariances=np.tile(spread, (9, 1, 1))), 4)
    assert np.isnan(joined.motions[0]).all()
    kept = np.array([np.zeros(3), ended(motions[1:5]), ended(motions[1:9])])
    np.testing.assert_allclose(joined.motions[1:], motion_between(kept[:-1], kept[1:]), atol=1e-12)
    drawn = [ended(motions[1:5] + rng.normal(size=(4, 3)) * np.sqrt(np.diag(spread))) for _ in range(5000)]
    np.testing.assert_allclose(np.cov(np.array(drawn).T), joined.covariances[1], rtol=0.1, atol=0.002)


def ended(motions):
    """The pose after some motions (forward, left, turn), from (0, 0, 0) on."""
    pose = np.zeros(3)
    for motion in motions:
        turn = pose[2] + motion[2]
        pose = moved_as_one(motion[None], np.zeros(3), pose)[0]
        pose[2] = turn
    return pose


def test_every_nth_frame_keeps_pictures_and_people_in_step(tmp_path):
    one = recording(pictures=Pictures(pattern="/films/{:04d}.png", first=7, step=1))
    dataset = made(tmp_path / "d", one, footage=FootageOptions(every=3))
    assert (dataset.info.dt, len(dataset.sequence(0).observations)) == (pytest.approx(1.2), FRAMES // 3)
    assert str(Dataset(tmp_path / "d").info.pictures[0].path(2)) == "/films/0013.png"
    poses = dataset.world(dataset.sequence(0)).poses(one.poses[::3])
    np.testing.assert_array_equal(dataset.truth(dataset.sequence(0)).poses, poses)


@pytest.mark.parametrize(
    ("split", "name", "value"),
    [
        ("own", "cyclists", True),
        ("kitti", "cameras", ("panorama",)),
        ("jrdb", "poses", Path("p")),
        ("motsynth", "bags", Path("g")),
        ("argoverse2", "interpolated", False),
        ("nuscenes", "cyclists", True),
    ],
)
def test_an_option_that_a_split_does_not_read_is_refused(tmp_path, split, name, value):
    options = Options(source=tmp_path, footage=FootageOptions(**{name: value}))
    with pytest.raises(
        VbbenchError, match=f"^{split} is footage and does not read `{name}`; it reads `seed`, .* and `"
    ):
        load("generator", split).plan(options)


@pytest.mark.parametrize(
    ("option", "named"),
    [
        (["--tier", "noisy"], "--tier"),
        (["--sigma-h", "0.2"], "--sigma-h"),
        (["--no-interpolated"], "--interpolated"),
        (["--options", "detector=false"], "--detector"),
        (["--scenario", "plaza"], "--scenario or --people"),
    ],
)
def test_the_command_refuses_it_in_one_line(tmp_path, capsys, option, named):
    command = ["generate", "own", "--source", str(tmp_path), *option, "--out", str(tmp_path / "d")]
    assert main(command) == 2
    read = "--seed, --limit, --source, --dt, --sequences, --every, --longest, --poses, --boxes and --person-class"
    assert capsys.readouterr().err == f"vbbench: own is footage and does not read {named}; it reads {read}\n"


def test_footage_without_enough_people_in_a_row_is_refused(tmp_path):
    nothing = np.full((FRAMES, PEOPLE + 1), np.nan)
    empty = replace(recording(), boxes=np.repeat(nothing[..., None], 3, axis=2), visible=nothing)
    with pytest.raises(VbbenchError, match="walk: nowhere are there 5 frames in a row, 1 apart, with 3 people"):
        made(tmp_path / "d", empty)


def test_sequences_are_as_long_and_as_many_as_is_asked(tmp_path):
    cut = made(tmp_path / "d", recording("one"), footage=FootageOptions(longest=12))
    assert [sequence.frames for sequence in cut.sequences()] == [12, 12, 6]
    assert len(made(tmp_path / "e", recording("one"), recording("two"), limit=1)) == 1


@pytest.mark.parametrize("kind", KINDS[1:])
def test_other_commands_work_or_state_what_they_lack(tmp_path, kind, capsys):
    dataset = made(tmp_path / "d", known_as(kind))
    folder = str(dataset.folder)
    answer = str(solve(dataset, f"{LIB}:Walker", "cold-start", tmp_path / "answer"))
    for command in (["export", "mot"], ["export", "csv"]):
        assert main([*command, folder, "--out", str(tmp_path / command[1])]) == 0
    assert main(["verify", folder]) == main(["info", folder]) == 0
    capsys.readouterr()
    assert main(["compare", answer, answer, "--dataset", folder]) == (2 if kind == "none" else 0)
    table = capsys.readouterr().out
    assert "nan" not in table
    assert table.count("not known") == {"poses": 2, "relative": 5, "none": 0}[kind]
