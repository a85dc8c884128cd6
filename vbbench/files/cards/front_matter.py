"""The YAML at the head of ``README.md``, which hubs and the library ``datasets`` read."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from vbbench.files.cards.licences import hub_identifier, licence_address
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
    return "\n".join([FENCE, *_lines(values), FENCE])


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


def _lines(values: Mapping[str, Any], indent: str = "") -> Iterator[str]:
    """The values as block YAML; text is in double quotes, as JSON writes it, which YAML reads alike."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield f"{indent}{name}:"
            yield from _lines(value, f"{indent}  ")
        elif isinstance(value, list):
            yield f"{indent}{name}:"
            for entry in value:
                inside = (
                    list(_lines(entry, f"{indent}  ")) if isinstance(entry, Mapping) else [f"{indent}  {_word(entry)}"]
                )
                yield f"{indent}- {inside[0].lstrip()}"
                yield from inside[1:]
        else:
            yield f"{indent}{name}: {_word(value)}"


def _word(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)
