"""A stranger's way onto the leaderboard: the template runs, files of any language score, mistakes say what to do."""

import json
import re
import shutil
import subprocess
from collections.abc import Callable
from datetime import date
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.lib.challenges import declared, run_lines
from tests.lib.commands import understood
from tests.lib.made_results import made_results
from tests.lib.make_dataset import Crowd
from tests.lib.tiny_board import FILE, tiny_dataset
from vbbench.camera import PanoramaCamera
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.exchange.csv_export import export_csv
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.scoring import score
from vbbench.sequence import Given
from vbbench.solver import Frame, Problem
from vbbench.solving import solve
from vbbench_leaderboards.results.folder import published_results, read_datasets, read_results
from vbbench_leaderboards.results.result import read_result
from vbbench_leaderboards.site.pages import Site, again_lines, take_part_lines
from vbbench_leaderboards.submitting import add, parse_board, try_solver

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


@pytest.mark.parametrize("protocol", ["one-step", "sequential", "rollout"])
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


def test_the_template_overwrites_nothing(mine: Path, dataset: Dataset, mistake: Said) -> None:
    (mine / "README.md").unlink()
    (mine / "mysolver.py").write_text("years of work", encoding="utf-8")
    assert "mysolver.py exists" in mistake("leaderboard", "template", mine)
    assert (mine / "mysolver.py").read_text("utf-8") == "years of work"
    assert "is a dataset" in mistake("leaderboard", "template", dataset.folder)
    assert "is not a folder" in mistake("leaderboard", "template", mine / "mysolver.py")


def _solve_with_awk(dataset: Dataset, folder: Path, protocol: str) -> Path:
    boxes, answer = export_csv(dataset, folder / "boxes"), folder / "answer"
    answer.mkdir()
    files = [boxes / "given.csv", boxes / "observations.csv"]
    variables = ["-v", f"out={answer}", "-v", f"protocol={protocol}"]
    subprocess.run(["awk", *variables, "-f", folder / "mysolver.awk", *files], check=True)
    facts = {"solver": "my-awk", "dataset": dataset.info.id, "protocol": protocol}
    (answer / "submission.json").write_text(json.dumps(facts), encoding="utf-8")
    return answer


@pytest.fixture
def tiny(tiny_room: Path) -> Path:
    return tiny_room / "work/datasets/tiny-ideal"


@pytest.fixture
def submission(tiny_room: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(tiny_room / "work/submissions" / FILE.with_suffix(""), tmp_path / "answers"))


@pytest.fixture
def results(tmp_path: Path) -> Path:
    """A folder that a command makes."""
    return tmp_path / "results"


@pytest.fixture
def added(submission: Path, tiny: Path, results: Path) -> Words:
    """The words that add an answer to a dataset, by default the submission to its own."""

    def words(*more: object, answers: Path = submission, dataset: Path = tiny) -> list[object]:
        return ["leaderboard", "add", answers, "--dataset", dataset, "--results", results, *more]

    return words


def succeeds(words: list[object]) -> bool:
    return main([str(word) for word in words]) == 0


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
    declared(submission, solver=name)
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


