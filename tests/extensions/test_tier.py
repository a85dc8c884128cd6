"""A tier of another package goes from generate to score, and its datasets outlive the package."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.lib.installing import Install
from vbbench.cli import main
from vbbench.errors import FileError, UnknownNameError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.datasets import stream
from vbbench.generation.generator import Options, Simulation
from vbbench.generation.tier import all_tiers, get_tier
from vbbench_leaderboards.results.result import Board
from vbbench_leaderboards.site import words

VALUE = "tests.extensions.fragmented_tier:fragmented"
BUNDLED = ["field", "ideal", "noisy", "occluded", "tracked"]
SMALL = Options(tier="fragmented", limit=2, simulation=Simulation(people=(6,)))


@pytest.fixture
def fragmented(install: Install) -> Install:
    install("vbbench.tiers", "fragmented", VALUE)
    return install


def test_it_goes_from_generate_to_score(
    fragmented: Install, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data, answer = tmp_path / "data", tmp_path / "answer"
    assert main(["generate", "demo", "--tier", "fragmented", "--limit", "3", "--out", str(data)]) == 0
    assert main(["verify", str(data)]) == 0
    assert "8 tables and 3 sequences are as written" in capsys.readouterr().out
    assert main(["info", str(data)]) == 0
    assert "tier fragmented (0.25 px)" in capsys.readouterr().out
    for protocol in ("one-step", "sequential"):
        solving = ["solve", str(data), "--solver", "vb-cv", "--protocol", protocol]
        assert main([*solving, "--out", str(answer), "--overwrite"]) == 0
        assert main(["score", str(answer), "--dataset", str(data)]) == 0
        assert "fragmented" in capsys.readouterr().out
    sequence = Dataset(data).sequence(0)
    assert sequence.observed.sum(axis=0).max() <= 6
    assert DatasetInfo.read(data).definition["fragments"] == {"life": 6, "missed": 0.1}


def test_it_is_listed_wherever_tiers_are(
    fragmented: Install, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert [tier.name for tier in all_tiers()] == [*BUNDLED, "fragmented"]
    assert main(["tiers"]) == 0
    listed = capsys.readouterr().out
    assert all(f"{tier.name}: " in listed for tier in all_tiers())
    words.tiers.cache_clear()
    assert words.term_of(words.tiers(), "fragmented").meaning.startswith("People are lost every six frames")
    words.tiers.cache_clear()


def test_a_split_whose_people_hide_one_another_hides_them_from_it(fragmented: Install, tmp_path: Path) -> None:
    crowded, open_ground = (generate(split, tmp_path / split, SMALL) for split in ("street", "sim"))
    assert crowded.info.definition["hiding"]["cut"] is False
    assert crowded.info.definition["input"] == "cline"
    assert "hiding" not in open_ground.info.definition
    assert len(verify(crowded.folder)) > 0


def test_its_datasets_are_read_where_it_is_not_installed(install: Install, tmp_path: Path) -> None:
    package = install("vbbench.tiers", "fragmented", VALUE)
    made = generate("sim", tmp_path / "sim", SMALL)
    persons = made.track_persons(made.sequence(1))
    package.remove()
    assert "8 tables and 2 sequences are as written" in verify(made.folder)
    again = Dataset(made.folder)
    np.testing.assert_array_equal(again.track_persons(again.sequence(1)), persons)
    for make in (lambda: generate("sim", tmp_path / "two", SMALL), lambda: next(stream("sim", SMALL))):
        with pytest.raises(UnknownNameError, match="no tier is called 'fragmented'; known: field, ideal"):
            make()
    assert words.term_of(words.tiers(), "fragmented").full == "fragmented"
    assert Board(split="sim", tier="fragmented", protocol="one-step").key == "sim/one-step-fragmented"


def test_a_dataset_imports_nothing_that_it_names(tmp_path: Path) -> None:
    made = generate("sim", tmp_path / "sim", Options(limit=1, simulation=Simulation(people=(6,))))
    path, trap = made.folder / "dataset.json", "tests.extensions.trap:tier"
    values = json.loads(path.read_text("utf-8"))
    path.write_text(json.dumps({**values, "tier": trap}), encoding="utf-8")
    with pytest.raises(FileError, match=r"dataset\.json: .* at `\$\.tier`; generate the dataset again"):
        DatasetInfo.read(made.folder)
    with pytest.raises(UnknownNameError, match=r"no tier is called 'tests\.extensions\.trap:tier'"):
        get_tier(trap)
    with pytest.raises(VbbenchError, match="no tier is called"):
        generate("sim", tmp_path / "other", Options(tier=trap))
    assert "tests.extensions.trap" not in sys.modules


def test_its_own_name_and_that_of_its_registration_are_one(install: Install) -> None:
    install("vbbench.tiers", "broken-up", VALUE)
    with pytest.raises(VbbenchError, match="tier 'broken-up' calls itself 'fragmented': register it under that name"):
        get_tier("broken-up")


def test_what_is_not_a_tier_is_refused(install: Install) -> None:
    install("vbbench.tiers", "life", "tests.extensions.fragmented_tier:LIFE")
    with pytest.raises(VbbenchError, match="tier 'life' is 6; register an object of a subclass of Tier"):
        get_tier("life")
