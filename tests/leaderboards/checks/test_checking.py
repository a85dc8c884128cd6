"""`leaderboard check` finds whatever is changed in a result file, with and without a digest made to fit."""

import base64
import contextlib
import json
import re
import shutil
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.lib.tiny_board import FILE, seal, tiny_board
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench_leaderboards.checks.checking import ResultsError, check
from vbbench_leaderboards.results.dataset_record import read_dataset
from vbbench_leaderboards.results.result import read_result
from vbbench_leaderboards.results.sealed_json import decode, encode
from vbbench_leaderboards.site.pages import build

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

Change = Callable[[dict[str, Any]], object]
RECORD = Path("tiny", "ideal.json")


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("check")
    tiny_board(folder)
    return folder


@pytest.fixture
def results(room: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(room / "results", tmp_path / "results"))


def forge(path: Path, change: Change) -> None:
    """Change a file's values and make the digest fit."""
    values = json.loads(path.read_text("utf-8"))
    change(values)
    seal(path, values)


def faults(results: Path, **options: Any) -> tuple[str, ...]:
    with pytest.raises(ResultsError) as caught:
        check(results, **options)
    return caught.value.faults


def numbers(part: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], float]]:
    """Every number of a JSON tree with its place."""
    if isinstance(part, bool) or part is None or isinstance(part, str):
        return
    if isinstance(part, (int, float)):
        yield path, part
        return
    for key, value in part.items() if isinstance(part, dict) else enumerate(part):
        yield from numbers(value, (*path, key))


def put(values: Any, path: tuple[Any, ...], value: Any) -> None:
    for key in path[:-1]:
        values = values[key]
    values[path[-1]] = value


def recoded(change: Callable[[dict[str, Any]], object], place: tuple[str, ...] = ("per_sequence",)) -> Change:
    """A change of the columns in a block."""

    def apply(values: dict[str, Any]) -> None:
        block = values
        for key in place:
            block = block[key]
        columns = decode(block)
        change(columns)
        block.update(encode(columns))

    return apply


def column(name: str, value: float, row: int | slice = 0) -> Change:
    return recoded(lambda columns: put(columns, (name, row), value))


def drop_first(columns: dict[str, Any]) -> None:
    columns.update({name: values[1:] for name, values in columns.items()})


def repeat_first(columns: dict[str, Any]) -> None:
    columns.update({name: np.insert(values, 0, values[0]) for name, values in columns.items()})


def test_all_is_well(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["leaderboard", "check", "--results", str(room / "results"), "--work", str(room / "work")]) == 0
    out, err = capsys.readouterr()
    assert out == f"{room / 'results'}: 2 results on 1 board checked, no faults; 2 scored again\n"
    assert err == ""


@pytest.mark.slow
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
@pytest.mark.parametrize("name", ["tiny/sequential-ideal/vb-cv.json", "tiny/ideal.json"])
def test_any_one_number_changed_is_caught(room: Path, tmp_path: Path, name: str, data: st.DataObject) -> None:
    results = tmp_path / "any"
    shutil.rmtree(results, ignore_errors=True)
    shutil.copytree(room / "results", results)
    values = json.loads((results / name).read_text("utf-8"))
    path, old = data.draw(st.sampled_from(sorted(numbers(values), key=str)))
    other = st.floats(allow_nan=False, allow_infinity=False) if isinstance(old, float) else st.integers()
    put(values, path, data.draw(other.filter(lambda value: value != old)))
    (results / name).write_text(json.dumps(values), encoding="utf-8")
    assert any(name in fault for fault in faults(results))


def test_any_one_number_of_the_score_is_caught_though_the_digest_fits(room: Path, tmp_path: Path) -> None:
    kept = json.loads((room / "results" / FILE).read_text("utf-8"))
    unseen = []
    for path, old in numbers(kept["score"]):
        if path in NOT_FROM_SEQUENCES:
            continue
        results = tmp_path / "_".join(map(str, path))
        shutil.copytree(room / "results", results)
        more = 0.5 if old == 0 else old * 1.0001 if isinstance(old, float) and old < 1 else old - 1 if old > 1 else 2
        forge(results / FILE, lambda values, path=path, more=more: put(values["score"], path, more))
        with contextlib.suppress(ResultsError):
            check(results)
            unseen.append(path)
    assert not unseen


def test_those_that_do_not_follow_are_caught_by_scoring_again(room: Path, results: Path) -> None:
    forge(results / FILE, lambda values: put(values, ("score", "metrics", "dx", "frame_mean"), 0.001))
    assert check(results)
    (fault,) = faults(results, work=room / "work")
    assert "scores differently now: score.metrics.dx.frame_mean: was 0.001, is" in fault
    submission, dataset = room / "work/submissions" / FILE.with_suffix(""), room / "work/datasets/tiny-ideal"
    assert len(faults(results, submissions=[submission], datasets=[dataset])) == 1


