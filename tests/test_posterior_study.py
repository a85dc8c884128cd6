"""The study of posteriors: how walking is measured, examples picked, effects estimated, and failures found."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.cli.test_cli import run
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray, IntArray
from vbbench.reproduction.making import Making
from vbbench.reproduction.posterior.claims import CLAIMS
from vbbench.reproduction.posterior.curves_picture import PEOPLE, groups_of
from vbbench.reproduction.posterior.density import find_density, tails_of
from vbbench.reproduction.posterior.effects import (
    FrameSample,
    rank_correlation,
    rank_correlation_at_equal_number,
    slope_at_equal_number,
)
from vbbench.reproduction.posterior.failures import CAUSES, Facts, _apart, facts_of
from vbbench.reproduction.posterior.figure import posterior_report
from vbbench.reproduction.posterior.measuring import PosteriorTable, instants, posterior_rows
from vbbench.reproduction.posterior.study import (
    REPORTED,
    SOLVER,
    Posteriors,
    PosteriorStudy,
    measure_posterior,
    text_reading,
)
from vbbench.reproduction.posterior.walking import (
    WINDOW,
    Walking,
    along_walk,
    directional_spread,
    pick_examples,
    spreads,
)
from vbbench.reproduction.report import write_report
from vbbench.scoring.block_bootstrap import Timeline, block_means
from vbbench.solving.posterior import find_posterior

STUDY = PosteriorStudy(split="demo", every=25)
"""Some five sequences."""


def heading(*degrees: float) -> FloatArray:
    """Velocities [1, K, 2] of 1 m/s."""
    angle = np.radians(degrees)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)[None]


@pytest.mark.parametrize(
    ("velocity", "directions", "lines"),
    [
        (heading(30, 30, 30), 0.0, 0.0),
        (heading(30, 210), 1.0, 0.0),
        (heading(0, 90), 1.0 - np.sqrt(0.5), 1.0),
        (heading(0, 90, 180, 270), 1.0, 1.0),
        (np.concatenate([heading(30, 30), 0.1 * heading(120, 0), heading(90) * np.nan], axis=1), 0.0, 0.0),
    ],
)
def test_spreads_of_directions_and_of_lines(velocity: FloatArray, directions: float, lines: float) -> None:
    spread, of_lines, standing = spreads(velocity)
    assert (spread[0], of_lines[0]) == pytest.approx((directions, lines), abs=1e-12)
    assert standing[0] == pytest.approx(0.5 if velocity.shape[1] == 5 else 0.0)


def test_nobody_who_moves_has_no_spread() -> None:
    spread, _, standing = spreads(np.zeros((1, 3, 2)))
    assert np.isnan(spread[0])
    assert standing[0] == 1.0
    assert np.isnan(directional_spread(np.full((1, 2), np.nan))[0])


def walking(sequence: int, velocity: FloatArray, frames: int = WINDOW + 3) -> Walking:
    """A sequence in which an observer and the people of ``velocity`` [1, K, 2] walk on."""
    spread, lines, standing = (np.repeat(values, frames) for values in spreads(velocity))
    people = np.full(frames, velocity.shape[1] - 1)
    return Walking(
        sequence=sequence,
        frame=np.arange(2, frames + 2),
        people=people,
        spread=spread,
        lines=lines,
        bearings=np.full(frames, 0.5),
        standing=standing,
        arrivals=np.zeros(frames, np.int64),
    )


def test_the_rule_finds_parallel_and_crossing_walks_with_few_and_with_more_people() -> None:
    walks = [
        walking(0, heading(0, 20, 50, 70)),
        walking(1, heading(0, 1, 2, 3)),  # few, parallel
        walking(2, heading(0, 90, 180, 265)),  # few, crossing
        walking(3, heading(0, 180, 0, 180)),  # opposite ways of one line do not cross
        walking(4, heading(0, 0, 1, 2, 3, 4, 5)),  # more, parallel
        walking(5, heading(0, 60, 120, 180, 240, 300, 90)),  # more, crossing
        walking(6, heading(*range(0, 360, 20))),  # too many for a picture
        walking(7, heading(0, 0, 0, 0), frames=WINDOW - 1),  # too short
    ]
    found = pick_examples(walks)
    assert [(one.title, one.sequence) for one in found] == [
        ("3 people, parallel", 1),
        ("3 people, crossing", 2),
        ("5 to 12 people, parallel", 4),
        ("5 to 12 people, crossing", 5),
    ]
    assert found[0].frames == range(2, 2 + WINDOW)
    assert pick_examples(walks[7:]) == []


def test_where_no_stretch_has_three_people_throughout_the_sparsest_counts() -> None:
    mixed = walking(0, heading(0, 10, 20, 30))
    people = np.where(np.arange(len(mixed.people)) % 2, 3, 4)
    found = pick_examples([replace(mixed, people=people)])
    assert [one.title for one in found] == ["3 to 4 people, parallel", "3 to 4 people, crossing"]


def test_pictures_have_the_walk_from_left_to_right() -> None:
    path = np.array([[5.0, 5.0], [6.0, 7.0], [5.0, 9.0]])
    np.testing.assert_allclose(along_walk(path)(path), [[0, 0], [2, -1], [4, 0]], atol=1e-12)


def sample(rng: np.random.Generator, sequences: int = 60, frames: int = 20) -> FrameSample:
    first = 5 * np.arange(sequences)
    timeline = Timeline.of(np.zeros(sequences, np.int64), first, first + frames - 1)
    sequence = np.repeat(np.arange(sequences), frames)
    return FrameSample(sequence=sequence, people=rng.integers(3, 9, sequences * frames), timeline=timeline)


def test_an_effect_of_the_number_alone_is_none_at_equal_number() -> None:
    rng = np.random.default_rng(0)
    frames = sample(rng)
    spread = frames.people + rng.normal(0.0, 1.0, len(frames.people))
    entropy = -2.0 * frames.people + rng.normal(0.0, 1.0, len(frames.people))
    plain = frames.estimate(rank_correlation, spread, entropy)
    equal = frames.estimate(rank_correlation_at_equal_number, spread, entropy)
    assert plain.high < -0.7
    assert equal.low < 0.0 < equal.high
    assert abs(equal.value) < 0.1
    slope = frames.estimate(slope_at_equal_number, spread, entropy + 0.5 * spread)
    assert slope.low < 0.5 < slope.high
    assert slope.value == pytest.approx(0.5, abs=0.1)


def test_ranks_at_equal_number_are_those_of_pandas() -> None:
    rng = np.random.default_rng(1)
    people: IntArray = rng.integers(3, 6, 300)
    one, other = rng.integers(0, 9, (2, 300)).astype(np.float64)
    table = pd.DataFrame({"people": people, "one": one, "other": other})
    ranks = table.groupby("people").rank(pct=True)
    centred = ranks - ranks.groupby(table["people"]).transform("mean")
    assert rank_correlation_at_equal_number(one, other, people) == pytest.approx(centred["one"].corr(centred["other"]))
    assert rank_correlation(one, other, people) == pytest.approx(table["one"].corr(table["other"], method="spearman"))


def test_means_of_groups_are_means_over_sequences() -> None:
    rng = np.random.default_rng(2)
    frames = sample(rng)
    values = rng.normal(size=len(frames.people))
    values[::7] = np.nan
    group = groups_of(frames.people.astype(np.float64), PEOPLE)
    mean, interval = frames.means(values, group, len(PEOPLE))
    table = pd.DataFrame({"sequence": frames.sequence, "group": group, "value": values}).dropna()
    cells = table.groupby(["sequence", "group"])["value"].mean().unstack().reindex(columns=range(len(PEOPLE)))
    np.testing.assert_allclose(mean, cells.mean(), rtol=1e-12)
    np.testing.assert_allclose(interval, block_means(frames.timeline, cells.to_numpy()).interval())


def test_causes_are_found_by_their_rules() -> None:
    calm = Facts(people=9.0, spread=0.5, bearings=0.5, standing=0.0, arrivals=1.0, empty=0)
    having = {"few": {"people": 4.0}, "one side": {"bearings": 0.1}, "parallel": {"spread": 0.01}}
    having |= {"standing": {"standing": 0.3}, "few new": {"arrivals": 0.1}, "gap": {"empty": 2}}
    assert set(having) == set(CAUSES)
    for name, change in having.items():
        facts = replace(calm, **change)
        assert [cause for cause, (_, has) in CAUSES.items() if has(facts)] == [name]
    walk = walking(0, heading(0, 90, 180))
    assert facts_of(walk).people == 2.0
    assert facts_of(walk).bearings == 0.5


def test_failures_on_one_sheet_share_no_frames() -> None:
    rows = {
        "scene": np.array([0, 0, 0, 1]),
        "first_frame": np.array([0, 5, 10, 0]),
        "frames": np.array([10, 10, 10, 9]),
    }
    failures: Any = [SimpleNamespace(sequence=number) for number in (1, 0, 2, 3)]
    dataset: Any = SimpleNamespace(rows=rows)
    assert [one.sequence for one in _apart(dataset, failures)] == [1, 3]
    assert [one.sequence for one in _apart(dataset, failures[1:])] == [0, 2, 3]


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("posterior") / "figure-posterior"


@pytest.fixture(scope="module")
def found(out: Path) -> Posteriors:
    return measure_posterior(STUDY, out)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("demo", tmp_path_factory.mktemp("posterior") / "demo", Options(limit=2))


COLUMNS = ("pose", "gaussian", "place", "yaw", "beyond", "kurtosis", "people", "share", "error")
GOLDEN: dict[str, tuple[float, ...]] = {
    "text": (-8.1517, -8.1258, -3.846, 0.0059, 0.0172, 0.9299, -1.1961, 0.2134, 0.0213),
    SOLVER: (-9.2116, -9.1877, -4.8975, 0.0045, 0.0195, 1.3519, np.nan, 0.0583, 0.0055),
}
"""Means over the frames of the first sequence: entropies and kurtosis to .02, the rest to .003."""


@pytest.mark.slow
@pytest.mark.parametrize("name", GOLDEN)
def test_figures_are_those_of_the_record(dataset: Dataset, name: str) -> None:
    table = PosteriorTable.of_rows(posterior_rows(dataset, text_reading() if name == "text" else name, 0, 1))
    assert table.frame.tolist() == list(range(2, dataset.sequence(0).frames))
    for column, wanted in zip(COLUMNS, GOLDEN[name], strict=True):
        rough = column in ("pose", "gaussian", "place", "kurtosis", "people")
        mean = float(np.mean(getattr(table, column)))
        assert mean == pytest.approx(wanted, abs=0.02 if rough else 0.003, nan_ok=True), column
    assert (table.pose <= table.gaussian + 1e-3).all()  # a normal density has the most entropy


@pytest.mark.parametrize("name", GOLDEN)
def test_finer_grids_change_little(dataset: Dataset, name: str) -> None:
    solver = text_reading() if name == "text" else name
    for instant in instants(dataset, dataset.sequence(0), solver, range(3, 12, 4)):
        source: Any = find_posterior(dataset, 0, instant.frame, solver=solver, protocol="one-step").source
        fine = find_density(source.pose_energy, *instant.density.moments(), points=41)
        assert instant.density.entropy == pytest.approx(fine.entropy, abs=0.01)
        one, other = tails_of(instant.place), tails_of(fine.marginal().finer())
        assert one.kurtosis == pytest.approx(other.kurtosis, abs=0.03)
        assert one.beyond == pytest.approx(other.beyond, abs=1e-3)


@pytest.mark.parametrize(
    ("solver", "message"), [("vb-cv", "no pose_energy"), ("map-batch", "whole sequences"), ("vb-fs", "mean 'vb-sf'")]
)
def test_who_has_no_posterior_says_so(dataset: Dataset, solver: str, message: str) -> None:
    with pytest.raises(VbbenchError, match=message):
        posterior_rows(dataset, solver, 0, 1)


@pytest.mark.slow
def test_the_report_has_every_claim_and_number(found: Posteriors, out: Path) -> None:
    report = posterior_report(found)
    paths = write_report(report, out)
    assert {path.name for path in paths} >= {
        f"figure-posterior{end}" for end in (".md", ".json", ".csv", "-curves.png")
    }
    values = json.loads(report.json)
    assert [len(rows) for rows in values["claims"].values()] == [len(CLAIMS)] * 2
    assert set(values["by_people"]) == {text_reading(), SOLVER, REPORTED}
    table = pd.read_csv(out / "figure-posterior.csv")
    assert len(table) == 2 * values["frames"] == 2 * len(found.sample.people)
    np.testing.assert_allclose(table["pose"][table["solver"] == SOLVER], found.tables[SOLVER].pose)
    for title in ("The paper's claims", "By number of people", "Where it fails", "What the worst have in common"):
        assert title in report.markdown


@pytest.mark.slow
def test_processes_change_nothing(found: Posteriors, out: Path) -> None:
    rows = posterior_rows(Dataset(out / "dataset"), SOLVER, 0, 2)
    again = measure_posterior(STUDY, out, Making(jobs=2)).tables[SOLVER]
    np.testing.assert_array_equal(again.pose, found.tables[SOLVER].pose)
    np.testing.assert_array_equal([row[2] for row in rows], again.pose[: len(rows)])


def test_what_is_never_alike_has_no_effect_and_no_interval() -> None:
    frames = sample(np.random.default_rng(0), sequences=3, frames=2)
    found = frames.estimate(slope_at_equal_number, np.arange(6.0), np.arange(6.0))
    assert np.isnan([found.value, found.low, found.high]).all()


def test_mistakes_are_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(VbbenchError, match="every must be 1 or more"):
        PosteriorStudy(every=0).check()
    status, _, error = run(capsys, "reproduce", "figure-posterior", "--every", "0", "--out", str(tmp_path / "x"))
    assert status == 2
    assert "every must be 1 or more" in error
