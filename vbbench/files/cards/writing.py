"""Writes the cards of a dataset folder, and checks whether they fit it."""

import re
from pathlib import Path

from vbbench.errors import FileError
from vbbench.files.cards.croissant import croissant
from vbbench.files.cards.readme import FENCE, readme, statements
from vbbench.files.cards.subject import Publisher, Subject, digest_of, origin_of, read_info_file, tables_here
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.files.tables import file_sha256
from vbbench.folders.replacing import write_text_atomically
from vbbench.parsing.json_text import read_object

README, CROISSANT = "README.md", "croissant.json"
_AGAIN = "write it again with 'vbbench card FOLDER --overwrite'"
_WITHOUT_CARDS = "; no card says what it is: 'vbbench card FOLDER' writes one"
_NOT_OURS = f"; its {README} is not one of vbbench's cards and was not checked"
_LONGEST_README = 2**22


def card_texts(folder: Path, publisher: Publisher | None = None) -> dict[str, str]:
    """The text of each card of the complete dataset in ``folder``, by file name.

    Only ``dataset.json`` is read, so that the cards hold nothing unpublished; facts of the split come from the ``card``
    registered under its name. ``publisher`` has further facts.
    """
    info = DatasetInfo.read(folder)
    values, info_file = read_info_file(folder)
    subject = Subject(
        info=info,
        values=values,
        info_file=info_file,
        origin=origin_of(info),
        publisher=publisher or Publisher(),
    )
    said = statements(subject)
    return {README: readme(subject, said), CROISSANT: croissant(subject, said)}


def write_cards(folder: Path, publisher: Publisher | None = None) -> list[Path]:
    """Write the cards of the complete dataset in ``folder``; return their paths. See `card_texts`."""
    texts = card_texts(folder, publisher)
    for name, text in texts.items():
        write_text_atomically(folder / name, text)
    return [folder / name for name in texts]


def card_dataset(folder: Path | str, publisher: Publisher | None = None, *, overwrite: bool = False) -> list[Path]:
    """Write the cards of an existing dataset; see `write_cards`.

    Raises FileError if there is no dataset, or it has a card already and ``overwrite`` is not set.
    """
    folder = Path(folder)
    DatasetInfo.read(folder)
    for name in (README, CROISSANT):
        if (folder / name).exists() and not overwrite:
            raise FileError(folder / name, "exists; set `overwrite` to replace it")
    return write_cards(folder, publisher)


def check_cards(folder: Path, info: DatasetInfo) -> str:
    """The end of a line about the cards of a dataset; empty if they fit it.

    The prose of a card may be edited. Its names of the dataset and of the tables, and their SHA-256, are checked.

    Raises FileError if a card is that of another dataset, or damaged.
    """
    readme, described = folder / README, folder / CROISSANT
    if not (readme.is_file() or described.is_file()):
        return _WITHOUT_CARDS
    if described.is_file():
        _check_croissant(described, info)
    return _check_readme(readme, info) if readme.is_file() else ""


def _check_readme(path: Path, info: DatasetInfo) -> str:
    """Check that the front matter has the dataset's id and digest, which hubs keep when they rewrite it."""
    with path.open("rb") as file:
        text = file.read(_LONGEST_README).decode("utf-8", "replace")
    found = re.match(rf"{FENCE}\r?\n(.*?)^{FENCE}", text, re.DOTALL | re.MULTILINE)
    head = found[1] if found else ""
    if "vbbench:" not in head:
        return _NOT_OURS
    named = set(re.findall(r"\b(?:[0-9a-f]{16}|[0-9a-f]{64})\b", head))
    if not {info.id, digest_of(read_info_file(path.parent)[0])} <= named:
        raise FileError(path, f"is the card of another dataset than {info.id}, or of an earlier one; {_AGAIN}")
    lost = [name for name in tables_here(info) if f"{name}.parquet" not in head]
    if lost:
        raise FileError(path, f"its front matter lacks {', '.join(lost)}; {_AGAIN}")
    return ""


def _check_croissant(path: Path, info: DatasetInfo) -> None:
    values = read_object(path, _AGAIN)
    if values.get("identifier") != info.id:
        raise FileError(path, f"describes another dataset than {info.id}; {_AGAIN}")
    sums = {f"{name}.parquet": info.tables[name]["sha256"] for name in tables_here(info)}
    files = values.get("distribution")
    entries = [entry for entry in files if isinstance(entry, dict)] if isinstance(files, list) else []
    stated = {str(entry.get("@id")): entry.get("sha256") for entry in entries}
    for name, digest in {INFO_FILE: file_sha256(path.parent / INFO_FILE), **sums}.items():
        if stated.get(name) != digest:
            raise FileError(path, f"has not the SHA-256 of {name}; {_AGAIN}")
