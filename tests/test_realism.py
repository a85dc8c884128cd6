"""The realism report: known answers of hand-made scenes, streaming, and the command as a stranger uses it."""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from tests.cli.test_cli import run
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray
from vbbench.realism import (
    Walking,
    dataset_scenes,
    describe_realism,
    measure_realism,
    plot_realism,
    walking_statistics,
)
from vbbench.scene import Scene

NAN = [np.nan, np.nan]
STATISTICS = ("speed", "nearest_distance", "acceleration", "path_efficiency")


def scene(*paths: ArrayLike, dt: float = 0.5) -> Scene:
    """A scene of people who walk the paths [T, 2]."""
    positions = np.stack([np.asarray(path, dtype=float) for path in paths], axis=1)
    count = positions.shape[1]
    return Scene(name="made", dt=dt, people=np.arange(count), positions=positions, heights=np.full(count, 1.7))


def line(start: ArrayLike, velocity: ArrayLike, frames: int = 10, dt: float = 0.5) -> FloatArray:
    return np.asarray(start) + np.asarray(velocity) * dt * np.arange(frames)[:, None]


def random_scenes(count: int, seed: int = 0) -> Iterator[Scene]:
    """People who wander, and are there three frames of four."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        positions = np.cumsum(random.normal(0.3, 0.3, (20, 8, 2)), axis=0) + random.uniform(-3, 3, (8, 2))
        positions[random.random((20, 8)) < 0.25] = np.nan
        yield scene(*positions.transpose(1, 0, 2), dt=0.4)


def brute_force(scenes: list[Scene]) -> dict[str, list[float]]:
    """All samples, and the collisions of every frame, by the definitions."""
    found: dict[str, list[float]] = {name: [] for name in ("speed", "nearest", "acceleration", "collision")}
    for one in scenes:
        p, dt = one.positions, one.dt
        for t in range(one.frames):
            there = np.flatnonzero(one.present[t])
            apart = {(i, j): float(np.linalg.norm(p[t, i] - p[t, j])) for i in there for j in there if i != j}
            found["nearest"] += [min(d for (i, _), d in apart.items() if i == k) for k in there if len(there) > 1]
            found["collision"] += [d for (i, j), d in apart.items() if i < j and d < 0.4]
            for k in there:
                if t >= 1 and one.present[t - 1, k]:
                    found["speed"].append(float(np.linalg.norm(p[t, k] - p[t - 1, k])) / dt)
                if t >= 2 and one.present[t - 2 : t, k].all():
                    found["acceleration"].append(float(np.linalg.norm(p[t, k] - 2 * p[t - 1, k] + p[t - 2, k])) / dt**2)
    return found


def assert_same(one: Walking, other: Walking) -> None:
    assert (one.scenes, one.person_frames, one.collisions, one.short_walks) == (
        other.scenes,
        other.person_frames,
        other.collisions,
        other.short_walks,
    )
    assert one.person_seconds == pytest.approx(other.person_seconds)
    for mine, theirs in zip(one.distributions, other.distributions, strict=True):
        np.testing.assert_allclose(mine.values, theirs.values)


def test_a_straight_walker_has_exactly_its_speed_and_wastes_no_way() -> None:
    walking = walking_statistics([scene(line([0, 0], [0.6, 0.8]))])
    assert (walking.scenes, walking.person_frames, walking.person_seconds, walking.dt) == (1, 10, 5.0, 0.5)
    assert len(walking.speed.values) == 9
    assert walking.speed.mean == pytest.approx(1.0)
    assert walking.speed.quantile(0.5) == pytest.approx(1.0)
    assert walking.acceleration.values.max() == pytest.approx(0.0, abs=1e-12)
    assert len(walking.path_efficiency.values) == 1
    assert walking.path_efficiency.mean == pytest.approx(1.0)


def test_collisions_count_once_a_pair_and_frame() -> None:
    pair = [line([0, 0], [1, 0]), line([0, 0.3], [1, 0])]
    walking = walking_statistics([scene(*pair, line([0, 5], [1, 0]))])
    assert walking.collisions == 10
    assert walking.collision_seconds == 5.0
    assert walking.collisions_a_minute == pytest.approx(10 / (30 * 0.5 / 60))
    assert walking.collision_seconds_a_minute == pytest.approx(60 * 10 / 30)
    assert len(walking.nearest_distance.values) == 30
    assert walking.nearest_distance.values.min() == pytest.approx(0.3)
    assert walking.nearest_distance.values.max() == pytest.approx(4.7)


def test_the_seconds_of_collision_do_not_depend_on_the_frame_rate() -> None:
    walkings = []
    for frames, dt in ((10, 0.4), (100, 0.04)):
        still = [np.zeros((frames, 2)), np.full((frames, 2), 0.1)]
        walkings.append(walking_statistics([scene(*still, dt=dt)]))
    assert walkings[0].collision_seconds_a_minute == pytest.approx(walkings[1].collision_seconds_a_minute)
    assert walkings[1].collisions_a_minute == pytest.approx(10 * walkings[0].collisions_a_minute)


def test_who_stands_has_a_speed_and_no_efficiency() -> None:
    walking = walking_statistics([scene(np.ones((6, 2)), line([3, 3], [1, 0], 6))])
    assert walking.short_walks == 1
    assert len(walking.path_efficiency.values) == 1
    assert (len(walking.speed.values), walking.speed.values.min()) == (10, 0.0)


@pytest.mark.parametrize("paths", [[[[0.0, 0.0]]], [[NAN, NAN]], [[NAN], [NAN]]])
def test_nothing_to_measure_is_no_number(paths: list[ArrayLike]) -> None:
    walking = walking_statistics([scene(*paths)])
    assert all(len(h.values) == 0 and np.isnan(h.mean) and np.isnan(h.quantile(0.5)) for h in walking.distributions)
    text = json.dumps(walking.to_json(), allow_nan=False)
    assert json.loads(text)["speed"]["median"] is None


def test_no_scene_at_all_is_nothing() -> None:
    walking = walking_statistics([])
    assert (walking.scenes, walking.collisions) == (0, 0)
    assert np.isnan(walking.dt)
    json.dumps(walking.to_json(), allow_nan=False)


def test_random_crowds_agree_with_the_definitions() -> None:
    scenes = list(random_scenes(5))
    walking, expected = walking_statistics(scenes), brute_force(scenes)
    assert walking.collisions == len(expected["collision"]) > 0
    for found, name in zip(walking.distributions, ("speed", "nearest", "acceleration"), strict=False):
        np.testing.assert_allclose(np.sort(found.values), np.sort(expected[name]), atol=1e-9)


def test_parts_together_are_the_same_as_all_at_once() -> None:
    scenes = list(random_scenes(6))
    parts = [walking_statistics(iter(scenes[:2])), walking_statistics([]), walking_statistics(scenes[2:])]
    assert_same(sum(parts, Walking()), walking_statistics(scenes))


def test_the_densities_of_a_distribution_sum_to_one() -> None:
    walking = walking_statistics(random_scenes(3))
    edges = np.linspace(0.0, walking.speed.values.max(), 41)
    assert np.sum(walking.speed.density(edges) * np.diff(edges)) == pytest.approx(1.0)


def test_scenes_of_a_dataset_are_those_that_were_written(tmp_path: Path) -> None:
    write_dataset(tmp_path / "d", Crowd(scenes=37, seed=4))
    dataset = Dataset(tmp_path / "d")
    whole = [Dataset(tmp_path / "d").scene(number) for number in range(37)]
    scenes = [scene(*positions.transpose(1, 0, 2), dt=dataset.info.dt) for _, positions, _ in whole]
    assert_same(walking_statistics(dataset_scenes(dataset)), walking_statistics(scenes))


def test_a_scene_that_many_sequences_share_counts_once(tmp_path: Path) -> None:
    dataset = generate("demo", tmp_path / "d", Options(limit=40))
    shared = np.unique(dataset.rows["scene"])
    assert len(dataset) > len(shared)
    assert walking_statistics(dataset_scenes(dataset)).scenes == len(shared)


def test_the_dataset_of_a_recording_walks_as_the_recording(data_folder: Path, tmp_path: Path) -> None:
    dataset = generate("eth-15fps", tmp_path / "d", Options(limit=3))
    report = measure_realism(dataset, ["eth-15fps", "students"])
    assert_same(report.columns["this: eth-15fps"], report.columns["eth-15fps"])
    assert list(report.columns) == ["this: eth-15fps", "eth-15fps", "students"]
    assert 1.2 < report.columns["eth-15fps"].speed.quantile(0.5) < 1.6
    assert "saturated" in describe_realism(report)


@pytest.fixture
def tiny(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a small dataset, beside the working directory."""
    write_dataset(tmp_path / "tiny")
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "tiny"


