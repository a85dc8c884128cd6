"""What reaches a solver under each protocol, and that truth never does."""

import gc
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
import scipy.linalg  # noqa: F401 - the library whose threads are counted
from threadpoolctl import threadpool_info, threadpool_limits

from tests.lib.made_sequence import sequence_of
from vbbench.camera import PanoramaCamera
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.geometry import world_to_relative
from vbbench.protocol import PROTOCOLS, get_protocol, scored_positions
from vbbench.registry import registered
from vbbench.sequence import Given, Odometry, Sequence, Truth
from vbbench.solver import Estimate, Frame, FrameEstimate, Problem
from vbbench.solving import solve
from vbbench.solving.isolation.remote import IsolatedSolver
from vbbench.solving.runner import run_sequence

FRAMES, PEOPLE = 8, 5


@pytest.fixture
def world() -> tuple[Problem, Sequence, Truth]:
    """Five people about an observer; the last arrives at frame 4, the first leaves for frames 3 to 5."""
    rng = np.random.default_rng(0)
    positions = rng.uniform(-8, 8, (FRAMES, PEOPLE, 2))
    poses = rng.uniform(-3, 3, (FRAMES, 3))
    observed = np.ones((FRAMES, PEOPLE), bool)
    observed[:4, -1] = observed[3:6, 0] = False
    heights = np.full(PEOPLE, 1.7)
    boxes = PanoramaCamera().project(world_to_relative(positions, poses), np.broadcast_to(heights, observed.shape))
    boxes[~observed] = np.nan
    truth = Truth(poses=poses, positions=positions, heights=heights)
    sequence = sequence_of(truth, boxes)
    problem = Problem(
        camera=PanoramaCamera(), dt=0.4, tracks=sequence.tracks, height_mean=1.7, height_std=0.07, pixel_std=0.0
    )
    return problem, sequence, truth


class Recorder:
    """Keeps every frame it is shown and answers zeros."""

    def start(self, problem: Problem) -> None:
        self.frames: list[Frame] = []

    def step(self, frame: Frame) -> FrameEstimate:
        self.frames.append(frame)
        return FrameEstimate(pose=np.zeros(3), positions=np.zeros((len(frame.observations), 2)))


class WholeRecorder:
    """The same for a solver of whole sequences."""

    def __init__(self) -> None:
        self.calls: list[Given] = []

    def solve(self, problem: Problem, observations: np.ndarray, given: Given) -> Estimate:
        self.calls.append(given)
        return Estimate(poses=np.zeros((len(observations), 3)), positions=np.zeros((*observations.shape[:2], 2)))


def frames_under(protocol: str, world: tuple[Problem, Sequence, Truth]) -> list[Frame]:
    recorder = Recorder()
    run_sequence(recorder, world[0], world[1], get_protocol(protocol), world[2])
    return recorder.frames


def test_one_step_shows_the_truth_of_two_past_frames_and_not_the_present(world: Any) -> None:
    _, sequence, truth = world
    for t, frame in enumerate(frames_under("one-step", world)):
        for back in (1, 2):
            if t < back:
                assert np.isnan(frame.given.poses[2 - back]).all()
                continue
            np.testing.assert_array_equal(frame.given.poses[2 - back], truth.poses[t - back])
            seen = sequence.observed[t - back]
            np.testing.assert_array_equal(frame.given.positions[2 - back][seen], truth.positions[t - back][seen])
            assert np.isnan(frame.given.positions[2 - back][~seen]).all()
        if t >= 2:
            assert np.isnan(frame.given.poses[2]).all()
            assert np.isnan(frame.given.positions[2]).all()


@pytest.mark.parametrize("protocol", ["sequential", "rollout"])
def test_the_rest_shows_what_is_given_and_no_more(protocol: str, world: Any) -> None:
    problem, sequence, _ = world
    given = get_protocol(protocol).select_given(sequence.given)
    recorder = Recorder()
    run_sequence(recorder, problem, sequence, get_protocol(protocol), world[2])  # truth at hand is not shown
    for t, frame in enumerate(recorder.frames):
        np.testing.assert_array_equal(frame.given.positions[2], given.positions[t])
        np.testing.assert_array_equal(frame.given.poses[2], given.poses[t])
        np.testing.assert_array_equal(frame.given.poses[0], given.poses[t - 2] if t >= 2 else np.full(3, np.nan))


def test_late_arrivals_are_given_in_sequential_only(world: Any) -> None:
    _, sequence, _ = world
    assert np.isfinite(get_protocol("sequential").select_given(sequence.given).positions[4:6, -1]).all()
    assert np.isnan(get_protocol("rollout").select_given(sequence.given).positions[2:]).all()


