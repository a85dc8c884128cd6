"""Every so many-th sequence of a dataset: the same as in the whole, numbered anew, under an id of its own."""

import json
from pathlib import Path

import numpy as np
import pytest

from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.files.generate_command import generate_command
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.generation.planning import build_sequence, planned, thinned
from vbbench.geometry import world_to_relative
from vbbench.registry import load
from vbbench.reproduction.grid import Making


def test_a_thinned_dataset_holds_every_third_sequence(tmp_path: Path) -> None:
    whole = generate("demo", tmp_path / "whole", Options(limit=8, tier="noisy"))
    part = generate("demo", tmp_path / "part", Options(limit=8, stride=3, tier="noisy"))
    assert len(part) == 3
    assert part.info.id != whole.info.id
    assert "--limit 8 --stride 3" in generate_command(json.loads(part.info.to_json()), "x")
    for index in range(len(part)):
        mine, theirs = part.sequence(index), whole.sequence(3 * index)
        assert mine.index == index
        # the same boxes, whatever their tracks are numbered
        np.testing.assert_array_equal(np.sort(mine.observations, axis=1), np.sort(theirs.observations, axis=1))


def test_a_sequence_in_its_world_is_the_same_under_other_numbers() -> None:
    plan = planned("demo", Options(limit=2))
    scene, own = plan.build(1), build_sequence(plan, 1)
    column = np.searchsorted(scene.sequence.tracks, own.persons[0])
    assert column.tolist() != sorted(column) == list(range(len(column)))
    np.testing.assert_array_equal(own.sequence.observations, scene.sequence.observations[:, column])
    np.testing.assert_allclose(
        world_to_relative(own.truth.positions, own.truth.poses),
        world_to_relative(scene.truth.positions[:, column], scene.truth.poses),
        atol=1e-9,
    )


def test_every_other_sequence_of_a_recording_is_as_it_was(data_folder: Path) -> None:
    whole = load("generator", "hotel").plan(Options(limit=5))
    some = thinned(whole, 2)
    assert thinned(whole, 1) is whole
    assert len(some) == 3
    assert some.info.id != whole.info.id
    for index in range(3):
        own, there = some.build(index).sequence, whole.build(2 * index).sequence
        assert (own.index, own.scene, own.first_frame) == (index, there.scene, there.first_frame)
        np.testing.assert_array_equal(own.observations, there.observations)
        np.testing.assert_array_equal(own.given.positions, there.given.positions)


def test_footage_and_strides_that_are_none_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(VbbenchError, match="stride"):
        Options(stride=1)
    assert main(["generate", "demo", "--options", "stride=1", "--out", str(tmp_path / "x")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_dataset_of_every_third_sequence_is_used_again(tmp_path: Path) -> None:
    options = Options(limit=8, stride=3)
    made = Making().dataset("demo", tmp_path / "part", options)
    assert Making().dataset("demo", tmp_path / "part", options).info.id == made.info.id
    with pytest.raises(VbbenchError, match="choose another folder"):
        Making().dataset("demo", tmp_path / "part", Options(limit=8))
