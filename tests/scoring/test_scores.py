"""Scores of small datasets against a slow implementation of its own, and against figures known beforehand."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.lib.answers import submit, true_answers
from tests.lib.make_dataset import FALSE_ALARM, Crowd, write_dataset
from tests.lib.slow_score import score_rows
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.protocol import get_protocol
from vbbench.scoring import score
from vbbench.scoring.scored_rows import scored_rows
from vbbench.scoring.scores import score_sequence


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("crowd")
    write_dataset(folder, Crowd(caution="made up", frames=24, people=9, seed=3))
    return folder


@pytest.fixture(scope="module")
def noisy(dataset, tmp_path_factory) -> Path:
    return submit(tmp_path_factory.mktemp("noisy"), dataset, true_answers(dataset, 0.1), seconds_per_frame=0.01)


def test_the_truth_scores_zero(dataset, tmp_path):
    result = score(submit(tmp_path, dataset, true_answers(dataset)), dataset)
    assert all(summary.mean < 1e-12 and summary.p95 < 1e-12 for summary in result.summaries.values())
    assert result.coverage == 1.0


@pytest.mark.parametrize(
    ("protocol", "given"), [("one-step", "arrivals"), ("sequential", "arrivals"), ("rollout", "start")]
)
def test_figures_are_those_of_the_slow_implementation(dataset, tmp_path, protocol, given):
    folder = submit(tmp_path, dataset, true_answers(dataset, 0.1), protocol=protocol)
    result, slow = score(folder, dataset), score_rows(dataset, folder, given)
    assert list(result.per_sequence.sequence) == list(slow)
    for metric in ("dx", "dx_rel", "dr", "dt"):
        figures = [figure.get(metric, np.nan) for figure in slow.values()]
        np.testing.assert_allclose(result.per_sequence.figures[metric], figures, rtol=1e-9, atol=1e-9)
        assert result.summaries[metric].mean == pytest.approx(np.nanmean(figures))
        assert result.summaries[metric].std == pytest.approx(np.nanstd(figures))
        assert result.summaries[metric].median == pytest.approx(np.nanmedian(figures))
        assert result.summaries[metric].p95 == pytest.approx(np.nanquantile(figures, 0.95))


@pytest.mark.parametrize("budget", ["FRAMES_AT_ONCE", "CELLS_AT_ONCE"])
def test_chunks_do_not_change_the_score(dataset, noisy, monkeypatch, budget):
    whole = score(noisy, dataset).to_json()
    monkeypatch.setattr(f"vbbench.scoring.scored_rows.{budget}", 1)
    assert score(noisy, dataset).to_json() == whole


def test_one_sequence_has_the_figures_that_it_has_in_the_score_of_all(dataset, noisy):
    every = score(noisy, dataset).per_sequence
    one = score_sequence(noisy, Dataset(dataset), 1)
    assert one.sequence.tolist() == [1]
    assert {name: values[0] for name, values in one.figures.items()} == pytest.approx(
        {name: values[every.sequence == 1][0] for name, values in every.figures.items()}, nan_ok=True
    )
    with pytest.raises(VbbenchError, match="999"):
        score_sequence(noisy, Dataset(dataset), 999)


def test_a_shifted_observer_has_the_error_of_the_shift(dataset, tmp_path):
    poses, positions = true_answers(dataset)
    poses = poses.assign(x=poses.x + 0.3, y=poses.y - 0.4, yaw=poses.yaw + 0.25 + 2 * np.pi)
    summaries = score(submit(tmp_path, dataset, (poses, positions)), dataset).summaries
    want = {"dt": 0.5, "dr": 0.25, "dx": 0.0, "dx_rel": 0.5, "drift_rad": 0.0}
    for metric, value in want.items():
        summary = summaries[metric]
        for figure in (summary.mean, summary.frame_mean, summary.median, summary.p95, *summary.ci95):
            assert figure == pytest.approx(value, abs=1e-9)
        assert summary.std == pytest.approx(0, abs=1e-9)


def test_drift_is_the_error_of_the_motion_over_a_second(dataset, tmp_path):
    poses, positions = true_answers(dataset)
    rate = 0.1  # rad a second
    poses = poses.assign(yaw=poses.yaw + rate * 0.4 * poses.frame)
    summaries = score(submit(tmp_path, dataset, (poses, positions)), dataset).summaries
    assert summaries["drift_rad"].mean == pytest.approx(rate)


def test_json_is_the_contract(dataset, noisy):
    values = json.loads(score(noisy, dataset).to_json())
    keys = {"dataset", "protocol", "solver", "sequences", "frames", "coverage", "seconds_per_frame", "metrics"}
    assert {*keys, "failure_rate"} <= set(values)
    assert values["failure_rate"] == values["metrics"]["dx"]["failure_rate"]
    assert set(values["metrics"]) == {"dr", "dt", "dx", "dx_rel"}
    for summary in values["metrics"].values():
        assert list(summary) == [*SUMMARY, "capped_mean"]
        assert summary["capped_mean"] == summary["capped"]
        assert summary["ci95"][0] <= summary["mean"] <= summary["ci95"][1]
    assert values["dataset"] == Dataset(dataset).info.id
    assert (values["protocol"], values["solver"], values["seconds_per_frame"]) == ("sequential", "test", 0.01)
    assert values["caution"] == "made up"


def test_golden_figures(dataset, noisy):
    result = score(noisy, dataset)
    means = {name: round(summary.mean, 4) for name, summary in result.summaries.items()}
    assert (result.sequences, result.frames, int(result.per_sequence.positions.sum())) == GOLDEN_COUNTS
    assert means == GOLDEN_MEANS


def test_the_table_says_what_was_scored_and_repeats_the_caution(dataset, noisy):
    text = score(noisy, dataset).table()
    assert "sequential/2" in text
    assert "Boards rank by 'capped'" in text
    assert "blocks of" in text
    assert "Caution: made up" in text
    assert "sequences scored" in text
    assert text.count("100.00%") == 6


def test_figures_of_runs_away_keep_their_columns_apart(dataset, tmp_path):
    poses, positions = true_answers(dataset)
    table = score(submit(tmp_path, dataset, (poses.assign(x=poses.x + 123456.789), positions)), dataset).table()
    line = next(line for line in table.splitlines() if line.startswith("Δt"))
    assert "1.23e+05  1.23e+05" in line
    assert max(map(len, line.replace("±", " ").split())) < 16


def test_csv_of_sequences(dataset, noisy, tmp_path):
    result = score(noisy, dataset)
    result.write_per_sequence(tmp_path / "figures.csv")
    lines = (tmp_path / "figures.csv").read_text().splitlines()
    heads = "sequence,scene,first_frame,last_frame,frames,positions,coverage,dx_rel,dx,dr,dt,drift_m,drift_rad"
    assert lines[0] == heads
    assert len(lines) == 1 + result.sequences
    assert float(lines[1].split(",")[10]) == pytest.approx(result.per_sequence.figures["dt"][0])


def test_false_alarms_are_not_scored_and_need_no_answer(tmp_path):
    write_dataset(tmp_path / "data", Crowd(tier="tracked", people=8, seed=1))
    poses, positions = true_answers(tmp_path / "data", 0.1)
    assert FALSE_ALARM not in set(positions.track)
    result = score(submit(tmp_path / "without", tmp_path / "data", (poses, positions)), tmp_path / "data")
    alarm = poses[["sequence", "frame"]].assign(track=FALSE_ALARM, x=50.0, y=50.0)
    marked = pd.concat([positions, alarm]).sort_values(["sequence", "frame", "track"])
    both = submit(tmp_path / "with", tmp_path / "data", (poses, marked))
    assert score(both, tmp_path / "data").to_json() == result.to_json()
    assert result.frames > 0


def test_given_rows_are_not_scored_and_may_be_there(dataset, noisy, tmp_path):
    poses, positions = true_answers(dataset, 0.1)
    poses.loc[poses.frame < 2, ["x", "y", "yaw"]] = 1e6
    positions.loc[positions.frame < 2, ["x", "y"]] = np.nan
    assert (
        score(submit(tmp_path, dataset, (poses, positions)), dataset)
        .to_json()
        .replace('"seconds_per_frame": null', '"seconds_per_frame": 0.01')
        == score(noisy, dataset).to_json()
    )


def test_scored_rows_leave_out_what_was_given(dataset):
    opened = Dataset(dataset)
    for protocol in map(get_protocol, ("sequential", "rollout")):
        rows = [set(zip(r.sequence, r.frame, r.track, strict=True)) for r in scored_rows(opened, protocol)]
        want = set()
        for sequence in opened.sequences():
            given = protocol.select_given(sequence.given)
            free = sequence.observed & np.isnan(given.positions[..., 0])
            want |= {(sequence.index, t, sequence.tracks[k]) for t, k in np.argwhere(free) if t >= 2}
        assert set().union(*rows) == want


def test_a_dataset_with_nothing_to_score_says_so(tmp_path):
    write_dataset(tmp_path / "data", Crowd(people=1, scenes=1, seed=2, stay=(9, 10)))
    folder = submit(tmp_path / "answer", tmp_path / "data", true_answers(tmp_path / "data"))
    with pytest.raises(VbbenchError, match="no sequence has a frame to score"):
        score(folder, tmp_path / "data")


SUMMARY = ["capped", "capped_ci95", "failure_rate", "median", "mean", "ci95", "std", "p95"]
SUMMARY += ["frame_mean", "frame_std", "blocks"]
GOLDEN_COUNTS = (18, 88, 202)
GOLDEN_MEANS = {"dr": 0.085, "dt": 0.1311, "drift_m": 0.2431, "drift_rad": 0.1579, "dx": 0.1195, "dx_rel": 0.1677}
