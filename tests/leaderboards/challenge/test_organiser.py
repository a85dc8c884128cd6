"""The parts of the challenge kit: its file, the secret division, and the bundle."""

import json
import re
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.lib.challenges import SECRET, TEXT, declared, vbbench
from tests.lib.commands import understood
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench_leaderboards.challenge.definition import parse_moment, read_challenge
from vbbench_leaderboards.challenge.organiser import Organiser, parts_of
from vbbench_leaderboards.submitting import add

Refused = Callable[..., str]

MISTAKES = {
    "unknown key": ('title = "A tiny', 'titel = "A tiny', "unknown key 'titel'; did you mean 'title'?"),
    "missing key": ('licence = "CC BY 4.0"\n', "", "key 'licence' is missing"),
    "empty": ('organisers = "Somebody"', 'organisers = " "', "organisers is empty"),
    "a name for no folder": ('name = "tiny"', 'name = "../tiny"', "name = '../tiny': up to 40 small letters"),
    "protocol": ('protocol = "sequential"', 'protocol = "sequentiel"', "did you mean 'sequential'"),
    "one-step gives truth away": ('protocol = "sequential"', 'protocol = "one-step"', "protocol"),
    "a day as text": ("start = 2026-12-01", 'start = "2026-12-01"', "a day, YYYY-MM-DD without quotation marks"),
    "a day with a time": ("start = 2026-12-01", "start = 2026-12-01T00:00:00Z", "start = datetime"),
    "the wrong way round": ("end = 2026-12-31", "end = 2026-11-01", "development: end = 2026-11-01 is before start"),
    "phases overlap": ("start = 2027-02-01", "start = 2026-12-31", "final: start = 2026-12-31 is not after the end"),
    "hidden first": ('part = "public"', 'part = "hidden"', "part = 'hidden' must be the last phase"),
    "a part": ('part = "public"', 'part = "publik"', "did you mean 'public'"),
    "none allowed": ("submissions = 3", "submissions = 0", "development: submissions = 0"),
    "a team twice": ('name = "cheat"', 'name = "Honest"', "[[teams]] name = 'honest' stands there twice"),
    "a team's name": ('name = "cheat"', 'name = "a/b"', "[[teams]] name = 'a/b'"),
    "share": ('tier = "noisy"', 'tier = "noisy"\npublic_share = 1.0', "[data] public_share = 1"),
    "the seed is ours": ("--options people=4:6", "--seed 1", "[data] options: --seed is decided by the challenge"),
    "the seed is ours in a word": ("people=4:6", "seed=1", "[data] options: seed=1 is decided by the challenge"),
    "quotes": ("people=4:6", "people='4", "[data] options cannot be read"),
    "address": ('name = "tiny"', 'name = "tiny"\nbundle = "ftp:x"', "bundle = 'ftp:x' is not an address"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_in_the_file_are_named_with_file_and_key(name: str, tmp_path: Path) -> None:
    old, new, words = MISTAKES[name]
    assert old in TEXT
    (tmp_path / "challenge.toml").write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(FileError, match=re.escape(words)) as caught:
        read_challenge(tmp_path)
    assert str(caught.value).startswith(str(tmp_path / "challenge.toml"))


def test_the_starting_file_is_one_and_overwrites_nothing(tmp_path: Path, refused: Refused) -> None:
    assert vbbench("challenge", "new", tmp_path / "mine") == 0
    challenge = read_challenge(tmp_path / "mine")
    assert [phase.part for phase in challenge.phases] == ["public", "hidden"]
    understood(challenge.data.command("--seed 1", "--out x").removeprefix("vbbench "))
    (tmp_path / "mine" / "challenge.toml").write_text(TEXT, encoding="utf-8")
    assert "exists and may be yours" in refused("challenge", "new", tmp_path / "mine")


def test_options_that_cannot_be_are_told_with_the_file(tmp_path: Path, refused: Refused) -> None:
    (tmp_path / "challenge.toml").write_text(TEXT.replace("people", "peeple"), encoding="utf-8")
    said = refused("challenge", "generate", tmp_path)
    assert "challenge.toml: [data]: --options: options of generate: unknown key 'peeple'" in said
    assert not (tmp_path / "data").exists()


def test_days_are_whole_and_in_utc() -> None:
    assert parse_moment("2027-02-07T23:59") == parse_moment("2027-02-08T00:59+01:00")
    assert parse_moment("2027-02-07").hour == 0
    assert parse_moment("").tzinfo is not None


def test_parts_follow_from_the_secret_alone(made: Path) -> None:
    parts = Organiser(made).parts
    assert sorted([*parts["public"], *parts["hidden"]]) == list(range(12))
    assert len(parts["public"]) == 6
    dataset = Dataset(made / "data", made / "data.truth")
    assert len(parts_of(dataset, 0.25)["public"]) == 3
    assert set(parts_of(dataset, 0.25)["public"]) < set(parts["public"])  # in one order, whatever the share


def test_another_secret_gives_other_parts(made: Path, tmp_path: Path) -> None:
    dataset = Dataset(made / "data", made / "data.truth")
    found = set()
    for n in range(4):
        truth = tmp_path / f"{n}"
        truth.mkdir()
        (truth / "seed.json").write_text(json.dumps({"seed": SECRET + n}), encoding="utf-8")
        dataset.truth_folder = truth
        found.add(tuple(parts_of(dataset, 0.5)["public"].tolist()))
    assert len(found) > 1
    (tmp_path / "0" / "seed.json").write_text(json.dumps({"seed": 7}), encoding="utf-8")
    dataset.truth_folder = tmp_path / "0"
    with pytest.raises(VbbenchError, match="can be guessed"):
        parts_of(dataset, 0.5)


def test_sequences_that_share_a_moment_are_not_parted(made: Path) -> None:
    dataset = Dataset(made / "data", made / "data.truth")
    first = np.array([0, 5, 30, 33, 60, 90, 0, 20, 95, 62, 31, 4], np.int32)
    scene = np.array([0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0], np.int32)
    dataset.rows.update(scene=scene, first_frame=first, frames=np.full(12, 10, np.int32))
    parts = {number: part for part, numbers in parts_of(dataset, 0.5).items() for number in numbers.tolist()}
    for together in ((0, 1, 11), (2, 3, 10), (4, 9), (5, 8)):
        assert len({parts[number] for number in together}) == 1
    dataset.rows.update(scene=0 * scene, first_frame=0 * first)
    with pytest.raises(VbbenchError, match="all sequences share moments of one scene"):
        parts_of(dataset, 0.5)


def test_the_bundle_has_no_truth_and_the_same_bytes_always(made: Path, tmp_path: Path) -> None:
    for name in ("one", "two"):
        assert vbbench("challenge", "bundle", made, "--out", tmp_path / name, "--archive") == 0
    files = {path.relative_to(tmp_path / "one"): path.read_bytes() for path in (tmp_path / "one").rglob("*.*")}
    assert files == {path.relative_to(tmp_path / "two"): path.read_bytes() for path in (tmp_path / "two").rglob("*.*")}
    assert (tmp_path / "one.zip").read_bytes() == (tmp_path / "two.zip").read_bytes()
    assert not any(str(SECRET).encode() in data for data in files.values())
    with zipfile.ZipFile(tmp_path / "one.zip") as archive:
        names = archive.namelist()
    assert {"tiny/README.md", "tiny/RULES.md", "tiny/LICENCE.txt", "tiny/challenge.toml"} < set(names)
    assert "tiny/data/README.md" in names
    assert not any("truth" in name or "seed" in name for name in names)
    verify(tmp_path / "one" / "data", made / "data.truth")


def with_its_truth(tiny: Path) -> None:
    shutil.copytree(tiny / "data.truth", tiny / "data" / "truth")


def with_its_seed(tiny: Path) -> None:
    data, truth = tiny / "data", tiny / "data.truth"
    shutil.rmtree(data)
    generate("sim", data, Options(limit=3, tier="noisy"))
    shutil.rmtree(truth)
    shutil.move(data / "truth", truth)


def with_texts_of_the_template(tiny: Path) -> None:
    text = TEXT.replace('"Somebody"', '"Your laboratory"').replace("somebody@", "challenge@")
    (tiny / "challenge.toml").write_text(text, encoding="utf-8")


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (with_its_truth, "is not withheld"),
        (with_its_seed, "is not withheld"),
        (lambda tiny: shutil.rmtree(tiny / "data"), "the secret set is missing; make it with"),
        (lambda tiny: shutil.rmtree(tiny / "data.truth"), "the secret truth is missing"),
        (
            lambda tiny: (tiny / "challenge.toml").write_text(TEXT.replace('"noisy"', '"ideal"')),
            "[data] is sim ideal, ",
        ),
        (with_texts_of_the_template, "challenge.toml: organisers, contact: as in the template"),
    ],
)
def test_a_bundle_that_must_not_be_handed_out_is_not_made(
    room: Path, tmp_path: Path, spoil: Callable[[Path], None], words: str, refused: Refused
) -> None:
    spoil(room / "tiny")
    assert words in refused("challenge", "bundle", room / "tiny", "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_folder_of_somebody_is_not_replaced(made: Path, tmp_path: Path, refused: Refused) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "work.txt").write_text("years", encoding="utf-8")
    assert "is not a bundle" in refused("challenge", "bundle", made, "--out", tmp_path / "mine")
    assert "may be the only copy" in refused("challenge", "generate", made)


def test_what_a_participant_must_say_is_asked_for(
    room: Path, refused: Refused, capsys: pytest.CaptureFixture[str]
) -> None:
    check = ["challenge", "check", declared(room / "cv", authors="", delay=None), "--challenge", room / "tiny"]
    assert "lacks authors, delay" in refused(*check)
    declared(room / "cv", authors="your name", delay=0)
    assert vbbench(*check) == 0
    assert "but for its authors: say who you are in place of 'your name'" in capsys.readouterr().out


def test_the_library_adds_nothing_to_a_challenge_behind_its_back(made: Path) -> None:
    with pytest.raises(VbbenchError, match="use 'vbbench challenge accept'"):
        add(made.parent / "cv", made / "data", made / "results" / "public", truth=made / "data.truth")
