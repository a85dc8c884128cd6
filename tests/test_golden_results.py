"""The committed results: sound, complete, a subset recomputed exactly, and drift that is found."""

import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vbbench.cli import main
from vbbench.errors import SourceMissingError, UnknownNameError
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.protocol import PROTOCOLS
from vbbench.scoring import score
from vbbench.solving import solve
from vbbench_leaderboards.checks.checking import check
from vbbench_leaderboards.checks.drift import drift
from vbbench_leaderboards.checks.rerunning import SPLITS, Rerun, bundled_solvers
from vbbench_leaderboards.results.folder import published_results
from vbbench_leaderboards.results.result import Board, Result, read_result, write_result

SEQUENCES = 40
"""Sequences of Hotel that are solved again; what comes after them does not change them."""
COMMITTED = [protocol for protocol in PROTOCOLS if protocol != "cold-start"]
"""The protocols of the committed boards: those of cold-start are made when all are made anew."""
TIERS = ("ideal", "noisy")
KEPT = Path("demo", "one-step-ideal", "cv.json")


@pytest.fixture(scope="module")
def hotel(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("hotel", tmp_path_factory.mktemp("golden") / "hotel", Options(limit=SEQUENCES))


@pytest.mark.parametrize("solver", bundled_solvers())
@pytest.mark.parametrize("protocol", ["one-step", "sequential"])
def test_hotel_scores_as_committed(
    data_folder: Path, request: pytest.FixtureRequest, tmp_path: Path, protocol: str, solver: str
) -> None:
    dataset = request.getfixturevalue("hotel")
    own = score(solve(dataset, solver, protocol, tmp_path / "answers"), dataset.folder).per_sequence
    board = Board(split="hotel", tier="ideal", protocol=protocol)
    kept = read_result(published_results() / board.key / f"{solver}.json").per_sequence
    rows = np.isin(kept.sequence, own.sequence)
    assert len(own.sequence) == rows.sum() > SEQUENCES // 2
    for name, values in own.figures.items():
        np.testing.assert_allclose(kept.figures[name][rows], values, rtol=1e-6, atol=1e-6)


def test_committed_results_are_sound() -> None:
    assert "no faults" in check(published_results())


def test_every_bundled_solver_has_its_results() -> None:
    boards = [
        Board(split=split, tier=tier, protocol=protocol)
        for split, tier, protocol in itertools.product(SPLITS, TIERS, COMMITTED)
    ]
    wanted = [Path(board.key, f"{solver}.json") for board, solver in itertools.product(boards, bundled_solvers())]
    missing = [str(path) for path in wanted if not (published_results() / path).is_file()]
    assert not missing, "write them with make leaderboard"
    assert all((published_results() / path).stat().st_size < 40_000 for path in wanted)


def spoil(result: Result) -> Result:
    figures = {name: values.copy() for name, values in result.per_sequence.figures.items()}
    figures["dx"][3] += 1e-5
    metrics = result.score["metrics"]
    metrics = {**metrics, "dt": {**metrics["dt"], "mean": metrics["dt"]["mean"] + 1.0}}
    changed = {**result.score, "metrics": metrics, "solver_version": "0.0.1", "seconds_per_frame": 77.0}
    return replace(result, score=changed, per_sequence=replace(result.per_sequence, figures=figures), version="0.0.1")


@pytest.fixture(scope="module")
def remade(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the results and the work of a run on the demo."""
    room = tmp_path_factory.mktemp("rerun")
    outcomes = list(
        Rerun(results=room / "results", work=room / "work", update=True).boards(["demo"], ["cv"], ["ideal"])
    )
    assert [outcome.text.split(": ")[1] for outcome in outcomes] == [
        "written anew\n  no record was kept",
        *["written anew\n  no result was kept"] * len(PROTOCOLS),
    ]
    return room


def command(room: Path, *more: str) -> int:
    names = ["--split", "demo", "--solver", "cv", "--tier", "ideal"]
    folders = ["--results", str(room / "results"), "--work", str(room / "work")]
    return main(["leaderboard", "rerun", *names, *folders, *more])


def test_drift_is_found_named_and_mended(remade: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = remade / "results" / KEPT
    before = path.read_bytes()
    assert command(remade) == 0
    assert capsys.readouterr().out.count("as committed") == 1 + len(PROTOCOLS)
    write_result(spoil(read_result(path)), remade / "results")
    assert command(remade) == 1
    lines = capsys.readouterr().out.splitlines()
    assert f"{KEPT}: drifted" in lines
    assert [line.split(":")[0].strip() for line in lines if line.startswith("  ")] == [
        "score.metrics.dt.mean",
        "per_sequence.dx",
    ]
    assert "1 of" in lines[3]
    assert "most row 3" in lines[3]
    assert command(remade, "--update") == 0
    assert path.read_bytes() == before


def test_damaged_files_are_drift_and_mended(remade: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = [remade / "results" / KEPT, remade / "results/demo/ideal.json"]
    before = [path.read_bytes() for path in paths]
    for path in paths:
        path.write_text("{")
    assert command(remade) == 1
    assert capsys.readouterr().out.count("cannot be read") == 2
    assert command(remade, "--update") == 0
    assert [path.read_bytes() for path in paths] == before


def test_a_time_alone_is_no_drift(remade: Path) -> None:
    path = remade / "results" / KEPT
    before, result = path.read_bytes(), read_result(path)
    write_result(replace(result, score={**result.score, "seconds_per_frame": 77.0}), remade / "results")
    slower = path.read_bytes()
    assert command(remade, "--update") == 0
    assert path.read_bytes() == slower != before
    path.write_bytes(before)


@pytest.mark.parametrize(
    ("touched", "again"),
    [
        ("submissions/demo/one-step-ideal/cv/poses.parquet", "submissions/demo/one-step-ideal/cv"),
        ("submissions/demo/rollout-ideal/cv.made-by", "submissions/demo/rollout-ideal/cv"),
        ("datasets/demo-ideal/given.parquet", "datasets/demo-ideal"),
    ],
)
def test_what_is_whole_is_used_again_and_the_rest_is_made(remade: Path, touched: str, again: str) -> None:
    def made() -> dict[Path, int]:
        markers = [*remade.glob("work/datasets/*/dataset.json"), *remade.glob("work/submissions/*/*/*/submission.json")]
        return {path.parent.relative_to(remade / "work"): path.stat().st_ino for path in markers}

    before = made()
    with (remade / "work" / touched).open("ab") as file:
        file.write(b"x")
    assert command(remade) == 0
    assert [str(path) for path, number in made().items() if number != before[path]] == [again]


def test_missing_sources_are_said_and_left_out_unless_named(
    no_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vbbench_leaderboards.checks.rerunning.SPLITS", ("hotel",))
    run = Rerun(results=tmp_path / "results", work=tmp_path / "work")
    assert list(run.boards()) == []
    assert "hotel noisy is left out: source files of hotel are missing" in capsys.readouterr().err
    with pytest.raises(SourceMissingError):
        list(run.boards(["hotel"]))
    with pytest.raises(UnknownNameError, match="did you mean 'hotel'"):
        list(run.boards(["hotle"]))
    with pytest.raises(UnknownNameError, match="did you mean 'vb-cv'"):
        list(run.boards(solvers=["vbcv"]))


def test_another_dataset_is_drift_of_the_record(remade: Path) -> None:
    from vbbench_leaderboards.results.dataset_record import read_dataset, write_dataset

    kept = read_dataset(remade / "results/demo/ideal.json")
    write_dataset(replace(kept, id="0" * 16, counts={**kept.counts, "id": "0" * 16}), remade / "results")
    outcomes = Rerun(results=remade / "results", work=remade / "work").boards(["demo"], ["cv"], ["ideal"])
    assert "$.id: is '0000000000000000'" in next(iter(outcomes)).text
    write_dataset(kept, remade / "results")


def with_dx(result: Result, change: Any) -> Result:
    figures = dict(result.per_sequence.figures)
    figures["dx"] = change(figures["dx"])
    return replace(result, per_sequence=replace(result.per_sequence, figures=figures))


@pytest.mark.parametrize(
    ("change", "lines"),
    [
        (lambda x: x, 0),
        (lambda x: x + 5e-7, 0),
        (lambda x: x + 2e-6, 1),
        (lambda x: 1e6 * (1 + x), 1),
        (lambda x: np.full_like(x, np.nan), 1),
        (lambda x: x[1:], 1),
    ],
)
def test_what_counts_as_drift(remade: Path, change: Any, lines: int) -> None:
    result = read_result(remade / "results" / KEPT)
    assert len(drift(result, with_dx(result, change))) == lines
