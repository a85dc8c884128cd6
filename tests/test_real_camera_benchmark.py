"""The benchmark of real cameras: figures are those of `score`; gaps, noise and targets are what they say."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.real_camera.cells import cells, errors
from benchmarks.real_camera.measuring import Trial, measure
from benchmarks.real_camera.scenes import BEFORE, GAP, autoregression, noisy_heights, one_at_a_time, stands, with_gap
from benchmarks.real_camera.targets import Target, read_targets
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.scoring import score
from vbbench.sequence import Sequence, Truth
from vbbench.solving import solve


@pytest.fixture(scope="module")
def sim(tmp_path_factory) -> Dataset:
    return generate("sim", tmp_path_factory.mktemp("real") / "sim", Options(tier="noisy", limit=3))


def lasting(dataset: Dataset) -> tuple[Sequence, Truth]:
    """A sequence with its truth, four times as long: everybody is seen again and again."""
    sequence = dataset.sequence(0)
    truth = dataset.truth(sequence)
    again = np.tile(np.arange(sequence.frames), 4)
    given = replace(sequence.given, poses=sequence.given.poses[again], positions=sequence.given.positions[again])
    longer = replace(
        sequence,
        observations=sequence.observations[again],
        visible=sequence.visible[again],
        given=given,
    )
    return longer, replace(truth, poses=truth.poses[again], positions=truth.positions[again])


def test_figures_are_those_of_score(sim: Dataset, tmp_path: Path):
    found = errors(measure(Trial(dataset=sim, protocol="sequential"), "vb-cv", jobs=1))["mean"]
    summaries = score(solve(sim, "vb-cv", "sequential", tmp_path / "answer"), sim.folder).summaries
    assert found == pytest.approx([summaries["dx"].mean, summaries["dt"].mean], rel=1e-5)


def test_in_a_gap_nobody_is_seen_and_after_it_everybody_is_given_anew(sim: Dataset):
    sequence, truth = lasting(sim)
    gapped = with_gap("everybody")(sequence, truth, 0)
    assert not gapped.observed[BEFORE : BEFORE + GAP].any()
    before, after = (gapped.observed[frames].any(axis=0) for frames in (slice(BEFORE), slice(BEFORE + GAP, None)))
    assert before.any()
    assert not (before & after).any()
    assert (~np.isnan(gapped.given.positions[..., 0])).sum(axis=0).max() <= 2
    alone = with_gap("arrivals")(sequence, truth, 0)
    assert not alone.observed[BEFORE + GAP :].any()  # everybody would have been seen in the gap


def test_after_a_gap_one_person_can_be_seen_at_a_time():
    seen = np.array([[1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1]], np.bool_)
    assert one_at_a_time(seen).tolist() == [
        [True, False, False],
        [True, False, False],
        [False, False, False],  # who came beside somebody else is not an arrival
        [False, False, True],
        [False, False, True],
    ]


def test_heights_err_by_three_percent_and_the_bottom_stays_if_asked(sim: Dataset):
    sequence = sim.sequence(0)
    truth, seen = sim.truth(sequence), sequence.observed
    for foot, rows in ((True, 0.5), (False, 0.0)):
        boxes = noisy_heights(0.4, foot)(sequence, truth, 1).observations
        change = boxes[seen] - sequence.observations[seen]
        assert np.allclose(change[:, 1] + rows * change[:, 2], 0.0)
        assert 0.015 < np.std(change[:, 2] / sequence.observations[seen][:, 2]) < 0.045
    drawn = autoregression((20_000, 1), 0.4, np.random.default_rng(0))[:, 0]
    assert np.std(drawn) == pytest.approx(1.0, abs=0.05)
    assert np.corrcoef(drawn[:-1], drawn[1:])[0, 1] == pytest.approx(np.exp(-0.4), abs=0.03)


def test_a_camera_that_sways_by_centimetres_stands():
    poses = np.zeros((5, 3))
    truth = Truth(poses=poses, positions=np.zeros((5, 0, 2)), heights=np.zeros(0))
    assert stands(truth)
    assert not stands(replace(truth, poses=poses + np.arange(5)[:, None] * 0.1))


def test_every_target_is_of_a_cell():
    names = {cell.name: cell for cell in cells()}
    for cell, rows in read_targets().items():
        for row in rows:
            starts = [trial for trial in names[cell].trials if row.startswith(trial)]
            assert starts or row in ("mean", "failed", "capped") or row.startswith(("Δt above", "far "))


def test_a_solver_that_failed_or_said_nothing_misses_its_target():
    target = Target(prototype=(0.5, 0.5), batch=(0.3, 0.3))
    assert not target.missed((0.4, 0.5), whole=False)
    assert target.missed((0.4, 0.5), whole=True)
    assert target.missed((np.inf, 0.1), whole=False)
    assert target.missed((np.nan, 0.1), whole=False)
    assert Target(within=(0.8, 1.25)).missed((0.7, 1.0), whole=False)
