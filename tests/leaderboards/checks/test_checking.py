"""`leaderboard check` finds whatever is changed in a result file, with and without a digest made to fit."""

import contextlib
import json
import re
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.lib.tiny_board import FILE, RECORD, Change, at, forge, recoded
from vbbench.cli import main
from vbbench.errors import FileError
from vbbench_leaderboards.checks import ResultsError, check
from vbbench_leaderboards.results.dataset_record import read_dataset

NOT_FROM_SEQUENCES = {
    ("seconds_per_frame",),
    ("fallback_frames",),
    *(
        (part, name, key)
        for part, name in (("metrics", "dx"), ("metrics", "dx_rel"), ("drift", "drift_m"), ("drift", "drift_rad"))
        for key in ("frame_mean", "frame_std")
    ),
    *(("metrics", name, "frame_std") for name in ("dr", "dt")),
}
"""Numbers of a score that do not follow from the per-sequence figures: the digest and scoring again watch over them."""


def faults(results: Path, **options: Any) -> tuple[str, ...]:
    with pytest.raises(ResultsError) as caught:
        check(results, **options)
    return caught.value.faults


def numbers(part: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], float]]:
    """Every number of a JSON tree with its place."""
    if isinstance(part, (dict, list)):
        for key, value in part.items() if isinstance(part, dict) else enumerate(part):
            yield from numbers(value, (*path, key))
    elif isinstance(part, (int, float)) and not isinstance(part, bool):
        yield path, part


def cell(name: str, value: float, place: Sequence[str] = ("per_sequence",)) -> Change:
    """A change of a column's first number."""
    return recoded(lambda columns: columns[name].__setitem__(0, value), place)


def row(change: Any) -> Change:
    """A change of every column."""
    return recoded(lambda columns: columns.update({name: change(values) for name, values in columns.items()}))


