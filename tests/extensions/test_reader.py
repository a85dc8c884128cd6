"""A recording format of another package: one reader file and a recipe go from generate to score."""

from pathlib import Path

import numpy as np
import pytest

from tests.extensions import stopwatch_reader
from tests.lib.installing import Install
from vbbench.cli import main
from vbbench.errors import FileError, UnknownNameError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench_generators.recordings.loading import get_reader
from vbbench_generators.recordings.recipe import read_recipe

HERE = Path(__file__).parent
VALUES = "tests.extensions.stopwatch_reader"


@pytest.fixture
def park(install: Install, monkeypatch: pytest.MonkeyPatch) -> None:
    install("vbbench.readers", "stopwatch", f"{VALUES}:stopwatch")
    install("vbbench.generators", "park", f"{VALUES}:park")
    monkeypatch.delitem(stopwatch_reader.park.__dict__, "recipe", raising=False)


def test_it_goes_from_generate_to_score(park: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data, answer = tmp_path / "park", tmp_path / "answer"
    assert main(["generate", "park", "--source", str(HERE), "--tier", "noisy", "--out", str(data)]) == 0
    assert main(["verify", str(data)]) == 0
    assert "8 tables and 5 sequences are as written" in capsys.readouterr().out
    assert main(["solve", str(data), "--solver", "vb-cv", "--protocol", "one-step", "--out", str(answer)]) == 0
    assert main(["score", str(answer), "--dataset", str(data)]) == 0
    assert "park" in capsys.readouterr().out
    definition = DatasetInfo.read(data).definition
    assert (definition["format"], definition["files"][0][0]) == ("stopwatch", "park.csv")
    made = Dataset(data)
    poses = made.truth(made.sequence(0)).poses
    assert np.all(np.hypot(*np.diff(poses[:, :2], axis=0).T) / 0.5 < 2.0)


def test_a_users_own_file_is_recognised_by_its_first_line(
    park: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    own = ["generate", "custom", "--source", str(HERE / "park.csv"), "--dt", "0.5", "--out", str(tmp_path / "own")]
    assert main(own) == 0
    assert "5 sequences" in capsys.readouterr().out
    other = tmp_path / "other.txt"
    other.write_text("when;who;where\n")
    assert main(["generate", "custom", "--source", str(other), "--dt", "0.5", "--out", str(tmp_path / "no")]) == 2
    assert "a header ms;who;east_cm;north_cm" in capsys.readouterr().err


def test_without_its_package_the_recipe_says_which_formats_there_are() -> None:
    with pytest.raises(FileError, match=r"park\.toml: recipe: no reader is registered for format = 'stopwatch'"):
        read_recipe(HERE / "park.toml")
    with pytest.raises(UnknownNameError, match="no recording format is called 'trajnt'; did you mean 'trajnet'"):
        get_reader("trajnt")
    with pytest.raises(VbbenchError, match="no recording format is called"):
        get_reader(f"{VALUES}:stopwatch")
