"""One frame of one sequence with everything that is known about it: what both views draw."""

from dataclasses import dataclass

import numpy as np

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.geometry import BoolArray, FloatArray
from vbbench.protocol import START_FRAMES, Protocol, get_protocol
from vbbench.scoring.metrics import frame_errors
from vbbench.sequence import Given, Sequence, Truth
from vbbench.solver import Estimate


@dataclass(frozen=True, kw_only=True)
class Moment:
    """Frame ``frame`` of a sequence; truth and estimate where they are at hand."""

    info: DatasetInfo
    sequence: Sequence
    frame: int
    truth: Truth | None
    estimate: Estimate | None
    solver: str
    protocol: Protocol

    @property
    def given(self) -> Given:
        """What the protocol hands over, frames revealed one by one left out."""
        return self.protocol.select_given(self.sequence.given)

    @property
    def boxes(self) -> FloatArray:
        """[K, 3] (u, v, l) in px, NaN = not observed."""
        return np.asarray(self.sequence.observations[self.frame])

    @property
    def observed(self) -> BoolArray:
        """[K] whose box is in the picture."""
        return np.asarray(self.sequence.observed[self.frame])

    @property
    def distances(self) -> FloatArray:
        """[K] distance in m that a box tells of somebody of mean height, f·μ_h/l."""
        return self.info.camera.focal * self.info.height_mean / self.boxes[:, 2]

    @property
    def given_now(self) -> BoolArray:
        """[K] whose position in this frame is given, and not scored."""
        return ~np.isnan(self.given.positions[self.frame, :, 0])

    @property
    def known(self) -> FloatArray:
        """[K, 2] positions in m to draw as the real ones: truth where it is at hand, else what is given."""
        source = self.given if self.truth is None else self.truth
        return np.asarray(source.positions[self.frame])

    @property
    def known_pose(self) -> FloatArray:
        """[3] the observer's real pose, as in `known`."""
        source = self.given if self.truth is None else self.truth
        return np.asarray(source.poses[self.frame])

    @property
    def estimated(self) -> FloatArray:
        """[K, 2] estimated positions in m of the people observed, NaN elsewhere."""
        if self.estimate is None:
            return np.full((len(self.boxes), 2), np.nan)
        return np.where(self.observed[:, None], self.estimate.positions[self.frame], np.nan)

    @property
    def errors(self) -> dict[str, float]:
        """Errors of this frame by metric, over the people observed and not given; {} without truth."""
        if self.truth is None or self.estimate is None or not np.isfinite(self.estimate.poses[self.frame]).all():
            return {}
        errors = frame_errors(
            self.estimate.poses[self.frame],
            self.estimated,
            self.truth.poses[self.frame],
            self.truth.positions[self.frame],
            ~self.given_now,
        )
        return {name: float(error) for name, error in errors.items() if np.isfinite(error)}


def gather(
    dataset: Dataset, index: int, estimate: Estimate | None, *, frame: int | None, solver: str, protocol: str
) -> Moment:
    """Read what there is to draw of a sequence; ``frame`` None means the fullest frame of its middle third.

    Raises
    ------
    VbbenchError
        If there is no such sequence or frame, or the estimate has another shape.
    """
    sequence = dataset.sequence(index)
    truth = dataset.truth(sequence) if dataset.has_truth else None
    _check_shape(sequence, estimate)
    if frame is None:
        frame = middle_frame(sequence) if truth or estimate else min(START_FRAMES, sequence.frames) - 1
    elif not 0 <= frame < sequence.frames:
        raise VbbenchError(f"sequence {index} has frames 0 to {sequence.frames - 1}, not {frame}")
    return Moment(
        info=dataset.info,
        sequence=sequence,
        frame=frame,
        truth=truth,
        estimate=estimate,
        solver=solver,
        protocol=get_protocol(protocol),
    )


def middle_frame(sequence: Sequence) -> int:
    """The fullest frame of the middle third."""
    first = sequence.frames // 3
    people = sequence.observed.sum(axis=1)[first : max(first + 1, 2 * sequence.frames // 3)]
    return first + int(people.argmax())


def _check_shape(sequence: Sequence, estimate: Estimate | None) -> None:
    wanted = (*sequence.observed.shape, 2)
    if estimate is not None and estimate.positions.shape != wanted:
        raise VbbenchError(
            f"the estimate has positions {list(estimate.positions.shape)}, sequence {sequence.index} has {list(wanted)}"
        )
