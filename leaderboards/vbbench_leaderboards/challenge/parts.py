"""Which sequences of the secret set are public and which hidden: it follows from the secret seed alone.

Sequences that share a moment of a scene show the same people at the same time, so that a score on one tells about the
other: they stay together.
"""

import hashlib
import hmac
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.withholding import GUESSABLE_BITS, SEED_FILE, read_seed
from vbbench.geometry import IntArray
from vbbench_leaderboards.challenge.definition import Part


def parts_of(dataset: Dataset, public_share: float) -> dict[Part, IntArray]:
    """The numbers of the public and of the hidden sequences, ascending.

    Groups of sequences are put in order by HMAC-SHA256 of their scene and first frame, with the secret seed as the key;
    the first groups, up to the share of sequences that is nearest to ``public_share``, are public.

    Raises
    ------
    VbbenchError
        If the seed can be guessed, or all sequences belong together.
    """
    seed = read_seed(dataset.truth_folder / SEED_FILE)
    if seed.bit_length() <= GUESSABLE_BITS:
        raise VbbenchError(f"{dataset.folder}: its seed can be guessed, and its parts with it; use --seed secret")
    groups = _together(dataset.rows)
    if len(groups) < 2:
        raise VbbenchError(
            f"{dataset.folder}: all sequences share moments of one scene, so that public scores would tell of hidden "
            "ones; add scenes"
        )

    def place(group: IntArray) -> bytes:
        scene, first = (dataset.rows[name][group].min() for name in ("scene", "first_frame"))
        return hmac.digest(str(seed).encode(), f"{dataset.info.id} {scene} {first}".encode(), hashlib.sha256)

    ordered = sorted(groups, key=place)
    sizes = np.cumsum([len(group) for group in ordered])[:-1]
    public = int(np.abs(sizes - public_share * len(dataset)).argmin()) + 1
    halves: dict[Part, list[IntArray]] = {"public": ordered[:public], "hidden": ordered[public:]}
    return {part: np.sort(np.concatenate(half)) for part, half in halves.items()}


def _together(rows: Mapping[str, NDArray[Any]]) -> list[IntArray]:
    """Groups of sequences: those of a scene whose frames overlap, directly or through others."""
    scene, first = rows["scene"].astype(np.int64), rows["first_frame"].astype(np.int64)
    last = first + rows["frames"] - 1
    groups: list[list[int]] = []
    until = (-1, -1)
    for row in np.lexsort([first, scene]).tolist():
        if scene[row] == until[0] and first[row] <= until[1]:
            groups[-1].append(row)
        else:
            groups.append([row])
            until = (-1, -1)
        until = (int(scene[row]), max(until[1], int(last[row])))
    return [np.array(group) for group in groups]
