"""An organiser's folder: ``challenge.toml``, the secret set and its truth, submissions, the log, and results."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from importlib.resources import files
from pathlib import Path

import numpy as np

from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE
from vbbench.files.withholding import truth_folder_beside
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import IntArray
from vbbench_leaderboards.challenge.definition import Challenge, Part, read_challenge
from vbbench_leaderboards.challenge.log import Entry, read_log
from vbbench_leaderboards.challenge.parts import parts_of
from vbbench_leaderboards.results.dataset_record import BoardDataset, ScoredSequences, read_dataset, record_path
from vbbench_leaderboards.results.folder import CHALLENGE_FILE

DATA = "data"
RESULTS = "results"


@dataclass(frozen=True)
class Organiser:
    """The folder of a challenge, with all that is read from it."""

    folder: Path

    @cached_property
    def challenge(self) -> Challenge:
        """``challenge.toml``."""
        return read_challenge(self.folder)

    @property
    def data(self) -> Path:
        """The secret set, without its truth."""
        return self.folder / DATA

    @property
    def truth(self) -> Path:
        """Its truth, and the seed."""
        return truth_folder_beside(self.data)

    def results(self, part: Part) -> Path:
        """The result files of a part."""
        return self.folder / RESULTS / part

    @cached_property
    def dataset(self) -> Dataset:
        """The secret set, its truth compared with the published hashes.

        Raises
        ------
        VbbenchError
            If it is missing, is not withheld, or is another one than ``challenge.toml`` says.
        """
        if not (self.data / INFO_FILE).is_file():
            raise FileError(self.data, "the secret set is missing; make it with 'vbbench challenge generate'")
        if not self.truth.is_dir():
            raise FileError(self.truth, "the secret truth is missing; if this is a bundle, name the folder it is from")
        found, wanted = Dataset(self.data, self.truth), self.challenge.data
        check_withheld(self.data)
        if (found.info.split, found.info.tier) != (wanted.split, wanted.tier):
            raise FileError(
                self.folder / CHALLENGE_FILE,
                f"[data] is {wanted.split} {wanted.tier}, {self.data} is {found.info.split} {found.info.tier}; "
                "correct one of them",
            )
        return found

    @cached_property
    def parts(self) -> dict[Part, IntArray]:
        """The numbers of the sequences of each part.

        Raises
        ------
        FileError
            If they are others than when submissions were scored.
        """
        divided = parts_of(self.dataset, self.challenge.data.public_share)
        for part, sequences in divided.items():
            path = self.results(part) / record_path(self.challenge.data.split, self.challenge.data.tier)
            if path.is_file():
                self._check_same(path, sequences)
        return divided

    def _check_same(self, path: Path, sequences: IntArray) -> None:
        """Raise FileError if the record at ``path`` scores other sequences of a part than these."""
        protocol: str = self.challenge.protocol
        scored, wanted = read_dataset(path).scored.get(protocol), _only(self._whole_record.scored[protocol], sequences)
        if scored is None or not np.array_equal(scored.sequence, wanted.sequence):
            problem = f"protocol or public_share is another than when submissions were scored ({path})"
            raise FileError(self.folder / CHALLENGE_FILE, f"{problem}; write it as it was")

    @cached_property
    def entries(self) -> list[Entry]:
        """The log as it is when first asked for."""
        return read_log(self.folder)

    def record(self, part: Part) -> BoardDataset:
        """The record of the dataset of a part's board: the secret set, of which the part's sequences are scored."""
        protocol: str = self.challenge.protocol
        scored = {protocol: _only(self._whole_record.scored[protocol], self.parts[part])}
        return replace(self._whole_record, title=f"{self.challenge.title}, {part} part", scored=scored)

    @cached_property
    def _whole_record(self) -> BoardDataset:
        return BoardDataset.of(self.dataset)

    def last_accepted(self, phase: str) -> dict[str, Entry]:
        """Team → its last submission in a phase, which is the one that counts."""
        return {entry.team: entry for entry in self.entries if entry.is_accepted and entry.phase == phase}

    def last_of_part(self, part: Part) -> dict[str, Entry]:
        """Team → its last submission in any phase that a part is scored in."""
        phases = {phase.name for phase in self.challenge.phases if phase.part == part}
        return {entry.team: entry for entry in self.entries if entry.is_accepted and entry.phase in phases}

    def shows_hidden(self, moment: datetime) -> bool:
        """Whether figures of the hidden part may be computed and shown: once its phase has closed."""
        return self.challenge.hidden_phase is not None and self.challenge.is_over(moment)


def check_withheld(data: Path) -> None:
    """Raise FileError if a dataset's folder gives its truth or its seed away."""
    if (data / "truth").exists() or Dataset(data).info.seed is not None:
        raise FileError(data, "its truth or seed is not withheld; make it with --seed secret --withhold-truth")


def start(folder: Path) -> Path:
    """Write a commented ``challenge.toml`` into a folder, created if necessary; return its path."""
    path, text = folder / CHALLENGE_FILE, (files("vbbench_leaderboards.challenge") / "start.toml").read_text("utf-8")
    with loose_files(folder):
        if path.exists() and not (path.is_file() and path.read_bytes() == text.encode()):
            raise VbbenchError(f"{path} exists and may be yours; choose another folder")
        write_text_atomically(path, text)
    return path


def generate(folder: Path, make: Callable[[list[str]], object]) -> Path:
    """Make the secret set of a challenge; return its folder.

    Parameters
    ----------
    make : runs ``vbbench`` with such words.

    Raises
    ------
    FileError
        If it exists, or the options in ``challenge.toml`` are not valid.
    """
    organiser = Organiser(folder)
    wanted = organiser.challenge.data
    if organiser.data.exists() or organiser.truth.exists():
        raise FileError(organiser.data, "exists, or its truth does, and may be the only copy; move both away")
    words = ["generate", wanted.split, "--tier", wanted.tier, *wanted.words, "--seed", "secret", "--withhold-truth"]
    try:
        make([*words, "--out", str(organiser.data)])
    except VbbenchError as error:
        raise FileError(folder / CHALLENGE_FILE, f"[data]: {error}") from error
    _ = organiser.parts  # they must be possible
    return organiser.data


def _only(scored: ScoredSequences, part: IntArray) -> ScoredSequences:
    keep = np.isin(scored.sequence, part)
    return ScoredSequences(**{name: values[keep] for name, values in vars(scored).items()})
