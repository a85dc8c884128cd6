"""Paired comparison of submissions."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.lib.answers import submit, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.errors import VbbenchError
from vbbench.scoring.comparison import compare

METRICS = ("dx", "dx_rel", "dr", "dt", "drift_m", "drift_rad")


@pytest.fixture(scope="module")
def folders(tmp_path_factory) -> dict[str, Path]:
    root = tmp_path_factory.mktemp("compare")
    write_dataset(root / "data", Crowd(scenes=8, frames=24, people=9, seed=3, caution="made up"))
    for name, noise, protocol in (("fine", 0.02, "sequential"), ("poor", 0.1, "sequential"), ("other", 0.1, "rollout")):
        submit(root / name, root / "data", true_answers(root / "data", noise, seed=1), solver=name, protocol=protocol)
    submit(root / "like poor", root / "data", true_answers(root / "data", 0.1, seed=2))
    return {path.name: path for path in root.iterdir()}


@pytest.mark.slow
def test_identical_submissions_do_not_differ(folders):
    result = compare(folders["poor"], folders["poor"], folders["data"])
    for difference in result.differences.values():
        assert (difference.difference, difference.ci95, difference.p_value) == (0.0, (0.0, 0.0), 1.0)


def test_a_better_submission_is_clearly_better(folders):
    for difference in compare(folders["fine"], folders["poor"], folders["data"]).differences.values():
        assert difference.difference < 0
        assert difference.ci95[1] < 0
        assert difference.p_value < 0.01


def test_equally_good_submissions_are_not_told_apart(folders):
    result = compare(folders["poor"], folders["like poor"], folders["data"])
    assert np.mean([result.differences[name].p_value for name in METRICS]) > 0.05


def test_the_other_way_round_is_the_negative(folders):
    one = compare(folders["fine"], folders["poor"], folders["data"]).differences
    two = compare(folders["poor"], folders["fine"], folders["data"]).differences
    for name in METRICS:
        assert one[name].difference == pytest.approx(-two[name].difference)
        assert one[name].ci95 == pytest.approx(tuple(-end for end in reversed(two[name].ci95)))
        assert one[name].p_value == two[name].p_value


def test_pairing_is_by_sequence(folders):
    result = compare(folders["fine"], folders["poor"], folders["data"])
    for name in METRICS:
        a, b = result.a.per_sequence.figures[name], result.b.per_sequence.figures[name]
        assert result.differences[name].difference == pytest.approx(np.nanmean(a - b))


def test_protocols_are_not_mixed(folders):
    with pytest.raises(VbbenchError, match="one protocol"):
        compare(folders["poor"], folders["other"], folders["data"])


def test_json_and_text(folders):
    result = compare(folders["fine"], folders["poor"], folders["data"])
    values = json.loads(result.to_json())
    assert values["a"] == {"solver": "fine", "coverage": 1.0}
    assert set(values["metrics"]) == {"dx", "dx_rel", "dr", "dt"}
    keys = {"a", "b", "difference", "ci95", "p_value", "failure_rate", "mean", "sequences"}
    assert set(values["metrics"]["dx"]) == keys
    assert values["metrics"]["dx"]["failure_rate"] == {"a": 0.0, "b": 0.0}
    assert values["ranked_by"] == "capped"
    assert "A = fine (coverage 100.00%), B = poor" in result.table()
    assert "Caution: made up" in result.table()
    assert "ranked on boards, by capped means" in result.table()
    assert f"{result.blocks:.1f} blocks of" in result.table()


def test_a_runaway_does_not_hide_who_is_better(folders: dict[str, Path], tmp_path: Path) -> None:
    """Fine in all sequences but one, where it goes 8 km astray: plain and capped means say different things."""
    poses, positions = true_answers(folders["data"], 0.02, seed=1)
    positions.loc[positions.sequence == 3, "x"] += 8000.0
    runaway = submit(tmp_path / "astray", folders["data"], (poses, positions), solver="astray")
    values = compare(runaway, folders["poor"], folders["data"]).values()["metrics"]["dx"]
    assert values["mean"]["difference"] > 100
    assert abs(values["difference"]) < 0.2
    assert values["failure_rate"]["a"] > 0 == values["failure_rate"]["b"]


def test_too_few_sequences_have_no_p_value(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data", Crowd(scenes=1, people=3, frames=12, stay=(10, 11)))
    for name, noise in (("a", 0.02), ("b", 0.1)):
        submit(tmp_path / name, tmp_path / "data", true_answers(tmp_path / "data", noise))
    result = compare(tmp_path / "a", tmp_path / "b", tmp_path / "data")
    dx = json.loads(result.to_json())["metrics"]["dx"]
    assert dx["difference"] < 0
    assert (dx["p_value"], dx["ci95"]) == (None, [None, None])
    assert "too few for honest ones" in result.table()
    assert "too few for honest ones" in result.a.table()
    assert json.loads(result.a.to_json())["metrics"]["dx"]["capped_ci95"] == [None, None]
