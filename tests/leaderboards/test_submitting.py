"""A stranger's way onto the leaderboard: the template runs, files of any language score, mistakes say what to do."""

import json
import shutil
import subprocess
from collections.abc import Callable
from datetime import date
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.lib.made_results import made_results
from tests.lib.make_dataset import Crowd
from tests.lib.tiny_board import FILE, tiny_board, tiny_dataset
from vbbench.camera import PanoramaCamera
from vbbench.cli import main
from vbbench.errors import UnknownNameError
from vbbench.exchange.csv_export import TABLES, export_csv
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.scoring import score
from vbbench.sequence import Given
from vbbench.solver import Frame, Problem
from vbbench.solving import solve
from vbbench_leaderboards.results.result import read_result
from vbbench_leaderboards.submitting import parse_board

PROTOCOLS = ("one-step", "sequential", "rollout")
Said, Words = Callable[..., str], Callable[..., list[object]]


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    folder = tmp_path_factory.mktemp("submitting") / "demo"
    return generate("demo", folder, Options(camera=PanoramaCamera(), tier="noisy", limit=6))


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a newcomer who stands in it."""
    assert main(["leaderboard", "template", str(tmp_path / "mine")]) == 0
    monkeypatch.chdir(tmp_path / "mine")
    monkeypatch.syspath_prepend(str(tmp_path / "mine"))
    return tmp_path / "mine"


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_the_class_of_the_template_answers(dataset: Dataset, mine: Path, protocol: str) -> None:
    answer = solve(dataset, "mysolver:MySolver", protocol, mine / "answer")
    plain = solve(dataset, "cv", protocol, mine / "plain")
    figures, others = score(answer, dataset.folder), score(plain, dataset.folder)
    assert figures.coverage == 1.0
    assert protocol == "one-step" or figures.summaries["dx_rel"].mean < others.summaries["dx_rel"].mean


@pytest.mark.usefixtures("mine")
def test_the_template_stays_where_nobody_has_shown_how_it_moves() -> None:
    """As after a cold start among few people: one pose is known, and nobody is in sight."""
    from mysolver import MySolver  # type: ignore[import-not-found]

    solver = MySolver()
    solver.start(
        Problem(camera=PanoramaCamera(), dt=0.4, tracks=np.arange(3), height_mean=1.7, height_std=0.1, pixel_std=0.0)
    )
    nobody, nothing = np.full((3, 3), np.nan), np.full((3, 3, 2), np.nan)
    unknown, first = [np.nan] * 3, [1.0, 2.0, 3.0]
    for t, poses in enumerate(([unknown, unknown, first], [unknown, first, unknown], [first, unknown, unknown])):
        frame = Frame(index=t, observations=nobody, given=Given(poses=np.array(poses), positions=nothing))
        np.testing.assert_array_equal(solver.step(frame).pose, (1.0, 2.0, 3.0))


@pytest.mark.skipif(shutil.which("awk") is None, reason="no awk here")
@pytest.mark.parametrize("protocol", ["sequential", "rollout"])
def test_a_program_in_another_language_answers(dataset: Dataset, mine: Path, protocol: str) -> None:
    answer = _solve_with_awk(dataset, mine, protocol)
    assert score(answer, dataset.folder).coverage == 1.0
    if protocol == "sequential":
        plain = score(solve(dataset, "cv", protocol, mine / "plain"), dataset.folder)
        assert score(answer, dataset.folder).summaries["dt"].mean == pytest.approx(plain.summaries["dt"].mean)


def test_csv_says_what_parquet_says_and_no_truth(dataset: Dataset, tmp_path: Path) -> None:
    export_csv(dataset, tmp_path / "csv")
    assert sorted(path.stem for path in (tmp_path / "csv").iterdir()) == sorted(TABLES)
    for name in TABLES:
        text = (tmp_path / "csv" / f"{name}.csv").read_text("utf-8")
        assert '"' not in text
        assert "nan" not in text
        read = pd.read_csv(tmp_path / "csv" / f"{name}.csv")
        there = pd.read_parquet(dataset.table_path(name))
        pd.testing.assert_frame_equal(read, there, check_dtype=False, rtol=1e-7)


def test_the_template_overwrites_nothing(mine: Path, dataset: Dataset, mistake: Said) -> None:
    (mine / "README.md").unlink()
    (mine / "mysolver.py").write_text("years of work", encoding="utf-8")
    assert "mysolver.py exists" in mistake("leaderboard", "template", mine)
    assert (mine / "mysolver.py").read_text("utf-8") == "years of work"
    assert "is a dataset" in mistake("leaderboard", "template", dataset.folder)
    assert "is not a folder" in mistake("leaderboard", "template", mine / "mysolver.py")


@pytest.mark.slow
def test_the_page_shows_ones_own_result_beside_the_published(
    dataset: Dataset, mine: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    published = made_results(tmp_path / "published")
    monkeypatch.setattr("vbbench_leaderboards.results.folder.published_results", lambda: published)
    answer = solve(dataset, "mysolver:MySolver", "sequential", mine / "answer")
    assert main(["leaderboard", "add", str(answer), "--dataset", str(dataset.folder), "--name", "my-solver"]) == 0
    assert main(["leaderboard", "build", "--out", "site"]) == 0
    data = {
        path.relative_to("site/data").as_posix(): path.read_text("utf-8") for path in Path("site/data").rglob("*.js")
    }
    assert "my-solver" in data["demo/sequential-noisy.js"]
    assert "your name" in data["demo/sequential-noisy.js"]
    assert "vb-cv" in data["hotel/sequential-noisy.js"]


def _solve_with_awk(dataset: Dataset, folder: Path, protocol: str) -> Path:
    boxes, answer = export_csv(dataset, folder / "boxes"), folder / "answer"
    answer.mkdir()
    files = [boxes / "given.csv", boxes / "observations.csv"]
    variables = ["-v", f"out={answer}", "-v", f"protocol={protocol}"]
    subprocess.run(["awk", *variables, "-f", folder / "mysolver.awk", *files], check=True)
    facts = {"solver": "my-awk", "dataset": dataset.info.id, "protocol": protocol}
    (answer / "submission.json").write_text(json.dumps(facts), encoding="utf-8")
    return answer


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("add")
    tiny_board(folder)
    return folder


@pytest.fixture
def tiny(room: Path) -> Path:
    return room / "work/datasets/tiny-ideal"


@pytest.fixture
def submission(room: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(room / "work/submissions" / FILE.with_suffix(""), tmp_path / "answers"))


@pytest.fixture
def results(tmp_path: Path) -> Path:
    return tmp_path / "results"


@pytest.fixture
def added(submission: Path, tiny: Path, results: Path) -> Words:
    """The words that add an answer to a dataset, by default the submission to its own."""

    def words(*more: object, answers: Path = submission, dataset: Path = tiny) -> list[object]:
        return ["leaderboard", "add", answers, "--dataset", dataset, "--results", results, *more]

    return words


def succeeds(words: list[object]) -> bool:
    return main([str(word) for word in words]) == 0


def declare(submission: Path, **facts: object) -> None:
    """Change what a submission says of itself."""
    path = submission / "submission.json"
    path.write_text(json.dumps({**json.loads(path.read_text("utf-8")), **facts}), encoding="utf-8")


def test_the_first_result_writes_the_record_too(
    capsys: pytest.CaptureFixture[str], added: Words, results: Path
) -> None:
    assert succeeds(added("--name", "mine", "--reference", "A paper", "--about", "code=https://example.org/mine"))
    said = capsys.readouterr()
    assert (said.out, said.err) == (f"{results / FILE.with_name('mine.json')}\n", "")
    result = read_result(results / FILE.with_name("mine.json"))
    about = result.about
    assert (result.solver, about.reference, about.code) == ("mine", "A paper", "https://example.org/mine")
    assert (about.authors, about.trained_on, about.delay) == ("the authors of vbbench", "nothing", 0)
    assert about.date == f"{date.today()}"
    assert result.score["solver"] == "mine"
    assert set(result.submission) == {"poses.parquet", "positions.parquet"}
    assert sorted(path.name for path in results.rglob("*") if path.is_file()) == ["ideal.json", "mine.json"]
    assert succeeds(["leaderboard", "check", "--results", results])


def test_a_result_is_replaced_only_when_asked(added: Words, mistake: Said, results: Path) -> None:
    assert succeeds(added())
    assert "cv.json exists; set --overwrite to replace it" in mistake(*added("--reference", "new"))
    assert succeeds(added("--reference", "new", "--overwrite"))
    assert read_result(results / FILE).about.reference == "new"


@pytest.mark.parametrize("name", ["a/b", "..", "mine:Still", "x" * 41, "-x", "é", "a b"])
def test_a_name_that_no_file_can_bear_is_refused(
    added: Words, mistake: Said, submission: Path, results: Path, name: str
) -> None:
    declare(submission, solver=name)
    assert "cannot be the name of a result's file; give one with --name" in mistake(*added())
    assert not results.exists()


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--about", "code=javascript:alert(1)"),
        ("--about", "reference=a\nb"),
        ("--about", "reference=" + "x" * 501),
        ("--about", "referense=x"),
        ("--about", "reference"),
        ("--date", "yesterday"),
        ("--date", "2026-2-3"),
        ("--delay", "-1"),
    ],
)
def test_facts_that_no_page_can_show_are_refused(
    added: Words, mistake: Said, results: Path, option: str, value: str
) -> None:
    assert value.partition("=")[0] in mistake(*added(option, value))
    assert not results.exists()


def test_another_dataset_is_refused_with_both_ids_and_the_way_out(mistake: Said, room: Path, tmp_path: Path) -> None:
    other = tiny_dataset(tmp_path / "other", Crowd(sequences=4, people=5))
    answers = solve(Dataset(other), "cv", "sequential", tmp_path / "cv")
    said = mistake("leaderboard", "add", answers, "--dataset", other, "--results", room / "results", "--name", "mine")
    board = read_result(room / "results" / FILE).dataset
    for words in (Dataset(other).info.id, board, "vbbench generate tiny --camera panorama", "--tier ideal"):
        assert words in said


def test_another_dataset_cannot_land_on_a_published_board(
    added: Words, mistake: Said, room: Path, results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vbbench_leaderboards.submitting.published_results", lambda: room / "results")
    other = tiny_dataset(tmp_path / "other", Crowd(sequences=4, people=5))
    said = mistake(*added(answers=solve(Dataset(other), "cv", "rollout", tmp_path / "cv"), dataset=other))
    assert "hold results on" in said
    assert "--tier ideal --sigma-h 0 --seed 0 --out tiny-ideal" in said
    assert not results.exists()


@pytest.mark.parametrize("table", ["truth/poses", "truth/scenes", "given"])
def test_truth_that_is_not_the_published_one_is_refused(
    added: Words, mistake: Said, tiny: Path, tmp_path: Path, table: str
) -> None:
    copy = Path(shutil.copytree(tiny, tmp_path / "copy"))
    path = copy / f"{table}.parquet"
    content = bytearray(path.read_bytes())
    content[20] ^= 1
    path.write_bytes(content)
    assert f"{path}: its SHA-256 is not the one in dataset.json" in mistake(*added(dataset=copy))


def test_withheld_truth_is_named_and_checked(
    added: Words, mistake: Said, tiny: Path, results: Path, tmp_path: Path
) -> None:
    copy, truth = Path(shutil.copytree(tiny, tmp_path / "copy")), tmp_path / "kept"
    (copy / "truth").rename(truth)
    assert "--truth" in mistake(*added(dataset=copy))
    (truth / "people.parquet").rename(tmp_path / "away")
    assert not succeeds(added("--truth", truth, dataset=copy))
    (tmp_path / "away").rename(truth / "people.parquet")
    assert succeeds(added("--truth", truth, dataset=copy))
    assert (results / FILE).is_file()


def test_a_submission_with_faults_is_not_added(
    added: Words, capsys: pytest.CaptureFixture[str], submission: Path, results: Path
) -> None:
    (submission / "positions.parquet").unlink()
    assert not succeeds(added())
    assert "positions.parquet: the file is missing" in capsys.readouterr().err
    assert not results.exists()


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("authors", "a row must state who made the solver: give --authors"),
        ("trained_on", "what the solver was trained on ('nothing' is an answer): give --trained-on"),
        ("tuned_on", "what the solver was tuned on by hand ('nothing' is an answer): give --tuned-on"),
        ("delay", "a row must state whether the solver is causal: give --delay"),
    ],
)
def test_a_row_that_does_not_say_all_is_refused_and_an_option_completes_it(
    added: Words, mistake: Said, submission: Path, results: Path, key: str, words: str
) -> None:
    declare(submission, **{key: None if key == "delay" else ""})
    assert words in mistake(*added())
    assert not results.exists()
    assert succeeds(added("--about", f"{key}=3"))
    assert str(getattr(read_result(results / FILE).about, key)) == "3"


def test_a_solver_that_gets_whole_sequences_is_offline_unless_it_gets_the_past_alone(
    tiny: Path, tmp_path: Path
) -> None:
    delays = {}
    for protocol in ("sequential", "one-step"):
        answers = solve(Dataset(tiny), "map-batch", protocol, tmp_path / protocol)
        delays[protocol] = SubmissionInfo.read(answers).delay
    assert delays == {"sequential": "offline", "one-step": 0}


def test_the_boards_of_a_split_are_listed_by_its_name() -> None:
    with pytest.raises(UnknownNameError, match=r"called 'sim'; known: sim/\S+(, sim/\S+)*$"):
        parse_board("sim")
