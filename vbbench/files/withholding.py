"""Withheld truth: the maintainer's private folder, the public dataset, and the check that they belong together.

The private folder holds the truth tables and the seed, from which a simulated dataset's truth can be regenerated. The
dataset keeps the SHA-256 of every truth table, and its id, which is computed from the seed and everything else.
"""

import json
import secrets
from dataclasses import replace
from pathlib import Path

from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.folders.work_folder import NEW_TRUTH, TRUTH, WORK, next_to, real
from vbbench.parsing.json_text import read_json

SEED_FILE = "seed.json"
SECRET_BITS = 128
GUESSABLE_BITS = 64
"""A seed of this many bits or fewer can be found by trial: the published hashes confirm a correct guess."""


def draw_seed() -> int:
    """A new seed that cannot be guessed."""
    return 1 << (SECRET_BITS - 1) | secrets.randbits(SECRET_BITS - 1)


def secret_seed(out: Path) -> int:
    """An unguessable seed: that of an interrupted run into ``out``, or a new one."""
    path = next_to(real(out), WORK) / NEW_TRUTH / SEED_FILE
    seed = read_seed(path) if path.is_file() else 0
    return seed if seed.bit_length() > GUESSABLE_BITS else draw_seed()


def truth_folder_of(out: Path) -> Path:
    """The folder of the withheld truth of the dataset ``out``."""
    return next_to(real(out), TRUTH)


def check_truth_free(kept: Path, overwrite: bool) -> None:
    """Raise VbbenchError if withheld truth cannot be written to ``kept``; ``overwrite`` replaces truth alone."""
    if not kept.exists():
        return
    if not kept.is_dir() or any(path.name != SEED_FILE and path.suffix != ".parquet" for path in kept.iterdir()):
        raise VbbenchError(f"{kept} exists and is not a withheld truth; move it or choose another folder")
    if not overwrite:
        raise VbbenchError(f"{kept} exists and may be the only copy of a truth; set `overwrite` to replace it")


def keep_seed(info: DatasetInfo, truth: Path) -> None:
    """Write the seed of a dataset into the folder ``truth``."""
    write_text_atomically(truth / SEED_FILE, json.dumps({"dataset": info.id, "seed": info.known_seed}) + "\n")


def check_truth(info: DatasetInfo, truth: Path) -> None:
    """Raise FileError unless ``truth`` holds tables with the published hashes, and no other seed than the id's."""
    for name, facts in info.truth_tables.items():
        path = truth / name
        if not path.is_file():
            raise FileError(path, "this truth table is missing; name the folder that holds all of them with `truth`")
        if path.stat().st_size != facts["bytes"] or file_sha256(path) != facts["sha256"]:
            raise FileError(path, f"is not the truth of dataset {info.id}: its SHA-256 is not the published one")
    if not (truth / SEED_FILE).is_file():
        return
    if replace(info, seed=read_seed(truth / SEED_FILE), withheld_id=None).id != info.id:
        raise FileError(truth / SEED_FILE, f"is not the seed of dataset {info.id}: another id follows from it")


def read_seed(path: Path) -> int:
    """The seed in a ``seed.json``."""
    try:
        return int(read_json(path)["seed"])
    except (ValueError, KeyError, TypeError, OverflowError) as error:
        raise FileError(path, f'is damaged ({error!r}); wanted {{"dataset": ID, "seed": NUMBER}}') from error
