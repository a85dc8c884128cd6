"""The experiment of a robot: drift against a plain loop, figures on small recordings, and the command."""

import json
from dataclasses import replace
from math import atan2, cos, hypot, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.test_cli import run
from tests.jrdb_recording import Robot as MadeRobot
from tests.jrdb_recording import recording
from tests.kitti_files import Drive, write_kitti
from vbbench.errors import VbbenchError
from vbbench.generation.generator import FootagePlan
from vbbench.geometry import FloatArray, moved_as_one
from vbbench.registry import load
from vbbench.reproduction.report import write_report
from vbbench.reproduction.robot import study as study_module
from vbbench.reproduction.robot.drift import LENGTHS, dead_reckoning, distances, drift
from vbbench.reproduction.robot.figure import robot_report
from vbbench.reproduction.robot.measuring import Course, Robot, Row, measure_robot
from vbbench.reproduction.robot.picture import INSTANTS, instants, plot_course, steps_around
from vbbench.reproduction.robot.silent import CameraAlone
from vbbench.reproduction.robot.study import RobotStudy, default_entrants, with_and_without
from vbbench.sequence import Odometry

PAPER, ALONE, WITH = (entrant.title for entrant in default_entrants())


def wander(seed: int, frames: int = 90) -> FloatArray:
    """A way [T, 3] with a stand in it."""
    rng = np.random.default_rng(seed)
    steps = np.where(np.arange(frames) // 10 == 3, 0.0, rng.uniform(0.1, 0.7, frames))
    yaw = np.cumsum(0.3 * rng.standard_normal(frames))
    places = np.cumsum(steps[:, None] * np.stack([np.cos(yaw), np.sin(yaw)], axis=-1), axis=0)
    return np.column_stack([places, (yaw + pi) % (2 * pi) - pi])


def by_loops(estimate: FloatArray, truth: FloatArray, length: float) -> list[tuple[float, float]]:
    """Shift and turn of every segment, a step after the other."""
    found = []
    for i in range(len(truth)):
        gone, j = 0.0, i
        while gone < length and j + 1 < len(truth):
            gone += hypot(*(truth[j + 1, :2] - truth[j, :2]))
            j += 1
        if gone < length or not np.isfinite(estimate[[i, j]]).all():
            continue
        ends = []
        for poses in (estimate, truth):
            dx, dy, yaw = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1], poses[i, 2]
            ends.append((cos(yaw) * dx + sin(yaw) * dy, cos(yaw) * dy - sin(yaw) * dx, poses[j, 2] - yaw))
        (x, y, a), (u, v, b) = ends
        found.append((hypot(x - u, y - v) / length, abs(atan2(sin(a - b), cos(a - b))) / length))
    return found


@pytest.mark.parametrize("length", [2.0, 5.0, 11.0, 1000.0])
def test_drift_is_what_a_plain_loop_finds(length: float) -> None:
    pairs = []
    for seed in range(3):
        truth = wander(seed)
        estimate = truth + np.cumsum(0.02 * np.random.default_rng(seed + 50).standard_normal(truth.shape), axis=0)
        estimate[[1, 40]] = np.nan
        pairs.append((estimate, truth))
    expected = np.array([one for pair in pairs for one in by_loops(*pair, length)]).reshape(-1, 2)
    found = drift(pairs, length)
    np.testing.assert_allclose(np.stack([found.shift, found.turn], axis=-1), expected, atol=1e-12)
    assert found.to_dict()["segments"] == len(expected)
    assert (found.to_dict()["mean"] is None) == (length == 1000.0)


def test_where_a_map_lies_does_not_count_and_its_scale_does() -> None:
    truth = wander(4)
    cos_, sin_ = np.cos(1.0), np.sin(1.0)
    moved = np.column_stack(
        [
            5.0 + cos_ * truth[:, 0] - sin_ * truth[:, 1],
            sin_ * truth[:, 0] + cos_ * truth[:, 1] - 3.0,
            truth[:, 2] + 1.0,
        ]
    )
    assert drift([(moved, truth)], 5.0).shift.max() < 1e-12
    np.testing.assert_allclose(moved_as_one(moved, moved[0], truth[0]), truth, atol=1e-9)
    straight = np.column_stack([np.arange(50.0), np.zeros((50, 2))])
    assert drift([(straight * [1.1, 1.0, 1.0], straight)], 10.0).mean == pytest.approx(0.1)
    np.testing.assert_allclose(distances(straight), np.arange(50.0))