def test_all_is_well(tiny_room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    results = tiny_room / "results"
    assert main(["leaderboard", "check", "--results", str(results), "--work", str(tiny_room / "work")]) == 0
    said = f"{results}: 2 results on 1 board checked, no faults; 2 scored again\n"
    assert capsys.readouterr() == (said, "")


@pytest.mark.slow
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
@pytest.mark.parametrize("name", ["tiny/sequential-ideal/vb-cv.json", "tiny/ideal.json"])
def test_any_one_number_changed_is_caught(tiny_room: Path, tmp_path: Path, name: str, data: st.DataObject) -> None:
    results = tmp_path / "any"
    shutil.rmtree(results, ignore_errors=True)
    shutil.copytree(tiny_room / "results", results)
    values = json.loads((results / name).read_text("utf-8"))
    path, old = data.draw(st.sampled_from(sorted(numbers(values), key=str)))
    other = st.floats(allow_nan=False, allow_infinity=False) if isinstance(old, float) else st.integers()
    at(path, data.draw(other.filter(lambda value: value != old)))(values)
    (results / name).write_text(json.dumps(values), encoding="utf-8")
    assert any(name in fault for fault in faults(results))


def test_any_one_number_of_the_score_is_caught_though_the_digest_fits(results: Path) -> None:
    kept, unseen = (results / FILE).read_bytes(), []
    for path, old in numbers(json.loads(kept)["score"]):
        if path in NOT_FROM_SEQUENCES:
            continue
        more = 0.5 if old == 0 else old * 1.0001 if isinstance(old, float) and old < 1 else old - 1 if old > 1 else 2
        (results / FILE).write_bytes(kept)
        forge(results / FILE, at(("score", *path), more))
        with contextlib.suppress(ResultsError):
            check(results)
            unseen.append(path)
    assert not unseen


def test_those_that_do_not_follow_are_caught_by_scoring_again(tiny_room: Path, results: Path) -> None:
    forge(results / FILE, at("score.metrics.dx.frame_mean", 0.001))
    assert check(results)
    (fault,) = faults(results, work=tiny_room / "work")
    assert "scores differently now: score.metrics.dx.frame_mean: was 0.001, is" in fault
    submission, dataset = tiny_room / "work/submissions" / FILE.with_suffix(""), tiny_room / "work/datasets/tiny-ideal"
    assert len(faults(results, submissions=[submission], datasets=[dataset])) == 1


FIRST = slice(1, None)
NOT_WHOLE = (np.nan, np.inf, -1.0, 0.5, 3e38)
PAST = {"date": "2999-01-01", "version": "1", "vbbench": "1", "dataset": "0" * 16, "protocol": "sequential/1"}


@pytest.mark.parametrize(
    ("file", "change", "message"),
    [
        (FILE, row(lambda c: c[1:]), r"\$.per_sequence: lacks sequence \d+; solve and score the whole dataset"),
        (FILE, recoded(lambda c: c["sequence"].__setitem__(1, c["sequence"][0])), r"lacks sequence \d+"),
        (FILE, row(lambda c: np.insert(c, 0, c[0])), r"\$.per_sequence: sequences are not in order, each once"),
        (FILE, cell("sequence", 999), r"has, and the board does not, sequence 999"),
        (FILE, cell("frames", 900), r"frames differs from the board's in sequence \d+"),
        (FILE, cell("scene", 900), r"scene differs from the board's in sequence \d+"),
        (FILE, cell("last_frame", 900), r"last_frame differs from the board's in sequence \d+"),
        (FILE, cell("positions", 900), r"positions differs from the board's in sequence \d+"),
        (FILE, cell("posed", 1), r"posed does not go with the failure policy in sequence \d+"),
        (FILE, cell("placed", 1), r"placed does not go with the failure policy in sequence \d+"),
        (FILE, cell("dx", np.nan), r"dx has impossible values in sequence \d+"),
        (FILE, cell("dr", 4.0), r"dr has impossible values in sequence \d+"),
        (FILE, cell("drift_rad", 4.0), r"drift_rad has impossible values in sequence \d+"),
        (FILE, cell("dx", -1.0), r"dx of sequence \d+ is below 0 or above"),
        (FILE, cell("frames", -1.0), r"\$\.per_sequence: frames must be whole numbers"),
        (FILE, cell("frames", np.inf), r"\$\.per_sequence: frames must be whole numbers"),
        (FILE, recoded(lambda c: c["dx"].__imul__(0.5)), r"\$.score.metrics.dx.mean: is"),
        (FILE, at("dataset.id", "0" * 16), r"\$.dataset.id: is 0{16}, everything on this board"),
        (FILE, at("dataset.seed", 3), r"\$.dataset.seed: is 3, must be 0"),
        (FILE, at("dataset.tier", "noisy"), "belongs in tiny/sequential-noisy/cv.json"),
        (FILE, at("dataset.camera", "perspective"), r"\$.dataset.camera"),
        (FILE, at("protocol", "rollout/2"), "belongs in tiny/rollout-ideal/cv.json"),
        (FILE, at("score.protocol", "rollout"), r"\$.score.protocol: is 'rollout'"),
        (FILE, at("score.dataset", "0" * 16), r"\$.score.dataset"),
        (FILE, at("score.caution", "none"), r"\$.score.caution"),
        (FILE, at("score.fallback_frames", 9999), "more than the"),
        (FILE, at("score.metrics.dt.frame_std", 0.0), r"dt.frame_std: is 0.0, the per-sequence"),
        (FILE, at("score.drift.drift_m.frame_mean", None), "contradicts"),
        (FILE, at("score.metrics.dx.mean", None), r"dx.mean: is None"),
        (FILE, at("score.metrics.dx.ci95", [0.1, 0.2]), r"dx.ci95\[0\]: is 0.1, must be None"),
        (FILE, recoded(lambda c: c.update(luck=c["dx"])), "Expected the columns sequence, scene, .*per_sequence"),
        (
            FILE,
            at("history", [{**PAST, "capped": {"dx": [0.5, 0.4, 0.6]}}]),
            r"\$.history\[0\].date: 2999-01-01 is after",
        ),
        (RECORD, at("id", "0" * 16), "counts.id"),
        (RECORD, at("split", "big"), "belongs in big/ideal.json"),
        (RECORD, at("counts.sequences", 3), "is not a list of the dataset's scored sequences"),
        (RECORD, at("caution", "do not"), "score.caution"),
        (RECORD, at("command", "rm -rf"), r"\$.command"),
        (RECORD, lambda values: values["scored"].pop("sequential"), "is older than sequential; remove it and add"),
        *(
            (RECORD, cell("frames", value, ("scored", "rollout")), r"\$\.scored\.rollout: frames must be")
            for value in NOT_WHOLE
        ),
    ],
)
def test_a_forged_file_is_caught_and_the_reason_said(results: Path, file: Path, change: Change, message: str) -> None:
    forge(results / file, change)
    found = faults(results)
    assert any(str(results / file.parent) in fault and re.search(message, fault) for fault in found), found


def test_a_record_is_held_against_the_dataset_at_hand(tiny_room: Path, results: Path) -> None:
    forge(results / RECORD, at("counts.people_max", 7))
    forge(results / RECORD, at("title", "Tinier"))
    forge(results / RECORD, recoded(lambda columns: columns["frames"].__iadd__(1), ("scored", "rollout")))
    assert check(results)
    found = faults(results, work=tiny_room / "work")
    assert [re.sub(r".*\.json: ([^:]*):.*", r"\1", fault) for fault in found] == [
        "$.title",
        "$.counts",
        "$.scored.rollout",
    ]


def test_swapped_truncated_and_stray_files_are_listed_at_once_a_line_each(
    results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one, other = results / FILE, (results / FILE).with_name("vb-cv.json")
    swapped = one.read_bytes(), other.read_bytes()
    other.write_bytes(swapped[0])
    one.write_bytes(swapped[1])
    shutil.copy(one, one.with_name("CV.json"))
    (results / "tiny" / "noisy.json").write_text(swapped[0].decode()[:300])
    (results / "stray.json").write_text("{}")
    assert main(["leaderboard", "check", "--results", str(results)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    head, *lines = err.splitlines()
    assert head == f"vbbench: {results}: {len(lines)} faults"
    assert [int(line.split(".")[0]) for line in lines] == list(range(1, len(lines) + 1))
    for words in (
        "/cv.json: holds the result that belongs in",
        "/vb-cv.json: holds",
        "/noisy.json: cannot be read",
        "/stray.json: is neither",
        "only in capitals",
    ):
        assert sum(words in line for line in lines) == 1


def test_a_damaged_record_is_one_fault_whatever_stands_on_its_boards(results: Path, tmp_path: Path) -> None:
    (results / RECORD).write_text("{")
    assert len(faults(results)) == 1
    (results / RECORD).unlink()
    assert ["has no dataset record tiny/ideal.json" in fault for fault in faults(results)] == [True, True]
    (tmp_path / "empty").mkdir()
    assert "no result is here" in faults(tmp_path / "empty")[0]


def test_named_submissions_that_belong_to_nothing_are_said(tiny_room: Path, results: Path, tmp_path: Path) -> None:
    submission = tiny_room / "work/submissions" / FILE.with_suffix("")
    assert "its dataset" in faults(results, submissions=[submission])[0]
    shutil.copytree(submission, tmp_path / "other")
    (tmp_path / "other" / "poses.parquet").write_bytes(b"")
    assert "no result has its tables" in faults(results, submissions=[tmp_path / "other"])[0]


def test_a_damaged_work_folder_stops_no_check(tiny_room: Path, results: Path, tmp_path: Path) -> None:
    work = Path(shutil.copytree(tiny_room / "work", tmp_path / "work"))
    (work / "submissions" / FILE.with_suffix("") / "submission.json").write_text("{")
    assert check(results, work=work).endswith("; 1 scored again")
    (work / "datasets/tiny-ideal/dataset.json").write_text("{")
    assert check(results, work=work).endswith("; 0 scored again")


@pytest.mark.parametrize("value", [10**30, 10**4000, -1, 1e308, True], ids="abcde")
@pytest.mark.parametrize("place", ["counts.sequences", "counts.people_max", "camera.width", "dt"])
def test_a_number_of_a_record_that_cannot_be(results: Path, place: str, value: Any) -> None:
    forge(results / RECORD, at(place, value))
    if not (place == "camera.width" and value is True):
        with pytest.raises(FileError, match="camera" if "camera" in place else place.split(".")[-1]) as caught:
            read_dataset(results / RECORD)
        assert len(caught.value.problem) < 700
    assert all("\n" not in fault and len(fault) < 1000 for fault in faults(results))
