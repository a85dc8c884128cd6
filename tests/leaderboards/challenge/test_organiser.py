"""The parts of the challenge kit: its file, the secret division, the bundle, and the lines that pages show."""

import json
import re
import shlex
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.lib.challenges import SECRET, TEXT, declared, run_lines, vbbench
from tests.lib.made_results import made_results
from vbbench.cli import all_commands, main
from vbbench.cli.parsing import parse
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.scoring import score
from vbbench.version import ON_PYPI
from vbbench_leaderboards.challenge.definition import parse_moment, read_challenge
from vbbench_leaderboards.challenge.organiser import Organiser, parts_of
from vbbench_leaderboards.results.folder import published_results, read_datasets, read_results
from vbbench_leaderboards.site.pages import Site, again_lines, take_part_lines
from vbbench_leaderboards.submitting import add, parse_board, try_solver

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
    words = shlex.split(challenge.data.command("--seed 1", "--out x"))[1:]
    parse(all_commands(), words)
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


@pytest.mark.parametrize("spoil", ["truth", "seed"])
def test_a_bundle_that_would_tell_is_not_made(room: Path, tmp_path: Path, spoil: str, refused: Refused) -> None:
    data, truth = room / "tiny" / "data", room / "tiny" / "data.truth"
    if spoil == "truth":
        shutil.copytree(truth, data / "truth")
    else:
        shutil.rmtree(data)
        generate("sim", data, Options(limit=3, tier="noisy"))
        shutil.rmtree(truth)
        shutil.move(data / "truth", truth)
    assert "is not withheld" in refused("challenge", "bundle", room / "tiny", "--out", tmp_path / "out")
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


def site_of(results: Path) -> Site:
    found = read_results(results)
    return Site(results=found, datasets=read_datasets(results), rankings={}, playable={})


@pytest.mark.slow
def test_lines_on_published_boards_are_commands(tmp_path: Path) -> None:
    for split in ("kitti", "sim"):
        (tmp_path / split).symlink_to(published_results() / split)
    site = site_of(tmp_path)
    for board in site.boards:
        for line in again_lines(site, board):
            program, *words = shlex.split(line)
            assert program == "vbbench"
            parse(all_commands(), [" ".join(words[:2]), *words[2:]])
            assert parse_board(words[words.index("--board") + 1]) == board
    assert take_part_lines(site)[-1] == (
        "vbbench leaderboard try mysolver:MySolver --board sim/sequential-field --out site"
    )


@pytest.mark.slow
def test_lines_on_other_boards_run_as_they_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    dataset = ["generate", "sim", "--tier", "noisy", "--sequences", "3", "--options", "people=4", "--out", "crowd"]
    assert main(dataset) == 0
    assert main(["solve", "crowd", "--solver", "cv", "--protocol", "rollout", "--out", "stranger"]) == 0
    made_results(tmp_path / "published")
    monkeypatch.setattr("vbbench_leaderboards.results.folder.published_results", lambda: tmp_path / "published")
    monkeypatch.setattr("vbbench_leaderboards.submitting.published_results", lambda: tmp_path / "published")
    assert main(["leaderboard", "add", "stranger", "--dataset", "crowd", "--results", "own", "--name", "me"]) == 0
    site = site_of(tmp_path / "own")
    lines = take_part_lines(site)
    assert lines[2].startswith("vbbench generate sim --camera perspective --tier noisy --sequences 3")
    assert again_lines(site, site.first) == lines  # of a solver that nobody else has, no figures can be made again
    run_lines(lines)
    assert Dataset("sim-noisy").info.id == Dataset(tmp_path / "crowd").info.id


