"""Result files: what is written is read again, and nothing else is."""

import base64
import itertools
import json
import re
import shutil
import zlib
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib.board_results import record_of, result
from tests.lib.tiny_board import FILE, RECORD, at, forge
from vbbench.camera import PanoramaCamera, camera_to_dict
from vbbench.errors import FileError
from vbbench_leaderboards.checks import ResultsError, check
from vbbench_leaderboards.results.dataset_record import read_dataset, write_dataset
from vbbench_leaderboards.results.folder import read_datasets, read_results
from vbbench_leaderboards.results.result import Board, Past, Result, grown, history_faults, read_result, write_result
from vbbench_leaderboards.results.sealed_json import decode


def assert_equal(one: Any, other: Any) -> None:
    for field in fields(one):
        mine, theirs = getattr(one, field.name), getattr(other, field.name)
        if field.name in ("per_sequence", "scored"):
            np.testing.assert_equal(vars(mine) if field.name == "per_sequence" else dict(mine), vars(theirs))
        else:
            assert mine == theirs


def test_a_result_is_read_as_it_was_written(results: Path, tmp_path: Path) -> None:
    first = read_result(results / FILE)
    assert write_result(first, tmp_path / "again") == tmp_path / "again" / FILE
    assert (tmp_path / "again" / FILE).read_bytes() == (results / FILE).read_bytes()
    assert_equal(first, read_result(tmp_path / "again" / FILE))
    assert first.board == Board(split="tiny", tier="ideal", protocol="sequential")
    assert first.score["protocol_version"] == 2


def test_a_record_is_read_as_it_was_written(results: Path, tmp_path: Path) -> None:
    record = read_dataset(results / RECORD)
    write_dataset(record, tmp_path / "again")
    assert (tmp_path / "again/tiny/ideal.json").read_bytes() == (results / RECORD).read_bytes()
    assert set(record.scored) == {"one-step", "sequential", "rollout", "cold-start"}
    assert set(record.tables) >= {"truth/poses", "truth/scenes", "truth/people"}
    assert (
        record.command == "vbbench generate tiny --camera panorama --tier ideal --sigma-h 0 --seed 0 --out tiny-ideal"
    )


def test_boards_come_sorted_with_their_datasets(results: Path) -> None:
    ((board, rows),) = read_results(results).items()
    assert [row.solver for row in rows] == ["cv", "vb-cv"]
    assert read_datasets(results)[board.split, board.tier].id == rows[0].dataset


