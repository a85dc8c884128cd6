"""`leaderboard check` finds whatever is changed in a result file, with and without a digest made to fit."""

import contextlib
import json
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib.tiny_board import FILE, seal, tiny_board
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.scoring.metrics import METRICS
from vbbench_leaderboards.checks.checking import ResultsError, check
from vbbench_leaderboards.results.dataset_record import read_dataset
from vbbench_leaderboards.results.sealed_json import decode, encode
from vbbench_leaderboards.site.building import build

NOT_FROM_SEQUENCES = {
    ("seconds_per_frame",),
    ("fallback_frames",),
    *(("metrics", name, "frame_mean") for name in ("dx", "dx_rel")),
    *(("drift", name, "frame_mean") for name in ("drift_m", "drift_rad")),
    *((METRICS[name].section, name, "frame_std") for name in METRICS),
}
"""Numbers of a score that do not follow from the per-sequence figures; only the digest watches over them."""

Change = Callable[[dict[str, Any]], object]


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


def faults(results: Path) -> tuple[str, ...]:
    with pytest.raises(ResultsError) as caught:
        check(results)
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


def test_all_is_well(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["leaderboard", "check", "--results", str(room / "results")]) == 0
    out, err = capsys.readouterr()
    assert out == f"{room / 'results'}: 2 results on 1 board checked, no faults\n"
    assert err == ""


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


def test_better_figures_of_a_sequence_are_caught(room: Path, results: Path) -> None:
    def better(values: dict[str, Any]) -> None:
        columns = decode(values["per_sequence"])
        columns["dx"][0] *= 0.5
        values["per_sequence"] = encode(columns)

    forge(results / FILE, better)
    found = faults(results)
    assert any("$.score.metrics.dx.mean: is" in fault for fault in found)
    assert all(str(FILE) in fault for fault in found)


def drop_first(values: dict[str, Any]) -> None:
    values["per_sequence"] = encode({name: column[1:] for name, column in decode(values["per_sequence"]).items()})


def twice(values: dict[str, Any]) -> None:
    columns = decode(values["per_sequence"])
    columns["sequence"][1] = columns["sequence"][0]
    values["per_sequence"] = encode(columns)


def column(name: str, value: float) -> Change:
    def put_there(values: dict[str, Any]) -> None:
        columns = decode(values["per_sequence"])
        columns[name][0] = value
        values["per_sequence"] = encode(columns)

    return put_there


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (drop_first, r"has not the board's sequences, each once and in order: sequence \d+; solve all of them"),
        (twice, r"has not the board's sequences"),
        (column("sequence", 999), r"sequences \d+, 999; solve all of them"),
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
    forge(results / "tiny/ideal.json", change)
    assert any(message.replace("\\", "") in fault for fault in faults(results))


def test_swapped_truncated_and_stray_files_are_all_listed_at_once(
    results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one, other = results / FILE, (results / FILE).with_name("vb-cv.json")
    swapped = one.read_bytes(), other.read_bytes()
    other.write_bytes(swapped[0])
    one.write_bytes(swapped[1])
    (results / "tiny" / "noisy.json").write_text(swapped[0].decode()[:300])
    (results / "stray.json").write_text("{}")
    assert main(["leaderboard", "check", "--results", str(results)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    for words in (
        "cv.json: holds the result that belongs in",
        "vb-cv.json: holds",
        "noisy.json: cannot be read",
        "stray.json: is neither",
    ):
        assert words in err
    assert "Traceback" not in err


def test_a_damaged_record_is_one_fault_whatever_stands_on_its_boards(results: Path) -> None:
    (results / "tiny/ideal.json").write_text("{")
    assert len(faults(results)) == 1
    (results / "tiny/ideal.json").unlink()
    assert ["has no dataset record tiny/ideal.json" in fault for fault in faults(results)] == [True, True]


def test_an_empty_folder_is_no_leaderboard(tmp_path: Path) -> None:
    assert "no result is here" in faults(tmp_path)[0]


RECORD = Path("tiny", "ideal.json")


def spoil_figures(results: Path, value: float) -> None:
    """Half the sequences at ``value``, the digest made to fit."""
    values = json.loads((results / FILE).read_text("utf-8"))
    columns = decode(values["per_sequence"])
    columns["dx"][::2] = value
    values["per_sequence"] = encode(columns)
    seal(results / FILE, values)


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


def test_nothing_usable_is_no_site(results: Path, tmp_path: Path) -> None:
    (results / RECORD).write_text("{")
    with pytest.warns(VbbenchWarning), pytest.raises(VbbenchError, match="that can be used"):
        build(tmp_path / "site", results)
    assert not (tmp_path / "site").exists()


@pytest.mark.parametrize("value", [10**30, 10**4000, -1, 1e308, True], ids="abcde")
@pytest.mark.parametrize("path", [("counts", "sequences"), ("counts", "people_max"), ("camera", "width"), ("dt",)])
def test_a_number_of_a_record_that_cannot_be(results: Path, path: tuple[str, ...], value: Any) -> None:
    values = json.loads((results / RECORD).read_text("utf-8"))
    put(values, path, value)
    seal(results / RECORD, values)
    if not (path == ("camera", "width") and value is True):
        with pytest.raises(FileError, match=path[-1] if path[0] != "camera" else "camera") as caught:
            read_dataset(results / RECORD)
        assert len(caught.value.problem) < 700
    with pytest.raises(ResultsError) as found:
        check(results)
    assert all("\n" not in fault and len(fault) < 1000 for fault in found.value.faults)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0, 0.5, 3e38])
def test_what_a_record_says_is_scored_is_whole_numbers(results: Path, value: float) -> None:
    values = json.loads((results / RECORD).read_text("utf-8"))
    columns = decode(values["scored"]["rollout"])
    columns["frames"][0] = value
    values["scored"]["rollout"] = encode(columns)
    seal(results / RECORD, values)
    with pytest.raises(ResultsError, match=r"\$\.scored\.rollout: frames must be whole numbers"):
        check(results)
