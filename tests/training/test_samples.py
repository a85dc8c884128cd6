"""Samples for training: all that is known, in fixed shapes with masks, the same from a folder and a generator."""

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib.kitti_files import write_kitti
from tests.lib.own_recording import CAMERA_TOML, make_walk
from vbbench import Dataset, PanoramaCamera
from vbbench.errors import VbbenchError
from vbbench.files.sequence_tables import SequenceTable
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.geometry import world_to_relative
from vbbench.protocol import get_protocol, scored_positions
from vbbench.training import FolderSamples, GeneratedSamples, Sample, sources
from vbbench.training.samples import AXES, CAMERA_VALUES, TOLD_VALUES, collate

TIERS = ("ideal", "noisy", "occluded", "tracked", "field")
SMALL = Options(simulation=Simulation(people=(5, 9)), camera=PanoramaCamera(), limit=3)


def assert_same(a: Sample[Any], b: Sample[Any]) -> None:
    for name, values in vars(a).items():
        other = getattr(b, name)
        assert (values.shape, values.dtype) == (other.shape, other.dtype), name
        np.testing.assert_array_equal(values, other, err_msg=name)


@pytest.fixture(scope="module")
def sim(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("sim", tmp_path_factory.mktemp("samples") / "sim", replace(SMALL, tier="noisy"))


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """Sequences of uneven length, of people who come and go in a few scenes that all share."""
    return generate("demo", tmp_path_factory.mktemp("samples") / "demo", Options(tier="occluded", limit=9))


@pytest.mark.parametrize("tier", TIERS)
def test_a_generator_makes_the_samples_that_its_folder_holds(tier: str, tmp_path: Path) -> None:
    options = replace(SMALL, tier=tier, limit=2)
    folder = generate("sim", tmp_path / "sim", options).folder
    for local in (False, True):
        written, made = FolderSamples(folder, local=local), GeneratedSamples("sim", options, stop=2, local=local)
        assert len(written) == len(made) == 2
        for number in range(2):
            assert_same(written[number], made[number])


def test_a_sample_holds_the_sequence_and_its_truth(demo: Dataset) -> None:
    protocol = get_protocol("sequential")
    for number in range(len(demo)):
        sequence, sample = demo.sequence(number), FolderSamples(demo.folder)[number]
        truth, problem = demo.truth(sequence), demo.problem(sequence)
        given = protocol.select_given(sequence.given)
        wanted = {
            "boxes": (sequence.observations, "seen"),
            "given_poses": (given.poses, "pose_given"),
            "given_positions": (given.positions, "position_given"),
            "poses": (truth.poses, "pose_known"),
            "positions": (truth.positions, "position_known"),
            "relative": (world_to_relative(truth.positions, truth.poses), "relative_known"),
            "sights": (problem.camera.unproject(sequence.observations, np.full(sequence.observed.shape, 1.7)), "seen"),
        }
        for name, (values, mask) in wanted.items():
            there = ~np.isnan(values[..., 0])
            np.testing.assert_array_equal(getattr(sample, mask), there, err_msg=name)
            got = getattr(sample, name)
            np.testing.assert_allclose(got[there], values[there], rtol=1e-6, atol=1e-5, err_msg=name)
            assert not got[~there].any(), name
        np.testing.assert_array_equal(sample.persons, demo.track_persons(sequence))
        np.testing.assert_array_equal(sample.scored_positions, scored_positions(sequence.observed, given))
        assert dict(zip(TOLD_VALUES, sample.told.tolist(), strict=True))["dt"] == pytest.approx(demo.info.dt)
        assert dict(zip(CAMERA_VALUES, sample.camera.tolist(), strict=True))["closed"] == 1.0


def test_people_arrive_and_leave_once(demo: Dataset) -> None:
    for sample in FolderSamples(demo.folder).read(range(len(demo))):
        assert (sample.arrives.sum(axis=0) == 1).all()
        assert (sample.leaves.sum(axis=0) == 1).all()
        before, after = np.cumsum(sample.arrives, axis=0) > 0, np.cumsum(sample.leaves[::-1], axis=0)[::-1] > 0
        assert not (sample.seen & ~(before & after)).any()


def test_windows_are_the_frames_of_their_sequence(demo: Dataset) -> None:
    whole = FolderSamples(demo.folder)
    windows = FolderSamples(demo.folder, frames=6, step=2)
    frames = demo.rows["frames"]
    assert len(windows) == sum(max(0, n - 6) // 2 + 1 for n in frames.tolist())
    for window in windows.read(range(len(windows))):
        sequence, part = whole[int(window.index)], slice(int(window.start), int(window.start) + 6)
        kept = np.isin(sequence.tracks, window.tracks)
        assert sequence.seen[part].any(axis=0).tolist() == kept.tolist()
        for name in ("boxes", "positions", "relative", "arrives", "leaves", "persons"):
            np.testing.assert_array_equal(getattr(window, name), getattr(sequence, name)[part][:, kept], err_msg=name)
        assert window.pose_given.tolist() == [t < 2 for t in range(len(window.frames))]
        known = window.seen & window.position_known
        assert (window.position_given == (known & (np.cumsum(known, axis=0) <= 2))).all()


def test_a_local_world_begins_at_the_first_pose_and_keeps_its_shape(demo: Dataset) -> None:
    own, there = FolderSamples(demo.folder, local=True)[0], FolderSamples(demo.folder)[0]
    np.testing.assert_allclose(own.poses[0], 0.0, atol=1e-6)
    np.testing.assert_allclose(own.given_poses[0], 0.0, atol=1e-6)
    np.testing.assert_array_equal(own.relative, there.relative)
    back = world_to_relative(own.positions.astype(float), own.poses.astype(float))
    np.testing.assert_allclose(back[own.position_known], own.relative[own.position_known], atol=1e-4)


def test_a_batch_is_padded_and_says_where(demo: Dataset) -> None:
    several = FolderSamples(demo.folder).read(range(len(demo)))
    batch = collate(several)
    longest, fullest = max(len(one.frames) for one in several), max(len(one.tracks) for one in several)
    assert len({len(one.frames) for one in several}) > 1
    for row, one in enumerate(several):
        frames, people = one.seen.shape
        for name, axes in AXES.items():
            values, inside = getattr(batch, name)[row], tuple({"T": slice(frames), "K": slice(people)}[a] for a in axes)
            np.testing.assert_array_equal(values[inside], getattr(one, name), err_msg=name)
            padding = np.ones(values.shape, np.bool_)
            padding[inside] = False
            assert (values[padding] == (-1 if name in ("tracks", "persons") else 0)).all(), name
    assert batch.seen.shape == (len(several), longest, fullest)


@pytest.mark.slow
def test_a_robot_tells_how_it_moved() -> None:
    options = replace(SMALL, observer="robot")
    sample = GeneratedSamples("sim", options, frames=12)[0]
    assert sample.odometry.shape == (12, 3)
    measured = sample.odometry_measured
    assert measured[1:].all()
    assert (np.diagonal(sample.odometry_covariances[measured], axis1=1, axis2=2) > 0).all()


def test_footage_says_what_was_never_measured(tmp_path: Path) -> None:
    walk = make_walk(frames=12)
    (tmp_path / "walk").mkdir()
    (tmp_path / "walk" / "camera.toml").write_text(CAMERA_TOML)
    lines = [f"{t + 1},{k},{','.join(f'{value:.3f}' for value in box)},1,-1,-1,-1" for t, k, box in walk.rows]
    (tmp_path / "walk" / "gt.txt").write_text("\n".join(lines))
    folder = generate("own", tmp_path / "own", Options(source=tmp_path / "walk")).folder
    sample = FolderSamples(folder)[0]
    assert sample.seen.any()
    assert not any(mask.any() for mask in (sample.pose_known, sample.position_known, sample.relative_known))
    known = FolderSamples(
        generate("kitti", tmp_path / "kitti", Options(source=write_kitti(tmp_path / "training"))).folder
    )
    assert known[0].pose_known.all()
    with pytest.raises(VbbenchError, match="kitti is footage: generate its folder"):
        GeneratedSamples("kitti", Options(source=tmp_path / "training"))


def test_what_is_asked_for_together_is_read_together(demo: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    alone = [FolderSamples(demo.folder)[number] for number in range(len(demo))]
    source, reads, read = FolderSamples(demo.folder), [], SequenceTable._read
    monkeypatch.setattr(SequenceTable, "_read", lambda *asked: reads.append(0) or read(*asked))
    for a, b in zip(alone, source.read(range(len(demo))), strict=True):
        assert_same(a, b)
    assert len(reads) <= len(demo.info.tables)
    reads.clear()
    source.read([3, 1])
    assert not reads


def test_a_source_goes_to_other_processes_as_its_settings(demo: Dataset) -> None:
    source = FolderSamples(demo.folder, frames=5)
    source.read(range(4))
    sent = pickle.dumps(source)
    assert len(sent) < 5000
    assert_same(pickle.loads(sent)[3], source[3])  # noqa: S301
    assert len(pickle.dumps(GeneratedSamples("sim", SMALL))) < 5000


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"frames": 0}, "windows of 0 frames"),
        ({"frames": 3, "step": 0}, "0 apart"),
        ({"sequences": [9]}, "has sequences 0 to 8"),
        ({"sequences": [-1]}, "has sequences 0 to 8"),
        ({"protocol": "sequentail"}, "did you mean 'sequential'"),
    ],
)
def test_what_a_folder_does_not_have_is_said(demo: Dataset, asked: dict[str, Any], said: str) -> None:
    with pytest.raises(VbbenchError, match=said):
        FolderSamples(demo.folder, **asked)


def test_ends_are_ends(demo: Dataset) -> None:
    endless = GeneratedSamples("sim", SMALL)
    assert endless.size is None
    with pytest.raises(TypeError, match="these samples have no end"):
        len(endless)
    assert len(GeneratedSamples("demo", Options(limit=3))) == 3
    for source in (FolderSamples(demo.folder), GeneratedSamples("sim", SMALL, stop=9)):
        with pytest.raises(IndexError):
            source[9]
    with pytest.raises(VbbenchError, match="both are 1 or more"):
        GeneratedSamples("sim", stop=0)


def test_no_more_is_kept_than_fits(demo: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sources, "CELLS_KEPT", int(demo.cells[:2].sum()))
    source = FolderSamples(demo.folder)
    for number in range(len(source)):
        source.read([number])
        assert demo.cells[list(source._kept)].sum() <= sources.CELLS_KEPT
    assert source._kept
