"""What to cite for a board, as BibTeX: vbbench, the paper, the sources of its data, and its solvers."""

import re
from collections.abc import Iterator, Sequence
from functools import cache
from hashlib import sha256
from importlib.resources import files
from string import Template

from vbbench import __version__
from vbbench.table import latex_text
from vbbench_leaderboards.markup import is_web_address
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.result import Result

ALWAYS = ("vbbench", "the paper")
"""What every board rests upon: names in ``references.bib``."""


def bibliography(results: Sequence[Result], records: Sequence[BoardDataset]) -> str:
    """The entries of boards with these results, on these datasets; each once."""
    known = known_references()
    entries = [Template(known[name]).safe_substitute(version=__version__) for name in ALWAYS]
    sources = dict.fromkeys(part for one in records for part in cited(one.citation) if part not in ALWAYS)
    data = (known.get(one) or _entry(f"data-{_short_hash(one)}", {"note": one}) for one in sources)
    return "\n\n".join([*entries, *data, *_solvers(results)]) + "\n"


def cited(citation: str) -> Iterator[str]:
    """The works that a citation names, without what is said in brackets of each."""
    for part in citation.split("; "):
        if part:
            yield re.sub(r" \([^()]*\)$", "", part)


@cache
def known_references() -> dict[str, str]:
    """Citation, as splits state it → its entry in ``references.bib``, where it stands as a comment above the entry."""
    text = (files("vbbench_leaderboards.exports") / "references.bib").read_text("utf-8")
    blocks = (block.partition("\n") for block in text.strip().split("\n\n"))
    return {comment.removeprefix("% "): entry.strip() for comment, _, entry in blocks}


def _solvers(results: Sequence[Result]) -> Iterator[str]:
    """An entry for every solver that says where it is described, the same on all boards."""
    told = {(one.solver, one.about.reference): one for one in results if one.about.reference}
    names = [solver for solver, _ in told]
    for (solver, reference), one in told.items():
        key = f"solver-{re.sub('[^A-Za-z0-9]+', '-', solver).strip('-')}"
        if names.count(solver) > 1 or key == "solver-":
            key += f"-{_short_hash(solver + reference)}"
        facts = {"title": solver, "author": one.about.authors, "year": one.about.date[:4], "note": reference}
        yield _entry(key, facts, next(filter(is_web_address, (reference, one.about.code)), ""))


def _entry(key: str, facts: dict[str, str], address: str = "") -> str:
    fields = [f"  {name} = {{{{{latex_text(value)}}}}}," for name, value in facts.items() if value]
    if address:
        fields.append(f"  url = {{{re.sub(r'[{}%]', _percent, address)}}},")
    return "\n".join([f"@misc{{{key},", *fields, "}"])


def _percent(found: re.Match[str]) -> str:
    r"""Braces as an address writes them; ``\%``, because TeX takes the rest of the line after % for a comment."""
    return r"\%" if found[0] == "%" else rf"\%{ord(found[0]):02X}"


def _short_hash(text: str) -> str:
    return sha256(text.encode()).hexdigest()[:8]
