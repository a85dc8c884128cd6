"""Studies on their grid: golden figures, taking over what exists, files, mistakes, and the commands."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.cli.test_cli import run
from tests.lib.kitti_files import Drive, write_kitti
from vbbench.errors import VbbenchError
from vbbench.paper import BEST, COLUMNS, PROTOCOLS, SIGMA_H, SPLITS, the_paper
from vbbench.reproduction import readings, robot
from vbbench.reproduction.grid import Making, Row, Study, row_at, rows_at
from vbbench.reproduction.keypoints import KeypointsStudy
from vbbench.reproduction.posterior import PosteriorStudy
from vbbench.reproduction.readings import ReadingsStudy
from vbbench.reproduction.report import Report, shown, write_report
from vbbench.reproduction.robot import RobotStudy, default_entrants
from vbbench.reproduction.sigma import PANELS, SigmaStudy
from vbbench.reproduction.solver_tables import SolverTableStudy, Table4Study
from vbbench.reproduction.table1 import Table1Study
from vbbench.reproduction.trajectories import TrajectoriesStudy
from vbbench.reproduction.transfer import TARGETS, TransferStudy
from vbbench.reproduction.variants import Variant, registered_variants
from vbbench.scoring import score

NAMES = ("cv", "sf", "vb-cv", "vb-cv-noise-4")
HOTEL = SolverTableStudy(table=2, splits=("hotel",), solvers=("cv", "vb-sf", "vb-sf-literal", "map-causal"), every=60)
DEMO = SolverTableStudy(table=2, splits=("demo",), solvers=("cv", "vb-cv", "map-causal", "map-batch"), every=16)
TABLE4 = Table4Study(solvers=("vb-cv",), jitter=(0.0, 2.0), sequences=1)
SIGMA = SigmaStudy(sequences=10, sigmas=(0.0, 0.07), people=(8, 12))
SMALL = SigmaStudy(sequences=2, sigmas=(0.07,), people=(8, 12), solvers=("vb-cv",))
KEYPOINTS = KeypointsStudy(
    distances=(2.0, 6.0, 20.0),
    trials=12,
    splits=("demo", "hotel"),
    solvers=("vb-cv",),
    tiers=("noisy",),
    protocols=("one-step",),
    every=4,
)


def few() -> list[Row]:
    """As ``vb-sf`` is, the paper's own text, and with known heights."""
    kept = {("learned", True, False), ("known", True, False)}
    return [
        one
        for one in readings.all_readings()
        if one["text"] or (one["heights"], one["ego_prior"], one["scaled"]) in kept
    ]


STUDIES: dict[str, Callable[[Path], Study]] = {
    "demo": lambda kitti: DEMO,
    "hotel": lambda kitti: HOTEL,
    "table4": lambda kitti: TABLE4,
    "sigma": lambda kitti: SIGMA,
    "keypoints": lambda kitti: KEYPOINTS,
    "readings": lambda kitti: ReadingsStudy(splits=("hotel",), every=85),
    "trajectories": lambda kitti: TrajectoriesStudy(splits=("demo",)),
    "posterior": lambda kitti: PosteriorStudy(split="demo", every=25),
    "robot": lambda kitti: RobotStudy(kitti=kitti, poses=kitti / "poses", sequences=1),
    "transfer": lambda kitti: TransferStudy(
        kitti=kitti / "training",
        variants={name: registered_variants()[name] for name in NAMES},
        every=1,
        split="demo",
        sequences=3,
    ),
}
PICTURES = {"robot": ("simulated", "kitti"), **dict.fromkeys(("demo", "hotel", "table4", "readings"), ())}
NEEDS_RECORDINGS = ("hotel", "readings")


