"""Checks every link of a built site without a network: ``python docs/site/links.py out/site``.

A link must lead to a file of the site, by a relative address, so that the site works below any folder of any server; a
part of a page must be there, and a board or solver of the leaderboard must have its data. Nothing may be loaded from
elsewhere.
"""

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

BOARDS = "leaderboard"
"""Folder of the leaderboard, whose addresses after the ``#`` name a board or solver and not a part of the page."""

_LOADED = {"script": "src", "img": "src", "link": "href", "source": "src", "iframe": "src", "video": "src"}
_ELSEWHERE = ("http", "https")
_INSIDE_THE_PAGE = ("data", "mailto", "javascript")
_NOT_LOADED = {"canonical", "edit", "author"}


@dataclass
class Found(HTMLParser):
    """What a page links to, what it loads, and the parts of it that a link can name."""

    links: list[str] = field(default_factory=list)
    loaded: list[str] = field(default_factory=list)
    parts: set[str] = field(default_factory=set)

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the links and the name of one element."""
        values = dict(attrs)
        self.parts |= {name for name in (values.get("id"), values.get("name") if tag == "a" else None) if name}
        address = values.get(_LOADED.get(tag, "href" if tag == "a" else ""))
        if not address:
            return
        if tag == "a" or values.get("rel") in _NOT_LOADED:
            self.links.append(address)
        else:
            self.loaded.append(address)


@cache
def read(page: Path) -> Found:
    """Everything in a page."""
    found = Found()
    found.feed(page.read_text(encoding="utf-8"))
    return found


def pages_of(site: Path) -> list[Path]:
    """Every page that a reader can open; what lies in ``_static`` are parts of pages."""
    return sorted(page for page in site.rglob("*.html") if page.relative_to(site).parts[0] != "_static")


def faults(site: Path) -> Iterator[str]:
    """One line for every link that leads nowhere, and for everything that another host would have to give."""
    for page in pages_of(site):
        found, name = read(page), page.relative_to(site)
        for address in found.loaded:
            if urlsplit(address).scheme in _ELSEWHERE or address.startswith("//"):
                yield f"{name}: loads {address} from another host"
        for address in dict.fromkeys((*found.links, *found.loaded)):
            if wrong := _fault(site, page, address):
                yield f"{name}: {address} {wrong}"


def _fault(site: Path, page: Path, address: str) -> str | None:
    """What is wrong with a link of a page, if anything is."""
    parts = urlsplit(address)
    if parts.scheme in (*_ELSEWHERE, *_INSIDE_THE_PAGE):
        return None
    if parts.scheme or parts.netloc or parts.path.startswith("/"):
        return "works below no other address than this one"
    target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    if not target.is_relative_to(site) or not target.is_file():
        return "leads to no file of the site"
    part = unquote(parts.fragment)
    if part.startswith("/") and target == site / BOARDS / "index.html":
        data = target.parent / "data" / f"{_data_of(part.partition('?')[0].strip('/'))}.js"
        return None if data.is_file() else "names no board or solver"
    if part and target.suffix == ".html" and part not in read(target).parts:
        return "names no part of that page"
    return None


def _data_of(view: str) -> str:
    """The name of the data that a view of the leaderboard loads first."""
    return f"pages/{view}" if view.startswith("solver/") else re.sub(r"/(play|compare)$", "", view)


def main(site: Path) -> int:
    """Print the faults; 1 if there are any."""
    pages = len(pages_of(site))
    wrong = list(faults(site.resolve())) if pages else [f"{site} has no pages"]
    sys.stdout.write("".join(f"{line}\n" for line in wrong) or f"{site}: every link of {pages} pages leads somewhere\n")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
