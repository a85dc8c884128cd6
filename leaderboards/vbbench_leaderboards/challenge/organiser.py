"""An organiser's folder: ``challenge.toml``, the secret set and its truth, submissions, the log, and results."""

import hashlib
import hmac
import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE
from vbbench.files.withholding import GUESSABLE_BITS, SEED_FILE, read_seed, truth_folder_of
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import IntArray
from vbbench_leaderboards.challenge.definition import Challenge, Part, read_challenge
from vbbench_leaderboards.results.dataset_record import BoardDataset, ScoredSequences, read_dataset
from vbbench_leaderboards.results.folder import CHALLENGE_FILE

DATA = "data"
LOG_FILE = "log.jsonl"
FIRST = "0" * 64
"""What stands for the line before the first."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A submission that was handed in: a line of the log, chained to the one before by SHA-256.

    Parameters
    ----------
    number : from 1 on, accepted or not.
    time, written : when it was handed in, in UTC, and when that was written down.
    team, phase : who, and in which phase; a phase is empty where none was open.
    decision, reason : what became of it, and why it was refused.
    answers : SHA-256 of what it answers, whatever its files look like; empty where that could not be read.
    files : file → SHA-256 of each file.
    about : the facts of the team's row (`About`).
    before : SHA-256 of the line before.
    """

    number: int
    time: str
    written: str
    team: str
    phase: str
    decision: Literal["accepted", "refused"]
    reason: str = ""
    answers: str = ""
    files: dict[str, str] = field(default_factory=dict)
    about: dict[str, Any] = field(default_factory=dict)
    before: str = FIRST

    @property
    def is_accepted(self) -> bool:
        """Whether it counts."""
        return self.decision == "accepted"

    @property
    def folder(self) -> Path:
        """Where an accepted submission is kept, below the challenge's folder."""
        return Path("submissions", f"{self.number:04}-{self.team}")

    @property
    def day(self) -> str:
        """The day on which it was handed in."""
        return self.time[:10]

    @property
    def line(self) -> str:
        """Its line of the log."""
        return json.dumps(asdict(self), ensure_ascii=False)


def read_log(folder: Path) -> list[Entry]:
    """The entries in order; raises FileError at a damaged line, or where the line before is not the original."""
    path, entries, before = folder / LOG_FILE, list[Entry](), FIRST
    for number, line in enumerate(path.read_text("utf-8").splitlines() if path.is_file() else (), 1):
        try:
            entry = Entry(**json.loads(line))
        except (ValueError, TypeError) as error:
            raise FileError(path, f"is damaged ({error}); restore a copy", number) from error
        if (entry.number, entry.before) != (number, before):
            raise FileError(path, "a line before this one was changed or removed; restore a copy", number)
        entries.append(entry)
        before = hashlib.sha256(line.encode()).hexdigest()
    return entries


def append(folder: Path, entries: list[Entry], entry: Entry) -> None:
    """Write the log with one entry more."""
    write_text_atomically(folder / LOG_FILE, "".join(f"{each.line}\n" for each in [*entries, entry]))