def test_scored_rows_are_those_of_the_contract(world: Any) -> None:
    _, sequence, _ = world
    arrivals = scored_positions(sequence.observed, sequence.given)
    assert not arrivals[:2].any()
    assert not arrivals[4:6, -1].any()
    assert arrivals[6:, -1].all()
    assert not arrivals[3:6, 0].any()
    assert arrivals.sum() == 2 + 3 * 6 + 3


def test_a_whole_sequence_solver_sees_only_the_past_in_one_step(world: Any) -> None:
    problem, sequence, truth = world
    solver = WholeRecorder()
    run_sequence(solver, problem, sequence, get_protocol("one-step"), truth)
    assert [len(call.poses) for call in solver.calls] == list(range(3, FRAMES + 1))
    for call in solver.calls:
        assert np.isnan(call.poses[-1]).all()
        assert np.isnan(call.positions[-1]).all()
        np.testing.assert_array_equal(call.poses[:-1], truth.poses[: len(call.poses) - 1])


def reachable(root: object) -> Iterator[object]:
    """Every object that can be had from ``root`` without going through modules, code or frames."""
    seen, todo = set(), [root]
    while todo:
        found = todo.pop()
        if id(found) in seen or isinstance(found, type) or type(found).__name__ in {"module", "function", "frame"}:
            continue
        seen.add(id(found))
        yield found
        todo.extend(gc.get_referents(found))
        if isinstance(found, np.ndarray) and found.base is not None:
            todo.append(found.base)


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_truth_cannot_be_reached_from_what_a_solver_holds(protocol: str, world: Any) -> None:
    problem, sequence, truth = world
    future = {float(x) for x in truth.poses[-1]} | {float(x) for x in truth.positions[-1].ravel()}

    class Thief(Recorder):
        def step(self, frame: Frame) -> FrameEstimate:
            for found in reachable((self, frame)):
                if isinstance(found, np.ndarray) and found.dtype == np.float64:
                    assert not future & set(found.ravel().tolist())
            return super().step(frame)

    run_sequence(Thief(), problem, sequence, get_protocol(protocol), truth)


class StackThief(Recorder):
    """Walks up the stack and takes any truth that a caller holds."""

    def step(self, frame: Frame) -> FrameEstimate:
        import sys

        caller, answer = sys._getframe(), super().step(frame)
        while caller is not None:
            for value in caller.f_locals.values():
                if isinstance(value, Truth):
                    return FrameEstimate(pose=value.poses[frame.index], positions=value.positions[frame.index])
            caller = caller.f_back  # type: ignore[assignment]
        return answer


def test_an_isolated_solver_cannot_even_walk_the_stack(world: Any) -> None:
    problem, sequence, truth = world
    protocol = get_protocol("one-step")
    stolen, _ = run_sequence(StackThief(), problem, sequence, protocol, truth)
    np.testing.assert_array_equal(stolen.poses[-1], truth.poses[-1])  # in process, a determined thief gets it
    with IsolatedSolver(f"{__name__}:StackThief") as solver:
        honest, _ = run_sequence(solver, problem, sequence, protocol, truth)
    np.testing.assert_array_equal(honest.poses, np.zeros((FRAMES, 3)))


class Garbled(Recorder):
    """Leaves track 2 out at frame 5."""

    def step(self, frame: Frame) -> FrameEstimate:
        answer = super().step(frame)
        positions = answer.positions.copy()
        positions[2 if frame.index == 5 else 0 : 3 if frame.index == 5 else 0] = np.nan
        return FrameEstimate(pose=answer.pose, positions=positions)


def test_what_a_solver_leaves_out_is_named(world: Any) -> None:
    with pytest.raises(VbbenchError, match="frame 5: the solver's position of track 2 is not finite"):
        run_sequence(Garbled(), world[0], world[1], get_protocol("sequential"), None)
    with pytest.raises(VbbenchError, match="neither start and step nor solve"):
        run_sequence(object(), world[0], world[1], get_protocol("sequential"), None)  # type: ignore[arg-type]


class InPlace:
    """Answers with the same arrays in every frame, into which it writes."""

    def start(self, problem: Problem) -> None:
        self.pose, self.positions = np.zeros(3), np.zeros((len(problem.tracks), 2))

    def step(self, frame: Frame) -> FrameEstimate:
        self.pose[0], self.positions[:] = frame.index, frame.index
        return FrameEstimate(pose=self.pose, positions=self.positions)


class InPlaceWhole:
    """The same for a solver of whole sequences, which keeps what it answered before."""

    def __init__(self) -> None:
        self.poses, self.positions = np.zeros((FRAMES, 3)), np.zeros((FRAMES, PEOPLE, 2))

    def solve(self, problem: Problem, observations: np.ndarray, given: Given) -> Estimate:
        self.poses[:, 0] = self.positions[:] = len(observations) - 1
        return Estimate(poses=self.poses[: len(observations)], positions=self.positions[: len(observations)])