@pytest.mark.parametrize("place", ["where results are", "where they are published"])
def test_another_dataset_is_refused_with_both_ids_and_the_way_out(
    mistake: Said, tiny_room: Path, results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    if "published" in place:
        monkeypatch.setattr("vbbench_leaderboards.submitting.published_results", lambda: tiny_room / "results")
    else:
        results = tiny_room / "results"
    other = tiny_dataset(tmp_path / "other", Crowd(sequences=4, people=5))
    answers = solve(Dataset(other), "cv", "rollout", tmp_path / "cv")
    said = mistake("leaderboard", "add", answers, "--dataset", other, "--results", results, "--name", "mine")
    board = read_result(tiny_room / "results" / FILE).dataset
    made_by = "vbbench generate tiny --camera panorama --tier ideal --sigma-h 0 --seed 0 --out tiny-ideal"
    assert all(words in said for words in (Dataset(other).info.id, f"hold results on {board} alone", made_by))
    assert not (tmp_path / "results").exists()


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
    declared(submission, **{key: None if key == "delay" else ""})
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


def site_of(results: Path) -> Site:
    return Site(results=read_results(results), datasets=read_datasets(results), rankings={}, playable={})


@pytest.mark.slow
def test_lines_on_published_boards_are_commands(tmp_path: Path) -> None:
    for split in ("kitti", "sim"):
        (tmp_path / split).symlink_to(published_results() / split)
    site = site_of(tmp_path)
    for board in site.boards:
        for line in again_lines(site, board):
            understood(line.removeprefix("vbbench "))
            assert parse_board(line.partition(" --board ")[2].split()[0]) == board
    last = "vbbench leaderboard try mysolver:MySolver --board sim/sequential-field --out site"
    assert take_part_lines(site)[-1] == last


@pytest.fixture
def published(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the results that come with vbbench are for this test."""
    for room in ("results.folder", "submitting"):
        monkeypatch.setattr(f"vbbench_leaderboards.{room}.published_results", lambda: tmp_path / "published")
    return tmp_path / "published"


@pytest.mark.slow
def test_lines_on_other_boards_run_as_they_are(
    published: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    dataset = ["generate", "sim", "--tier", "noisy", "--sequences", "3", "--options", "people=4", "--out", "crowd"]
    assert main(dataset) == 0
    crowd = Dataset(Path("crowd"))
    add(solve(crowd, "cv", "rollout", Path("stranger")), crowd.folder, Path("own"), name="me")
    made_results(published)
    site = site_of(Path("own"))
    lines = take_part_lines(site)
    assert lines[2].startswith("vbbench generate sim --camera perspective --tier noisy --sequences 3")
    assert again_lines(site, site.first) == lines  # of a solver that nobody else has, no figures can be made again
    run_lines(lines)
    assert Dataset("sim-noisy").info.id == crowd.info.id


@pytest.mark.slow
def test_a_solver_is_tried_in_one_step(
    mine: Path, published: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    limit = 4
    rules = SimpleNamespace(options=lambda seed: Options(tier="noisy", limit=limit, seed=seed))
    monkeypatch.setattr("vbbench_leaderboards.submitting.source", lambda split, tier: rules)
    made = generate("demo", tmp_path / "made", rules.options(5))
    add(solve(made, "cv", "sequential", tmp_path / "answer"), made.folder, published)
    guide = Path(__file__).parents[2] / "docs" / "writing-a-solver.md"
    (block,) = re.findall(r"(?ms)^```python\n((?:(?!^```).)*?^class StandStill.*?)^```", guide.read_text("utf-8"))
    Path("still.py").write_text(block, encoding="utf-8")
    words = ["leaderboard", "try", "mysolver:MySolver", "--board", "demo/sequential-noisy", "--out", "site"]
    capsys.readouterr()
    for _ in range(2):  # it may be tried again and again
        assert main(words) == 0
        assert re.match(r"MySolver on demo/sequential-noisy: rank .* of 2 causal solvers, Δx ", capsys.readouterr().out)
    assert "MySolver" in Path("site/data/demo/sequential-noisy.js").read_text("utf-8")
    assert main(["leaderboard", "try", "still:StandStill", *words[3:-2]]) == 0
    assert re.match(r"StandStill on demo/sequential-noisy: rank \d.* of 3 causal solvers", capsys.readouterr().out)
    assert not Path("leaderboards").exists()
    assert main(["leaderboard", "add", "../answer", "--dataset", "../made", "--name", "my-own"]) == 0
    assert main(["leaderboard", "build", "--out", "site"]) == 0
    page = Path("site/data/demo/sequential-noisy.js").read_text("utf-8")
    assert '"my-own"' in page
    assert '"cv"' in page
    limit = 3
    shutil.rmtree("out")
    assert main(words) == 2
    assert "source files differ" in capsys.readouterr().err


class Nobody:
    """Does not say who made it."""


@pytest.mark.parametrize(
    ("solver", "board", "words"),
    [
        (f"{__name__}:Nobody", "sim/sequential-field", "does not say authors, trained_on, tuned_on; its class needs"),
        ("cv", "sim/sequential-feild", "did you mean 'sim/sequential-field'"),
        ("cv", "sim", "no published board is called 'sim'; known: sim/"),
    ],
)
def test_a_trial_that_cannot_be_is_refused_before_anything_is_made(
    tmp_path: Path, solver: str, board: str, words: str
) -> None:
    with pytest.raises(VbbenchError, match=words):
        try_solver(solver, board, tmp_path / "work")
    assert not (tmp_path / "work").exists()
