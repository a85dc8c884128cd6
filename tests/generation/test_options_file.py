"""Files of options of `vbbench generate`, and datasets that are taken as such."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from vbbench.camera import PanoramaCamera
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.generation.generator import Options, Simulation
from vbbench.generation.options_file import WrittenOptions, parse_people, read_options
from vbbench.generation.planning import planned

SMALL = Simulation(sequences=1, people=(6,))


def made(written: WrittenOptions, split: str) -> Options:
    return written.options(split, source=None, homography=None)


def written_info(folder: Path, split: str, options: Options) -> DatasetInfo:
    """The facts of a dataset of these options, written where a dataset would lie."""
    info = planned(split, options).info
    folder.mkdir(exist_ok=True)
    (folder / INFO_FILE).write_text(info.to_json(), encoding="utf-8")
    return info


@pytest.mark.parametrize(
    ("split", "options"),
    [
        ("sim", Options(simulation=SMALL)),
        ("sim", Options(tier="noisy", noise=2.0, look="natural", height_std=0.05, seed=4, limit=2)),
        ("sim", Options(camera=PanoramaCamera(width=1000), simulation=Simulation(sequences=2, people=(3, 5, 9)))),
        ("sim", Options(tier="field", detector=False, observer="robot", simulation=Simulation(scenario="plaza"))),
        ("street", Options(tier="tracked", least_track=4, observer="vehicle", simulation=SMALL)),
        ("demo", Options(tier="occluded", limit=3, stride=2)),
    ],
)
def test_the_options_of_a_dataset_make_it_again(tmp_path: Path, split: str, options: Options) -> None:
    info = written_info(tmp_path / "d", split, options)
    for place in (tmp_path / "d", tmp_path / "d" / INFO_FILE):
        assert planned(split, made(read_options([str(place)], split), split)).info.id == info.id


def test_keys_of_a_file_are_options(tmp_path: Path) -> None:
    path = tmp_path / "options.toml"
    path.write_text(
        'tier = "noisy"\nnoise = 2\nsigma_h = 0.1\nlook = "sway"\nseed = 3\nsequences = 7\npeople = "4:8:2"\n'
        '[camera]\nkind = "panorama"\nwidth = 1000\n'
    )
    options = made(read_options([str(path)], "sim"), "sim")
    assert options.simulation == Simulation(sequences=7, people=(4, 6, 8))
    assert (options.tier, options.noise, options.height_std, options.look, options.seed) == ("noisy", 2, 0.1, "sway", 3)
    assert options.camera == PanoramaCamera(width=1000)


def test_recordings_are_named_in_a_text_or_a_list(tmp_path: Path) -> None:
    for names in ('"0015, 0019"', '["0015", "0019"]'):
        (tmp_path / "o.toml").write_text(f"sequences = {names}\nevery = 2\ncyclists = true")
        footage = made(read_options([str(tmp_path / "o.toml")], "kitti"), "kitti").footage
        assert (footage.sequences, footage.every, footage.cyclists) == (("0015", "0019"), 2, True)


def test_the_command_line_comes_before_the_file(tmp_path: Path) -> None:
    (tmp_path / "o.toml").write_text('tier = "noisy"\nseed = 3\nlimit = 5')
    asked = ["generate", "demo", "--options", str(tmp_path / "o.toml"), "--seed", "4", "--limit", "1"]
    assert main([*asked, "--out", str(tmp_path / "d")]) == 0
    info = Dataset(tmp_path / "d").info
    assert (info.tier, info.seed, info.counts["sequences"]) == ("noisy", 4, 1)


def test_a_dataset_of_another_split_or_a_secret_seed_is_refused(tmp_path: Path) -> None:
    info = written_info(tmp_path / "d", "demo", Options())
    with pytest.raises(FileError, match="is of the split 'demo', not of sim"):
        read_options([str(tmp_path / "d")], "sim")
    withheld = replace(info, seed=None, withheld_id=info.id)
    (tmp_path / "d" / INFO_FILE).write_text(withheld.to_json(), encoding="utf-8")
    with pytest.raises(FileError, match="its seed is withheld; add --seed"):
        read_options([str(tmp_path / "d")], "demo")
    assert read_options([str(tmp_path / "d")], "demo", seed=5).with_given(seed=5).seed == 5


@pytest.mark.parametrize(
    "facts", [{"definition": {"scenario": {"people": ["x"]}, "look": 3}, "seed": 0}, {"seed": [1]}]
)
def test_a_damaged_dataset_is_refused(tmp_path: Path, facts: dict[str, Any]) -> None:
    (tmp_path / INFO_FILE).write_text(json.dumps({"split": "sim", "tier": "ideal", "height_std": 0.07, **facts}))
    with pytest.raises(FileError, match=r"cannot be 3|wrong type"):
        read_options([str(tmp_path)], "sim")


def test_words_are_options_and_come_before_those_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "o.toml").write_text('noise = 2\nlook = "sway"\nboxes = "found"')
    words = ["noise=0.5", str(tmp_path / "o.toml"), "detector=false", "people=4:8:2", "least-track=4"]
    written = read_options(words, "sim")
    assert (written.noise, written.look, written.detector, written.least_track) == (0.5, "sway", False, 4)
    assert written.boxes == str(tmp_path / "found")
    assert made(written, "sim").simulation == Simulation(people=(4, 6, 8))


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ("nois = 2", r"o.toml: options of generate: unknown key 'nois'; did you mean 'noise'"),
        ('noise = "much"', "noise = 'much' has the wrong type"),
        ('look = "up"', "look cannot be 'up'; known: motion"),
        ('people = "many"', "numbers of people are a number from 2"),
        ('sequences = "all"', "a number of sequences is a whole number"),
        (["peeple=4"], "--options: options of generate: unknown key 'peeple'; did you mean 'people'"),
        (["every=often"], "every = 'often' has the wrong type"),
        (["observer=dog"], "observer cannot be 'dog'; known: walker"),
        (["a.toml", "b.toml"], "takes one file, not a.toml and b.toml"),
    ],
)
def test_wrong_files_and_words_are_refused(tmp_path: Path, asked: str | list[str], message: str) -> None:
    file = tmp_path / "o.toml"
    if isinstance(asked, str):
        file.write_text(asked)
    with pytest.raises(VbbenchError, match=message):
        made(read_options([str(file)] if isinstance(asked, str) else asked, "sim"), "sim")


def test_options_of_single_splits_are_options_of_the_command(tmp_path: Path) -> None:
    short = ["--people", "4:6", "--scenario=plaza", "--observer", "vehicle", "--no-detector"]
    behind = ["--options", "people=4:6", "scenario=plaza", "observer=vehicle", "detector=false"]
    ids = set()
    for words in (short, behind):
        command = ["generate", "sim", *words, "--tier", "field", "--sequences", "2"]
        assert main([*command, "--overwrite", "--out", str(tmp_path / "d")]) == 0
        ids.add(Dataset(tmp_path / "d").info.id)
    assert len(ids) == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--peeple", "4"], "no option of 'generate' is called '--peeple'; did you mean '--people'?"),
        (["--people", "--seed", "1"], "--people: expected one argument"),
        (["--observer", "dog"], "vbbench: --observer: cannot be 'dog'; known: walker, vehicle, robot"),
        (["--boxes", "here"], "--boxes"),
    ],
)
def test_wrong_options_of_single_splits_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert main(["generate", "sim", *words, "--out", str(tmp_path / "d")]) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "counts"), [("30", (30,)), ("3:5", (3, 4, 5)), ("10:50:10", (10, 20, 30, 40, 50)), ("10:25:10", (10, 20))]
)
def test_numbers_of_people(text: str, counts: tuple[int, ...]) -> None:
    assert parse_people(text) == counts


@pytest.mark.parametrize("text", ["1", "0", "5:3", "10:", "a", "10:20:0", "-3", "2:3:4:5", ""])
def test_numbers_of_people_that_cannot_be(text: str) -> None:
    with pytest.raises(VbbenchError, match="numbers of people are a number from 2 to 10,000"):
        parse_people(text)
