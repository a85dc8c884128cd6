"""Results made again: the same seed gives the same figures, another one figures that agree; what drifted is found."""

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks import kinds
from tests.lib import cars
from tests.lib.board_results import result as made_result
from vbbench.cli import main
from vbbench.errors import SourceMissingError, UnknownNameError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.protocol import PROTOCOLS, get_protocol
from vbbench.registry import make_solver
from vbbench.solving.runner import run_sequence
from vbbench_leaderboards.checks import drift, rerunning
from vbbench_leaderboards.checks.rerunning import Rerun, code_of, disagreements
from vbbench_leaderboards.results.boards import REFERENCES, BoardSource, chosen_sources
from vbbench_leaderboards.results.dataset_record import read_dataset, write_dataset
from vbbench_leaderboards.results.folder import dataset_folder, submission_folder
from vbbench_leaderboards.results.result import Board, Result, read_result, write_result

KEPT = Path("sim", "one-step-ideal", "cv.json")
SEED = "0"


@pytest.fixture(scope="module", autouse=True)
def few_sequences() -> Iterator[None]:
    """The simulator as a board of sixteen crowds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vbbench_leaderboards.results.boards._LIMITS", {"sim": 16})
        yield


@pytest.fixture(scope="module")
def first(few_sequences: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the results and the work of a run on the simulator."""
    room = tmp_path_factory.mktemp("rerun")
    run = Rerun(results=room / "results", work=room / "work", update=True, seed=0, together=True)
    outcomes = list(run.boards(["sim"], ["cv"], ["ideal"]))
    wanted = ["written again\n  nothing was kept"] * (1 + len(PROTOCOLS))
    assert [outcome.text.split(": ")[1] for outcome in outcomes] == wanted
    return room


@pytest.fixture
def remade(first: Path, tmp_path: Path) -> Path:
    """A copy of it that a test may spoil."""
    return Path(shutil.copytree(first, tmp_path / "room"))


def command(room: Path, *more: str) -> int:
    names = ["--split", "sim", "--solver", "cv", "--tier", "ideal", "--together"]
    folders = ["--results", str(room / "results"), "--work", str(room / "work")]
    return main(["leaderboard", "rerun", *names, *folders, *more])


def with_dx(result: Result, change: Any) -> Result:
    figures = dict(result.per_sequence.figures)
    figures["dx"] = change(figures["dx"])
    return replace(result, per_sequence=replace(result.per_sequence, figures=figures))


def spoil(result: Result) -> Result:
    metrics = result.score["metrics"]
    metrics = {**metrics, "dt": {**metrics["dt"], "mean": metrics["dt"]["mean"] + 1.0}}
    changed = {**result.score, "metrics": metrics, "solver_version": "0.0.1", "seconds_per_frame": 77.0}
    return with_dx(replace(result, score=changed), lambda dx: dx + 1e-5 * (np.arange(len(dx)) == 3))