def test_better_figures_of_a_sequence_are_caught(room: Path, results: Path) -> None:
    forge(results / FILE, recoded(lambda columns: put(columns, ("dx", 0), 0.5 * columns["dx"][0])))
    found = faults(results)
    assert any("$.score.metrics.dx.mean: is" in fault for fault in found)
    assert all(str(FILE) in fault for fault in found)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (recoded(drop_first), r"\$.per_sequence: lacks sequence \d+; solve and score the whole dataset"),
        (recoded(lambda c: put(c, ("sequence", 1), c["sequence"][0])), r"lacks sequence \d+"),
        (recoded(repeat_first), r"\$.per_sequence: sequences are not in order, each once"),
        (column("sequence", 999), r"has, and the board does not, sequence 999"),
        (column("frames", 900), r"frames differs from the board's in sequence \d+"),
        (column("scene", 900), r"scene differs from the board's in sequence \d+"),
        (column("last_frame", 900), r"last_frame differs from the board's in sequence \d+"),
        (column("positions", 900), r"positions differs from the board's in sequence \d+"),
        (column("posed", 1), r"posed does not go with the failure policy in sequence \d+"),
        (column("placed", 1), r"placed does not go with the failure policy in sequence \d+"),
        (column("dx", np.nan), r"dx has impossible values in sequence \d+"),
        (column("dr", 4.0), r"dr has impossible values in sequence \d+"),
        (column("drift_rad", 4.0), r"drift_rad has impossible values in sequence \d+"),
        (lambda v: put(v, ("dataset", "id"), "0" * 16), r"\$.dataset.id: is 0{16}, everything on this board"),
        (lambda v: put(v, ("dataset", "seed"), 3), r"\$.dataset.seed: is 3, must be 0"),
        (lambda v: put(v, ("dataset", "tier"), "noisy"), "belongs in tiny/sequential-noisy/cv.json"),
        (lambda v: put(v, ("dataset", "camera"), "perspective"), r"\$.dataset.camera"),
        (lambda v: put(v, ("protocol",), "rollout/2"), "belongs in tiny/rollout-ideal/cv.json"),
        (lambda v: put(v, ("score", "protocol"), "rollout"), r"\$.score.protocol: is 'rollout'"),
        (lambda v: put(v, ("score", "dataset"), "0" * 16), r"\$.score.dataset"),
        (lambda v: put(v, ("score", "caution"), "none"), r"\$.score.caution"),
        (lambda v: put(v, ("score", "fallback_frames"), 9999), "more than the"),
        (lambda v: put(v, ("score", "metrics", "dt", "frame_std"), 0.0), r"dt.frame_std: is 0.0, the per-sequence"),
        (lambda v: put(v, ("score", "drift", "drift_m", "frame_mean"), None), "contradicts"),
        (lambda v: put(v, ("score", "metrics", "dx", "mean"), None), r"dx.mean: is None"),
    ],
)
def test_a_forged_result_is_caught_and_the_reason_said(results: Path, change: Change, message: str) -> None:
    forge(results / FILE, change)
    found = faults(results)
    assert any(re.search(message, fault) for fault in found), found


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda v: put(v, ("id",), "0" * 16), "counts.id"),
        (lambda v: put(v, ("split",), "big"), "belongs in big/ideal.json"),
        (lambda v: put(v, ("counts", "sequences"), 3), "is not a list of the dataset's scored sequences"),
        (lambda v: put(v, ("caution",), "do not"), r"score.caution"),
        (lambda v: put(v, ("command",), "rm -rf"), r"\$.command"),
    ],
)
def test_a_forged_record_is_caught(results: Path, change: Change, message: str) -> None:
    forge(results / RECORD, change)
    assert any(message.replace("\\", "") in fault for fault in faults(results))


def test_a_record_is_held_against_the_dataset_at_hand(room: Path, results: Path) -> None:
    forge(results / RECORD, lambda values: put(values, ("counts", "people_max"), 7))
    forge(results / RECORD, lambda values: put(values, ("title",), "Tinier"))
    assert check(results)
    assert len(faults(results, work=room / "work")) == 2


