"""What a row said before: kept when newer figures take its place, checked, and never needed."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.board_results import record_of, result
from vbbench.camera import PanoramaCamera, camera_to_dict
from vbbench.errors import FileError
from vbbench_leaderboards.checks.checking import ResultsError, check
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.result import Past, Result, grown, history_faults, read_result, write_result
from vbbench_leaderboards.results.sealed_json import digest

ERRORS = np.random.default_rng(5).gamma(4.0, 0.1, 20).astype("f4").astype(float)


def past(**facts: object) -> Past:
    return replace(result("a", ERRORS).present, **facts)  # type: ignore[arg-type]


def the_record(row: Result) -> BoardDataset:
    return record_of(row, camera=camera_to_dict(PanoramaCamera()))


def written(folder: Path, row: Result) -> Result:
    return read_result(write_result(row, folder, the_record(row)))


def test_figures_that_are_replaced_become_history(tmp_path: Path) -> None:
    first = result("a", ERRORS, version="1.0", date="2026-01-02")
    assert written(tmp_path, first).history == ()
    better = written(tmp_path, result("a", ERRORS / 2, version="2.0", date="2026-02-03"))
    assert better.history == (Past.read(first.present.values()),)
    assert better.history[0].has_figures_of(first.present)
    best = written(tmp_path, result("a", ERRORS / 3, version="3.0", date="2026-03-04", score={"solver_version": "3.0"}))
    assert [entry.version for entry in best.history] == ["1.0", "2.0"]
    assert best.history[1].capped["dx"][0] == pytest.approx(np.mean(ERRORS / 2), rel=1e-6)
    assert "1 result on 1 board checked, no faults" in check(tmp_path)


def test_figures_that_are_kept_are_short_and_in_order() -> None:
    entry = past(capped={"dx": (1.0 / 3.0, 1.0 / 3.0 - 1e-12, 2.0 / 3.0), "dt": (None, None, None)})
    kept = Past.read(json.loads(json.dumps(entry.values())))
    assert kept.capped == {"dx": (0.33333333, 0.33333333, 0.66666667), "dt": (None, None, None)}
    assert kept.has_figures_of(entry)
    assert not list(history_faults((kept,), kept.date))


def test_the_same_figures_add_nothing(tmp_path: Path) -> None:
    row = result("a", ERRORS)
    written(tmp_path, row)
    assert written(tmp_path, replace(row, about=replace(row.about, rerun_by="B. Else"))).history == ()


def test_another_dataset_is_said(tmp_path: Path) -> None:
    entries = grown((), past(), past(dataset="f" * 16))
    assert [entry.dataset for entry in entries] == ["0123456789abcdef"]


def test_a_file_of_an_older_protocol_leaves_its_figures(tmp_path: Path) -> None:
    path = write_result(result("a", ERRORS), tmp_path, the_record(result("a", ERRORS)))
    values = json.loads(path.read_text("utf-8"))
    values["protocol"] = "one-step/1"
    values["digest"] = digest(values)
    path.write_text(json.dumps(values), encoding="utf-8")
    with pytest.raises(FileError, match=r"one-step/1"):
        read_result(path)
    assert [entry.protocol for entry in written(tmp_path, result("a", ERRORS / 2)).history] == ["one-step/1"]


def test_a_damaged_file_leaves_nothing_and_is_replaced(tmp_path: Path) -> None:
    path = write_result(result("a", ERRORS), tmp_path, the_record(result("a", ERRORS)))
    path.write_text("{", encoding="utf-8")
    assert written(tmp_path, result("a", ERRORS / 2)).history == ()


@pytest.mark.parametrize(
    ("facts", "fault"),
    [
        ({"date": "2026-13-01"}, r"\$\.history\[0\]\.date: 2026-13-01 is not a day"),
        ({"date": "2027-01-01"}, r"\$\.history\[0\]\.date: 2027-01-01 is after 2026-11-22"),
        ({"capped": {"dx": (0.5, 0.6, 0.7)}}, r"\$\.history\[0\]\.capped\.dx: the mean does not lie"),
        ({"capped": {"luck": (0.5, 0.4, 0.7)}}, r"\$\.history\[0\]\.capped\.luck: is no metric"),
    ],
)
def test_faults_are_named(facts: dict[str, object], fault: str) -> None:
    (found,) = history_faults([past(**facts)], "2026-11-22")
    assert re.match(fault, found)


def test_check_finds_a_history_out_of_order(tmp_path: Path) -> None:
    row = replace(result("a", ERRORS), history=(past(date="2027-01-01"),))
    written(tmp_path, row)
    with pytest.raises(ResultsError, match=r"2027-01-01 is after 2026-11-22"):
        check(tmp_path)


def test_strangers_keys_are_refused(tmp_path: Path) -> None:
    row = replace(result("a", ERRORS), history=(past(version="x\ny"),))
    with pytest.raises(FileError, match=r"\$\.history"):
        write_result(row, tmp_path, the_record(row))