@pytest.mark.slow
def test_a_solver_is_tried_in_one_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    options = Options(tier="noisy", limit=4, seed=5)
    monkeypatch.setattr("vbbench_leaderboards.submitting.source", lambda split, tier: _Source(options))
    made = generate("demo", tmp_path / "made", options)
    assert main(["solve", "made", "--solver", "cv", "--protocol", "sequential", "--out", "answer"]) == 0
    add(Path("answer"), made.folder, Path("published"))
    for room in ("results.folder", "submitting"):
        monkeypatch.setattr(f"vbbench_leaderboards.{room}.published_results", lambda: tmp_path / "published")
    assert main(["leaderboard", "template", "."]) == 0
    monkeypatch.syspath_prepend(str(tmp_path))
    capsys.readouterr()
    words = ["leaderboard", "try", "mysolver:MySolver", "--board", "demo/sequential-noisy", "--out", "site"]
    for _ in range(2):  # it may be tried again and again
        assert main(words) == 0
        said = capsys.readouterr().out
        assert said.startswith("MySolver on demo/sequential-noisy: rank ")
        assert "of 2 causal solvers, Δx " in said
    page = (tmp_path / "site" / "data" / "demo" / "sequential-noisy.js").read_text("utf-8")
    assert "MySolver" in page
    guide = Path(__file__).parents[3] / "docs" / "writing-a-solver.md"
    (block,) = re.findall(r"(?ms)^```python\n((?:(?!^```).)*?^class StandStill.*?)^```", guide.read_text("utf-8"))
    Path("still.py").write_text(block, encoding="utf-8")
    assert main([*words[:2], "still:StandStill", *words[3:]]) == 0
    assert re.match(r"StandStill on demo/sequential-noisy: rank \d.* of 3 causal solvers, Δx ", capsys.readouterr().out)
    assert not Path("leaderboards").exists()
    assert main(["leaderboard", "try", "cv", "--board", "demo/sequential-nosy"]) == 2
    assert "did you mean 'demo/sequential-noisy'" in capsys.readouterr().err
    options = Options(tier="noisy", limit=3, seed=5)
    shutil.rmtree(tmp_path / "out")
    assert main(words) == 2
    assert "source files differ" in capsys.readouterr().err


class _Source:
    def __init__(self, options: Options) -> None:
        self._options = options

    def options(self, seed: int) -> Options:
        assert seed == self._options.seed
        return self._options


class Nobody:
    """Does not say who made it."""


def test_a_solver_that_says_nothing_of_itself_is_told_before_anything_is_made(tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match=r"does not say authors, trained_on, tuned_on; its class needs .* facts = "):
        try_solver(f"{__name__}:Nobody", "sim/sequential-field", tmp_path / "work")
    assert not (tmp_path / "work").exists()


def test_a_trial_is_on_a_published_board(made: Path, tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match="no published board is called 'sim/sequential'"):
        try_solver("cv", "sim/sequential", tmp_path)


def test_texts_of_the_template_are_not_handed_out(room: Path, tmp_path: Path, refused: Refused) -> None:
    text = TEXT.replace('"Somebody"', '"Your laboratory"').replace("somebody@", "challenge@")
    (room / "tiny" / "challenge.toml").write_text(text, encoding="utf-8")
    said = refused("challenge", "bundle", room / "tiny", "--out", tmp_path / "out")
    assert "challenge.toml: organisers, contact: as in the template" in said
    assert not (tmp_path / "out").exists()


def test_codabench_gets_an_archive_that_scores(made: Path, tmp_path: Path) -> None:
    assert vbbench("challenge", "bundle", made, "--out", tmp_path / "tiny", "--codabench") == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["tiny", "tiny.codabench.zip"]
    with zipfile.ZipFile(tmp_path / "tiny.codabench.zip") as archive:
        archive.extractall(tmp_path / "there")
    there = tmp_path / "there"
    competition = yaml.safe_load((there / "competition.yaml").read_text("utf-8"))
    assert [task["name"] for task in competition["tasks"]] == ["public part", "hidden part"]
    for phase, (task,) in zip(competition["phases"], ([0], [1]), strict=True):
        assert phase["tasks"] == [task]
        assert (there / competition["tasks"][task]["reference_data"] / "truth").is_dir()
    assert competition["phases"][0]["end"] == "2027-01-01 00:00:00"
    named = [competition["image"], competition["terms"], *(page["file"] for page in competition["pages"])]
    assert all((there / name).is_file() for name in named)
    assert not list(there.rglob("seed.json"))
    installs = (there / "scoring" / "Containerfile").read_text("utf-8")
    assert ("COPY vbbench-*.whl /" in installs) != ON_PYPI
    words = shlex.split(yaml.safe_load((there / "scoring" / "metadata.yaml").read_text("utf-8"))["command"])
    program, *_ = words[1:3][1:]
    (tmp_path / "scores").mkdir()
    folders = [there / "reference-hidden", made.parent / "cv", tmp_path / "scores"]
    subprocess.run([sys.executable, "-m", program, *folders], check=True)
    found = json.loads((tmp_path / "scores" / "scores.json").read_text("utf-8"))
    assert set(found) == {column["key"] for column in competition["leaderboards"][0]["columns"]}
    hidden = score(made.parent / "cv", made / "data", made / "data.truth", sequences=Organiser(made).parts["hidden"])
    assert found["dx"] == pytest.approx(hidden.summaries["dx"].capped)