@pytest.mark.parametrize(("solver", "protocol"), [(InPlace, "sequential"), (InPlaceWhole, "one-step")])
def test_what_a_solver_writes_into_its_answers_later_changes_nothing(solver: Any, protocol: str, world: Any) -> None:
    problem, sequence, truth = world
    estimate, _ = run_sequence(solver(), problem, sequence, get_protocol(protocol), truth)
    np.testing.assert_array_equal(estimate.poses[2:, 0], np.arange(2.0, FRAMES))
    np.testing.assert_array_equal(estimate.positions[2:, 1, 1], np.arange(2.0, FRAMES))


def test_a_solver_that_ends_the_program_is_a_fault_of_the_solver(world: Any) -> None:
    class Leaving(Recorder):
        def step(self, frame: Frame) -> FrameEstimate:
            raise SystemExit(0)

    with pytest.raises(VbbenchError, match=r"sequence 0: the solver ended the program \(exit status 0\)"):
        run_sequence(Leaving(), world[0], world[1], get_protocol("sequential"), None)


def test_positions_of_a_changing_shape_are_named(world: Any) -> None:
    class Growing(Recorder):
        def step(self, frame: Frame) -> FrameEstimate:
            return FrameEstimate(pose=np.zeros(3), positions=np.zeros((PEOPLE + (frame.index == 3), 2)))

    with pytest.raises(VbbenchError, match=r"sequence 0, frame 3: the solver's positions have shape \[6, 2\], not"):
        run_sequence(Growing(), world[0], world[1], get_protocol("sequential"), None)


def test_motions_of_later_frames_cannot_be_reached_in_one_step(world: Any) -> None:
    problem, sequence, truth = world
    odometry = Odometry(motions=np.ones((FRAMES, 3)), covariances=np.tile(np.eye(3), (FRAMES, 1, 1)))
    given = Given(poses=sequence.given.poses, positions=sequence.given.positions, odometry=odometry)
    recorder = WholeRecorder()
    run_sequence(recorder, problem, replace(sequence, given=given), get_protocol("one-step"), truth)
    for call in recorder.calls:
        base: Any = call.odometry.motions
        while base is not None:
            assert len(base) == len(call.poses)
            base = base.base


def test_one_step_needs_truth(world: Any) -> None:
    with pytest.raises(VbbenchError, match="no truth is available"):
        run_sequence(Recorder(), world[0], world[1], get_protocol("one-step"), None)


class ThreadCounter:
    """Answers the largest number of threads that a library may use, for want of a pose."""

    def start(self, problem: Problem) -> None:
        self._people = len(problem.tracks)

    def step(self, frame: Frame) -> FrameEstimate:
        threads = max(library["num_threads"] for library in threadpool_info())
        return FrameEstimate(pose=np.full(3, float(threads)), positions=np.zeros((self._people, 2)))


@pytest.mark.slow
@pytest.mark.parametrize("how", [{}, {"isolate": True}, {"jobs": 2}], ids=str)
def test_a_solver_has_one_thread(tmp_path: Path, how: dict[str, Any]) -> None:
    folder = generate("sim", tmp_path / "sim", Options(limit=2), jobs=1).folder
    name = f"{ThreadCounter.__module__}:{ThreadCounter.__name__}"
    with threadpool_limits(3):
        out = solve(Dataset(folder), name, "sequential", tmp_path / "out", **how)
        assert max(library["num_threads"] for library in threadpool_info()) == 3
    answers = pq.read_table(out / "poses.parquet").to_pandas()
    assert set(answers["x"]) == {1.0}


LATE = """
import sys
from pathlib import Path
from vbbench.files.dataset import Dataset
from vbbench.solving import runner, solve

def clock():
    loaded.append(set(sys.modules))
    return float(len(loaded))

runner.perf_counter, loaded = clock, []
solve(Dataset(Path(sys.argv[1])), sys.argv[2], "sequential", Path(sys.argv[3]))
assert loaded
print(*sorted(set().union(*(after - before for before, after in zip(loaded[::2], loaded[1::2])))))
"""


@pytest.mark.slow
def test_a_bundled_solver_imports_nothing_while_its_seconds_are_counted(tmp_path: Path) -> None:
    """In a new process each: no library comes after the threads were limited."""
    folder = generate("demo", tmp_path / "demo", Options(limit=1), jobs=1).folder
    late = {}
    for solver in registered("solver"):
        command = [sys.executable, "-c", LATE, str(folder), solver, str(tmp_path / solver)]
        late[solver] = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    assert len(late) >= 9
    assert {solver: modules for solver, modules in late.items() if modules} == {}
