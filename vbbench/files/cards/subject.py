"""Subject of a card: everything that is published of a dataset, with the meaning, unit and key of each column.

Origin of a dataset: licence, citation and sources of its split, and the publisher's additions.
"""

import hashlib
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from vbbench.errors import VbbenchError, is_printable, quoted
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.files.tables import CAMERA, table_schema
from vbbench.paper import the_paper
from vbbench.parsing.json_text import canonical_digest, read_object
from vbbench.parsing.numbers import is_day
from vbbench.parsing.toml_text import bundled_table
from vbbench.registry import load_registered, registered

OWN = ("the user's", "your own")
"""What splits of a user's own recording say of licence and citation: nobody but the user knows."""
LONGEST_NOTE = 1000
"""Most characters of what a publisher says."""


@dataclass(frozen=True, kw_only=True)
class Publisher:
    """Facts that the publisher of a dataset adds to its cards; ``None`` is omitted.

    Raises VbbenchError if a text is empty or not printable, or the day or the address is invalid.

    Parameters
    ----------
    creator : author of the dataset.
    url : address of its publication.
    published : day of publication, as YYYY-MM-DD.
    contact : address for questions and corrections.
    licence, citation : licence and citation of the publisher's own recording.
    """

    creator: str | None = None
    url: str | None = None
    published: str | None = None
    contact: str | None = None
    licence: str | None = None
    citation: str | None = None

    def __post_init__(self) -> None:
        for name, text in vars(self).items():
            if text is not None and not (0 < len(text.strip()) <= LONGEST_NOTE and is_printable(text)):
                raise VbbenchError(
                    f"{name} must be printable text of 1 to {LONGEST_NOTE} characters, not {quoted(text)}"
                )
        if self.url is not None and not self.url.startswith(("https://", "http://")):
            raise VbbenchError(f"url must be a web address such as https://..., not {quoted(self.url)}")
        if self.published is not None and not is_day(self.published):
            raise VbbenchError(f"published must be a day such as 2026-11-30, not {quoted(self.published)}")


@dataclass(frozen=True, kw_only=True)
class Origin:
    """The origin of a dataset.

    Parameters
    ----------
    licence, citation : licence and citation of the sources; ``None`` where the split is not installed.
    recorded : whether real people were filmed or measured; true if that is unknown.
    files : path and address of each public source file.
    tier : description of the dataset's tier.
    """

    licence: str | None
    citation: str | None
    recorded: bool
    files: tuple[tuple[str, str], ...]
    tier: str | None

    @property
    def is_own(self) -> bool:
        """Whether the publisher states licence and citation."""
        return self.licence is None or self.licence in OWN


def origin_of(info: DatasetInfo) -> Origin:
    """The origin of a dataset, from the ``card`` that is registered under the name of its split."""
    known: Any = None
    with suppress(VbbenchError):  # the split is not installed here, or cannot be loaded
        known = load_registered("generator", info.split).card
    return Origin(
        licence=(known and known.licence) or None,
        citation=(known and known.citation) or None,
        recorded=known is None or known.people == "recorded",
        files=tuple((source.path, source.url) for source in known.sources) if known else (),
        tier=load_registered("tier", info.tier).summary if info.tier in registered("tier") else None,
    )


def said_licence(origin: Origin, publisher: Publisher) -> str:
    """The licence in words: that of the sources, or the publisher's for an own recording.

    Raises VbbenchError if the publisher states another licence than that of the sources.
    """
    if publisher.licence is not None and not origin.is_own:
        raise VbbenchError(f"the licence is that of the sources, {quoted(str(origin.licence))}; remove yours")
    return publisher.licence or origin.licence or "not known: the split is not installed where this card was written"


def citations(origin: Origin, publisher: Publisher) -> list[str]:
    """What to cite: the publisher's own, the sources, the paper of the task."""
    paper = the_paper()
    of_sources = None if origin.citation in OWN or (origin.citation or "").startswith("none") else origin.citation
    return [text for text in (publisher.citation, of_sources, f"{paper.source}. {paper.link}") if text]


_CREATIVE_COMMONS = re.compile(r"CC[ -](BY(?:-(?:NC|SA|ND))*)[ -]([1-4]\.\d)", re.IGNORECASE)
_NAMED = {
    "Apache-2.0": ("apache-2.0", "https://www.apache.org/licenses/LICENSE-2.0"),
    "CC0": ("cc0-1.0", "https://creativecommons.org/publicdomain/zero/1.0/"),
    "MIT": ("mit", "https://opensource.org/license/mit"),
}


def hub_identifier(licence: str) -> str:
    """Hugging Face's name of a licence: ``unknown`` if none is stated, ``other`` if its list lacks it."""
    if licence.startswith("none stated"):
        return "unknown"
    known = _known(licence)
    return known[0] if known else "other"


def licence_address(licence: str) -> str | None:
    """Web address of a licence's text, if it is a well-known one."""
    known = _known(licence)
    return known[1] if known else None


def _known(licence: str) -> tuple[str, str] | None:
    """Identifier and address of the licence that a text begins with."""
    if found := _CREATIVE_COMMONS.match(licence):
        kind, version = found[1].lower(), found[2]
        return f"cc-{kind}-{version}", f"https://creativecommons.org/licenses/{kind}/{version}/"
    return next((facts for name, facts in _NAMED.items() if re.match(rf"{name}\b", licence)), None)


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
