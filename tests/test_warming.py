"""Solvers are warm before their seconds are counted, whatever they come to only later."""

import json
import os
import subprocess
import sys
from itertools import product
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from tests.make_dataset import Crowd, write_dataset
from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.protocol import PROTOCOLS, get_protocol
from vbbench.sequence import Given
from vbbench.solver import Estimate, Frame, FrameEstimate, Problem
from vbbench.solving import solve
from vbbench.solving.warming import FRAMES, synthetic_sequence, warm_up

SOLVERS = {
    **dict.fromkeys(("cv", "sf"), "no"),
    **dict.fromkeys(
        ("vb-cv", "vb-sf", "vb-sf-literal", "map-causal", "map-batch", "vb-former", "vb-former-pure"), "yes"
    ),
}
"""Bundled solvers, and whether they report covariances."""

CAMERAS = [PanoramaCamera(), PerspectiveCamera()]


def problem(**changes: Any) -> Problem:
    facts = {"camera": PanoramaCamera(), "dt": 0.4, "tracks": np.arange(2), "height_mean": 1.7}
    return Problem(**{**facts, "height_std": 0.07, "pixel_std": 1.0, **changes})


class Seen:
    """Notes what the solvers below are shown, over all of them."""

    frames: ClassVar[list[Frame]] = []
    problems: ClassVar[list[Problem]] = []
    lengths: ClassVar[list[int]] = []


class Watching:
    """Notes frames and problems, and answers zeros."""

    def start(self, problem: Problem) -> None:
        Seen.problems.append(problem)

    def step(self, frame: Frame) -> FrameEstimate:
        Seen.frames.append(frame)
        return FrameEstimate(pose=np.zeros(3), positions=np.zeros((len(frame.observations), 2)))


class WatchingWhole:
    """The same for a solver of whole sequences."""

    def solve(self, problem: Problem, observations: np.ndarray, given: Given) -> Estimate:
        Seen.lengths.append(len(observations))
        return Estimate(poses=np.zeros((len(observations), 3)), positions=np.zeros((*observations.shape[:2], 2)))


class FailingOnMade(Watching):
    """Cannot do with a frame in which nobody is seen."""

    def step(self, frame: Frame) -> FrameEstimate:
        if np.isnan(frame.observations).all():
            raise ZeroDivisionError("nobody there")
        return super().step(frame)


class NeedsMore(Watching):
    """Has a ``start`` that nobody can call."""

    def start(self, problem: Problem, more: int) -> None:  # type: ignore[override]
        raise AssertionError


@pytest.fixture(autouse=True)
def _forget() -> None:
    Seen.frames, Seen.problems, Seen.lengths = [], [], []


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_made_sequence_has_many_few_nobody_and_who_comes_and_goes(camera: Any) -> None:
    sequence, truth = synthetic_sequence(problem(camera=camera), FRAMES)
    seen = sequence.observed
    assert np.all(np.isfinite(truth.positions))
    assert {0, 1} < set(seen.sum(axis=1).tolist())
    assert seen.sum(axis=1).max() >= 6
    arrivals = seen.argmax(axis=0)
    assert (arrivals > 2).sum() == 2  # late
    hides = [np.flatnonzero(np.diff(column.astype(int)) == 1) for column in seen[6:].T]
    assert any(len(back) for back in hides)  # somebody leaves and comes back beside the blank frames
    given = ~np.isnan(sequence.given.positions[..., 0])
    assert np.all(given[:2] == seen[:2])
    assert given[4, 0]


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_a_solver_is_shown_the_protocol_and_the_datasets_noise(protocol: str) -> None:
    warm_up(Watching(), problem(covariances=True), get_protocol(protocol))
    assert len(Seen.frames) == FRAMES
    assert Seen.problems[0].covariances
    assert len(Seen.problems[0].tracks) == len(Seen.frames[0].observations)
    past_known = [bool(np.isfinite(frame.given.poses[:2]).all()) for frame in Seen.frames]
    assert all(past_known[4:]) == (protocol == "one-step")
    late_given = any(np.isfinite(frame.given.positions[2]).any() for frame in Seen.frames[2:])
    assert late_given == (protocol == "sequential")


