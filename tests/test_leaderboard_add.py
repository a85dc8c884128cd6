"""`leaderboard add`: a submission becomes a result file, or it is said why not."""

import json
import shutil
from datetime import date
from pathlib import Path

import pytest

from tests.make_dataset import Crowd
from tests.tiny_board import FILE, tiny_board, tiny_dataset
from vbbench.cli import main
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo
from vbbench.solving import solve
from vbbench_leaderboards.results.result import read_result


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("add")
    tiny_board(folder)
    return folder


@pytest.fixture
def dataset(room: Path) -> Path:
    return room / "work/datasets/tiny-ideal"


@pytest.fixture
def submission(room: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(room / "work/submissions" / FILE.with_suffix(""), tmp_path / "answers"))


def add(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    status = main(["leaderboard", "add", *map(str, arguments)])
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def test_the_first_result_writes_the_record_too(
    capsys: pytest.CaptureFixture[str], submission: Path, dataset: Path, tmp_path: Path
) -> None:
    results = tmp_path / "results"
    words = ["--name", "mine", "--reference", "A paper", "--code", "https://example.org/mine"]
    status, out, err = add(capsys, submission, "--dataset", dataset, "--results", results, *words)
    assert (status, err) == (0, "")
    assert out == f"{results / FILE.with_name('mine.json')}\n"
    result = read_result(results / FILE.with_name("mine.json"))
    about = result.about
    assert (result.solver, about.reference, about.code) == ("mine", "A paper", "https://example.org/mine")
    assert (about.authors, about.trained_on, about.delay) == ("the authors of vbbench", "nothing", 0)
    assert about.date == f"{date.today()}"
    assert result.score["solver"] == "mine"
    assert set(result.submission) == {"poses.parquet", "positions.parquet"}
    assert sorted(path.name for path in results.rglob("*") if path.is_file()) == ["ideal.json", "mine.json"]
    assert main(["leaderboard", "check", "--results", str(results)]) == 0


def test_a_result_is_replaced_only_when_asked(
    capsys: pytest.CaptureFixture[str], submission: Path, dataset: Path, tmp_path: Path
) -> None:
    arguments = (submission, "--dataset", dataset, "--results", tmp_path / "results")
    assert add(capsys, *arguments)[0] == 0
    status, out, err = add(capsys, *arguments, "--reference", "new")
    assert (status, out) == (2, "")
    assert "cv.json exists; set --overwrite to replace it" in err
    assert add(capsys, *arguments, "--reference", "new", "--overwrite")[0] == 0
    assert read_result(tmp_path / "results" / FILE).about.reference == "new"


@pytest.mark.parametrize("name", ["a/b", "..", "mine:Still", "x" * 41, "-x", "é", "a b"])
def test_a_name_that_no_file_can_bear_is_refused(
    capsys: pytest.CaptureFixture[str], submission: Path, dataset: Path, tmp_path: Path, name: str
) -> None:
    facts = json.loads((submission / "submission.json").read_text())
    (submission / "submission.json").write_text(json.dumps({**facts, "solver": name}))
    status, _, err = add(capsys, submission, "--dataset", dataset, "--results", tmp_path / "results")
    assert (status, err.count("\n")) == (2, 1)
    assert "cannot be the name of a result's file; give one with --name" in err
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    "words", [["--code", "javascript:alert(1)"], ["--reference", "a\nb"], ["--reference", "x" * 501]]
)
def test_words_that_no_page_can_show_are_refused(
    capsys: pytest.CaptureFixture[str], submission: Path, dataset: Path, tmp_path: Path, words: list[str]
) -> None:
    status, _, err = add(capsys, submission, "--dataset", dataset, "--results", tmp_path / "results", *words)
    assert (status, err.count("\n")) == (2, 1)
    assert words[0].strip("-") in err
    assert not (tmp_path / "results").exists()


def test_another_dataset_is_refused_with_both_ids_and_the_way_out(
    capsys: pytest.CaptureFixture[str], room: Path, tmp_path: Path
) -> None:
    other = tiny_dataset(tmp_path / "other", Crowd(sequences=4, people=5))
    (tmp_path / "answers").mkdir()
    answers = solve(Dataset(other), "cv", "sequential", tmp_path / "answers" / "cv")
    status, _, err = add(capsys, answers, "--dataset", other, "--results", room / "results", "--name", "mine")
    board = read_result(room / "results" / FILE).dataset
    assert status == 2
    assert Dataset(other).info.id in err
    assert board in err
    assert "vbbench generate tiny --camera panorama" in err
    assert "--tier ideal" in err


