"""Every registered split: what it is, whether its sources are on this machine, and how to get them."""

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill

from vbbench.errors import VbbenchError
from vbbench.generation.generator import Card, Generator
from vbbench.generation.sources import fetch, is_here
from vbbench.registry import load, load_all


def describe_splits() -> str:
    """All splits as text, sorted by name."""
    return "\n".join(_describe(generator.card) for _, generator in sorted(load_all("generator").items()))


def fetch_splits(names: Sequence[str]) -> list[Path]:
    """Download missing sources of splits; return the paths of all their sources."""
    if not names:
        raise VbbenchError("fetch what? name splits, such as hotel eth students; 'vbbench splits' lists them")
    found: list[Generator] = [load("generator", name) for name in names]
    wanted = {source.path: source for generator in found for source in generator.card.sources}
    return fetch(list(wanted.values()))


def _describe(card: Card) -> str:
    here = sum(map(is_here, card.sources))
    state = "files of your own, --source" if card.own_files else "no source files"
    if card.sources:
        state = f"source here ({here}/{len(card.sources)} files)"
    if here < len(card.sources):
        state = f"source missing: {here} of {len(card.sources)} files here; vbbench fetch {card.name}"
    notes = {"licence": card.licence, "cite": card.citation, "caution": card.caution}
    details = [
        fill(f"{what}: {text}", 110, initial_indent="    ", subsequent_indent="      ")
        for what, text in notes.items()
        if text
    ]
    return "\n".join([f"{card.name}: {card.title} [{state}]", *details])
