"""The readings of the paper: what each is, its table, and figures on a few sequences of Hotel."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.test_cli import run
from vbbench.errors import VbbenchError
from vbbench.generation.generator import Options, Plan
from vbbench.generation.planning import thinned
from vbbench.paper import BEST, the_paper
from vbbench.registry import load, make_solver
from vbbench.reproduction.readings import study as readings
from vbbench.reproduction.readings.figure import plot_readings, readings_report, readings_values
from vbbench.reproduction.readings.study import (
    Reading,
    Readings,
    ReadingsStudy,
    all_readings,
    measure_readings,
)
from vbbench.scene import Scene
from vbbench_baselines.social_force_birdifier import SocialForceBirdifier
from vbbench_generators.recordings.eligibility import Rules
from vbbench_generators.recordings.loading import scale_to_field

EVERY = 85
"""Four sequences of Hotel."""


def few() -> tuple[Reading, ...]:
    """As shipped, under the paper's own text, and with known heights."""
    return tuple(
        one
        for one in all_readings()
        if one.is_text or (one.heights, one.ego_prior, one.scaled) in {("learned", True, False), ("known", True, False)}
    )


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Readings:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(readings, "all_readings", few)
        return measure_readings(ReadingsStudy(splits=("hotel",), every=EVERY), tmp_path_factory.mktemp("readings"))


@pytest.fixture
def found(data_folder: Path, request: pytest.FixtureRequest) -> Readings:
    """What was measured, once for all tests, if there are recordings."""
    answer: Readings = request.getfixturevalue("measured")
    return answer


def test_there_is_every_reading_once_and_one_is_the_text() -> None:
    ways = [(one.protocol, one.heights, one.ego_prior, one.scaled, one.literal) for one in all_readings()]
    assert len(ways) == len(set(ways)) == 2 * 2 * (3 * 2 + 1)
    (text,) = (one for one in all_readings() if one.is_text)
    assert text == Reading(
        protocol="sequential", solver="vb-sf-literal", heights="prior", ego_prior=False, scaled=True, literal=True
    )


@pytest.mark.parametrize("one", all_readings(), ids=str)
def test_solvers_are_what_the_reading_says(one: Reading) -> None:
    solver = make_solver(one.solver)
    assert isinstance(solver, SocialForceBirdifier)
    assert solver.calibrate == (one.heights == "learned")
    assert solver.ego_prior == one.ego_prior


@pytest.mark.slow
def test_figures_on_hotel(found: Readings) -> None:
    """Golden: Δx in m over sequences."""
    measured = {(row.reading.protocol, row.reading.heights): row.summaries["hotel"]["dx"].mean for row in found.rows}
    assert measured == pytest.approx(
        {
            ("one-step", "learned"): 0.04518,
            ("one-step", "known"): 0.04518,
            ("sequential", "learned"): 0.12046,
            ("sequential", "known"): 0.13589,
            ("sequential", "prior"): 0.32765,
        },
        rel=0.02,
    )
    assert measured["one-step", "learned"] < the_paper().figures("hotel", BEST)["dx"] < measured["sequential", "known"]


def test_the_table_has_a_row_a_reading(found: Readings) -> None:
    table = readings_report(found).markdown
    rows = [line.split("|") for line in table.splitlines() if line.startswith("|")]
    assert len(rows) == 3 + len(few())
    assert {len(cells) for cells in rows} == {len(rows[0])}
    assert "| the paper | | | | VB-SF | 0.052 | 1 |" in table
    assert "every 85th sequence (hotel 4)" in table
    (text,) = (line for line in table.splitlines() if "scaled | `vb-sf-literal`" in line)
    own = found.rows[-1].summaries["hotel"]["dx"]
    times = f"{own.mean / 0.052:.2f} / {own.frame_mean / 0.052:.2f}"
    assert text.endswith(f" | {own.mean:.3f} / {own.frame_mean:.3f} | {times} |")


def test_json_has_every_figure(found: Readings) -> None:
    values = json.loads(json.dumps(readings_values(found)))
    assert values["sequences"] == {"hotel": 4}
    assert values["paper"]["hotel"]["dx"] == 0.052
    assert [row["text"] for row in values["readings"]] == [False] * 4 + [True]
    for row, shown in zip(found.rows, values["readings"], strict=True):
        assert shown["solver"] == row.reading.solver
        for metric in ("dx_rel", "dx", "dr", "dt"):
            assert shown["figures"]["hotel"][metric]["mean"] == row.summaries["hotel"][metric].mean


def test_the_picture_has_a_point_a_reading_and_the_papers_line(found: Readings) -> None:
    (axes,) = plot_readings(found).axes
    paper, frames, sequences = axes.lines[:3]
    np.testing.assert_array_equal(paper.get_xdata(), [0.052, 0.052])
    own = [row.summaries["hotel"]["dx"] for row in found.rows]
    np.testing.assert_array_equal(frames.get_xdata(), [s.frame_mean for s in own])
    np.testing.assert_array_equal(sequences.get_xdata(), [s.mean for s in own])
    assert len(axes.get_yticklabels()) == len(own)


@pytest.mark.slow
def test_the_command_takes_over_what_is_there(
    data_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(readings, "all_readings", lambda: few()[-1:])
    command = ["reproduce", "readings", "--split", "hotel", "--every", EVERY, "--out", tmp_path / "out"]
    status, printed, _ = run(capsys, *command)
    assert status == 0
    assert printed.startswith((tmp_path / "out" / "readings.md").read_text("utf-8"))
    assert (tmp_path / "out" / "readings.png").read_bytes()[:4] == b"\x89PNG"
    made = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.parquet")}
    status, printed, _ = run(capsys, *command, "--json")
    assert status == 0
    assert json.loads(printed) == json.loads((tmp_path / "out" / "readings.json").read_text("utf-8"))
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.parquet")} == made
    status, _, said = run(capsys, *command[:-4], "--every", 170, "--out", tmp_path / "out")
    assert status == 2
    assert "wanted is" in said


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"splits": ("hotle",)}, "did you mean 'hotel'"),
        ({"splits": ()}, "name a split of hotel, eth, students"),
        ({"every": 0}, "every must be 1 or more, not 0"),
    ],
)
def test_mistakes_are_found_before_anything_is_made(changes: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match=message):
        measure_readings(replace(ReadingsStudy(), **changes), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_every_other_sequence_is_as_it_was(data_folder: Path) -> None:
    whole: Plan = load("generator", "hotel").plan(Options(limit=5))
    some = thinned(whole, 2)
    assert thinned(whole, 1) is whole
    assert len(some) == 3
    assert some.info.id != whole.info.id
    for index in range(3):
        own, there = some.build(index).sequence, whole.build(2 * index).sequence
        assert own.index == index
        np.testing.assert_array_equal(own.observations, there.observations)
        np.testing.assert_array_equal(own.given.positions, there.given.positions)


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
