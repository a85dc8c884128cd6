"""Withheld truth: nothing published gives it away, and what is kept can be shown to be what was published."""

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.verification import verify
from vbbench.files.withholding import GUESSABLE_BITS, SEED_FILE, draw_seed
from vbbench.generation import generate
from vbbench.generation.datasets import who_knows
from vbbench.generation.generator import Options
from vbbench.scoring import score
from vbbench.solving import solve

SECRET = 0xC0FFEE << 100
LIMIT = 3


def options(seed: int = SECRET) -> Options:
    return Options(limit=LIMIT, seed=seed, tier="noisy")


@pytest.fixture(scope="module")
def challenge(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A withheld dataset; its truth lies beside it in ``challenge.truth``."""
    folder = tmp_path_factory.mktemp("withheld") / "challenge"
    generate("sim", folder, options(), withhold_truth=True)
    return folder


@pytest.fixture
def kept(challenge: Path, tmp_path: Path) -> Path:
    """A copy of its truth."""
    return shutil.copytree(challenge.with_name("challenge.truth"), tmp_path / "kept")


def test_nothing_published_names_the_seed(challenge: Path) -> None:
    facts = json.loads((challenge / "dataset.json").read_text("utf-8"))
    assert facts["seed"] is None
    assert not any(str(SECRET).encode() in path.read_bytes() for path in challenge.iterdir())
    cards, tables = ["README", "croissant"], ["given", "observations", "sequences"]
    assert sorted(path.stem for path in challenge.iterdir()) == [*cards, "dataset", *tables]
    with pytest.raises(VbbenchError, match=r"seed .* is withheld"):
        _ = Dataset(challenge).info.known_seed


def test_the_seed_that_is_told_later_makes_the_same_dataset(challenge: Path, tmp_path: Path) -> None:
    seed = json.loads((challenge.with_name("challenge.truth") / SEED_FILE).read_text("utf-8"))["seed"]
    again = generate("sim", tmp_path / "again", options(seed))
    assert again.info.id == Dataset(challenge).info.id
    assert again.info.tables == Dataset(challenge).info.tables
    assert "truth is the published one" in verify(challenge, again.folder)


def test_it_is_solved_and_scored_like_the_whole(challenge: Path, tmp_path: Path) -> None:
    whole = generate("sim", tmp_path / "whole", options())
    answer = solve(Dataset(challenge), "cv", "sequential", tmp_path / "answer")
    figures = score(answer, challenge, challenge.with_name("challenge.truth"))
    assert figures.to_json() == score(answer, whole.folder).to_json()
    assert "seed withheld" in figures.table()
    with pytest.raises(VbbenchError, match=r"truth of .* is not available"):
        score(answer, challenge)
    with pytest.raises(VbbenchError, match="needs truth while solving"):
        solve(Dataset(challenge), "cv", "one-step", tmp_path / "one-step")


@pytest.mark.parametrize("table", ["people", "poses", "scenes"])
@pytest.mark.parametrize("damage", ["another", "missing", "one byte"])
def test_other_truth_is_refused_by_name(
    challenge: Path, kept: Path, table: str, damage: str, tmp_path: Path, mistake: Callable[..., str]
) -> None:
    path = kept / f"{table}.parquet"
    if damage == "another":
        generate("sim", tmp_path / "other", options(SECRET + 1), withhold_truth=True)
        shutil.copy(tmp_path / "other.truth" / path.name, path)
    elif damage == "one byte":
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 1
        path.write_bytes(data)
    else:
        path.unlink()
    answer = solve(Dataset(challenge), "cv", "sequential", tmp_path / "answer")
    for command in (
        ["score", answer, "--dataset", challenge],
        ["compare", answer, answer, "--dataset", challenge],
        ["solve", challenge, "--solver", "cv", "--protocol", "one-step", "--out", tmp_path / "one-step"],
        ["verify", challenge],
    ):
        assert f"{table}.parquet" in mistake(*command, "--truth", kept)
    assert not (tmp_path / "one-step").exists()


def test_another_seed_is_refused(challenge: Path, kept: Path) -> None:
    (kept / SEED_FILE).write_text(json.dumps({"seed": SECRET + 1}), encoding="utf-8")
    with pytest.raises(FileError, match=r"seed\.json: is not the seed"):
        Dataset(challenge, kept)
    (kept / SEED_FILE).write_text("{}", encoding="utf-8")
    with pytest.raises(FileError, match=r"seed\.json: is damaged"):
        Dataset(challenge, kept)


def test_info_prints_one_hash_that_sha256sum_gives_too(
    challenge: Path, kept: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tables = sorted(kept.glob("*.parquet"))
    listing = "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in tables)
    digest = hashlib.sha256(listing.encode()).hexdigest()
    assert main(["info", str(challenge)]) == 0
    assert f"truth withheld, SHA-256 {digest}" in capsys.readouterr().out
    assert main(["info", str(challenge), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["truth_sha256"] == digest
    assert verify(challenge, kept).endswith(f"truth is the published one, SHA-256 {digest}")


def test_the_only_copy_of_a_truth_is_not_overwritten(challenge: Path, tmp_path: Path) -> None:
    generate("sim", tmp_path / "a", options(), withhold_truth=True)
    shutil.rmtree(tmp_path / "a")
    with pytest.raises(VbbenchError, match=r"a\.truth exists and may be the only copy"):
        generate("sim", tmp_path / "a", options(SECRET + 1), withhold_truth=True)
    generate("sim", tmp_path / "a", options(SECRET + 1), withhold_truth=True, overwrite=True)
    (tmp_path / "b.truth").mkdir()
    (tmp_path / "b.truth" / "thesis.tex").write_text("years of work")
    with pytest.raises(VbbenchError, match="is not a withheld truth"):
        generate("sim", tmp_path / "b", options(), withhold_truth=True, overwrite=True)
    assert (tmp_path / "b.truth" / "thesis.tex").read_text() == "years of work"


def test_what_can_be_guessed_or_looked_up_is_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["generate", "sim", "--limit", "1", "--seed", "7", "--withhold-truth", "--out", str(tmp_path / "small")]
    assert main(command) == 0
    assert "warning: seed 7 can be guessed" in capsys.readouterr().err
    assert "hotel is a public recording" in str(who_knows("hotel", SECRET))
    assert who_knows("sim", SECRET) is None


def test_secret_seeds_are_long_differ_and_are_for_withheld_truth(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert draw_seed() != draw_seed()
    assert draw_seed().bit_length() > GUESSABLE_BITS
    command = ["generate", "sim", "--limit", "1", "--seed", "secret", "--out"]
    assert main([*command, str(tmp_path / "open")]) == 2
    assert "--withhold-truth" in capsys.readouterr().err
    for name in ("a", "b"):
        assert main([*command, str(tmp_path / name), "--withhold-truth"]) == 0
        said = capsys.readouterr()
        assert "warning" not in said.err
        assert "seed withheld" in said.out
    assert DatasetInfo.read(tmp_path / "a").id != DatasetInfo.read(tmp_path / "b").id


def test_interrupted_secret_work_goes_on_with_its_seed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("vbbench.parallel.parts.PATIENCE", -1.0)
    command = ["generate", "sim", "--limit", "1", "--seed", "secret", "--withhold-truth", "--out", str(tmp_path / "a")]
    with monkeypatch.context() as patch:
        patch.setattr("vbbench.generation.datasets.describe_tables", stop)
        with pytest.raises(KeyboardInterrupt):
            main(command)
    seed = json.loads(next(tmp_path.rglob(SEED_FILE)).read_text("utf-8"))["seed"]
    made: list[int] = []
    monkeypatch.setattr("vbbench.generation.datasets._build_part", lambda *_: made.append(1))
    assert main(command) == 0
    assert made == []
    assert json.loads((tmp_path / "a.truth" / SEED_FILE).read_text("utf-8"))["seed"] == seed
    monkeypatch.undo()
    assert main([*command, "--overwrite"]) == 0
    assert json.loads((tmp_path / "a.truth" / SEED_FILE).read_text("utf-8"))["seed"] != seed


def test_a_challenge_has_boards_of_its_own(challenge: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    solve(Dataset(challenge), "cv", "sequential", "answer")
    truth = challenge.with_name("challenge.truth")
    add = ["leaderboard", "add", "answer", "--dataset", str(challenge), "--truth", str(truth), "--results", "board"]
    assert main(add) == 0
    record = json.loads(Path("board/sim/noisy.json").read_text("utf-8"))
    assert (record["id"], record["seed"]) == (Dataset(challenge).info.id, None)
    assert record["tables"]["truth/poses"] == Dataset(challenge).info.truth_tables["poses.parquet"]["sha256"]
    assert main(["leaderboard", "build", "--results", "board", "--out", "site"]) == 0
    assert Dataset(challenge).info.truth_sha256 in Path("site/data/sim/sequential-noisy.js").read_text("utf-8")
    again = score("answer", generate("sim", "told", options()).folder)  # anyone's, once the seed is published
    kept = json.loads(Path("board/sim/sequential-noisy/cv.json").read_text("utf-8"))["score"]
    assert again.values()["metrics"] == kept["metrics"]
