"""The study of transfer on made footage: its numbers against scores, taking over what is there, and the command."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.test_cli import run
from tests.kitti_files import write_kitti
from tests.solver_runs import CAMERAS, problem_of, see, walk
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.protocol import get_protocol
from vbbench.registry import load, make_solver
from vbbench.reproduction.making import Making
from vbbench.reproduction.report import shown, write_report
from vbbench.reproduction.transfer.figure import TARGETS, plot_transfer, spoken, transfer_report
from vbbench.reproduction.transfer.study import (
    Case,
    Comparison,
    TransferStudy,
    errors_of,
    measure_transfer,
    people_as_text,
)
from vbbench.reproduction.transfer.variants import Variant, registered_variants
from vbbench.scene import Scene
from vbbench.scoring import score
from vbbench.solver import FrameSolver, Problem
from vbbench.solving.runner import run_sequence
from vbbench_baselines.variants import FACTORIES, Misinformed

CAP = 2.0
"""In m, of both metrics under both protocols."""
NAMES = ("cv", "sf", "vb-cv", "vb-cv-noise-4")


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> TransferStudy:
    training = write_kitti(tmp_path_factory.mktemp("kitti") / "training")
    variants = {name: registered_variants()[name] for name in NAMES}
    return TransferStudy(kitti=training, variants=variants, every=(1,), split="demo", limit=3)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("transfer") / "study"


@pytest.fixture(scope="module")
def found(study: TransferStudy, out: Path) -> list[Comparison]:
    return measure_transfer(study, out)


@pytest.mark.slow
def test_every_case_is_compared(found: list[Comparison]) -> None:
    cases = [(1, protocol, metric) for protocol in ("sequential", "one-step") for metric in ("dx", "dt")]
    assert [tuple(one.case) for one in found] == cases


def test_figures_are_capped_means_of_the_scores(found: list[Comparison], out: Path) -> None:
    folder = out / "kitti-1"
    scored = score(folder / "sequential-vb-cv", folder / "dataset")
    expected = np.minimum(scored.per_sequence.figures["dx"], CAP).mean()
    assert found[0].real.means[NAMES.index("vb-cv")] == pytest.approx(expected)


def test_sequences_are_where_they_were_in_the_recording(found: list[Comparison], out: Path) -> None:
    real, rows = found[0].real.timeline, Dataset(out / "kitti-1" / "dataset").rows
    np.testing.assert_allclose(real.middle, rows["first_frame"] - rows["first_frame"][0] + 0.5 * rows["frames"])


def test_people_between_frames_are_on_a_smooth_curve_and_nobody_is_extrapolated() -> None:
    time = 0.4 * np.arange(8)
    walk = np.column_stack([1.2 * time, 0.3 * time**2])
    places = np.full((8, 2, 2), np.nan)
    places[:, 0], places[[1, 2, 5], 1] = walk, walk[[1, 2, 5]] + 3.0
    scene = Scene(name="two", dt=0.4, people=np.array([4, 7]), positions=places, heights=np.full(2, 1.7))
    rows = np.array([line.split() for line in people_as_text(scene, 0.1).splitlines()], float)
    assert rows[rows[:, 1] == 4][:, 0].tolist() == list(range(29))
    assert rows[rows[:, 1] == 7][:, 0].tolist() == [4, 5, 6, 7, 8]
    first = rows[rows[:, 1] == 4]
    np.testing.assert_allclose(first[:, 2:], np.column_stack([0.12 * first[:, 0], 0.003 * first[:, 0] ** 2]), atol=1e-4)


def test_people_on_smooth_walks_stay_near_where_they_were_recorded() -> None:
    time, clicked = 0.4 * np.arange(30), np.random.default_rng(3).normal(0.0, 0.03, (30, 2))
    walk = np.column_stack([1.2 * time, np.sin(0.4 * time)])
    places = np.full((30, 2, 2), np.nan)
    places[:, 0], places[:4, 1] = walk + clicked, (walk + clicked)[:4]
    scene = Scene(name="two", dt=0.4, people=np.array([4, 7]), positions=places, heights=np.full(2, 1.7))
    rows = np.array([line.split() for line in people_as_text(scene, 0.4, 0.03).splitlines()], float)
    smooth, few = (rows[rows[:, 1] == person][:, 2:] for person in (4, 7))
    assert (np.sqrt(np.mean((smooth - places[:, 0]) ** 2, axis=0)) < 0.0303).all()
    assert np.abs(np.diff(smooth, 2, axis=0)).mean() < 0.3 * np.abs(np.diff(places[:, 0], 2, axis=0)).mean()
    assert np.sqrt(np.mean((smooth - walk) ** 2)) < 0.02
    np.testing.assert_allclose(few, places[:4, 1], atol=1e-4)


@pytest.mark.parametrize("smooth", [-0.1, np.inf, np.nan])
def test_walks_beside_the_recorded_ones_are_a_distance(study: TransferStudy, smooth: float) -> None:
    with pytest.raises(VbbenchError, match="people walk some m beside where they were recorded"):
        replace(study, smooth=smooth).check()


def test_who_goes_astray_counts_as_the_cap(out: Path, found: list[Comparison]) -> None:
    assert found
    folder = out / "kitti-1"
    scored = score(folder / "sequential-cv", folder / "dataset")
    figures = scored.per_sequence.figures
    far = {**figures, "dx": np.where(np.arange(len(figures["dx"])) == 0, 1e5, np.nan)}
    errors = errors_of([scored, replace(scored, per_sequence=replace(scored.per_sequence, figures=far))], "dx")
    assert (errors.values[1] == CAP).all()
    np.testing.assert_array_equal(errors.values[0], np.minimum(figures["dx"], CAP))


@pytest.mark.slow
def test_what_is_there_is_taken_over_and_files_hold_every_number(
    study: TransferStudy, found: list[Comparison], out: Path
) -> None:
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*") if path.is_file()}
    report = transfer_report(study, measure_transfer(study, out))
    printed = shown(report, write_report(report, out))
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert printed.endswith("\n".join(str(out / f"transfer{suffix}") for suffix in (".md", ".json", ".png")))
    assert printed.startswith((out / "transfer.md").read_text("utf-8"))
    values: dict[str, Any] = json.loads((out / "transfer.json").read_text("utf-8"))
    assert list(values["variants"]) == list(NAMES)
    for one, case in zip(found, values["cases"], strict=True):
        assert Case(case["every"], case["protocol"], case["metric"]) == one.case
        assert [case["errors"][name]["kitti"] for name in NAMES] == one.real.means.tolist()
        for name in TARGETS:
            value = getattr(one.agreement, name).value
            assert case[name]["value"] == (None if np.isnan(value) else value)
        assert f"| {spoken(one.case)} | {one.agreement.spearman.value:.2f} [" in printed


@pytest.mark.slow
def test_numbers_do_not_depend_on_the_number_of_processes(
    study: TransferStudy, found: list[Comparison], tmp_path: Path
) -> None:
    few = {name: study.variants[name] for name in NAMES[:3]}
    one = replace(study, variants=few, protocols=("one-step",))
    (dx, _), (same, _) = (measure_transfer(one, tmp_path / str(jobs), Making(jobs=jobs)) for jobs in (1, 2))
    np.testing.assert_array_equal(dx.made.values, same.made.values)
    np.testing.assert_array_equal(dx.real.values, found[2].real.values[:3])
    assert dx.agreement.spearman == same.agreement.spearman


def test_the_picture_has_a_numbered_point_for_every_variant(study: TransferStudy, found: list[Comparison]) -> None:
    figure = plot_transfer(study, found)
    assert [axes.get_label() for axes in figure.axes] == [spoken(one.case) for one in found]
    for axes, one in zip(figure.axes, found, strict=True):
        points = [line for line in axes.lines if line.get_marker() == "o"]
        drawn = [(line.get_xdata()[0], line.get_ydata()[0]) for line in points]  # type: ignore[index]
        np.testing.assert_array_equal(drawn, np.column_stack([one.made.means, one.real.means]))
        assert [text.get_text() for text in axes.texts] == ["1", "2", "3", "4"]
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    key = [text.get_text() for text in figure.texts]
    assert {f"{n}  {name}" for n, name in enumerate(NAMES, 1)} <= set(key)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"every": (0,)}, "every must be 1 to 1,000, not 0"),
        ({"protocols": ("onestep",)}, "onestep"),
        ({"variants": {"cv": Variant(solver="cv")}}, "1 solvers have no ranks to compare"),
        ({"variants": {name: Variant(solver=name) for name in ("cv", "sf", "vb-fs")}}, "did you mean 'vb-sf'"),
    ],
)
def test_mistakes_are_found_before_anything_is_made(
    study: TransferStudy, changes: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(VbbenchError, match=message):
        measure_transfer(replace(study, **changes), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_there_are_enough_variants_and_all_of_them_start() -> None:
    variants = registered_variants()
    assert len(variants) >= 20
    assert sum(variant.feet for variant in variants.values()) >= 5
    assert sum(not variant.feet for variant in variants.values()) >= 15
    for variant in variants.values():
        assert hasattr(make_solver(variant.solver), "step") or hasattr(make_solver(variant.solver), "solve")


def test_no_two_variants_are_the_same() -> None:
    made = [str(vars(factory())) + type(factory()).__name__ for factory in FACTORIES.values()]
    assert len(set(made)) == len(made)


def test_answers_of_variants_with_feet_alone_follow_their_rows() -> None:
    """Rows say nothing to the others: boxes 20 px lower have the same answers."""
    sequence = see(walk(0), CAMERAS[0], 1.0)
    lower = replace(sequence, observations=sequence.observations + np.array([0.0, 20.0, 0.0]))
    problem, protocol = problem_of(sequence, CAMERAS[0], 1.0), get_protocol("sequential")
    for name, variant in registered_variants().items():
        answers = [run_sequence(make_solver(variant.solver), problem, s, protocol, None)[0] for s in (sequence, lower)]
        same = np.allclose(answers[0].positions, answers[1].positions, rtol=0.0, atol=1e-6, equal_nan=True)
        assert same != variant.feet, name


def test_an_unknown_variant_is_named() -> None:
    with pytest.raises(VbbenchError, match="no variant is called map-casual"):
        load("solver", "vbbench_baselines.variants:map-casual")


class Listening:
    """Remembers the noise that it was told."""

    told = 0.0

    def start(self, problem: Problem) -> None:
        self.told = problem.pixel_std

    step = None


def test_noise_is_told_otherwise(study: TransferStudy, out: Path, found: list[Comparison]) -> None:
    assert found
    dataset = Dataset(out / "kitti-1" / "dataset")
    problem, listening = dataset.problem(dataset.sequence(0)), Listening()
    solver: Any = listening
    Misinformed(solver, 4.0).start(problem)
    assert listening.told == 4.0 * problem.pixel_std == 8.0
    assert isinstance(Misinformed(solver, 4.0), FrameSolver)


def test_command_line(study: TransferStudy, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "transfer"
    arguments = ["reproduce", "transfer", "--kitti", study.kitti, "--out", out, "--every", 0]
    status, printed, complaint = run(capsys, *arguments)
    assert (status, printed) == (2, "")
    assert "every must be 1 to 1,000, not 0" in complaint
    status, _, complaint = run(capsys, *arguments[:4], "--out", out, "--solver", "vb-fs")
    assert status == 2
    assert "did you mean 'vb-sf'" in complaint
    assert not out.exists()