def test_of_two_folders_the_first_counts(results: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    shutil.copytree(results, mine)
    (mine / FILE).with_name("vb-cv.json").unlink()
    kept = read_result(mine / FILE)
    write_result(replace(kept, about=replace(kept.about, rerun_by="me")), mine)
    (rows,) = read_results(mine, results).values()
    assert [(row.solver, row.about.rerun_by) for row in rows] == [("cv", "me"), ("vb-cv", "")]


def test_the_block_is_read_in_five_lines(results: Path) -> None:
    block = json.loads((results / FILE).read_text("utf-8"))["per_sequence"]
    raw = zlib.decompress(base64.b64decode(block["data"]))
    numbers = np.frombuffer(raw, np.uint8).reshape(4, -1).T.copy().view("<f4")
    rows = numbers.reshape(len(block["columns"]), block["rows"])
    table = dict(zip(block["columns"], rows, strict=True))
    own = read_result(results / FILE).per_sequence
    np.testing.assert_array_equal(table["dx"], own.figures["dx"])
    np.testing.assert_array_equal(table["sequence"], own.sequence)


def packed_again(text: str, level: int, more: bytes = b"") -> str:
    """A result whose block is packed in another way."""
    values = json.loads(text)
    raw = zlib.decompress(base64.b64decode(values["per_sequence"]["data"]))
    values["per_sequence"]["data"] = base64.b64encode(zlib.compress(raw, level) + more).decode()
    return json.dumps(values)


def test_the_digest_does_not_depend_on_how_zlib_packs(results: Path) -> None:
    kept = read_result(results / FILE)
    (results / FILE).write_text(packed_again((results / FILE).read_text("utf-8"), 0), encoding="utf-8")
    assert_equal(read_result(results / FILE), kept)


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        ("format_version", 1, "is 1, this vbbench reads 2; make it again: 'vbbench leaderboard add'"),
        ("colour", "red", "colour"),
        ("protocol", "sequential/1", "is sequential/1, this vbbench scores sequential/2"),
        ("protocol", "two-step/1", "$.protocol"),
        ("submission", {"poses.parquet": "x"}, "$.submission"),
        ("solver.name", "../cv", "$.solver.name"),
        ("solver.code", "javascript:x", "$.solver.code"),
        ("solver.authors", " ", "$.solver.authors"),
        ("solver.trained_on", "", "$.solver.trained_on"),
        ("solver.date", "2026-13-01", "$.solver.date"),
        ("solver.delay", -1, "$.solver.delay"),
        ("solver.delay", "late", "$.solver.delay"),
        ("solver", {"name": "cv"}, "missing required field `version` - at `$.solver`"),
        ("score", {}, "$.score"),
    ],
)
def test_a_file_of_another_form_is_refused_with_its_place(
    results: Path, place: str, value: object, message: str
) -> None:
    forge(results / FILE, at(place, value))
    with pytest.raises(FileError, match=re.escape(message)) as caught:
        read_result(results / FILE)
    assert str(caught.value).startswith(str(results / FILE))
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda text: text[: len(text) // 2], "cannot be read"),
        (lambda text: "[]", "is not a JSON object"),
        (lambda text: text.replace('"seed": 0', '"seed": NaN'), "NaN is not a JSON number"),
        (lambda text: text.replace('"seed": 0', '"seed": 0, "seed": 0'), "key 'seed' stands twice"),
        (lambda text: text.replace('"seed": 0', '"seed": 1'), "it was changed by hand"),
        (lambda text: text.replace('"data": "', '"data": "AAAA'), "data is damaged"),
        (lambda text: text.replace('"rows": ', '"rows": 9'), "data does not hold"),
        (lambda text: text.replace('"rows": ', '"rows": 99999'), "does not hold"),
        (lambda text: packed_again(text, 9, b"more"), "does not hold"),
        (lambda text: "[" * 100_000, "nested more than 64"),
        (lambda text: '{"a": ' + "[" * 100 + "]" * 100 + "}", "nested more than 64"),
        (lambda text: '{"seed": 1e999}', "1e999 is too large a number"),
        (lambda text: '{"seed": 1' + 5000 * "0" + "}", "cannot be read"),
        (lambda text: '{"seed": "\\ud800"}', "unknown field `seed`"),
    ],
)
def test_a_damaged_file_is_refused_and_is_one_fault(results: Path, spoil: Any, message: str) -> None:
    (results / FILE).write_text(spoil((results / FILE).read_text("utf-8")), encoding="utf-8")
    with pytest.raises(FileError, match=message):
        read_result(results / FILE)
    with pytest.raises(ResultsError) as caught:
        check(results)
    assert len(caught.value.faults) == 1


def test_a_block_that_would_fill_the_memory_is_refused() -> None:
    bomb = base64.b64encode(zlib.compress(bytes(50_000_000), 9)).decode()
    with pytest.raises(ValueError, match="does not hold"):
        decode({"columns": ["a"], "rows": 2, "data": bomb})
    with pytest.raises(ValueError, match="more than any board has"):
        decode({"columns": ["a"] * 100, "rows": 10**6, "data": bomb})