def test_another_dataset_cannot_land_on_a_published_board(
    capsys: pytest.CaptureFixture[str], room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vbbench_leaderboards.submitting.published_results", lambda: room / "results")
    other = tiny_dataset(tmp_path / "other", Crowd(sequences=4, people=5))
    solve(Dataset(other), "cv", "rollout", tmp_path / "cv")
    status, _, err = add(capsys, tmp_path / "cv", "--dataset", other, "--results", tmp_path / "results")
    assert status == 2
    assert "hold results on" in err
    assert "--tier ideal --sigma-h 0 --seed 0 --out tiny-ideal" in err
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize("table", ["truth/poses", "truth/scenes", "given"])
def test_truth_that_is_not_the_published_one_is_refused(
    capsys: pytest.CaptureFixture[str], submission: Path, dataset: Path, tmp_path: Path, table: str
) -> None:
    copy = Path(shutil.copytree(dataset, tmp_path / "copy"))
    path = copy / f"{table}.parquet"
    content = bytearray(path.read_bytes())
    content[20] ^= 1
    path.write_bytes(content)
    status, _, err = add(capsys, submission, "--dataset", copy, "--results", tmp_path / "results")
    assert status == 2
    assert f"{path}: its SHA-256 is not the one in dataset.json" in err


def test_withheld_truth_is_named_and_checked(
    capsys: pytest.CaptureFixture[str], submission: Path, dataset: Path, tmp_path: Path
) -> None:
    copy, truth = Path(shutil.copytree(dataset, tmp_path / "copy")), tmp_path / "kept"
    (copy / "truth").rename(truth)
    arguments = (submission, "--dataset", copy, "--results", tmp_path / "results")
    status, _, err = add(capsys, *arguments)
    assert status == 2
    assert "--truth" in err
    (truth / "people.parquet").rename(tmp_path / "away")
    assert add(capsys, *arguments, "--truth", truth)[0] == 2
    (tmp_path / "away").rename(truth / "people.parquet")
    assert add(capsys, *arguments, "--truth", truth)[0] == 0
    assert (tmp_path / "results" / FILE).is_file()


def test_a_submission_with_faults_is_not_added(
    capsys: pytest.CaptureFixture[str], submission: Path, dataset: Path, tmp_path: Path
) -> None:
    (submission / "positions.parquet").unlink()
    status, _, err = add(capsys, submission, "--dataset", dataset, "--results", tmp_path / "results")
    assert status == 2
    assert "positions.parquet: the file is missing" in err
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("authors", "a row must say who made the solver: give --authors"),
        ("trained_on", "what the solver was trained on ('nothing' is an answer): give --trained-on"),
        ("tuned_on", "what the solver was tuned on by hand ('nothing' is an answer): give --tuned-on"),
        ("delay", "a row must say whether the solver is causal: give --delay"),
    ],
)
def test_a_row_that_does_not_say_all_is_refused_and_an_option_completes_it(
    capsys: pytest.CaptureFixture[str], submission: Path, dataset: Path, tmp_path: Path, key: str, words: str
) -> None:
    facts = json.loads((submission / "submission.json").read_text())
    (submission / "submission.json").write_text(json.dumps({**facts, key: None if key == "delay" else ""}))
    arguments = (submission, "--dataset", dataset, "--results", tmp_path / "results")
    status, _, err = add(capsys, *arguments)
    assert (status, err.count("\n")) == (2, 1)
    assert words in err
    assert not (tmp_path / "results").exists()
    option = f"--{key.replace('_', '-')}"
    assert add(capsys, *arguments, option, "3")[0] == 0
    assert str(getattr(read_result(tmp_path / "results" / FILE).about, key)) == "3"


@pytest.mark.parametrize(("option", "value"), [("--date", "yesterday"), ("--date", "2026-2-3"), ("--delay", "-1")])
def test_days_and_delays_that_are_none_are_refused(
    capsys: pytest.CaptureFixture[str], submission: Path, dataset: Path, tmp_path: Path, option: str, value: str
) -> None:
    status, _, err = add(
        capsys, submission, "--dataset", dataset, "--results", tmp_path / "results", f"{option}={value}"
    )
    assert (status, err.count("\n")) == (2, 1)
    assert value in err


def test_a_solver_that_gets_whole_sequences_is_offline_unless_it_gets_the_past_alone(
    dataset: Path, tmp_path: Path
) -> None:
    delays = {}
    for protocol in ("sequential", "one-step"):
        answers = solve(Dataset(dataset), "map-batch", protocol, tmp_path / protocol)
        delays[protocol] = SubmissionInfo.read(answers).delay
    assert delays == {"sequential": "offline", "one-step": 0}
