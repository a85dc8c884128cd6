"""The site made of these pages: its reference has everything public, and every link is checked.

That every page has its place in the navigation is checked where the site is built, by `make site`.
"""

import runpy
from pathlib import Path

import pytest

import vbbench

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


def test_the_reference_has_everything_public() -> None:
    text = "".join(page.read_text("utf-8") for page in (DOCS / "reference").glob("api-*.md"))
    missing = [name for name in vbbench.__all__ if name[0] != "_" and f":: vbbench.{name}\n" not in text]
    assert not missing


check_links = runpy.run_path(str(DOCS / "site" / "links.py"))["main"]
BOARDS = "leaderboard/index.html#"
PAGE = f"""<h1 id="top">a</h1><a href="below/b.html#part">b</a><a href="{BOARDS}/sim/board?by=dx">c</a>
<a href="{BOARDS}/sim/board/compare?a=cv&amp;b=sf">d</a><a href="{BOARDS}/solver/cv">e</a>"""
FAULTS = {
    '<a href="below/c.html">': "below/c.html leads to no file of the site",
    '<a href="below/b.html#none">': "below/b.html#none names no part of that page",
    '<a href="#none">': "#none names no part of that page",
    '<a href="below">': "below leads to no file of the site",
    '<a href="../outside.html">': "../outside.html leads to no file of the site",
    '<a href="/below/b.html">': "/below/b.html works below no other address than this one",
    '<a href="leaderboard/index.html#/sim/none">': "leaderboard/index.html#/sim/none names no board or solver",
    '<a href="leaderboard/index.html#/solver/none">': "leaderboard/index.html#/solver/none names no board or solver",
    '<img src="none.png">': "none.png leads to no file of the site",
    '<script src="https://example.org/x.js"></script>': "loads https://example.org/x.js from another host",
    '<link rel="stylesheet" href="//example.org/x.css">': "loads //example.org/x.css from another host",
}


def small_site(folder: Path, more: str = "") -> Path:
    """Two pages and a board, all of whose links lead somewhere, and ``more``."""
    for name, text in {
        "site/index.html": PAGE + more,
        "site/below/b.html": '<a id="part" href="../index.html#top">a</a><a href="https://example.org">elsewhere</a>',
        "site/leaderboard/index.html": "",
        "site/leaderboard/data/sim/board.js": "",
        "site/leaderboard/data/pages/solver/cv.js": "",
        "site/_static/part.html": '<a href="{{ filled in later }}">',
        "outside.html": "",
    }.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder / "site"


def test_a_site_without_fault_passes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(small_site(tmp_path).parent)
    assert check_links(Path("site")) == 0
    assert "every link of 3 pages" in capsys.readouterr().out


@pytest.mark.parametrize(("element", "said"), FAULTS.items())
def test_a_link_that_leads_nowhere_is_found(
    element: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert check_links(small_site(tmp_path, element)) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"index.html: {said}"