def test_whole_sequences_and_prefixes_are_warmed_up() -> None:
    warm_up(WatchingWhole(), problem(), get_protocol("one-step"), frames=6)
    assert Seen.lengths == [3, 4, 5, 6]
    warm_up(WatchingWhole(), problem(), get_protocol("rollout"), frames=6)
    assert Seen.lengths[4:] == [6]


def test_a_process_is_warmed_up_once_whatever_the_parts(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data", Crowd(scenes=16, people=6))
    data = Dataset(tmp_path / "data")
    assert len(data) > 64  # three parts
    longest = min(FRAMES, int(data.rows["frames"].max()))
    solve(data, f"{__name__}:Watching", "rollout", tmp_path / "out")
    counted = int(data.rows["frames"].sum())
    parts = -(-len(data) // 32)
    assert len(Seen.frames) == counted + longest + 3 * parts


def test_a_failure_on_what_was_made_up_fails_no_run(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data", Crowd(people=9, stay=(16, 17)))
    data = Dataset(tmp_path / "data")
    out = solve(data, f"{__name__}:FailingOnMade", "rollout", tmp_path / "out")
    assert SubmissionInfo.read(out).protocol == "rollout"
    assert len(Seen.frames) > int(data.rows["frames"].sum())


def test_a_start_that_cannot_be_called_fails_the_run(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data")
    with pytest.raises(TypeError, match="more"):
        solve(Dataset(tmp_path / "data"), f"{__name__}:NeedsMore", "rollout", tmp_path / "out")


@pytest.mark.slow
@pytest.mark.parametrize(("camera", "tier", "every"), [(CAMERAS[0], "ideal", 0), (CAMERAS[1], "noisy", 1)])
def test_nothing_is_compiled_or_loaded_while_the_clock_runs(camera: Any, tier: Any, every: int, tmp_path: Path) -> None:
    """Each camera with every second pair of a solver and a protocol."""
    generate("demo", tmp_path / "data", Options(camera=camera, tier=tier, limit=6))
    pairs = [
        (solver, name)
        for (i, solver), (j, name) in product(enumerate(SOLVERS), enumerate(PROTOCOLS))
        if (i + j) % 2 == every
    ]
    cases = [word for solver, name in pairs for word in (solver, name, SOLVERS[solver])]
    command = [sys.executable, "-m", "tests.late_loading", str(tmp_path / "data"), *cases]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    found = json.loads(run.stdout)
    assert len(found) == len(pairs)
    assert [name for name, case in found.items() if not case["loaded"]] == []
    assert {name: case["late"] for name, case in found.items() if case["late"]} == {}


COLD = """
import sys, time
from pathlib import Path
from vbbench.solving import submissions as solving
from vbbench.files.dataset import Dataset
from vbbench.protocol import get_protocol
from vbbench.solving.runner import run_sequence

def passes(solver, problem, sequence, protocol, truth):
    for n in range(len(spent)):
        started = time.process_time()
        answer = run_sequence(solver, problem, sequence, protocol, truth)
        spent[n] += time.process_time() - started
    return answer

spent, solving.run_sequence = [0.0] * 4, passes
data = Dataset(Path(sys.argv[1]))
solving._solve_part(data, "vb-sf", solving._opened_here, get_protocol("sequential"), False, False, 0, len(data))
print(*spent)
"""


@pytest.mark.slow
def test_cold_seconds_a_frame_are_those_of_a_warm_solver(tmp_path: Path) -> None:
    """On cold caches every sequence is answered four times: the first counts no more than half again the others."""
    generate("demo", tmp_path / "data", Options())
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-c", COLD, str(tmp_path / "data")]
    run = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    cold, *warm = (float(word) for word in run.stdout.split())
    assert cold < 1.5 * max(warm)
