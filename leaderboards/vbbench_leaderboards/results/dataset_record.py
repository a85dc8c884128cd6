"""The record of a board's dataset: one committed file per split and tier, ``SPLIT/TIER.json`` next to the results."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.camera import camera_to_dict
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import summary
from vbbench.files.generate_command import generate_command
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import IntArray
from vbbench.protocol import PROTOCOLS, Protocol, get_protocol
from vbbench.registry import load, registered
from vbbench.scoring.scored_rows import TruthRows, scored_rows
from vbbench.sequence import NOBODY
from vbbench_leaderboards.results.sealed_json import (
    FORMAT_VERSION,
    decode,
    encode,
    read_object,
    sealed_text,
    whole_columns,
)


@dataclass(frozen=True, kw_only=True)
class ScoredSequences:
    """What a protocol scores: the sequences with a scored frame.

    Parameters
    ----------
    sequence : [N] its number.
    scene, first_frame, last_frame : [N] its scene, and its first and last frame there: what intervals rest upon.
    frames, positions : [N] its scored frames and positions.
    """

    sequence: IntArray
    scene: IntArray
    first_frame: IntArray
    last_frame: IntArray
    frames: IntArray
    positions: IntArray


@dataclass(frozen=True, kw_only=True)
class BoardDataset:
    """What everybody who stands on a board has solved.

    Parameters
    ----------
    id, split, tier, title, seed, dt, caution : as in ``dataset.json``; a withheld seed is ``None``.
    camera : its parameters, as there.
    command : the ``vbbench generate`` line that makes it.
    counts : its row of the paper's Table 1, as ``vbbench info --json`` prints it.
    licence, citation : of the recordings that it is made from.
    tables : file → SHA-256, the truth's among them, so that withheld truth can be audited later.
    scored : protocol → what it scores.
    """

    id: str
    split: str
    tier: str
    title: str
    camera: dict[str, Any]
    seed: int | None
    dt: float
    command: str
    counts: dict[str, Any]
    caution: str | None
    licence: str
    citation: str
    tables: dict[str, str]
    scored: Mapping[str, ScoredSequences]

    @property
    def path(self) -> Path:
        """Where its file lies below the folder of results."""
        return record_path(self.split, self.tier)

    @property
    def advice(self) -> str:
        """How to get the dataset and onto its boards."""
        if self.seed is None:
            return "ask who withholds its truth for that dataset, and solve it"
        return f"make that with '{self.command}' and solve it"

    @staticmethod
    def of(dataset: Dataset) -> "BoardDataset":
        """The record of a dataset whose truth is available."""
        info = dataset.info
        card = load("generator", info.split).card if info.split in registered("generator") else None
        return BoardDataset(
            id=info.id,
            split=info.split,
            tier=info.tier,
            title=info.title,
            camera=camera_to_dict(info.camera),
            seed=info.seed,
            dt=info.dt,
            command=generate_command(json.loads(info.to_json()), f"{info.split}-{info.tier}"),
            counts=summary(info),
            caution=info.caution,
            licence=card.licence if card else "",
            citation=card.citation if card else "",
            tables={name: facts["sha256"] for name, facts in info.tables.items()},
            scored={
                name: scored_sequences(dataset, rules)
                for name, rules in ((name, get_protocol(name)) for name in PROTOCOLS)
                if rules.given == "origin" or info.truth == "whole"
            },
        )


def record_path(split: str, tier: str) -> Path:
    """Where the record of a split and tier lies below the folder of results."""
    return Path(split, f"{tier}.json")


def read_dataset(path: Path) -> BoardDataset:
    """Read a record.

    Raises FileError if it is of another form or was changed by hand.
    """
    values = read_object(path, "dataset")
    scored = {
        name: ScoredSequences(**whole_columns(decode(block), block["columns"], path, f"$.scored.{name}"))
        for name, block in values["scored"].items()
    }
    facts = {name: value for name, value in values.items() if name not in ("format_version", "digest")}
    return BoardDataset(**{**facts, "scored": scored})


def write_dataset(record: BoardDataset, results: Path) -> None:
    """Write a record below the folder ``results``, whole or not at all."""
    path, scored = results / record.path, {name: encode(vars(part)) for name, part in record.scored.items()}
    values = {"format_version": FORMAT_VERSION, **vars(record), "scored": scored}
    write_text_atomically(path, sealed_text(values, path, "dataset"))


def scored_sequences(dataset: Dataset, protocol: Protocol) -> ScoredSequences:
    """What a protocol scores of a dataset."""
    truth, size = TruthRows(dataset), len(dataset)
    frames, positions = np.zeros(size, np.int64), np.zeros(size, np.int64)
    for rows in scored_rows(dataset, protocol):
        known = truth.persons(rows) != NOBODY
        frames += np.bincount(rows.pose_sequence, minlength=size)
        positions += np.bincount(rows.sequence[known], minlength=size)
    there = np.flatnonzero(frames)
    first = dataset.rows["first_frame"][there]
    return ScoredSequences(
        sequence=there,
        scene=dataset.rows["scene"][there],
        first_frame=first,
        last_frame=first + dataset.rows["frames"][there] - 1,
        frames=frames[there],
        positions=positions[there],
    )
