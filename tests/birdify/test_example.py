"""``vbbench birdify --example``: a map from what the package holds, as near to the truth as it prints."""

import re
from pathlib import Path

import pytest

from vbbench.birdify.example import birdify_example, errors
from vbbench.cli import main


@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")
def test_the_map_is_near_the_truth(tmp_path: Path) -> None:
    text = birdify_example(tmp_path / "map")
    people, camera = errors(tmp_path / "map")
    assert len(camera) == 201
    assert len(people) > 1000
    assert camera.mean() < 0.25
    assert people.mean() < 0.5
    assert (tmp_path / "map" / "map.png").is_file()
    printed = re.search(r"people are off by ([\d.]+) m on average, the camera by ([\d.]+) m", text)
    assert [float(value) for value in printed.groups()] == pytest.approx([people.mean(), camera.mean()], abs=0.006)


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ([], "name a file of boxes, a film or a bag; or try --example"),
        (["boxes.csv", "--example"], "remove boxes.csv"),
    ],
)
def test_either_a_recording_or_the_example_is_named(
    arguments: list[str], problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["birdify", *arguments]) == 2
    assert problem in capsys.readouterr().err
