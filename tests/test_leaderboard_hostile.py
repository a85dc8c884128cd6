"""Result files and records made to harm: a fault of their file alone; the others are checked, and the site is built."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.tiny_board import FILE, seal, tiny_board
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench_leaderboards.checks.checking import ResultsError, check
from vbbench_leaderboards.results.dataset_record import read_dataset
from vbbench_leaderboards.results.result import read_result
from vbbench_leaderboards.results.sealed_json import decode, encode
from vbbench_leaderboards.site.building import build

RECORD = Path("tiny", "ideal.json")


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tiny_board(tmp_path_factory.mktemp("board"))


@pytest.fixture
def results(board: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(board, tmp_path / "results"))


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
        VbbenchWarning, match=r"LEFT OUT of the site: .*cv\.json: \$\.per_sequence: dx of sequence \d+ is"
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
    assert said.err.count("LEFT OUT of the site") == 2
    assert said.err.count("\n") == 2
    assert (tmp_path / "site" / "index.html").is_file()


def test_nothing_usable_is_no_site(results: Path, tmp_path: Path) -> None:
    (results / RECORD).write_text("{")
    with pytest.warns(VbbenchWarning), pytest.raises(VbbenchError, match="that can be used"):
        build(tmp_path / "site", results)
    assert not (tmp_path / "site").exists()


def put(*path: str, value: Any) -> Any:
    def change(values: dict[str, Any]) -> None:
        for key in path[:-1]:
            values = values[key]
        values[path[-1]] = value

    return change


@pytest.mark.parametrize("value", [10**30, 10**4000, -1, 1e308, True], ids="abcde")
@pytest.mark.parametrize("path", [("counts", "sequences"), ("counts", "people_max"), ("camera", "width"), ("dt",)])
def test_a_number_of_a_record_that_cannot_be(results: Path, path: tuple[str, ...], value: Any) -> None:
    values = json.loads((results / RECORD).read_text("utf-8"))
    put(*path, value=value)(values)
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
