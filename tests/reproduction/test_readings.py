"""Every reading of the paper: its solver, and recordings scaled and thinned."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vbbench.generation.generator import Options
from vbbench.registry import load, make_solver
from vbbench.reproduction.readings import all_readings
from vbbench.scene import Scene
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_generators.recordings.loading import scale_to_field
from vbbench_generators.recordings.recipe import Rules


def test_there_is_every_reading_once_and_one_is_the_text() -> None:
    axes = ("protocol", "heights", "ego_prior", "scaled", "literal")
    ways = [tuple(one[name] for name in axes) for one in all_readings()]
    assert len(ways) == len(set(ways)) == 2 * 2 * (3 * 2 + 1)
    (text,) = (one for one in all_readings() if one["text"])
    assert (text["protocol"], text["solver"], text["heights"]) == ("sequential", "vb-sf-literal", "prior")
    assert (text["ego_prior"], text["scaled"], text["literal"]) == (False, True, True)


@pytest.mark.parametrize("one", all_readings(), ids=str)
def test_solvers_are_what_the_reading_says(one: dict[str, Any]) -> None:
    solver = make_solver(one["solver"])
    assert isinstance(solver, SocialForceBirdifier)
    assert solver.calibrate == (one["heights"] == "learned")
    assert solver.ego_prior == one["ego_prior"]


def test_a_scaled_recording_fills_its_field_and_keeps_who_stands() -> None:
    places = np.random.default_rng(0).uniform(-3.0, 5.0, (9, 4, 2)) * (1.0, 2.0)
    places[2, 1] = np.nan
    scene = Scene(name="small", dt=0.4, people=np.arange(4), positions=places, heights=np.full(4, 1.7))
    wide = replace(scene, name="wide", positions=3.0 * places + 100.0)
    (one, other), rules = scale_to_field([scene, wide], Rules(standing_displacement=0.4), 8.0)
    assert np.nanmax(np.abs(other.positions)) == pytest.approx(8.0)
    np.testing.assert_allclose(3.0 * one.positions, other.positions, atol=1e-9)
    extent = np.nanmax(wide.positions, axis=(0, 1)) - np.nanmin(wide.positions, axis=(0, 1))
    assert rules.standing_displacement == pytest.approx(0.4 * 16.0 / extent.max())
    np.testing.assert_array_equal(other.heights, scene.heights)


def test_the_papers_splits_have_the_same_sequences_scaled(data_folder: Path) -> None:
    hotel = load("generator", "hotel")
    whole, scaled = (generator.plan(Options()) for generator in (hotel, hotel.scaled(8.0)))
    assert len(whole) == len(scaled) == 340
    assert whole.info.id != scaled.info.id
