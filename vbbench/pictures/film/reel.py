"""A sequence made ready to be filmed: everything that is known of it, and one frame of that at a time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vbbench.files.dataset import Dataset
from vbbench.files.submission_rows import SubmittedEstimates
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.bystanders import unseen
from vbbench.pictures.plotting.moment import Moment
from vbbench.protocol import get_protocol
from vbbench.scene import Scene
from vbbench.sequence import Sequence, Truth
from vbbench.solver import Estimate

FARTHEST = 30.0
"""Colours tell distances up to so many m apart."""


@dataclass(frozen=True, kw_only=True)
class Reel:
    """A sequence with its scene and truth, and the estimate if there is one.

    Parameters
    ----------
    dataset : where it lies.
    sequence, truth : what is seen, and what is so.
    scene : everybody, for all of the recording.
    estimate : a submission's answer, ``None`` without one.
    solver, protocol : of the submission.
    """

    dataset: Dataset
    sequence: Sequence
    truth: Truth
    scene: Scene
    estimate: Estimate | None = None
    solver: str = ""
    protocol: str = "sequential"

    @cached_property
    def farthest(self) -> float:
        """Distance in m at the light end of the colours."""
        info = self.dataset.info
        reach = info.camera.focal * info.height_mean / self.sequence.observations[..., 2]
        return float(np.clip(np.ceil(np.nanmax(reach, initial=1.0)), 1.0, FARTHEST))

    @cached_property
    def persons(self) -> IntArray:
        """[T, K] who is behind each track."""
        return self.dataset.track_persons(self.sequence)

    def moment(self, frame: int) -> Moment:
        """One frame of it."""
        return Moment(
            info=self.dataset.info,
            sequence=self.sequence,
            frame=frame,
            truth=self.truth,
            estimate=self.estimate,
            solver=self.solver,
            protocol=get_protocol(self.protocol),
        )

    def unseen(self, frame: int) -> FloatArray:
        """[N, 2] positions in m of people who are there without a box, the observer left out."""
        places = self._unseen[frame]
        return np.asarray(places[~np.isnan(places[:, 0])])

    @cached_property
    def _unseen(self) -> FloatArray:
        return unseen(self.sequence, self.persons, self.scene.people, self.scene.positions)


def load_reel(dataset: Dataset, number: int, scene: Scene, submission: SubmittedEstimates | None = None) -> Reel:
    """Read a sequence of ``scene`` for filming.

    Raises
    ------
    VbbenchError
        If there is no such sequence, or its truth is withheld.
    """
    sequence = dataset.sequence(number)
    truth = dataset.truth(sequence)
    if submission is None:
        return Reel(dataset=dataset, sequence=sequence, truth=truth, scene=scene)
    return Reel(
        dataset=dataset,
        sequence=sequence,
        truth=truth,
        scene=scene,
        estimate=submission.of(sequence),
        solver=submission.info.solver,
        protocol=submission.info.protocol,
    )