@pytest.fixture(scope="module")
def kitti(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A made drive of 48 m, whose stereo poses drift away by 1.5 m."""
    folder, drifting = tmp_path_factory.mktemp("kitti"), Drive()
    drifting.motions[:, :2, 3] += np.linspace(0.0, 1.5, len(drifting.motions))[:, None] * [0.6, 0.8]
    write_kitti(folder / "training", oxts=drifting.oxts())
    return folder


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("studies")


class Runs:
    """Every study is measured once, with Table 2 of the demo and fewer readings."""

    def __init__(self, out: Path, kitti: Path) -> None:
        self.out, self.kitti = out, kitti
        self.reports: dict[str, Report] = {}

    def again(self, name: str, jobs: int = 1) -> Report:
        kept = few()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(readings, "all_readings", lambda: kept)
            patch.setattr(robot, "SCENARIO", "plaza")
            if name == "demo":
                patch.setitem(SPLITS, 2, ("demo",))
            if name == "keypoints":
                patch.setenv("XDG_CACHE_HOME", str(self.out / "cache"))
                patch.setenv("VBBENCH_DATA", str(self.out / "data"))
            return STUDIES[name](self.kitti).run(self.out / name, Making(jobs=jobs))

    def report(self, name: str) -> Report:
        if name not in self.reports:
            self.reports[name] = self.again(name)
        return self.reports[name]


@pytest.fixture(scope="module")
def runs(out: Path, kitti: Path) -> Runs:
    return Runs(out, kitti)


@pytest.fixture
def report(runs: Runs, request: pytest.FixtureRequest) -> Report:
    if request.param in NEEDS_RECORDINGS:
        request.getfixturevalue("data_folder")
    return runs.report(request.param)


def dx(rows: list[Row], axes: tuple[str, ...], field: str = "frame_mean", **at: Any) -> dict[Any, float]:
    return {tuple(row[axis] for axis in axes): getattr(row["figures"]["dx"], field) for row in rows_at(rows, **at)}


def of(*names: str) -> Any:
    """The reports of studies, one a test."""
    return pytest.mark.parametrize("report", names, indirect=True)


@of("demo")
def test_figures_on_the_demo(report: Report) -> None:
    """Golden: Δx in m over frames with heights known and unknown."""
    golden = {
        ("one-step", "cv"): (0.03157, 0.03157),
        ("one-step", "vb-cv"): (0.01585, 0.01585),
        ("one-step", "map-causal"): (0.00635, 0.00635),
        ("one-step", "map-batch"): (0.00657, 0.00656),
        ("sequential", "cv"): (1.9214, 1.9214),
        ("sequential", "vb-cv"): (0.03948, 0.09352),
        ("sequential", "map-causal"): (0.00839, 0.00847),
        ("sequential", "map-batch"): (0.003439, 0.003425),
    }
    rows = report.values["rows"]
    for n, sigma_h in enumerate((0.0, SIGMA_H)):
        found = dx(rows, ("protocol", "solver"), sigma_h=sigma_h)
        assert found == pytest.approx({at: figures[n] for at, figures in golden.items()}, rel=0.02, abs=2e-5)
    places = [(row["protocol"], row["sigma_h"], row["solver"]) for row in rows]
    assert places == [(p, s, solver) for p in PROTOCOLS for s in (0.0, SIGMA_H) for solver in DEMO.solvers]


@pytest.mark.slow
@of("hotel")
def test_figures_on_hotel(report: Report) -> None:
    """Golden: Δx in m over frames, and by how many times it is the paper's."""
    rows = report.values["rows"]
    assert dx(rows, ("protocol", "solver"), sigma_h=SIGMA_H) == pytest.approx(
        {
            ("one-step", "cv"): 0.08524,
            ("one-step", "vb-sf"): 0.04147,
            ("one-step", "vb-sf-literal"): 0.08173,
            ("one-step", "map-causal"): 0.03310,
            ("sequential", "cv"): 0.46999,
            ("sequential", "vb-sf"): 0.14853,
            ("sequential", "vb-sf-literal"): 0.34080,
            ("sequential", "map-causal"): 0.07679,
        },
        rel=0.02,
    )
    row = row_at(rows, protocol="sequential", sigma_h=SIGMA_H, solver="vb-sf-literal")
    assert row["times_the_paper"]["dx"] == pytest.approx(row["figures"]["dx"].frame_mean / 0.052)
    own = row_at(rows, protocol="one-step", sigma_h=SIGMA_H, solver="vb-sf")["figures"]
    printed = the_paper().figures("hotel", "VB-SF")
    summaries = [(own[metric], printed[metric]) for metric in COLUMNS]
    cells = [f"{s.frame_mean:.4f} ± {s.frame_std:.4f} ({s.frame_mean / one:.2f})" for s, one in summaries]
    assert f"| one-step | 0.07 | `vb-sf` | {' | '.join(cells)} |" in report.markdown
    assert "| the paper | 0.07 | VB-SF | 0.049 | 0.052 | 0.016 | 0.062 |" in report.markdown


@pytest.mark.slow
@of("table4")
def test_figures_of_table4(report: Report) -> None:
    """Golden: means of vb-cv, one-step, on the first sequence: Δx̃, Δx, Δr, Δt."""
    golden = {
        "cline-0px": (0.000489, 0.000693, 0.000426, 0.00138),
        "cline-2px": (0.036545, 0.034889, 0.000995, 0.003315),
        "tracked-4": (0.097721, 0.096787, 0.003986, 0.002516),
    }
    for name, figures in golden.items():
        own = row_at(report.values["rows"], protocol="one-step", input=name)["figures"]
        assert [own[metric].mean for metric in COLUMNS] == pytest.approx(figures, rel=0.02, abs=2e-5), name
    assert "| the paper | | by hand | 1.11 | 1.08 | 1.07 | 1.04 |" in report.markdown
    exact, rough = (row_at(report.values["ratios"], protocol="one-step", jitter=jitter) for jitter in (0.0, 2.0))
    assert exact["tracked"]["dx"]["sequences"] > 10.0 > rough["tracked"]["dx"]["sequences"] > 1.0


@pytest.mark.slow
@of("readings")
def test_figures_of_readings(report: Report) -> None:
    """Golden: Δx in m over sequences."""
    found = {(one["protocol"], one["heights"]): one["figures"]["hotel"]["dx"].mean for one in report.values["readings"]}
    assert found == pytest.approx(
        {
            ("one-step", "learned"): 0.04518,
            ("one-step", "known"): 0.04518,
            ("sequential", "learned"): 0.12046,
            ("sequential", "known"): 0.13589,
            ("sequential", "prior"): 0.32765,
        },
        rel=0.02,
    )
    assert found["one-step", "learned"] < the_paper().figures("hotel", BEST)["dx"] < found["sequential", "known"]
    own = report.values["readings"][-1]["figures"]["hotel"]["dx"]
    times = f"{own.mean / 0.052:.2f} / {own.frame_mean / 0.052:.2f}"
    assert f"scaled | `vb-sf-literal` | {own.mean:.3f} / {own.frame_mean:.3f} | {times} |" in report.markdown


@pytest.mark.slow
@of("keypoints")
def test_figures_of_static_points(report: Report) -> None:
    """Golden: mean errors in m of 12 trials at 2, 6 and 20 m; OpenCV's versions may differ in which sample is best."""
    means = report.values["translation"]["mean"]
    np.testing.assert_allclose(means, (0.0235, 0.0584, 0.264), rtol=0.1)
    assert report.values["unanswered"] == 0
    assert [row[1] for row in report.tables[0].rows] == [f"{one:.3f}" for one in means]
    hotel, car = report.values["missing"]
    assert "vbbench fetch hotel" in hotel
    assert "kitti, footage: " in car
    assert report.facts[-1].splitlines() == [f"- missing: {hotel}", f"- missing: {car}"]


@of("trajectories")
def test_errors_of_an_example(report: Report) -> None:
    """Golden: sequence 61 of demo, sequential, to 5 %."""
    (example,) = report.values["examples"]
    assert [example[name] for name in ("split", "sequence", "frames", "people")] == ["demo", 61, 18, 26]
    errors = [example["errors"][name] for name in ("dx_rel", "dx", "dr", "dt")]
    assert errors == pytest.approx([0.0260, 0.0250, 0.00359, 0.0397], rel=0.05)


@pytest.mark.slow
@of("robot")
def test_figures_of_the_simulated_robot(report: Report) -> None:
    """Golden: mean drift over 5 and 10 m, and Δx̃ in m; odometry and who has it drift least."""
    simulated, car = report.values["recordings"]
    paper, alone, both = (entrant.title for entrant in default_entrants())
    reference, *solved = [row for row in simulated["rows"] if row["protocol"] in (None, "sequential")]
    drifts = {row["way"]: [one["mean"] for one in row["drift"][:2]] for row in (reference, *solved)}
    assert drifts == {
        reference["way"]: pytest.approx([0.01645, 0.01607], rel=0.02),
        paper: pytest.approx([0.6307, 0.6880], rel=0.05),
        alone: pytest.approx([0.0620, 0.0377], rel=0.05),
        both: pytest.approx([0.01370, 0.01150], rel=0.05),
    }
    figures = {row["way"]: row["figures"]["dx_rel"].mean for row in solved}
    assert figures == pytest.approx({paper: 2.957, alone: 0.3553, both: 0.2190}, rel=0.05)
    known = [one["mean"] for one in car["rows"][0]["drift"] if one["segments"]]
    assert known[-1] == pytest.approx(1.5 / 48.0, rel=0.05)
    assert {row["way"] for row in car["rows"][1:]} == {paper, alone}
    assert car["metres"].tolist() == pytest.approx([46.4], abs=0.1)


@pytest.mark.slow
@of("transfer")
def test_a_case_for_each_protocol_and_metric(report: Report) -> None:
    cases = report.values["cases"]
    places = [(one["every"], one["protocol"], one["metric"]) for one in cases]
    assert places == [(1, protocol, metric) for protocol in ("sequential", "one-step") for metric in ("dx", "dt")]
    for one in cases:
        assert set(TARGETS) < set(one)
        assert tuple(one["errors"]) == NAMES
        assert all(0.0 < error["kitti"] <= 2.0 for error in one["errors"].values())


@of("sigma")
def test_known_heights_need_no_learning_and_unknown_ones_cost(report: Report) -> None:
    learned, prior, free = SIGMA.solvers
    rows = report.values["rows"]
    figures = ("metric", "people", "mean", "median")
    known = [
        [[row[name] for name in figures] for row in rows_at(rows, solver=s, sigma_h=0.0)] for s in (learned, prior)
    ]
    assert known[0] == known[1]
    unknown = {s: {m: rows_at(rows, solver=s, sigma_h=0.07, metric=m) for m in PANELS} for s in SIGMA.solvers}
    for n in range(2):
        assert unknown[prior]["dx"][n]["mean"] > 2.0 * unknown[learned]["dx"][n]["mean"]
        assert unknown[free]["dt"][n]["mean"] > unknown[prior]["dt"][n]["mean"]
    assert [row[0] for table in report.tables for row in table.rows].count("Δr (rad)") == 3 * 2


SLOW = ("hotel", "readings", "robot", "posterior", "transfer")


@pytest.mark.parametrize("name", [pytest.param(one, marks=pytest.mark.slow) if one in SLOW else one for one in STUDIES])
def test_what_exists_is_taken_over_and_files_hold_every_number(
    runs: Runs, name: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    if name in NEEDS_RECORDINGS:
        request.getfixturevalue("data_folder")
    report = runs.report(name)
    before = {path: path.stat().st_mtime_ns for path in (runs.out / name).rglob("*") if path.is_file()}
    assert runs.again(name).json == report.json
    assert {path: path.stat().st_mtime_ns for path in (runs.out / name).rglob("*") if path.is_file()} == before
    paths = write_report(report, tmp_path)
    pictures = [f"{report.name}{'-' if key else ''}{key}.png" for key in PICTURES.get(name, ("",))]
    assert [path.name for path in paths] == [f"{report.name}.md", f"{report.name}.json", *pictures]
    printed = shown(report, paths)
    assert printed.startswith((tmp_path / f"{report.name}.md").read_text("utf-8"))
    assert printed.endswith("\n".join(map(str, paths)))
    assert json.loads(shown(report, paths, as_json=True)) == json.loads(paths[1].read_text("utf-8"))
    for table in report.tables:
        assert {len(row) for row in table.rows} <= {len(table.head)}
    for key in pictures:
        assert (tmp_path / key).read_bytes()[:4] == b"\x89PNG"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["transfer", "keypoints"])
def test_numbers_do_not_depend_on_the_number_of_processes(runs: Runs, name: str) -> None:
    assert runs.again(name, jobs=2).json == runs.report(name).json


def test_another_definition_is_refused_unless_it_may_overwrite(tmp_path: Path) -> None:
    SMALL.run(tmp_path / "out")
    other = replace(SMALL, seed=1)
    with pytest.raises(VbbenchError, match=r"is dataset \w{16}, wanted is \w{16}; .* set `overwrite` to replace it"):
        other.run(tmp_path / "out")
    assert "seed 1" in other.run(tmp_path / "out", Making(overwrite=True)).title
    info = tmp_path / "out" / "sigma-0.07" / "one-step-vb-cv" / "submission.json"
    info.write_text(info.read_text("utf-8").replace('"solver": "vb-cv"', '"solver": "cv"'), "utf-8")
    with pytest.raises(VbbenchError, match=r"is of cv .*; wanted is vb-cv .*set `overwrite`"):
        other.run(tmp_path / "out")


TRANSFER = TransferStudy(kitti=Path("kitti"))
MISTAKES: list[tuple[Study, dict[str, Any], str]] = [
    (SMALL, {"solvers": ("vb-fs",)}, "did you mean 'vb-sf'"),
    (SMALL, {"solvers": ()}, "name a solver"),
    (SMALL, {"sigmas": (0.07, -0.01)}, "height_std.* must be 0 to 0.3 m"),
    (SMALL, {"protocol": "onestep"}, "onestep"),
    (SMALL, {"sequences": 0}, "sequences must be 1 to 10,000,000, not 0"),
    (SMALL, {"seed": -1}, "seed must be 0 to"),
    (HOTEL, {"splits": ("hotle",)}, "did you mean 'hotel'"),
    (HOTEL, {"splits": ("shibuya01",)}, "split of the paper's Table 2"),
    (HOTEL, {"splits": ()}, "nothing to measure"),
    (HOTEL, {"every": 0}, "every must be 1 or more, not 0"),
    (Table1Study(), {"splits": ("student",)}, "did you mean 'students'"),
    (ReadingsStudy(), {"splits": ()}, "name a split of hotel, eth, students"),
    (KEYPOINTS, {"every": 0}, "every must be 1 or more, not 0"),
    (TrajectoriesStudy(), {"splits": ("hotell",)}, "did you mean 'hotel'"),
    (PosteriorStudy(), {"every": 0}, "every must be 1 or more"),
    (RobotStudy(), {"jrdb": Path("jrdb")}, "only its rosbags hold how JRDB's robot moved; name their folder"),
    (RobotStudy(), {"protocols": ()}, "nothing to measure: name a solver and a protocol"),
    (RobotStudy(), {"sequences": 0}, "sequences"),
    (TRANSFER, {"every": 0}, "every must be 1 to 1,000, not 0"),
    (TRANSFER, {"variants": {"cv": Variant(solver="cv")}}, "1 solvers have no ranks to compare"),
]


@pytest.mark.parametrize(("study", "changes", "message"), MISTAKES)
def test_mistakes_are_found_before_anything_is_made(
    study: Any, changes: dict[str, Any], message: str, tmp_path: Path
) -> None:
    with pytest.raises(VbbenchError, match=message):
        replace(study, **changes).run(tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("figure-sigma --sequences 2 --solver vb-cv cv", "2 sequences at each"),
        ("figure-trajectories --split demo --solver cv --protocol one-step", "as `cv` answers it under protocol"),
        ("figure-robot --sequences 1 --solver cv", "kitti is missing: kitti is made from files of your own"),
        ("table1 --split hotel eth", "| ETH | the paper | 346 | 14.4 | 3 / 9.29 / 26 |"),
        ("table2", "`eth` is not here: `vbbench fetch eth` gets it."),
        ("table4 --sequences 1 --solver vb-cv", "Table 4: split street, seed 0, 1 sequences"),
    ],
)
def test_commands_without_recordings(
    command: str,
    said: str,
    no_data: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(robot, "SCENARIO", "tests/lib/short_walk.toml")
    name = command.split()[0]
    status, printed, _ = run(capsys, "reproduce", *command.split(), "--out", tmp_path / "out")
    assert status == 0
    assert said in printed
    assert printed.startswith((tmp_path / "out" / f"{name}.md").read_text("utf-8"))
    assert json.loads((tmp_path / "out" / f"{name}.json").read_text("utf-8"))


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("table2 --split shibuya01", "split of the paper's Table 2"),
        ("transfer --kitti nowhere --solver vb-fs", "did you mean 'vb-sf'"),
        ("all table44", "no study is called 'table44'; did you mean 'table4'?"),
        ("figure-sgima", "no study is called 'figure-sgima'; did you mean 'figure-sigma'?"),
        ("table1 --solver cv", "table1: --solver changes nothing here; remove it"),
        ("figure-trajectories --solver cv vb-cv", "name one each"),
        ("all --json", "a page writes that of each"),
        ("", "which study? name some of all, table1, table2"),
    ],
)
def test_mistakes_on_the_command_line(
    command: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, printed, complaint = run(capsys, "reproduce", *command.split())
    assert (status, printed) == (2, "")
    assert message in complaint
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@of("sigma")
def test_points_are_plain_groups_of_the_scored_sequences(report: Report, out: Path, tmp_path: Path) -> None:
    for sigma_h, solver in ((0.0, SIGMA.solvers[0]), (0.07, SIGMA.solvers[2])):
        data = out / "sigma" / f"sigma-{sigma_h:g}" / "dataset"
        score(data.with_name(f"one-step-{solver.replace(':', '-')}"), data).write_per_sequence(tmp_path / "scored.csv")
        scored = pd.read_csv(tmp_path / "scored.csv").set_index("sequence")
        scene = pd.read_parquet(data / "sequences.parquet").set_index("sequence")["scene"]
        scored["people"] = scene.map(pd.read_parquet(data / "truth" / "people.parquet").groupby("scene").size())
        for metric in PANELS:
            rows = rows_at(report.values["rows"], solver=solver, sigma_h=sigma_h, metric=metric)
            groups = scored.groupby("people")
            assert [row["people"] for row in rows] == list(groups.groups) == [8, 12]
            assert [row["mean"] for row in rows] == pytest.approx(groups[metric].mean())
            assert [row["median"] for row in rows] == pytest.approx(groups[metric].median())
            assert all(row["low"] < row["mean"] < row["high"] for row in rows)