@pytest.mark.slow
def test_with_the_same_seed_drift_is_found_named_and_mended(remade: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, record = remade / "results" / KEPT, remade / "results/sim/ideal.json"
    damaged = (record, remade / "results/sim/rollout-ideal/cv.json")
    assert command(remade, "--update", "--seed", SEED, "--by", "A. Judge, 2026-11-22") == 0
    captured = capsys.readouterr()
    assert captured.out.count("as committed") == 1 + len(PROTOCOLS)
    assert "vbbench: seed 0, as asked" in captured.err
    before = {file: file.read_bytes() for file in (remade / "results").rglob("*.json")}
    assert {read_result(file).about.rerun_by for file in before if file != record} == {"A. Judge, 2026-11-22"}
    write_result(spoil(read_result(path)), remade / "results")
    for file in damaged:
        file.write_text("{")
    assert command(remade, "--seed", SEED) == 1
    said = capsys.readouterr().out
    assert said.count("cannot be read") == len(damaged)
    lines = said.partition(f"{KEPT}: drifted\n")[2].splitlines()[:2]
    assert [line.split(":")[0] for line in lines] == ["  score.metrics.dt.mean", "  per_sequence.dx"]
    assert "1 of" in lines[1]
    assert "most row 3" in lines[1]
    assert command(remade, "--update", "--seed", SEED, "--by", "A. Judge, 2026-11-22") == 0
    assert {file: file.read_bytes() for file in before} == before


@pytest.mark.slow
def test_another_seed_is_drawn_for_each_run_that_ends_and_the_results_stand(
    remade: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    drawn = iter((17, 18))
    monkeypatch.setattr(rerunning.secrets, "randbelow", lambda _: next(drawn))
    before = {path: path.read_bytes() for path in (remade / "results").rglob("*.json")}
    with monkeypatch.context() as patch:
        patch.setattr(Rerun, "_result", stop)
        with pytest.raises(KeyboardInterrupt):
            list(Rerun(results=remade / "results", work=remade / "work").boards(["sim"], ["cv"], ["ideal"]))
    assert "seed 17, drawn for this run" in capsys.readouterr().err
    for said in ("seed 17, of the run that was stopped", "seed 18, drawn for this run"):
        assert command(remade) == 0
        captured = capsys.readouterr()
        assert said in captured.err
        assert captured.out.count(": stands") == 1 + len(PROTOCOLS)
        assert f"seed {DatasetInfo.read(remade / 'work/again/datasets/sim-ideal').seed}," in said
        assert not (remade / "work/again/unfinished-seed").exists()
    assert before == {path: path.read_bytes() for path in (remade / "results").rglob("*.json")}


@pytest.mark.slow
def test_figures_that_no_seed_explains_are_drift_and_all_of_a_dataset_is_written(
    remade: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = remade / "results" / KEPT
    write_result(with_dx(read_result(path), lambda dx: dx / 10), remade / "results")
    assert command(remade, "--seed", "17") == 1
    assert "dx: was" in capsys.readouterr().out
    others = write_result(replace(read_result(path), solver="other"), remade / "results")
    assert command(remade, "--seed", "17", "--update") == 1
    assert f"not written: {others.relative_to(remade / 'results')} would stand on the old" in capsys.readouterr().out
    others.unlink()
    assert command(remade, "--seed", "17", "--update") == 0
    assert capsys.readouterr().out.count("written again") == 1 + len(PROTOCOLS)
    assert read_dataset(remade / "results/sim/ideal.json").seed == 17
    assert {read_result(file).seed for file in (remade / "results").glob("*/*/*.json")} == {17}


def test_datasets_that_are_named_are_made_once(no_data: Path) -> None:
    found = chosen_sources(("kitti", "hotel"), ("noisy", "field"))
    assert [(one.split, one.tier) for one in found] == [("kitti", "footage"), ("hotel", "noisy"), ("hotel", "field")]


@pytest.mark.parametrize(
    ("names", "meant"),
    [
        ({"splits": ["kitti", "hotle"], "tiers": ["noisy"]}, "hotel"),
        ({"splits": ["hotle"]}, "hotel"),
        ({"solvers": ["vbcv"]}, "vb-cv"),
        ({"splits": ["hotel"], "tiers": ["noisi"]}, "noisy"),
    ],
)
def test_unknown_names_are_refused_before_anything_is_made(
    tmp_path: Path, names: dict[str, list[str]], meant: str
) -> None:
    with pytest.raises(UnknownNameError, match=f"did you mean '{meant}'"):
        list(Rerun(results=tmp_path / "results", work=tmp_path / "work").boards(**names))
    assert not list(tmp_path.iterdir())


def test_real_recordings_are_regenerated_by_whoever_has_them(
    no_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cars.write_log(tmp_path / "data" / "argoverse2" / "val" / cars.LOG, cars.Drive())
    cars.write_tables(tmp_path / "data" / "nuscenes" / "v1.0-mini", {"scene-0003": cars.Drive(ground=0.0)})
    asked = ["leaderboard", "rerun", "--split", "real", "--solver", "cv", "--root", str(tmp_path / "data"), "--update"]
    folders = ["--results", str(tmp_path / "results"), "--work", str(tmp_path / "work")]
    assert main([*asked, *folders, "--seed", SEED, "--together"]) == 0
    rows = {str(path.relative_to(tmp_path / "results")) for path in (tmp_path / "results").glob("*/*/*.json")}
    protocols = ("sequential", "rollout", "cold-start")
    assert rows == {f"{s}/{p}-footage/cv.json" for s in ("argoverse2", "nuscenes") for p in protocols}
    said = capsys.readouterr().err
    assert "kitti footage is omitted" in said
    assert "jrdb footage is omitted" in said
    work = tmp_path / "work"
    answers = submission_folder(work, Board(split="nuscenes", tier="footage", protocol=protocols[0]), "cv")
    dataset = dataset_folder(work, "nuscenes", "footage")
    assert np.isfinite(kinds.errors(answers, dataset)).tolist() == [[True] * 3]
    found = [name for name, numbers in kinds.kinds(kinds.features(Dataset(dataset))) if len(numbers)]
    assert found[:3] == ["all", "camera driven, m: 1 or more", "people a frame: 5 to 10"]
    assert found[3:] == ["speed of people, m/s: 1 or more", "box height, px: 80 or more"]


def test_whatever_a_solver_reads_makes_what_it_answered_old(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    found = []
    for text in ("one = 1\n", "one = 2\n"):
        (tmp_path / "judged.py").write_text(text)
        code_of.cache_clear()
        found.append(code_of("solver", "judged:Solver"))
    assert found[0] != found[1]


@pytest.mark.slow
def test_what_is_whole_is_used_again_and_the_rest_is_made(remade: Path) -> None:
    work, touched = remade / "work", {"submissions/sim/one-step-ideal/cv": "poses", "datasets/sim-ideal": "given"}

    def made() -> dict[Path, int]:
        markers = [*work.glob("datasets/*/dataset.json"), *work.glob("submissions/*/*/*/submission.json")]
        return {path.parent.relative_to(work): path.stat().st_ino for path in markers}

    before = made()
    for folder, table in touched.items():
        with (work / folder / f"{table}.parquet").open("ab") as file:
            file.write(b"x")
    assert command(remade, "--seed", SEED, "--update") == 0
    assert {str(path) for path, number in made().items() if number != before[path]} == set(touched)


def test_missing_sources_are_said_and_left_out_unless_named(
    no_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "vbbench_leaderboards.results.boards.published_sources", lambda: (BoardSource(split="hotel", tier="noisy"),)
    )
    run = Rerun(results=tmp_path / "results", work=tmp_path / "work")
    assert list(run.boards()) == []
    assert "hotel noisy is omitted: source files of hotel are missing" in capsys.readouterr().err
    with pytest.raises(SourceMissingError):
        list(run.boards(["hotel"]))


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "found"), [(0, True), (17, False)])
def test_a_dataset_that_the_same_seed_makes_in_another_way_is_drift(remade: Path, seed: int, found: bool) -> None:
    """However well figures on it agree: nobody could make it again."""
    kept = read_dataset(remade / "results/sim/ideal.json")
    write_dataset(replace(kept, id="0123456789abcdef"), remade / "results")
    run = Rerun(results=remade / "results", work=remade / "work", seed=seed, together=True)
    said = next(run.boards(["sim"], ["cv"], ["ideal"])).text
    assert (f"was 0123456789abcdef, is {kept.id} with the same seed" in said) == found


@pytest.mark.parametrize(
    ("solver", "change", "lines"),
    [
        ("cv", lambda x: x, 0),
        ("cv", lambda x: x + 5e-7, 0),
        ("cv", lambda x: x + 2e-6, 1),
        ("cv", lambda x: 1e6 * (1 + x), 1),
        ("cv", lambda x: np.full_like(x, np.nan), 1),
        ("cv", lambda x: x[1:], 1),
        ("vb-former", lambda x: x + 2e-6, 0),
        ("vb-former", lambda x: x + 2e-4, 1),
    ],
)
def test_what_counts_as_drift_with_the_same_seed(solver: str, change: Any, lines: int) -> None:
    """Figures of single precision may differ in their last digits."""
    result = made_result(solver, np.linspace(0.1, 0.9, 20))
    assert len(drift(result, with_dx(result, change))) == lines


def test_other_noise_agrees_and_other_skill_does_not() -> None:
    rng = np.random.default_rng(4)
    usual = rng.gamma(3.0, 0.1, 200)
    first = made_result("a", usual + rng.normal(0.0, 0.05, 200))
    again = [made_result("a", np.abs(usual + rng.normal(0.0, 0.05, 200))) for _ in range(50)]
    assert [one for one in again if disagreements(first, one, 600)] == []
    assert disagreements(first, made_result("a", usual * 1.3 + 0.02), 600)
    usual[::20] = 50.0
    beyond_the_cap = np.where(usual > 2.0, 7000.0, usual)
    assert disagreements(made_result("a", usual), made_result("a", beyond_the_cap), 600) == []


def test_where_sequences_are_too_few_a_tenth_is_allowed() -> None:
    few = np.array([0.5, 0.6, 0.4])
    assert disagreements(made_result("a", few), made_result("a", few * 1.05), 600) == []
    assert "more than 10% apart" in disagreements(made_result("a", few), made_result("a", few * 1.2), 600)[0]
    elsewhere = with_dx(made_result("a", few), lambda dx: dx)
    elsewhere = replace(elsewhere, per_sequence=replace(elsewhere.per_sequence, sequence=few.astype(int) + 10))
    assert "no sequence is scored in both" in disagreements(made_result("a", few), elsewhere, 600)[0]


@pytest.mark.parametrize("solver", sorted(REFERENCES))
def test_a_bundled_solver_remembers_nothing_of_other_sequences(solver: str, tmp_path: Path) -> None:
    """So that its boards may be solved in one process."""
    dataset = generate("sim", tmp_path / "sim", Options(limit=2, tier="noisy"))
    rules, first, second = get_protocol("sequential"), dataset.sequence(0), dataset.sequence(1)
    used = make_solver(solver)
    run_sequence(used, dataset.problem(first), first, rules, None)
    after, _ = run_sequence(used, dataset.problem(second), second, rules, None)
    alone, _ = run_sequence(make_solver(solver), dataset.problem(second), second, rules, None)
    np.testing.assert_array_equal(after.poses, alone.poses)
    np.testing.assert_array_equal(after.positions, alone.positions)


def test_solvers_of_strangers_are_solved_in_fresh_processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, bool] = {}

    def note(_dataset: object, solver: str, _protocol: str, out: Path, **how: Any) -> None:
        asked[solver] = how["fresh_processes"]
        out.mkdir(parents=True)

    monkeypatch.setattr("vbbench_leaderboards.checks.rerunning.solve", note)
    dataset = generate("sim", tmp_path / "sim", Options(limit=1))
    board = Board(split="sim", tier="ideal", protocol="sequential")
    for solver in ("cv", "tests.lib.session_solvers:Anything"):
        Rerun(results=tmp_path, work=tmp_path / "room", update=True, together=True).submission(dataset, board, solver)
    assert asked == {"cv": False, "tests.lib.session_solvers:Anything": True}
    Rerun(results=tmp_path, work=tmp_path / "diagnostic").submission(dataset, board, "cv")
    assert not asked["cv"]
    Rerun(results=tmp_path, work=tmp_path / "other").submission(dataset, replace(board, tier="noisy"), "cv")
    assert asked["cv"]
