"""The player's data: what is read back, how large it is, and which sequences can be played."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from tests.lib.answers import submit, true_answers
from tests.lib.board_results import ABOUT, result
from tests.lib.made_footage import FRAMES, known_as, made, photographed
from tests.lib.made_sequence import DT, MadeSequence, made_sequence
from tests.lib.make_dataset import Crowd, write_dataset
from tests.lib.player_decoding import METRE, PIXEL, RADIAN, decode_clip, decode_estimate
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.geometry import wrap_angle
from vbbench.pictures.rendering import Backend
from vbbench.scoring import score
from vbbench.solver import Estimate
from vbbench.solving import solve
from vbbench_leaderboards.results.folder import dataset_folder, read_results, submission_folder
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.site.pages import build
from vbbench_leaderboards.site.player import (
    FOLDER,
    LARGEST,
    WIDTH,
    Films,
    choose_sequences,
    encode_clip,
    encode_estimate,
    write_player,
)
from vbbench_leaderboards.submitting import add

Results = dict[Board, tuple[Result, ...]]

SLACK = 1e-6
"""Of a quantum, for the rounding of floats."""


def close(got: object, wanted: object, quantum: float) -> bool:
    off = np.abs(np.asarray(got) - np.asarray(wanted))
    return bool(np.array_equal(np.isnan(got), np.isnan(wanted)) and np.all(~(off > (0.5 + SLACK) * quantum)))


def moved(values: object, made: MadeSequence) -> object:
    return np.asarray(values) - np.rint(made.truth.poses[0, :2])


@settings(deadline=None, max_examples=60)
@given(
    people=st.integers(1, 12),
    frames=st.integers(1, 9),
    seed=st.integers(0, 1000),
    share=st.sampled_from([0.0, 0.3, 0.9, 1.0]),
    far=st.sampled_from([0.0, -55.5, 5.4e6]),
    error=st.sampled_from([0.0, 0.02, 1.0, 30.0]),
    camera=st.sampled_from([PanoramaCamera(), PerspectiveCamera()]),
)
def test_a_sequence_comes_back_within_half_a_quantum(
    people: int, frames: int, seed: int, share: float, far: float, error: float, camera: Camera
) -> None:
    made = made_sequence(people, frames, seed=seed, share=share, far=far, camera=camera)
    clip = decode_clip(encode_clip(made.camera, DT, made.sequence, made.truth))
    assert np.array_equal(clip["observed"], made.sequence.observed)
    assert np.array_equal(clip["known"], ~np.isnan(made.truth.positions[..., 0]))
    assert np.array_equal(clip["given"], ~np.isnan(made.sequence.given.positions[..., 0]))
    assert close(clip["poses"][:, :2], moved(made.truth.poses[:, :2], made), METRE)
    assert close(clip["poses"][:, 2], made.truth.poses[:, 2], RADIAN)
    assert close(clip["positions"], moved(made.truth.positions, made), METRE)
    assert close(clip["boxes"], made.sequence.observations, PIXEL)
    estimate = made.estimate(np.random.default_rng(seed), error)
    poses, positions = decode_estimate(encode_estimate(made.truth, estimate), clip)
    assert close(positions, moved(estimate.positions, made), METRE)
    assert close(poses[:, :2], moved(estimate.poses[:, :2], made), METRE)
    assert close(wrap_angle(poses[:, 2] - estimate.poses[:, 2]), np.zeros(frames), RADIAN)


def test_what_a_solver_says_of_nobody_is_kept_and_what_is_no_number_is_not() -> None:
    made = made_sequence(5, 6, share=1.0)
    truth = replace(made.truth, positions=np.where(np.arange(5)[:, None] == 2, np.nan, made.truth.positions))
    positions = np.array(made.truth.positions)
    positions[3, 1], positions[4, 0] = np.inf, 1e12
    estimate = Estimate(poses=made.truth.poses, positions=positions)
    clip = decode_clip(encode_clip(made.camera, DT, made.sequence, truth))
    _, read = decode_estimate(encode_estimate(truth, estimate), clip)
    assert np.isnan(read[3, 1]).all()
    assert np.allclose(read[4, 0], LARGEST * METRE, rtol=1e-3)
    assert close(read[:, 2], moved(positions[:, 2], made), METRE)


def test_students_with_three_solvers_are_small() -> None:
    made, rng = made_sequence(51, 46), np.random.default_rng(1)
    values = [encode_estimate(made.truth, made.estimate(rng, 0.05)) for _ in range(3)]
    values.append(encode_clip(made.camera, DT, made.sequence, made.truth))
    assert sum(len(json.dumps(one)) for one in values) <= 30 * 51 * 46


NOISY = Board(split="made", tier="noisy", protocol="sequential")
IDEAL = Board(split="made", tier="ideal", protocol="one-step")


def test_the_best_and_the_worst_are_played_and_others_between() -> None:
    errors = np.array([0.5, 0.1, np.nan, 0.9, 0.3, 0.7, 0.2])
    factors = {"a": 9.0, "b": 1.0, "c": 0.1}
    results = {
        NOISY: tuple(result(name, factor * errors, board=NOISY) for name, factor in factors.items()),
        IDEAL: (result("a", errors[::-1], board=IDEAL),),
    }
    for count, available, chosen in (
        (3, 100, [1, 3, 4]),
        (1, 100, [1]),
        (99, 100, [0, 1, 3, 4, 5, 6]),
        (99, 4, [0, 1, 3]),
    ):
        for order in (results, dict(reversed(results.items()))):
            assert choose_sequences(order, count, available).tolist() == chosen


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset and two answers to it."""
    folder = tmp_path_factory.mktemp("work")
    dataset = folder / "datasets" / "made-noisy"
    write_dataset(dataset, Crowd(scenes=1, people=12, frames=30, stay=(12, 16), seed=1))
    for solver, error in [("near", 0.05), ("wide", 0.8)]:
        submit(folder / "submissions" / NOISY.key / solver, dataset, true_answers(dataset, error))
    return folder


