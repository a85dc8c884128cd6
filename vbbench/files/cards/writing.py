"""Writes the cards of a dataset folder."""

from pathlib import Path

from vbbench.errors import FileError
from vbbench.files.cards.croissant import croissant
from vbbench.files.cards.readme import readme, statements
from vbbench.files.cards.subject import Publisher, Subject, origin_of, read_info_file
from vbbench.files.dataset_info import DatasetInfo
from vbbench.folders.replacing import write_text_atomically

README, CROISSANT = "README.md", "croissant.json"


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