def test_mixtures_are_refused_with_the_reason(results: Path, tmp_path: Path) -> None:
    shutil.copy(results / FILE, results / FILE.with_name("other.json"))
    with pytest.raises(FileError, match=r"belongs in .*cv\.json"):
        read_results(results)
    (results / FILE.with_name("other.json")).unlink()
    other = tmp_path / "other"
    write_dataset(replace(read_dataset(results / RECORD), id="1" * 16), other)
    with pytest.raises(FileError, match="cannot be on one page"):
        read_datasets(results, other)
    (results / RECORD).unlink()
    with pytest.raises(FileError, match="has no dataset record"):
        read_results(results)


ERRORS = np.random.default_rng(5).gamma(4.0, 0.1, 20).astype("f4").astype(float)


def past(**facts: object) -> Past:
    return replace(result("a", ERRORS).present, **facts)  # type: ignore[arg-type]


def written(folder: Path, row: Result) -> Result:
    return read_result(write_result(row, folder, record_of(row, camera=camera_to_dict(PanoramaCamera()))))


def test_figures_that_are_replaced_become_history(tmp_path: Path) -> None:
    first = result("a", ERRORS, version="1.0", date="2026-01-02")
    assert written(tmp_path, first).history == ()
    better = written(tmp_path, result("a", ERRORS / 2, version="2.0", date="2026-02-03"))
    assert better.history == (Past.read(first.present.values()),)
    best = written(tmp_path, result("a", ERRORS / 3, version="3.0", date="2026-03-04", score={"solver_version": "3.0"}))
    assert [entry.version for entry in best.history] == ["1.0", "2.0"]
    assert best.history[1].capped["dx"][0] == pytest.approx(np.mean(ERRORS / 2), rel=1e-6)
    assert "1 result on 1 board checked, no faults" in check(tmp_path)


def test_figures_that_are_kept_are_short_and_in_order() -> None:
    entry = past(capped={"dx": (1.0 / 3.0, 1.0 / 3.0 - 1e-12, 2.0 / 3.0), "dt": (None, None, None)})
    kept = Past.read(json.loads(json.dumps(entry.values())))
    assert kept.capped == {"dx": (0.33333333, 0.33333333, 0.66666667), "dt": (None, None, None)}
    assert not list(history_faults((kept,), kept.date))


def test_history_has_the_last_figures_of_each_release() -> None:
    history: tuple[Past, ...] = ()
    versions = ("0.4.0", "0.5.0.dev1+gabc1234", "0.5.0.dev2+gabc1234.dirty", "0.5.0", "0.6.0.dev1", "0.6.0.dev2")
    for old, new in itertools.pairwise(versions):
        history = grown(history, past(version=old, vbbench=old), past(version=new, vbbench=new))
    assert [entry.version for entry in history] == ["0.4.0", "0.5.0"]
    both = grown(history, past(version="1.0", vbbench="0.5.0"), past(version="1.0", vbbench="0.6.0"))
    assert [entry.vbbench for entry in both] == ["0.4.0", "0.5.0", "0.5.0"]
    back = grown([past(version="1.0"), past(version="2.0")], past(version="1.0"), past(version="3.0"))
    assert [entry.version for entry in back] == ["2.0", "1.0"]


def test_a_file_of_an_older_protocol_leaves_its_figures_and_a_damaged_one_nothing(tmp_path: Path) -> None:
    path = tmp_path / written(tmp_path, result("a", ERRORS)).path
    forge(path, at("protocol", "one-step/1"))
    with pytest.raises(FileError, match=r"one-step/1"):
        read_result(path)
    newer = result("a", ERRORS / 2, version="2.0")
    assert [entry.protocol for entry in written(tmp_path, newer).history] == ["one-step/1"]
    path.write_text("{", encoding="utf-8")
    assert written(tmp_path, newer).history == ()


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


def test_what_is_of_another_form_is_not_written(tmp_path: Path) -> None:
    row = replace(result("a", ERRORS), history=(past(version="x\ny"),))
    with pytest.raises(FileError, match=r"\$\.history"):
        written(tmp_path, row)
    assert not list(tmp_path.iterdir())