@pytest.fixture(scope="module")
def results(work: Path) -> dict[Board, tuple[Result, ...]]:
    dataset, answers = work / "datasets" / "made-noisy", work / "submissions" / NOISY.key
    folders = {solver: answers / solver for solver in ("near", "wide")}
    scored = [Result.of(score(folder, dataset), folder, ABOUT, name=solver) for solver, folder in folders.items()]
    return {NOISY: tuple(replace(row, board=NOISY) for row in scored)}


def read_data(path: Path) -> tuple[str, dict[str, object]]:
    text = path.read_text("utf-8").removeprefix("vbbench.provide(").removesuffix(");\n")
    key, value = json.loads(f"[{text}]")
    return key, value


def test_the_site_gets_an_index_a_sequence_and_a_file_a_solver(work: Path, results: Results, tmp_path: Path) -> None:
    assert write_player(tmp_path, results, Films(work=work, sequences=4)) == {NOISY: ("near", "wide")}
    key, index = read_data(tmp_path / FOLDER / "made.js")
    assert key == "player/made"
    assert len(index["sequences"]) == 4
    board = index["boards"]["sequential-noisy"]
    assert board["given"] == "arrivals"
    for name in board["solvers"]:
        for number in index["sequences"]:
            key, value = read_data(tmp_path / FOLDER / "made" / "sequential-noisy" / str(number) / f"{name}.js")
            assert key == f"player/made/sequential-noisy/{number}/{name}"
            assert set(value) == {"data"}
    assert read_data(tmp_path / FOLDER / "made" / "noisy" / f"{index['sequences'][0]}.js")[1]["frames"] > 1
    again = tmp_path / "again"
    write_player(again, results, Films(work=work, sequences=4))
    assert [path.read_bytes() for path in sorted(again.rglob("*.js"))] == [
        path.read_bytes() for path in sorted(path for path in tmp_path.rglob("*.js") if again not in path.parents)
    ]


def test_nothing_is_played_of_what_is_not_there(work: Path, results: Results, tmp_path: Path) -> None:
    assert write_player(tmp_path, {IDEAL: (result("a", np.ones(1), board=IDEAL),)}, Films(work=work)) == {}
    assert write_player(tmp_path, results, None) == {}
    assert not list(tmp_path.iterdir())


