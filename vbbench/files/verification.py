"""Verifies a dataset folder: every checksum, and every invariant that readers rely on."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from vbbench.errors import FileError
from vbbench.files.cards.writing import check_cards
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE
from vbbench.files.tables import file_sha256
from vbbench.geometry import IntArray
from vbbench.parsing.json_text import read_json
from vbbench.sequence import Sequence

SAME_PLACE = 1e-9
"""Most m between a given position and the true one: sine and cosine may differ in the last bit between machines."""


def verify(folder: Path | str, truth: Path | str | None = None) -> str:
    """Verify a dataset folder; returns a line with the checks.

    Raises FileError at the first table whose checksum differs, or whose rows are inconsistent.
    """
    dataset = Dataset(folder, truth)
    checked = list(_check_sums(dataset))
    people = [_check_sequence(dataset, sequence) for sequence in dataset.sequences()]
    _check_counts(dataset, np.concatenate(people))
    found = f"{folder}: {len(checked)} tables and {len(dataset)} sequences are as written"
    if dataset.info.truth == "none":
        found += "; no truth was ever measured"
    elif not dataset.has_truth:
        found += "; truth is withheld and was not checked"
    elif truth:
        found += f"; truth is the published one, SHA-256 {dataset.info.truth_sha256}"
    if "digest" not in read_json(dataset.folder / INFO_FILE):
        found += f"; {INFO_FILE} has no digest (older format): its title, caution and scenes' names were not checked"
    return found + check_cards(dataset.folder, dataset.info)


def _check_sums(dataset: Dataset) -> Iterator[str]:
    for name, facts in dataset.info.tables.items():
        path = dataset.table_path(name)
        if name.startswith("truth/") and not dataset.has_truth:
            continue
        if not path.is_file():
            raise FileError(path, "the file is missing; generate the dataset again")
        if file_sha256(path) != facts["sha256"]:
            raise FileError(path, f"its SHA-256 is not the one in {INFO_FILE}; generate the dataset again")
        if pq.read_metadata(path).num_rows != facts["rows"]:
            raise FileError(path, f"has other rows than the {facts['rows']} in {INFO_FILE}; generate the dataset again")
        yield name


def _check_counts(dataset: Dataset, people: IntArray) -> None:
    """Compare the counts with the number of people in each frame of the dataset [F]."""
    seen = people[people > 0]
    found = {
        "sequences": len(dataset),
        "frames": len(seen),
        "observations": int(seen.sum()),
        "people_min": int(seen.min(initial=1 << 30)),
        "people_max": int(seen.max(initial=0)),
    }
    for name, count in found.items():
        if dataset.info.counts.get(name) != count:
            problem = f"key 'counts' has {dataset.info.counts.get(name)} {name}, the tables {count}"
            raise FileError(dataset.folder / INFO_FILE, f"{problem}; generate the dataset again")


def _check_sequence(dataset: Dataset, sequence: Sequence) -> IntArray:
    """Check one sequence; return the number of people in each frame [T]."""
    where = f"sequence {sequence.index}"
    boxes, seen = sequence.observations, sequence.observed
    if not np.isfinite(boxes[seen]).all() or (boxes[seen][:, 2] <= 0).any():
        raise FileError(dataset.table_path("observations"), f"{where}: a box is not finite or has no height")
    first = 2 if dataset.info.truth == "whole" else 1
    if np.isnan(sequence.given.poses[:first]).any():
        raise FileError(dataset.table_path("given"), f"{where}: the observer's first poses are not given")
    if (~np.isnan(sequence.given.positions[..., 0]) & ~seen).any():
        raise FileError(dataset.table_path("given"), f"{where}: a position is given of a person who is not observed")
    if dataset.has_whole_truth:
        _check_truth(dataset, sequence, where)
    elif dataset.has_truth and dataset.info.truth == "relative":
        dataset.relative_truth(sequence)  # which checks it
    people: IntArray = seen.sum(axis=1)
    return people


def _check_truth(dataset: Dataset, sequence: Sequence, where: str) -> None:
    truth, given = dataset.truth(sequence), sequence.given
    if not np.isfinite(truth.poses).all():
        raise FileError(dataset.table_path("truth/poses"), f"{where}: wanted {sequence.frames} finite poses")
    known = ~np.isnan(given.positions)
    if not np.allclose(given.positions[known], truth.positions[known], rtol=0.0, atol=SAME_PLACE):
        raise FileError(dataset.table_path("given"), f"{where}: a given position is not the true one")
