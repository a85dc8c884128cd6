"""Everything about a submission that can be checked without truth: participants of a challenge have none."""

from dataclasses import dataclass
from pathlib import Path

from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.submission import SubmissionInfo
from vbbench.protocol import Protocol
from vbbench.scoring.answers import CheckedSubmission


@dataclass(frozen=True, kw_only=True)
class Share:
    """How many of the rows that are scored a submission has."""

    there: int
    wanted: int

    def __str__(self) -> str:
        return f"{self.there} of {self.wanted}"


@dataclass(frozen=True, kw_only=True)
class Checked:
    """A submission without a fault.

    Parameters
    ----------
    info, dataset, protocol : the submission's facts, the dataset it answers, and how it was solved.
    poses, positions : rows that must be there. Boxes of nobody are among them, which are not scored: only truth tells.
    """

    info: SubmissionInfo
    dataset: DatasetInfo
    protocol: Protocol
    poses: Share
    positions: Share

    def table(self) -> str:
        """What was checked, for people."""
        info, data = self.info, self.dataset
        lines = [
            f"{f'{info.solver} {info.version}'.strip()} on {data.split} ({data.camera.kind}, {data.tier}, {data.id}), "
            f"{self.protocol.id}: no fault",
            f"{self.poses} poses and {self.positions} positions that must be answered; "
            f"missing rows: {info.failure_policy}",
        ]
        if self.poses.there < self.poses.wanted or self.positions.there < self.positions.wanted:
            lines.append("A missing row counts as the last one known of the same person in the same sequence.")
        return "\n".join(lines)


def check_submission(submission: Path | str, dataset: Dataset) -> Checked:
    """Check a submission without truth; rows of false alarms, which are never scored, are then required as well.

    Raises
    ------
    SubmissionError
        With every fault, if there is any.
    """
    checked = CheckedSubmission(Path(submission), dataset, None)
    parts = [
        [answers.posed.sum(), len(answers.posed), answers.placed.sum(), len(answers.placed)]
        for _, answers in checked.chunks()
    ]
    posed, poses, placed, positions = (int(sum(column)) for column in zip(*parts, strict=True))
    return Checked(
        info=checked.info,
        dataset=dataset.info,
        protocol=checked.protocol,
        poses=Share(there=posed, wanted=poses),
        positions=Share(there=placed, wanted=positions),
    )
