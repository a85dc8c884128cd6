"""Card ``README.md`` of a dataset: front matter for hubs and the library ``datasets``, and answers of a datasheet.

The questions are those of Gebru et al., Datasheets for Datasets (CACM 2021), in our words.
"""

from collections.abc import Iterable, Sequence
from typing import Any

import yaml

from vbbench.files.cards.origin import Origin, citations, hub_identifier, licence_address, said_licence
from vbbench.files.cards.statements import TASK, Statements
from vbbench.files.cards.subject import Subject
from vbbench.files.dataset_info import DatasetInfo, summary
from vbbench.files.generate_command import generate_command
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


def readme(subject: Subject, said: Statements) -> str:
    """The text of ``README.md``."""
    info = subject.info
    parts = [
        front_matter(subject),
        f"# {info.title}",
        f"{said.kind[0].upper()}{said.kind[1:]}: boxes in, positions on the ground plane out. {TASK}",
        *([f"> **Caution.** {info.caution}"] if info.caution else []),
        _figures(subject),
        "## How it was made",
        _making(subject, said),
        "## How to read it",
        _READING,
        "## Tables",
        *(_table(subject, name) for name in subject.tables),
        *_withheld(info),
        "## Datasheet",
        "The questions follow Gebru et al., *Datasheets for Datasets* (2021).",
        *_datasheet(subject, said),
        "## Licence and citation",
        _citing(subject, said),
    ]
    return "\n\n".join(parts) + "\n"


def _figures(subject: Subject) -> str:
    info = subject.info
    counts = summary(info)
    rows = {
        "split, tier": f"`{info.split}`, `{info.tier}`",
        "camera": _camera(info),
        "sequences": f"{counts['sequences']:,}, of {counts['mean_frames']:.1f} frames on average, {info.dt:g} s apart",
        "boxes": f"{counts['observations']:,}",
        "people in a frame": f"{counts['people_min']} / {counts['people_mean']:.1f} / {counts['people_max']} (least / "
        f"mean / most), the observer {'' if info.definition.get('count_observer') else 'not '}included",
        "made with": f"vbbench {info.package_version}, seed {info.spoken_seed}",
        "id": f"`{subject.id}`",
    }
    first, *others = rows.items()
    return _markdown_table(first, others)


def _camera(info: DatasetInfo) -> str:
    if len(info.cameras) > 1:
        return f"{len(info.cameras)} cameras, listed in dataset.json"
    width, height = info.camera.picture_size
    return f"{info.camera.kind}, {width:g} × {height:g} px, {info.camera.mount_height:g} m above the ground"


def _making(subject: Subject, said: Statements) -> str:
    info = subject.info
    command = generate_command(subject.values, info.split)
    again = "The same line gives the same id." if info.seed is not None else "Nobody else can: its seed is secret."
    lines = [said.collection, "", f"    {command}", "", f"{again} {_sources(subject, said)}", ""]
    return "\n".join([*lines, *(f"* {step}" for step in said.preprocessing)])


_READING = """\
With vbbench, with pandas, with `datasets`, or with any reader of Croissant (`croissant.json`):

```python
from vbbench import Dataset
sequence = Dataset("FOLDER").sequence(0)  # observations [T, K, 3] in px, NaN where nobody is seen

import pandas
boxes = pandas.read_parquet("FOLDER/observations.parquet")

import datasets
boxes = datasets.load_dataset("FOLDER", "observations", split="train")  # "train" is all of it

import mlcroissant
boxes = mlcroissant.Dataset("FOLDER/croissant.json").records("observations")
```

Lengths are metres, angles radians, times seconds. `vbbench verify FOLDER` checks every file."""


def _sources(subject: Subject, said: Statements) -> str:
    """What it was made from, public files as links."""
    links = ", ".join(f"[{path}]({address})" for path, address in subject.origin.files)
    return f"Source files: {links}." if links else said.raw


def _table(subject: Subject, name: str) -> str:
    meaning = subject.meaning(name)
    rows = [(f"`{column}`", str(kind), text) for column, kind, text in subject.columns(name)]
    key = ", ".join(f"`{column}`" for column in meaning.key)
    facts = f"{subject.info.tables[name]['rows']:,} rows; a row is named by {key}."
    return "\n\n".join(
        [f"### `{name}.parquet`", f"{meaning.about} {facts}", _markdown_table(("column", "type", "meaning"), rows)]
    )


def _withheld(info: DatasetInfo) -> Iterable[str]:
    if info.seed is None:
        rows = [
            (f"`{name}`", f"{facts['rows']:,}", f"`{facts['sha256']}`") for name, facts in info.truth_tables.items()
        ]
        yield "### Withheld truth"
        yield f"Not in this folder. SHA-256 of all of it together: `{info.truth_sha256}`."
        yield _markdown_table(("table", "rows", "SHA-256"), rows)


def _datasheet(subject: Subject, said: Statements) -> Iterable[str]:
    publisher = subject.publisher
    creator = publisher.creator or f"Whoever ran the line above; the program is vbbench {subject.info.package_version}"
    sections: dict[str, dict[str, str]] = {
        "Motivation": {
            "What was it made for?": said.uses[0],
            "By whom?": f"{creator}.",
        },
        "Composition": {
            "What is an instance?": "A sequence: a run of frames with the boxes of everybody whom one observer sees.",
            "Is anything missing?": said.missing,
            "What is the label?": said.known,
            "Are there recommended splits?": "None is built in; sequences that share a scene belong on the same side.",
            "Errors, noise, redundancy?": " ".join(said.limitations),
            "Does it rely on something outside?": f"No{'; the pictures are not needed' if subject.is_footage else ''}.",
            "Does it show people?": said.privacy,
        },
        "Collection": {
            "How was it acquired?": "See [How it was made](#how-it-was-made).",
            "Who collected it, and was there an ethical review?": _collectors(subject.origin),
        },
        "Preprocessing": {
            "What was done?": "The steps under [How it was made](#how-it-was-made).",
            "Is the raw data kept?": "Not in this folder.",
        },
        "Uses": {
            "What is it good for?": " ".join(said.uses),
            "What must it not be used for?": " ".join(said.misuses),
            "What may bias a result?": " ".join(said.biases),
        },
        "Distribution": {
            "May it be passed on?": "See [Licence and citation](#licence-and-citation).",
            "Where is it?": publisher.url or "Not published so far.",
        },
        "Maintenance": {"Who keeps it, and how does it change?": said.maintenance},
    }
    for title, answers in sections.items():
        yield f"### {title}"
        yield "\n\n".join(f"**{question}** {answer}" for question, answer in answers.items())


def _collectors(origin: Origin) -> str:
    if not origin.recorded:
        return "A program; there were no participants."
    return (
        "The authors of the sources, cited below. No review is known to vbbench; ask them, or read their publications."
    )


def _citing(subject: Subject, said: Statements) -> str:
    listed = "\n".join(f"* {text}" for text in citations(subject.origin, subject.publisher))
    software = f"This card was written by vbbench {__version__}; its `CITATION.cff` says how to cite the program."
    return f"{said.sharing}\n\nPlease cite:\n\n{listed}\n\n{software}"


def _markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(head)} |", f"|{'---|' * len(head)}"]
    return "\n".join([*lines, *(f"| {' | '.join(map(_cell, row))} |" for row in rows)])


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
