"""Card ``README.md`` of a dataset: front matter for hubs and the library ``datasets``, and what its templates say."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import yaml
from jinja2 import Environment

from vbbench.files.cards.subject import OWN, Subject, citations, hub_identifier, licence_address, said_licence
from vbbench.files.dataset_info import DatasetInfo, given_noise, summary
from vbbench.files.generate_command import generate_command
from vbbench.table import environment
from vbbench.version import __version__

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


@cache
def _environment() -> Environment:
    found = environment(Path(__file__).parent)
    found.filters["full"] = lambda text: f"{text.removesuffix('.')}."
    return found


def statements(subject: Subject) -> dict[str, Any]:
    """Statements about a dataset, texts or lists, by the blocks of ``statements.md.j2``."""
    info, licence = subject.info, said_licence(subject.origin, subject.publisher)
    template = _environment().get_template("statements.md.j2")
    facts = {"info": info, "origin": subject.origin, "publisher": subject.publisher, "footage": subject.is_footage}
    more = {"recorded": subject.origin.recorded, "noise": given_noise(info), "licence": licence, "own": OWN}
    context = template.new_context({**facts, **more, "hub": hub_identifier(licence)})
    texts = {name: "".join(block(context)).strip() for name, block in template.blocks.items()}
    return {
        name: [line[2:] for line in text.split("\n") if line] if text.startswith("* ") else " ".join(text.split())
        for name, text in texts.items()
    }


def readme(subject: Subject, said: Mapping[str, Any]) -> str:
    """The text of ``README.md``."""
    info, counts = subject.info, summary(subject.info)
    figures = {
        "camera": _camera(info),
        "sequences": f"{counts['sequences']:,}, of {counts['mean_frames']:.1f} frames on average, {info.dt:g} s apart",
        "boxes": f"{counts['observations']:,}",
        "people in a frame": f"{counts['people_min']} / {counts['people_mean']:.1f} / {counts['people_max']} (least / "
        f"mean / most), the observer {'' if info.definition.get('count_observer') else 'not '}included",
        "made with": f"vbbench {info.package_version}, seed {info.spoken_seed}",
        "id": f"`{subject.id}`",
    }
    hidden = info.truth_tables.items() if info.seed is None else ()
    text = (
        _environment()
        .get_template("readme.md.j2")
        .render(
            subject=subject,
            info=info,
            origin=subject.origin,
            publisher=subject.publisher,
            footage=subject.is_footage,
            recorded=subject.origin.recorded,
            said=said,
            figures=figures,
            command=generate_command(subject.values, info.split),
            columns={
                name: [(f"`{column}`", str(kind), text) for column, kind, text in subject.columns(name)]
                for name in subject.tables
            },
            withheld=[(f"`{name}`", f"{facts['rows']:,}", f"`{facts['sha256']}`") for name, facts in hidden],
            citations=citations(subject.origin, subject.publisher),
            version=__version__,
        )
    )
    return f"{front_matter(subject)}\n\n{text.strip()}\n"


def _camera(info: DatasetInfo) -> str:
    if len(info.cameras) > 1:
        return f"{len(info.cameras)} cameras, listed in dataset.json"
    width, height = info.camera.picture_size
    return f"{info.camera.kind}, {width:g} × {height:g} px, {info.camera.mount_height:g} m above the ground"
