"""Withheld truth: what a maintainer keeps, what is published of it, and whether the two belong together.

The truth tables and the seed, from which a simulated dataset's truth could be made again, go to a folder of their own.
The dataset keeps the SHA-256 of every truth table, and its id, which follows from the seed and all else.
"""

import json
import secrets
from pathlib import Path

from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.folders.swapping import NEW_TRUTH, TRUTH, WORK, beside, real
from vbbench.parsing.json_text import read_json

SEED_FILE = "seed.json"
SECRET_BITS = 128
GUESSABLE_BITS = 64
"""A seed of no more bits can be found by trying: the published SHA-256 say when a guess is right."""


def draw_seed() -> int:
    """A seed that nobody can guess."""
    return 1 << (SECRET_BITS - 1) | secrets.randbits(SECRET_BITS - 1)


def secret_seed(out: Path) -> int:
    """A seed that nobody can guess: that with which work on ``out`` was interrupted, or a new one."""
    path = beside(real(out), WORK) / NEW_TRUTH / SEED_FILE
    seed = _read_seed(path) if path.is_file() else 0
    return seed if seed.bit_length() > GUESSABLE_BITS else draw_seed()


def truth_folder_beside(out: Path) -> Path:
    """Where withheld truth is kept."""
    return beside(real(out), TRUTH)


def check_truth_free(kept: Path, overwrite: bool) -> None:
    """Raise VbbenchError if ``kept``, where withheld truth is to go, is in the way: only truth is ever replaced."""
    if not kept.exists():
        return
    if not kept.is_dir() or not all(_is_of_truth(path.name) for path in kept.iterdir()):
        raise VbbenchError(f"{kept} exists and is not a withheld truth; move it or choose another folder")
    if not overwrite:
        raise VbbenchError(f"{kept} exists and may be the only copy of a truth; set overwrite to replace it")


def _is_of_truth(name: str) -> bool:
    """Whether this is a file of withheld truth."""
    return name == SEED_FILE or name.endswith(".parquet")


def withhold(info: DatasetInfo, truth: Path) -> DatasetInfo:
    """Keep the seed beside the truth tables in the folder ``truth``; return what may be published."""
    keep_seed(info, truth)
    return info.without_seed()


def keep_seed(info: DatasetInfo, truth: Path) -> None:
    """Write the seed of a dataset into the folder ``truth``."""
    write_text_atomically(truth / SEED_FILE, json.dumps({"dataset": info.id, "seed": info.known_seed}) + "\n")


def check_truth(info: DatasetInfo, truth: Path) -> None:
    """Check that the folder ``truth`` holds what was published of it.

    Raises
    ------
    FileError
        If a table is missing or another one than was published, or the seed is not the one that the id follows from.
    """
    for name, facts in info.truth_tables.items():
        path = truth / name
        if not path.is_file():
            raise FileError(path, "this truth table is missing; name the folder that holds all of them")
        if path.stat().st_size != facts["bytes"] or file_sha256(path) != facts["sha256"]:
            raise FileError(path, f"is not the truth of dataset {info.id}: its SHA-256 is not the published one")
    if (truth / SEED_FILE).is_file() and info.with_seed(_read_seed(truth / SEED_FILE)).id != info.id:
        raise FileError(truth / SEED_FILE, f"is not the seed of dataset {info.id}: another id follows from it")


def _read_seed(path: Path) -> int:
    try:
        return int(read_json(path)["seed"])
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise FileError(path, f'is damaged ({error!r}); wanted {{"dataset": ID, "seed": NUMBER}}') from error