def test_the_command_without_recordings_says_how_to_get_them(
    capsys: pytest.CaptureFixture[str], tiny: Path, no_data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    status, out, err = run(capsys, "info", tiny, "--realism")
    assert (status, err) == (0, "")
    assert "students: source not available (vbbench fetch students)" in out
    assert "eth-15fps: source not available (vbbench fetch eth-15fps)" in out
    assert out.splitlines()[-1] == "realism.png"
    assert Path("realism.png").read_bytes().startswith(b"\x89PNG")


def test_json_has_figures_and_picture(capsys: pytest.CaptureFixture[str], tiny: Path, no_data: Path) -> None:
    status, out, _ = run(capsys, "info", tiny, "--realism", "--json", "--plot", "made/p.png")
    assert status == 0
    result = json.loads(out)
    assert {"split", "sequences", "id"} <= set(result)
    realism = result["realism"]
    assert realism["missing"] == ["students", "eth-15fps"]
    assert Path(realism["picture"]).is_file()
    source = realism["sources"][realism["dataset"]]
    assert {"dt", "scenes", "person_frames", "person_minutes", "collisions", "short_walks", *STATISTICS} == set(source)
    assert set(source["collisions"]) == {"limit", "pair_frames", "per_person_minute", "seconds_per_person_minute"}
    for name in STATISTICS:
        figures = source[name]
        assert set(figures) == {"unit", "count", "mean", "median", "p5", "p95"}
        assert figures["p5"] <= figures["median"] <= figures["p95"]


def test_withheld_truth_is_named_with_truth(capsys: pytest.CaptureFixture[str], tiny: Path, no_data: Path) -> None:
    (tiny / "truth").rename(tiny.parent / "kept")
    status, out, err = run(capsys, "info", tiny, "--realism")
    assert (status, out) == (2, "")
    assert "has no truth; name the folder that holds it" in err
    assert run(capsys, "info", tiny, "--realism", "--truth", tiny.parent / "kept")[0] == 0


@pytest.mark.parametrize("extra", [["--plot", "x.png"], ["--truth", "kept"]])
def test_options_of_the_report_alone_are_a_mistake(
    capsys: pytest.CaptureFixture[str], tiny: Path, extra: list[str]
) -> None:
    status, out, err = run(capsys, "info", tiny, *extra)
    assert (status, out) == (2, "")
    assert "--realism" in err
    assert not list(Path.cwd().iterdir())


def test_the_picture_shows_every_source_in_four_panels(tiny: Path, data_folder: Path) -> None:
    figure = plot_realism(measure_realism(Dataset(tiny)))
    assert len(figure.axes) == 4
    for axes in figure.axes:
        assert {patch.get_gid() for patch in axes.patches} >= {"this: tiny", "students", "eth-15fps"}
        assert axes.get_xlabel()
        assert axes.get_ylabel()
    assert [axes.get_label() for axes in figure.axes if "collision" in {p.get_gid() for p in axes.patches}] == [
        "nearest distance"
    ]
    assert len(figure.legends) == 1