def test_pictures_go_with_a_sequence_and_are_made_where_they_are_asked_for(
    work: Path, results: Results, tmp_path: Path
) -> None:
    own_work = Path(shutil.copytree(work, tmp_path / "work"))
    pictures = own_work / "pictures" / "made"
    (pictures / "0").mkdir(parents=True)
    (pictures / "0" / "00000.jpg").write_bytes(b"picture")
    for backend in (None, Backend(name="tests.lib.flat_renderer:FlatRenderer")):
        write_player(tmp_path, results, Films(work=own_work, sequences=99, pictures=backend))
        index = read_data(tmp_path / FOLDER / "made.js")[1]
        frames = dict(zip(map(str, index["sequences"]), index["frames"], strict=True))
        assert index["pictures"] == ({**frames, "0": 1} if backend else {"0": 1})
        for number, count in index["pictures"].items():
            assert len([*(tmp_path / FOLDER / "pictures" / "made" / number).iterdir()]) == count
    assert (tmp_path / FOLDER / "pictures" / "made" / "0" / "00000.jpg").read_bytes() == b"picture"
    with Image.open(tmp_path / FOLDER / "pictures" / "made" / "1" / "00000.jpg") as picture:
        assert picture.width == WIDTH


def test_another_dataset_than_the_results_are_of_is_refused(work: Path, results: Results, tmp_path: Path) -> None:
    others = {NOISY: tuple(replace(row, dataset="sha256:other") for row in results[NOISY])}
    with pytest.raises(VbbenchError, match=r"made-noisy is dataset .* is of sha256:other; run 'vbbench leaderboard"):
        write_player(tmp_path, others, Films(work=work))


__all__ = ["photographed"]
WALKER = "tests.lib.made_footage:Walker"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")
@pytest.mark.parametrize("kind", ["whole", "poses", "relative"])
def test_the_player_shows_what_is_known_over_small_copies_of_the_pictures(tmp_path, photographed, kind):
    pictures = photographed.info.pictures[0]
    folder = dataset_folder(tmp_path / "work", "walk", "footage")
    dataset = made(folder, known_as(kind, pictures=pictures))
    board = Board(split="walk", tier="footage", protocol="cold-start")
    solve(dataset, WALKER, "cold-start", submission_folder(tmp_path / "work", board, "walker"))
    words = {"name": "walker", "authors": "somebody", "trained_on": "nothing", "tuned_on": "nothing"}
    add(submission_folder(tmp_path / "work", board, "walker"), folder, tmp_path / "results", **words)
    results = read_results(tmp_path / "results")
    build(tmp_path / "page", tmp_path / "results", films=Films(work=tmp_path / "work"))
    assert (tmp_path / "page/data/player/walk.js").is_file()
    films = Films(work=tmp_path / "work", footage=True)
    assert write_player(tmp_path / "site", results, films) == {board: ("walker",)}
    index = read_data(tmp_path / "site/data/player/walk.js")[1]
    assert (index["truth"], index["sequences"], index["pictures"]) == (kind, [0], {"0": FRAMES})
    (figures,) = index["boards"]["cold-start-footage"]["solvers"].values()
    assert (figures["dx"] == [None]) == (kind == "poses")
    assert (figures["dt"] == [None]) == (kind == "relative")
    with Image.open(tmp_path / "site/data/player/pictures/walk/0/00007.jpg") as thumbnail:
        assert thumbnail.size == (640, 360)
    data = tmp_path / "site/data/player/walk"
    clip = decode_clip(read_data(data / "footage/0.js")[1])
    poses, positions = decode_estimate(read_data(data / "cold-start-footage/0/walker.js")[1], clip)
    assert np.isnan(poses).all() == (kind == "relative")
    counted = clip["observed"] & clip["known"]
    errors = np.where(counted, np.linalg.norm(positions - clip["positions"], axis=-1), np.nan)[2:]
    if kind == "poses":
        assert np.isnan(errors).all()
    else:
        assert np.nanmean(errors) == pytest.approx(figures["dx"][0], abs=0.002)
