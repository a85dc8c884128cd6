"""The families on which every solver is judged: the robot simulator's description, figures, and the smallest run."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.families.families import families
from benchmarks.families.places import Places
from benchmarks.families.robot import Drive, boxes_of, crowd, robot_path, write
from benchmarks.families.table import HEAD, Row, lines
from benchmarks.real_camera.measuring import Run, Runs
from vbbench.errors import SourceMissingError

SHORT = Drive(people=30, seconds=4.0, rate=5.0)


def test_missing_recordings_are_named(tmp_path: Path) -> None:
    with pytest.raises(SourceMissingError, match=r"jrdb_tracks is not in a folder of recordings \(--data\)"):
        Places(data=None, cache=tmp_path).jrdb()
    with pytest.raises(SourceMissingError, match="kitti is not in"):
        Places(data=tmp_path, cache=tmp_path).kitti(4, found=False)


def test_a_drive_is_written_as_a_recording_and_the_same_again(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write(tmp_path / name, SHORT, 0)
    files = {path.name for path in (tmp_path / "a").iterdir()}
    assert files == {"boxes.csv", "camera.toml", "odometry.txt", "people.csv", "poses.txt"}
    assert all((tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes() for name in files)
    assert "pitch" not in (tmp_path / "a" / "camera.toml").read_text("utf-8")


@pytest.mark.slow
@pytest.mark.parametrize(("people", "least", "most"), [(70, 4.5, 7.0), (30, 1.8, 3.2)])
def test_crowds_are_as_described(people: int, least: float, most: float) -> None:
    """How many boxes a frame has, and how far the robot drives in a minute."""
    seen, driven = [], []
    for seed in range(3):
        drive, random = Drive(people=people, rate=2.5), np.random.default_rng([seed, people])
        truth = crowd(drive, robot_path(drive, random), random)
        frames = np.arange(0, len(truth.times), 12)
        seen += [len(rows) for rows in boxes_of(truth, frames, drive, np.random.default_rng(seed))]
        driven.append(np.hypot(*np.diff(truth.poses[:, :2], axis=0).T).sum())
    assert least < np.mean(seen) < most
    assert 42.0 < np.mean(driven) < 56.0


def test_figures_of_a_row() -> None:
    runs = Runs((Run(dx=1.0, dt=0.5, dx_camera=0.2, pose_held=0.9, rate=100.0), Run(dx=5.0, dt=0.5, dx_camera=np.nan)))
    row = Row.of("a", "b", runs, (2.0, 2.0, 2.0))
    assert row.plain == pytest.approx((3.0, 0.5, 0.2))
    assert row.capped == pytest.approx((1.5, 0.5, 0.2))
    assert (row.worst, row.runs, row.rate) == ((5.0, 0.5), 2, 100.0)
    assert row.values()["held"] == [0.9, None]
    naive = replace(row, solver="ground-plane", plain=(6.0, 1.0, 0.0))
    cells = list(row.cells(naive))
    assert len(cells) == len(HEAD)
    assert cells[2:5] == ["3.00 (×0.50)", ".500 (×0.50)", ".200"]
    assert list(naive.cells(naive))[2] == "6.00"
    assert len(list(lines([cells]))) == 3


@pytest.mark.slow
def test_the_smallest_size_runs(tmp_path: Path) -> None:
    """As CI runs it, without any recording."""
    command = [sys.executable, "-m", "benchmarks.families", "cv", "--smoke", "--cache", str(tmp_path / "cache")]
    done = subprocess.run(
        [*command, "--json", str(tmp_path / "found.json")], capture_output=True, text=True, encoding="utf-8", check=True
    )
    rows = json.loads((tmp_path / "found.json").read_text("utf-8"))
    names = [family.name for family in families(smoke=True)]
    assert [(row["family"], row["solver"]) for row in rows] == [
        (name, solver) for name in names for solver in ("ground-plane", "cv")
    ]
    assert done.stdout.count("\n") == len(rows) + 2
    assert all(row["plain"][0] is not None for row in rows)
