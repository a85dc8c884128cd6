"""The YAML at the head of ``README.md``, which hubs and the library ``datasets`` read."""

import re
from typing import Any

import yaml

from vbbench.files.cards.origin import said_licence
from vbbench.files.cards.subject import Subject

FENCE = "---"
_SIZES = ((10**3, "n<1K"), (10**4, "1K<n<10K"), (10**5, "10K<n<100K"), (10**6, "100K<n<1M"), (10**7, "1M<n<10M"))
_LARGER = ((10**8, "10M<n<100M"), (10**9, "100M<n<1B"))


def front_matter(subject: Subject) -> str:
    """The front matter with its fences."""
    info, licence = subject.info, said_licence(subject.origin, subject.publisher)
    values: dict[str, Any] = {
        "pretty_name": info.title,
        "license": hub_identifier(licence),
        **({} if licence_address(licence) else {"license_details": licence}),
        "task_categories": ["robotics"],
        "tags": tags(subject),
        "size_categories": [size_category(info.tables.get("observations", {}).get("rows", 0))],
        "configs": [_config(name) for name in subject.tables],
        "vbbench": {"dataset": subject.id, "digest": subject.digest, "version": info.package_version},
    }
    text = yaml.safe_dump(values, allow_unicode=True, sort_keys=False, width=2**16)
    return f"{FENCE}\n{text}{FENCE}"


def tags(subject: Subject) -> list[str]:
    """Words to find the dataset by."""
    kind, info = "recorded" if subject.origin.recorded else "simulated", subject.info
    return ["view-birdification", "crowd", "pedestrians", "trajectories", "localization", kind, info.split, info.tier]


def size_category(rows: int) -> str:
    """The hub's name of a number of rows."""
    return next((name for most, name in (*_SIZES, *_LARGER) if rows < most), "1B<n<10B")


def config_name(table: str) -> str:
    """A table's name as hubs allow it: without a slash."""
    return table.replace("/", "_")


def _config(table: str) -> dict[str, Any]:
    first = {"default": True} if table == "observations" else {}
    return {"config_name": config_name(table), **first, "data_files": f"{table}.parquet"}


_CREATIVE_COMMONS = re.compile(r"CC[ -](BY(?:-(?:NC|SA|ND))*)[ -]([1-4]\.\d)", re.IGNORECASE)
_NAMED = {
    "Apache-2.0": ("apache-2.0", "https://www.apache.org/licenses/LICENSE-2.0"),
    "CC0": ("cc0-1.0", "https://creativecommons.org/publicdomain/zero/1.0/"),
    "MIT": ("mit", "https://opensource.org/license/mit"),
}


def hub_identifier(licence: str) -> str:
    """What Hugging Face calls a licence: ``unknown`` where none is stated, ``other`` where its list has it not."""
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