def test_dead_reckoning_goes_the_way_that_was_measured() -> None:
    truth = wander(2)
    motions = np.full((len(truth), 3), np.nan)
    for t in range(1, len(truth)):
        (dx, dy, turn), yaw = truth[t] - truth[t - 1], truth[t - 1, 2]
        motions[t] = cos(yaw) * dx + sin(yaw) * dy, cos(yaw) * dy - sin(yaw) * dx, turn
    odometry = Odometry(motions=motions, covariances=np.zeros((len(truth), 3, 3)))
    np.testing.assert_allclose(dead_reckoning(odometry, truth[0]), truth, atol=1e-9)


@pytest.fixture(scope="module")
def kitti(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A made drive of 48 m, whose stereo poses drift away by 1.5 m."""
    folder, drifting = tmp_path_factory.mktemp("kitti"), Drive()
    drifting.motions[:, :2, 3] += np.linspace(0.0, 1.5, len(drifting.motions))[:, None] * [0.6, 0.8]
    write_kitti(folder / "training", oxts=drifting.oxts())
    return folder


@pytest.fixture(scope="module")
def study(kitti: Path) -> RobotStudy:
    return RobotStudy(kitti=kitti, poses=kitti / "poses", sequences=1)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("robot")


@pytest.fixture(scope="module")
def found(study: RobotStudy, out: Path) -> Robot:
    """Twenty seconds in a smaller square."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study_module, "SCENARIO", "plaza")
        return measure_robot(study, out)


def rows_of(course: Course, protocol: str) -> dict[str, Row]:
    return {row.title: row for row in course.rows if row.protocol in ("", protocol)}


def means(row: Row) -> list[float]:
    return [one.mean for one in row.drifts if len(one.shift)]


@pytest.mark.slow
def test_figures_of_the_simulated_robot(found: Robot) -> None:
    """Golden: mean drift over 5 and 10 m, and Δx̃ in m; odometry and who has it drift least."""
    simulated, _ = found.courses
    rows = rows_of(simulated, "sequential")
    reference = simulated.recording.reference
    assert {name: means(row)[:2] for name, row in rows.items()} == {
        reference: pytest.approx([0.01645, 0.01607], rel=0.02),
        PAPER: pytest.approx([0.3545, 0.3600], rel=0.05),
        ALONE: pytest.approx([0.0820, 0.0569], rel=0.05),
        WITH: pytest.approx([0.01655, 0.01329], rel=0.05),
    }
    figures = {name: row.summaries["dx_rel"].mean for name, row in rows.items() if row.summaries}
    assert figures == pytest.approx({PAPER: 0.914, ALONE: 0.4752, WITH: 0.2388}, rel=0.05)


@pytest.mark.slow
def test_figures_of_the_car(found: Robot) -> None:
    """The reference drifts by the 1.5 m in 48 m that were made, and there is nobody with odometry."""
    _, car = found.courses
    for protocol in found.study.protocols:
        assert set(rows_of(car, protocol)) == {car.recording.reference, PAPER, ALONE}
    reference = rows_of(car, "sequential")[car.recording.reference]
    assert means(reference)[-1] == pytest.approx(1.5 / 48.0, rel=0.05)
    assert reference.summaries == {}
    way = car.example.ways[car.recording.reference]
    assert np.hypot(*(way - car.example.truth.poses)[:, :2].T).max() == pytest.approx(1.5, rel=0.05)
    assert car.metres == pytest.approx([46.4], abs=0.1)


def test_the_camera_alone_sees_the_same_without_odometry(study: RobotStudy) -> None:
    simulated, _ = study.recordings()
    whole = load("generator", simulated.split).plan(simulated.options)
    assert isinstance(whole, FootagePlan)
    alone = CameraAlone(whole)
    assert alone.info.id != whole.info.id
    assert set(whole.tables) - set(alone.tables) == {"odometry"}
    mine, own = alone.build(0).sequence, whole.build(0).sequence
    np.testing.assert_array_equal(mine.observations, own.observations)
    np.testing.assert_array_equal(mine.given.positions, own.given.positions)
    assert mine.given.odometry is None
    assert own.given.odometry is not None


def test_what_is_there_is_taken_over(
    found: Robot, study: RobotStudy, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study_module, "SCENARIO", "plaza")
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*.parquet")}
    again = measure_robot(study, out)
    assert robot_report(again).json == robot_report(found).json
    assert {path: path.stat().st_mtime_ns for path in out.rglob("*.parquet")} == before


@pytest.mark.slow
def test_the_report_has_a_row_a_way_and_every_number(found: Robot, tmp_path: Path) -> None:
    report = robot_report(found)
    paths = {path.name for path in write_report(report, tmp_path)}
    pictures = {"figure-robot-simulated.png", "figure-robot-kitti.png"}
    assert paths == {"figure-robot.md", "figure-robot.json"} | pictures
    values = json.loads(report.json)
    assert [one["name"] for one in values["recordings"]] == ["simulated", "kitti"]
    for course, table, told in zip(found.courses, report.tables, values["recordings"], strict=True):
        assert len(table.rows) == len(course.rows) == len(told["rows"])
        for row, cells, own in zip(course.rows, table.rows, told["rows"], strict=True):
            assert cells[0] == row.title == own["way"]
            assert cells[2] == f"{100 * row.drifts[0].mean:.1f} % ({100 * np.median(row.drifts[0].shift):.1f})"
            assert [one["length"] for one in own["drift"]] == list(LENGTHS)
            if row.protocol:
                assert cells[-2].startswith(f"{row.summaries['dx_rel'].capped:.2f} (")
                assert own["figures"]["dx_rel"]["mean"] == row.summaries["dx_rel"].mean
    assert "jrdb is missing" in report.markdown
    assert "–" in report.tables[0].rows[0][1]


def test_the_picture_has_maps_drift_and_five_instants(found: Robot) -> None:
    for course in found.courses:
        drawn = plot_course(course, found.study)
        shown = list(course.example.people)
        panels = {axes.get_label(): axes for axes in drawn.axes}
        assert set(panels) == {*shown, "drift", *(f"instant {n + 1}" for n in range(INSTANTS))}
        (first,) = (line for line in panels["drift"].lines if line.get_label() == shown[0])
        row = next(row for row in course.rows if row.title == shown[0])
        np.testing.assert_allclose(first.get_ydata(), 100.0 * np.array(means(row)))
        frames, sequence = instants(course.example), course.example.sequence
        assert (np.diff(frames) > 0).all()
        for number, frame in enumerate(frames.tolist(), 1):
            assert len(panels[f"instant {number}"].patches) >= sequence.observed[frame].sum()
        around = steps_around(course.example, int(frames[2]))
        assert around.start <= frames[2] < around.stop <= sequence.frames


@pytest.mark.slow
def test_without_kitti_it_is_said_to_be_missing(
    no_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study_module, "SCENARIO", "tests/short_walk.toml")
    command = ["reproduce", "figure-robot", "--sequences", "1", "--solver", "cv", "--out", tmp_path / "out"]
    status, printed, _ = run(capsys, *command)
    assert status == 0
    assert "kitti is missing: kitti is made from files of your own: name with --source" in printed
    assert "| cv with odometry | cold-start |" in printed
    assert (tmp_path / "out" / "figure-robot-simulated.png").read_bytes()[:4] == b"\x89PNG"
    assert not (tmp_path / "out" / "figure-robot-kitti.png").exists()


@pytest.mark.slow
@pytest.mark.extra("rosbags")
def test_jrdb_is_measured_where_bags_tell_its_motion(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = recording(robot=MadeRobot(seconds=25.0))
    root, bags = files.write(tmp_path / "jrdb"), files.write_bag(tmp_path / "bags")
    (entrant, _) = with_and_without("cv")
    study = RobotStudy(jrdb=root, bags=bags, entrants=(entrant,), protocols=("sequential",))
    monkeypatch.setattr(RobotStudy, "recordings", lambda study: (study._jrdb,))
    found = measure_robot(study, tmp_path / "out")
    (jrdb,) = found.courses
    assert jrdb.recording.name == "jrdb"
    reference, solved = jrdb.rows
    assert means(reference)[0] < 0.2
    assert len(solved.drifts[0].shift) > 0
    assert not any("jrdb" in text for text in found.missing)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"jrdb": Path("jrdb")}, "only its rosbags tell how JRDB's robot moved; name their folder"),
        ({"protocols": ()}, "nothing to measure: name a solver and a protocol"),
        ({"protocols": ("cold-strat",)}, "did you mean 'cold-start'"),
        ({"entrants": with_and_without("map-casual")}, "did you mean 'map-causal'"),
        ({"sequences": 0}, "sequences"),
    ],
)
def test_mistakes_are_found_before_anything_is_made(changes: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match=message):
        measure_robot(replace(RobotStudy(), **changes), tmp_path / "out")
    assert not (tmp_path / "out").exists()
