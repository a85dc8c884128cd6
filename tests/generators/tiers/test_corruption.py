"""Tiers of whole datasets: tracks, noise of any size, and the fewest frames of a track that counts."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib.answers import submit, true_answers
from vbbench.camera import PanoramaCamera
from vbbench.errors import VbbenchError
from vbbench.exchange.mot import export_mot, import_mot
from vbbench.files.dataset import Dataset
from vbbench.files.generate_command import options_of
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options, Plan, Simulation
from vbbench.generation.tier import chosen_tier
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_generators.splits import sim, street

FEW = Simulation(sequences=1, people=(16,))


def plan(tier: str, **options: object) -> Plan:
    return street.plan(Options(tier=tier, simulation=FEW, **options))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def tracked(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("street", tmp_path_factory.mktemp("street") / "tracked", Options(tier="tracked", limit=1))


def test_tracks_are_as_files_promise(tracked: Dataset) -> None:
    assert "8 tables and 1 sequences are as written" in verify(tracked.folder)
    sequence = tracked.sequence(0)
    persons, truth = tracked.track_persons(sequence), tracked.truth(sequence)
    assert np.all(sequence.observed.sum(axis=0) >= 3)
    assert np.all(np.isnan(truth.positions[..., 0]) == (persons < 0))
    somebody = (persons >= 0).any(axis=0)
    assert np.array_equal(~np.isnan(truth.heights), somebody)
    assert np.all(np.abs(truth.heights[somebody] - 1.7) < 0.4)
    persons = np.where(sequence.observed, persons, -1)
    first_two = (persons >= 0) & (np.cumsum(persons >= 0, axis=0) <= 2)
    assert np.array_equal(~np.isnan(sequence.given.positions[..., 0]), first_two)
    switched = [len(set(column[column >= 0])) > 1 for column in persons.T]
    assert any(switched)
    assert len(sequence.tracks) > len(set(persons[persons >= 0]))  # tracks break


def test_the_truth_scores_zero_and_false_alarms_count_for_nothing(tracked: Dataset, tmp_path: Path) -> None:
    folder = tracked.folder
    result = score(submit(tmp_path / "true", folder, true_answers(folder)), folder)
    for name in ("dx_rel", "dx", "dr", "dt"):
        assert result.summaries[name].mean == pytest.approx(0.0, abs=1e-9)
    assert result.coverage == 1.0


@pytest.mark.parametrize("protocol", ["one-step", "sequential"])
def test_solvers_answer_tracks(tracked: Dataset, protocol: str, tmp_path: Path) -> None:
    result = score(solve(tracked, "vb-cv", protocol, tmp_path / "answers"), tracked.folder)
    assert result.coverage == 1.0
    if protocol == "one-step":
        assert result.summaries["dx"].mean < 0.491  # Table 4 of the paper


def test_tracks_in_the_panorama() -> None:
    made = plan("tracked", camera=PanoramaCamera()).build(0)
    sequence = made.sequence
    assert np.all(sequence.observations[sequence.observed][:, 0] >= 0)
    assert np.all(sequence.observations[sequence.observed][:, 0] < 1440)
    assert made.persons is not None
    assert (made.persons >= 0).sum() > 0.9 * sequence.observed.sum()


@pytest.mark.slow
@pytest.mark.parametrize("tier", ["tracked", "field"])
def test_longer_tracks_are_the_same_tracks_without_the_shorter(tier: str) -> None:
    usual, long = plan(tier).build(0), plan(tier, least_track=20).build(0)
    lengths = usual.sequence.observed.sum(axis=0)
    kept = lengths >= 20
    assert 0 < kept.sum() < len(kept)
    assert lengths.min() >= 3
    np.testing.assert_array_equal(long.sequence.observations, usual.sequence.observations[:, kept])
    np.testing.assert_array_equal(long.sequence.given.positions, usual.sequence.given.positions[:, kept])
    np.testing.assert_array_equal(long.truth.positions, usual.truth.positions[:, kept])


@pytest.mark.parametrize("tier", ["tracked", "field"])
def test_nothing_changes_where_nothing_is_asked(tier: str) -> None:
    usual = plan(tier).info
    assert plan(tier, least_track=3).info == usual
    assert plan(tier, least_track=4).info.id != usual.id
    assert plan("noisy", noise=1.0).info == plan("noisy").info


def test_noise_has_the_size_that_is_asked_for_and_solvers_are_given_it() -> None:
    exact, rough = plan("ideal").build(0), plan("noisy", noise=2.0)
    off = rough.build(0).sequence.observations - exact.sequence.observations
    assert rough.info.pixel_std == 2.0
    assert np.nanstd(off[..., 0]) == pytest.approx(2.0, abs=0.1)
    for end in (-0.5, 0.5):
        assert np.nanstd(off[..., 1] + end * off[..., 2]) == pytest.approx(2.0, abs=0.1)
    half = plan("noisy", noise=1.0).build(0).sequence.observations - exact.sequence.observations
    np.testing.assert_allclose(2.0 * half, off, atol=1e-9)  # the same hand, twice as hasty


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tier": "ideal", "noise": 1.0}, "tier 'ideal' has no noise whose size can be chosen; remove `noise`"),
        ({"tier": "tracked", "noise": 1.0}, "tier 'tracked' has no noise"),
        ({"tier": "noisy", "least_track": 4}, "tier 'noisy' has no tracks that could be too short"),
        ({"tier": "field", "detector": False, "least_track": 4}, "tier 'field' has no tracks that could be too short"),
        ({"tier": "noisy", "noise": 0.0}, "noise must be 0.001 to 100 px, not 0"),
        ({"tier": "tracked", "least_track": 0}, "least_track must be 1 to 1,000,000, not 0"),
    ],
)
def test_what_cannot_be_is_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises(VbbenchError, match=message):
        chosen_tier(Options(**options))  # type: ignore[arg-type]


def test_a_dataset_says_how_it_is_made_again() -> None:
    def made(tier: str, **options: object) -> dict[str, Any]:
        return options_of(json.loads(sim.plan(Options(tier=tier, **options)).info.to_json()))  # type: ignore[arg-type]

    assert made("noisy", noise=2.0)["noise"] == 2.0
    assert made("noisy", noise=0.5)["noise"] == 0.5
    for tier in ("tracked", "field"):
        assert made(tier, least_track=4)["least_track"] == 4
        assert "least_track" not in made(tier)
    assert "noise" not in made("noisy")
    assert "noise" not in made("tracked")


@pytest.mark.slow
def test_tracks_of_others_count_from_as_many_frames(tmp_path: Path) -> None:
    tracked = generate("street", tmp_path / "tracked", Options(tier="tracked", simulation=FEW))
    plain = generate("street", tmp_path / "plain", Options(simulation=FEW))
    exported = export_mot(tracked, tmp_path / "mot", sequence=0)
    folder = shutil.copytree(exported, tmp_path / "files")
    usual = import_mot(folder, plain, tmp_path / "usual")
    long = import_mot(folder, plain, tmp_path / "long", least_track=20)
    behind = [usual.track_persons(usual.sequence(0)), long.track_persons(long.sequence(0))]
    assert behind[0].shape[1] > behind[1].shape[1] > 0
    assert (long.sequence(0).observed & (behind[1] >= 0)).sum(axis=0).min() >= 20
    assert (usual.info.definition["least_frames"], long.info.definition["least_frames"]) == (3, 20)
    with pytest.raises(VbbenchError, match="least_track must be 1 or more, not 0"):
        import_mot(folder, plain, tmp_path / "no", least_track=0)