def test_swapped_truncated_and_stray_files_are_all_listed_at_once(
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
    for words in ("cv.json: holds the result that belongs in", "vb-cv.json: holds", "noisy.json: cannot be read"):
        assert words in err
    assert "stray.json: is neither" in err
    assert "only in capitals" in err
    assert "Traceback" not in err


def test_a_damaged_record_is_one_fault_whatever_stands_on_its_boards(results: Path) -> None:
    (results / RECORD).write_text("{")
    assert len(faults(results)) == 1
    (results / RECORD).unlink()
    assert ["has no dataset record tiny/ideal.json" in fault for fault in faults(results)] == [True, True]


def test_every_fault_stands_on_a_line_of_its_own_however_many_there_are() -> None:
    error = ResultsError(Path("results"), (f"fault {n} {'x' * 200}" for n in range(60)))
    lines = str(error).split("\n")
    assert lines[0] == "results: 60 faults"
    assert [line.split()[2] for line in lines[1:]] == [str(n) for n in range(60)]


def test_an_empty_folder_is_no_leaderboard(tmp_path: Path) -> None:
    assert "no result is here" in faults(tmp_path)[0]


def test_named_submissions_that_belong_to_nothing_are_said(room: Path, results: Path, tmp_path: Path) -> None:
    submission = room / "work/submissions" / FILE.with_suffix("")
    assert "its dataset" in faults(results, submissions=[submission])[0]
    shutil.copytree(submission, tmp_path / "other")
    (tmp_path / "other" / "poses.parquet").write_bytes(b"")
    assert "no result has its tables" in faults(results, submissions=[tmp_path / "other"])[0]


def test_a_damaged_work_folder_stops_no_check(room: Path, results: Path, tmp_path: Path) -> None:
    work = Path(shutil.copytree(room / "work", tmp_path / "work"))
    (work / "submissions" / FILE.with_suffix("") / "submission.json").write_text("{")
    assert check(results, work=work).endswith("; 1 scored again")
    (work / "datasets/tiny-ideal/dataset.json").write_text("{")
    assert check(results, work=work).endswith("; 0 scored again")


def test_data_after_the_end_of_a_block_is_caught(results: Path) -> None:
    values = json.loads((results / FILE).read_text("utf-8"))
    raw = zlib.decompress(base64.b64decode(values["per_sequence"]["data"]))
    values["per_sequence"]["data"] = base64.b64encode(zlib.compress(raw) + b"more").decode()
    (results / FILE).write_text(json.dumps(values))
    assert "does not hold" in faults(results)[0]


def spoil_figures(results: Path, value: float) -> None:
    """Half the sequences at ``value``, the digest made to fit."""
    forge(results / FILE, column("dx", value, slice(None, None, 2)))


@pytest.mark.parametrize("value", [np.inf, 3e38, 1.1e7])
def test_a_bad_result_is_left_out_of_the_site_and_named(
    results: Path, tmp_path: Path, value: float, capsys: pytest.CaptureFixture[str]
) -> None:
    with np.errstate(over="ignore"):
        spoil_figures(results, value)
    site = tmp_path / "site"
    with pytest.warns(
        VbbenchWarning, match=r"OMITTED from the site: .*cv\.json: \$\.per_sequence: dx of sequence \d+ is"
    ):
        built = build(site, results)
    ((_, rows),) = built.results.items()
    assert [row.solver for row in rows] == ["vb-cv"]
    with pytest.raises(ResultsError) as caught:
        check(results)
    (fault,) = caught.value.faults
    assert fault.startswith(str(results / FILE))


@pytest.mark.filterwarnings("default::vbbench.errors.VbbenchWarning")
def test_the_command_says_it_on_one_line_and_succeeds(results: Path, tmp_path: Path, capsys) -> None:
    spoil_figures(results, 1e30)
    (results / FILE).with_name("deep.json").write_text("[" * 100_000)
    assert main(["leaderboard", "build", "--results", str(results), "--out", str(tmp_path / "site")]) == 0
    said = capsys.readouterr()
    assert said.err.count("OMITTED from the site") == 2
    assert said.err.count("\n") == 2
    assert (tmp_path / "site" / "index.html").is_file()


def test_nothing_usable_is_no_site(results: Path, tmp_path: Path) -> None:
    (results / RECORD).write_text("{")
    with pytest.warns(VbbenchWarning), pytest.raises(VbbenchError, match="that can be used"):
        build(tmp_path / "site", results)
    assert not (tmp_path / "site").exists()


@pytest.mark.parametrize("value", [10**30, 10**4000, -1, 1e308, True], ids="abcde")
@pytest.mark.parametrize("path", [("counts", "sequences"), ("counts", "people_max"), ("camera", "width"), ("dt",)])
def test_a_number_of_a_record_that_cannot_be(results: Path, path: tuple[str, ...], value: Any) -> None:
    forge(results / RECORD, lambda values: put(values, path, value))
    if not (path == ("camera", "width") and value is True):
        with pytest.raises(FileError, match=path[-1] if path[0] != "camera" else "camera") as caught:
            read_dataset(results / RECORD)
        assert len(caught.value.problem) < 700
    with pytest.raises(ResultsError) as found:
        check(results)
    assert all("\n" not in fault and len(fault) < 1000 for fault in found.value.faults)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0, 0.5, 3e38])
def test_what_a_record_says_is_scored_is_whole_numbers(results: Path, value: float) -> None:
    forge(results / RECORD, recoded(lambda columns: put(columns, ("frames", 0), value), ("scored", "rollout")))
    with pytest.raises(ResultsError, match=r"\$\.scored\.rollout: frames must be whole numbers"):
        check(results)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[" * 100_000, "nested more than 64"),
        ('{"a": ' + "[" * 100 + "]" * 100 + "}", "nested more than 64"),
        ('{"seed": 1e999}', "1e999 is too large a number"),
        ('{"seed": 1' + 5000 * "0" + "}", "cannot be read"),
        ('{"seed": "\\ud800"}', "unknown field `seed`"),
    ],
)
def test_json_made_to_harm_is_the_fault_of_its_file(results: Path, text: str, message: str) -> None:
    (results / FILE).write_text(text)
    with pytest.raises(FileError, match=message):
        read_result(results / FILE)
    with pytest.raises(ResultsError) as caught:
        check(results)
    assert len(caught.value.faults) == 1