def digest_of_last(entries: list[Entry]) -> str:
    """SHA-256 of the last line, which stands for the whole log."""
    return hashlib.sha256(entries[-1].line.encode()).hexdigest() if entries else FIRST


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
        return truth_folder_of(self.data)

    def results(self, part: Part) -> Path:
        """The result files of a part."""
        return self.folder / "results" / part

    @cached_property
    def dataset(self) -> Dataset:
        """The secret set, its truth compared with the published hashes.

        Raises VbbenchError if it is missing, is not withheld, or is another one than that of ``challenge.toml``.
        """
        if not (self.data / INFO_FILE).is_file():
            raise FileError(self.data, "the secret set is missing; make it with 'vbbench challenge generate'")
        if not self.truth.is_dir():
            raise FileError(self.truth, "the secret truth is missing; if this is a bundle, name the folder it is from")
        found, wanted = Dataset(self.data, self.truth), self.challenge.data
        check_withheld(self.data)
        if (found.info.split, found.info.tier) != (wanted.split, wanted.tier):
            here = f"{self.data} is {found.info.split} {found.info.tier}"
            problem = f"[data] is {wanted.split} {wanted.tier}, {here}; correct one of them"
            raise FileError(self.folder / CHALLENGE_FILE, problem)
        return found

    @cached_property
    def parts(self) -> dict[Part, IntArray]:
        """The numbers of the sequences of each part; raises FileError if they changed since submissions were scored."""
        divided, protocol = parts_of(self.dataset, self.challenge.data.public_share), str(self.challenge.protocol)
        for part, sequences in divided.items():
            path = self.results(part) / self._whole_record.path
            scored = read_dataset(path).scored.get(protocol) if path.is_file() else self._scored(sequences)
            if scored is None or not np.array_equal(scored.sequence, self._scored(sequences).sequence):
                problem = f"protocol or public_share is another than when submissions were scored ({path})"
                raise FileError(self.folder / CHALLENGE_FILE, f"{problem}; write it as it was")
        return divided

    @cached_property
    def entries(self) -> list[Entry]:
        """The log as it is when it is first read."""
        return read_log(self.folder)

    def record(self, part: Part) -> BoardDataset:
        """The record of the dataset of a part's board: the secret set, of which the part's sequences are scored."""
        scored: dict[str, ScoredSequences] = {self.challenge.protocol: self._scored(self.parts[part])}
        return replace(self._whole_record, title=f"{self.challenge.title}, {part} part", scored=scored)

    @cached_property
    def _whole_record(self) -> BoardDataset:
        return BoardDataset.of(self.dataset)

    def _scored(self, part: IntArray) -> ScoredSequences:
        scored = self._whole_record.scored[str(self.challenge.protocol)]
        keep = np.isin(scored.sequence, part)
        return ScoredSequences(**{name: values[keep] for name, values in vars(scored).items()})

    def last_accepted(self, phases: set[str]) -> dict[str, Entry]:
        """Team → its last submission in these phases, which is the one that counts."""
        return {entry.team: entry for entry in self.entries if entry.is_accepted and entry.phase in phases}

    def shows_hidden(self, moment: datetime) -> bool:
        """Whether figures of the hidden part may be computed and shown: once its phase has closed."""
        return self.challenge.hidden_phase is not None and self.challenge.is_over(moment)


def check_withheld(data: Path) -> None:
    """Raise FileError if a dataset's folder gives its truth or its seed away."""
    if (data / "truth").exists() or Dataset(data).info.seed is not None:
        raise FileError(data, "its truth or seed is not withheld; make it with --seed secret --withhold-truth")


def generate(folder: Path, make: Callable[[list[str]], object]) -> Path:
    """Make the secret set of a challenge by a ``vbbench`` that ``make`` runs with such words; return its folder.

    Raises FileError if it exists, or the options in ``challenge.toml`` are not valid.
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


def parts_of(dataset: Dataset, public_share: float) -> dict[Part, IntArray]:
    """The numbers of the public and of the hidden sequences, ascending: they follow from the secret seed alone.

    Groups of sequences are put in order by HMAC-SHA256 of their scene and first frame, with the secret seed as the key;
    the first groups, up to the share of sequences that is nearest to ``public_share``, are public.

    Raises VbbenchError if the seed can be guessed, or all sequences belong together.
    """
    seed = read_seed(dataset.truth_folder / SEED_FILE)
    if seed.bit_length() <= GUESSABLE_BITS:
        raise VbbenchError(f"{dataset.folder}: its seed can be guessed, and its parts with it; use --seed secret")
    groups = _together(dataset.rows)
    if len(groups) < 2:
        problem = "all sequences share moments of one scene, so that public scores would reveal hidden ones; add scenes"
        raise VbbenchError(f"{dataset.folder}: {problem}")

    def place(group: IntArray) -> bytes:
        scene, first = (dataset.rows[name][group].min() for name in ("scene", "first_frame"))
        return hmac.digest(str(seed).encode(), f"{dataset.info.id} {scene} {first}".encode(), hashlib.sha256)

    ordered = sorted(groups, key=place)
    sizes = np.cumsum([len(group) for group in ordered])[:-1]
    public = int(np.abs(sizes - public_share * len(dataset)).argmin()) + 1
    halves: dict[Part, list[IntArray]] = {"public": ordered[:public], "hidden": ordered[public:]}
    return {part: np.sort(np.concatenate(half)) for part, half in halves.items()}


def _together(rows: Mapping[str, NDArray[Any]]) -> list[IntArray]:
    """Groups of sequences of one scene whose frames overlap, directly or through others: they show the same people."""
    scene, first = rows["scene"].astype(np.int64), rows["first_frame"].astype(np.int64)
    order, apart = np.lexsort([first, scene]), int(first.max() + rows["frames"].max()) + 1
    begins = (scene * apart + first)[order]  # scenes after one another on one axis
    ends = np.maximum.accumulate(begins + rows["frames"][order] - 1)
    return np.split(order, np.flatnonzero(begins[1:] > ends[:-1]) + 1)
