"""Subject of a card: everything that is published of a dataset, with the meaning, unit and key of each column."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from vbbench.files.cards.origin import Origin, Publisher
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.files.tables import CAMERA, table_schema
from vbbench.parsing.json_text import canonical_digest, read_object
from vbbench.parsing.toml_text import bundled_table


@dataclass(frozen=True, kw_only=True)
class TableMeaning:
    """The meaning of a table.

    Parameters
    ----------
    about : meaning of a row.
    key : columns whose values together identify a row.
    columns : meaning and unit of every column.
    """

    about: str
    key: Sequence[str]
    columns: Mapping[str, str]


@cache
def table_meanings() -> dict[str, TableMeaning]:
    """Every table that a dataset can have; `vbbench.files.tables.SCHEMAS` has the types."""
    return {name: TableMeaning(**facts) for name, facts in bundled_table(__package__, "tables.toml").items()}


RELATIVE = "truth/scenes relative"
"""``truth/scenes`` where people were measured relative to the camera only."""


_ORDER = ("observations", "given", "odometry", "sequences")


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A dataset as its card shows it.

    Parameters
    ----------
    info : its published facts.
    values : the same as the object in ``dataset.json``.
    info_file : size in bytes and SHA-256 of ``dataset.json``.
    origin : its origin.
    publisher : the publisher's additions.
    """

    info: DatasetInfo
    values: dict[str, Any]
    info_file: dict[str, Any]
    origin: Origin
    publisher: Publisher

    @property
    def id(self) -> str:
        """The dataset's id as ``dataset.json`` states it, since computing it takes time."""
        return str(self.values["id"])

    @property
    def digest(self) -> str:
        """Digest of the values in ``dataset.json``."""
        return digest_of(self.values)

    @property
    def is_footage(self) -> bool:
        """Whether the boxes are from pictures of a real camera or a game."""
        imported = self.info.definition.get("of")
        return "every" in (imported if isinstance(imported, dict) else self.info.definition)

    @property
    def tables(self) -> list[str]:
        """Names of the tables in the folder, in the order of the card."""
        return tables_here(self.info)

    def meaning(self, table: str) -> TableMeaning:
        """The meaning of a table."""
        return table_meanings()[RELATIVE if self.info.truth == "relative" and table == "truth/scenes" else table]

    def columns(self, table: str) -> list[tuple[str, Any, str]]:
        """Name, Arrow type and meaning of every column of a table."""
        meanings = self.meaning(table).columns
        schema = table_schema(table, [CAMERA] if self.info.cameras else [])
        return [(field.name, field.type, meanings[field.name]) for field in schema]


def read_info_file(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """The values in ``dataset.json``, and its bytes and SHA-256."""
    data = (folder / INFO_FILE).read_bytes()
    values = read_object(folder / INFO_FILE, "generate the dataset again")
    return values, {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}


def digest_of(values: dict[str, Any]) -> str:
    """Digest of the values of a ``dataset.json``; older versions do not contain it."""
    return str(values.get("digest") or canonical_digest(values))


def tables_here(info: DatasetInfo) -> list[str]:
    """Names of the tables in the folder of a dataset, without those of withheld truth."""
    names = [name for name in _ORDER if name in info.tables]
    truth = [name for name in sorted(info.tables) if name.startswith("truth/")]
    return names if info.seed is None else [*names, *truth]
