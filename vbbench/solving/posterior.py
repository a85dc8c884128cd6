"""The observer's location posterior in one frame of a sequence, as a solver sees it: the numbers behind a heat map."""

from dataclasses import dataclass
from itertools import islice

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.estimate import Estimate, FrameEstimate
from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray
from vbbench.protocol import START_FRAMES, get_protocol
from vbbench.registry import make_solver
from vbbench.solver import LocationPosterior
from vbbench.solving.runner import frames_of, reveal


@dataclass(frozen=True, kw_only=True)
class Posterior:
    """A solver that has just answered for a frame, with its energy of the observer's location.

    Parameters
    ----------
    solver, protocol : their names.
    frame : the frame answered last.
    estimate : its answers up to that frame, NaN after.
    source : the solver itself.
    """

    solver: str
    protocol: str
    frame: int
    estimate: Estimate
    source: LocationPosterior

    @property
    def pose(self) -> FloatArray:
        """[3] the estimated pose in m and rad."""
        return np.asarray(self.estimate.poses[self.frame])

    def excess(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """How much −ln p exceeds that of the estimated pose, on the grid of x [N] and y [M] in m: [M, N]."""
        grid = np.stack(np.meshgrid(x, y), axis=-1)
        places = np.vstack([self.pose[None, :2], grid.reshape(-1, 2)])
        energies = self.source.location_energy(places)
        return np.asarray(energies[1:] - energies[0]).reshape(len(y), len(x))

    def reach(self, level: float, farthest: float = 16.0) -> float:
        """Half the side in m of a square about the pose that holds (nearly) all places of excess under ``level``."""
        half, steps, (x, y, _) = 0.05, np.linspace(-1.0, 1.0, 9), self.pose
        while half < farthest and self.excess(x + half * steps, y + half * steps)[_RIM].min() < level:
            half *= 1.4
        return half


_RIM = np.pad(np.zeros((7, 7), dtype=np.bool_), 1, constant_values=True)


def find_posterior(dataset: Dataset, index: int, frame: int, *, solver: str, protocol: str) -> Posterior:
    """Run a solver on frames 0 … ``frame`` of a sequence.

    Raises
    ------
    VbbenchError
        If a name is unknown, the frame is given or does not exist, truth is needed but withheld, or the solver is not a
        `LocationPosterior`.
    """
    rules, source, sequence = get_protocol(protocol), make_solver(solver), dataset.sequence(index)
    if not isinstance(source, LocationPosterior):
        raise VbbenchError(f"solver '{solver}' has no location_energy and so no posterior to draw; try vb-cv")
    if not START_FRAMES <= frame < sequence.frames:
        last = sequence.frames - 1
        raise VbbenchError(f"sequence {index} has posteriors in frames {START_FRAMES} to {last}, not in {frame}")
    given = rules.select_given(sequence.given)
    known = reveal(given, sequence.observed, dataset.truth(sequence)) if rules.needs_truth else given
    source.start(dataset.problem(sequence))
    answers = [source.step(shown) for shown in islice(frames_of(sequence, given, known), frame + 1)]
    silence = FrameEstimate(pose=np.full(3, np.nan), positions=np.full_like(answers[0].positions, np.nan))
    estimate = Estimate.of_frames([*answers, *[silence] * (sequence.frames - len(answers))])
    return Posterior(solver=solver, protocol=protocol, frame=frame, estimate=estimate, source=source)
