"""The site: whole or not at all, the same bytes every time, small, self-contained, safe from strangers; its pages."""

import json
import re
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from tests.lib.answers import submit, true_answers
from tests.lib.board_results import BOARD, record_of, result
from tests.lib.made_results import KITTI_CAUTION, SOLVERS, made_results
from tests.lib.make_dataset import Crowd, write_dataset
from tests.lib.tiny_board import FILE, RECORD, forge, recoded
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.paper import the_paper
from vbbench.protocol import PROTOCOLS
from vbbench.scoring import score
from vbbench.scoring.comparison import compare
from vbbench_leaderboards.results.folder import read_datasets, read_results
from vbbench_leaderboards.results.ranking import rank_apart
from vbbench_leaderboards.results.result import About, Board, Result
from vbbench_leaderboards.site import words
from vbbench_leaderboards.site.export import DOWNLOADS, ExportedBoard, exported_text, table_address
from vbbench_leaderboards.site.pages import MARKER, Site, build, bundled_sources, site_files
from vbbench_leaderboards.site.words import is_web_address, provided

HOSTILE = "\"><img src=x onerror=alert(1)></script><!--&'"
RNG = np.random.default_rng(3)
ERRORS = RNG.gamma(4.0, 0.02, 40)
FIELD = Board(split="hotel", tier="field", protocol="sequential")
PAPERS = Board(split="hotel", tier="ideal", protocol="one-step")


class Outline(HTMLParser):
    """Elements of a page, and what is wrong with its nesting."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in {"meta", "link", "input"}:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.elements if name == tag]

    def values(self, attribute: str) -> list[str]:
        return [attributes[attribute] or "" for _, attributes in self.elements if attribute in attributes]


def site_of(*results: Result, playable: bool = False) -> Site:
    boards = {found.board for found in results}
    rows = {board: tuple(found for found in results if found.board == board) for board in boards}
    return Site(
        results=rows,
        datasets={(found.board.split, found.board.tier): record_of(found) for found in results},
        rankings={board: rank_apart(found) for board, found in rows.items()},
        playable=dict.fromkeys(boards, ("a",)) if playable else {},
    )


def pages(site: Site) -> dict[str, str]:
    return dict(site_files(site))


def provided_html(text: str) -> str:
    """The piece of a page that a data file provides."""
    found = re.fullmatch(r"vbbench\.provide\((\"[^\"]+\"),(.*)\);\n", text, flags=re.S)
    assert found
    return str(json.loads(found[2])["html"])


def board_of(site: Site, board: Board = BOARD) -> str:
    return provided_html(pages(site)[f"data/{board.key}.js"])


def solver_page(site: Site, solver: str) -> str:
    return provided_html(pages(site)[f"data/pages/solver/{solver}.js"])


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_results(tmp_path_factory.mktemp("made"))


@pytest.fixture(scope="module")
def committed(made: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("committed") / "site"
    build(out, made)
    return out


def test_the_page_leads_to_the_documentation_where_there_is_one() -> None:
    site = site_of(result("a", ERRORS))
    assert "Docs</a>" not in pages(site)["index.html"]
    assert '<a href="../a&amp;b.html">Docs</a>' in pages(replace(site, docs="../a&b.html"))["index.html"]


@pytest.mark.slow
def test_the_first_page_is_small(committed: Path) -> None:
    first = Outline((committed / "index.html").read_text("utf-8"))
    board = first.values("data-first")[0]
    own = [address for address in (*first.values("src"), *first.values("href")) if address.startswith("assets/")]
    assert len(own) == 4
    size = sum((committed / name).stat().st_size for name in ("index.html", *own, f"data/{board}.js"))
    assert size < 200_000


def test_the_page_offers_every_board_in_every_format(committed: Path, made: Path) -> None:
    records = read_datasets(made)
    for board, rows in read_results(made).items():
        piece = (committed / "data" / f"{board.key}.js").read_text("utf-8")
        exported = ExportedBoard.of(board, records[board.split, board.tier], rows)
        for form in DOWNLOADS:
            address = table_address(board, form)
            assert (committed / address).read_text("utf-8") == exported_text([exported], form)
            assert address in piece


def test_pages_are_well_formed_and_explain_their_words(committed: Path) -> None:
    front = Outline((committed / "index.html").read_text("utf-8"))
    metrics = words.error_terms() | words.drift_terms()
    explained = metrics | words.COLUMNS | words.SUMMARIES | words.PROTOCOLS | words.tiers()
    assert {f"def-{key}" for key in explained} <= set(front.values("id"))
    assert tuple(words.PROTOCOLS) == PROTOCOLS
    for path in sorted((committed / "data").glob("hotel/*-*.js")):
        html = provided_html(path.read_text("utf-8"))
        board = Outline(html)
        assert not board.open
        ids = [*board.values("id"), *front.values("id")]
        assert len(ids) == len(set(ids))
        assert set(board.values("data-def")) <= set(ids)
        rows = re.findall(r"<tr.*?</tr>", html.partition("</table>")[0], re.S)
        assert len({_width(row) for row in rows}) == 1, path.name
    assert not front.open


def _width(row: str) -> int:
    spans = [int(span) for span in re.findall(r'colspan="(\d+)"', row)]
    return len(re.findall(r"<t[hd][ >]", row)) + sum(spans) - len(spans)


def test_the_same_results_give_the_same_bytes(committed: Path, made: Path, tmp_path: Path) -> None:
    build(tmp_path / "again", made)
    first, again = (
        {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        for folder in (committed, tmp_path / "again")
    )
    assert first == again


def test_strangers_words_stay_words() -> None:
    facts = dict.fromkeys(("reference", "version", "hardware", "authors", "trained_on"), HOSTILE)
    site = site_of(result("a", ERRORS, code="javascript:alert(1)", **facts), result(HOSTILE, ERRORS * 2))
    files = pages(site)
    assert "<img" not in files["index.html"]
    assert "</script><!--" not in files["index.html"]
    assert "<" not in files["data/hotel/one-step-noisy.js"]
    board, own = Outline(board_of(site)), Outline(solver_page(site, "a"))
    for page in (board, own):
        assert not page.all("img")
        assert not page.all("script")
        assert all(address.startswith(("#/", "tables/")) for address in page.values("href"))
    assert HOSTILE in board.values("data-solver")


@pytest.mark.parametrize(
    "address",
    [
        "javascript:alert(1)",
        "data:text/html,x",
        "//a.org",
        "file:///etc",
        "https:",
        "a\nb:x",
        "ftp://a",
        "",
        "http://[",
    ],
)
def test_nothing_else_becomes_a_link(address: str) -> None:
    assert not is_web_address(address)


def test_the_papers_rows_stand_apart_and_take_no_rank() -> None:
    html = board_of(site_of(result("a", ERRORS, board=PAPERS)), PAPERS)
    quoted = html.partition('<tbody class="quoted">')[2].partition("</tbody>")[0]
    head, *rows = re.findall(r"<tr>.*?</tr>", quoted, re.S)
    assert "not measured here, not ranked" in head
    assert "The paper's text describes sequential" in unescape(head)
    printed = the_paper().select("hotel", "ideal")
    assert len(rows) == len(printed) == 4
    for row, one in zip(rows, printed, strict=True):
        assert row.startswith(f'<tr><td class="rank"></td><th scope="row" class="name">{one.solver}<')
        wanted = [f"{one.figures[name]:.3f}" for name in words.error_terms() if name in one.figures]
        assert re.findall(r">(\d\.\d+)<", row) == wanted
        assert re.search("read as one-step|no single reading fits", row)
    assert "data-ranks" not in quoted
    assert "VB-CV" not in html.partition('<section class="charts"')[2]
    assert "quoted" not in board_of(site_of(result("a", ERRORS)))


def test_a_caution_stands_at_its_board_and_below_the_headline() -> None:
    site = site_of(result("a", ERRORS, board=FIELD, score={"caution": "saturated truth"}))
    assert "saturated truth" in board_of(site, FIELD)
    assert "saturated truth" in pages(site)["index.html"].partition('id="boards"')[0]


def test_without_a_board_like_a_real_camera_there_is_no_headline() -> None:
    page = pages(site_of(result("a", ERRORS)))["index.html"]
    assert 'id="headline"' not in page
    assert "No board of tier field and no footage is here yet" in page


def test_the_front_page_leads_with_the_field_and_with_real_footage(committed: Path) -> None:
    page = (committed / "index.html").read_text("utf-8")
    table = page.partition('id="headline"')[2].partition("</table>")[0]
    assert re.findall(r'<a href="#/(\w+/[^"]+)"', table.partition("<tbody>")[0]) == [
        "sim/sequential-field",
        "hotel/sequential-field",
        "kitti/sequential-footage",
    ]
    order = re.findall(
        r'<th scope="row"><span class="dot c\d+"></span><a href="#/solver/[^"]+">([^<]+)</a></th>', table
    )
    assert order == ["map-causal", "vb-sf", "vb-cv", "cv", "sf", "map-batch"]
    assert table.index("ranked among themselves") < table.index("map-batch")
    assert KITTI_CAUTION in page
    assert table.count(" lost</span>") == 3 * len(SOLVERS)


@pytest.mark.parametrize(
    ("far", "bold"),
    [({"one": 0.0, "two": 0.0, "worse": 0.1}, False), ({"one": 0.0, "two": 0.1, "worse": 0.2}, True)],
)
def test_bold_is_who_leads_alone_and_a_tie_is_a_sentence(far: dict[str, float], bold: bool) -> None:
    page = pages(site_of(*(result(name, ERRORS + more, board=FIELD) for name, more in far.items())))["index.html"]
    rows = re.findall(r"<tr><th scope=\"row\">.*?</tr>", page.partition('<table class="headline')[2], re.S)
    assert ["first" in row for row in rows] == [bold, False, False]
    tie = "does not separate the best of its 3 causal solvers: one and two share rank 1."
    assert (tie in page) != bold


def test_a_row_says_who_made_it_and_what_it_has_seen() -> None:
    seen = {"trained_on": "Zara 1", "tuned_on": "Hotel", "rerun_by": "B. Else, 2026-03-04"}
    facts = {"authors": "A. Somebody", "date": "2026-02-03", "code": "https://example.org/code", "delay": 2, **seen}
    html = board_of(site_of(result("a", ERRORS, **facts)))
    who = html.partition('id="who"')[2].partition("</table>")[0]
    for fact in ("2 frames late", "A. Somebody", "2026-02-03", "Zara 1", "Hotel", "B. Else, 2026-03-04"):
        assert f">{fact}<" in who
    assert 'href="https://example.org/code"' in who
    assert "Regenerated by" not in board_of(site_of(result("a", ERRORS)))


def test_diagnostics_are_marked_and_the_papers_splits_stand_apart(committed: Path) -> None:
    for name in ("hotel/one-step-ideal", "students/one-step-ideal", "hotel/sequential-field"):
        html = provided_html((committed / "data" / f"{name}.js").read_text("utf-8"))
        assert ('id="diagnostic"' in html) == name.endswith("ideal")
    picker = (committed / "index.html").read_text("utf-8").partition('id="picker"')[2].partition("</nav>")[0]
    leading, kept = picker.split('id="kept"')
    assert re.findall(r'data-split="([^"]+)"', leading) == ["sim", "hotel", "kitti"]
    assert re.findall(r'data-split="([^"]+)"', kept) == ["eth", "students"]
    assert re.findall(r'data-tier="([^"]+)"', leading) == ["field", "noisy", "footage", "ideal"]


def test_only_boards_with_films_lead_to_the_player() -> None:
    assert 'id="watch"' in board_of(site_of(result("a", ERRORS), playable=True))
    silent = board_of(site_of(result("a", ERRORS)))
    assert 'id="watch"' not in silent
    assert 'id="no-films"' in silent


def test_figures_that_are_not_there_are_dashes_and_have_no_difference() -> None:
    nothing = result("a", np.full(5, np.nan), score={"seconds_per_frame": None, "coverage": 0.5})
    html = board_of(site_of(nothing, result("b", np.ones(5))))
    assert "nan" not in html.lower().replace("finance", "")
    assert "50 %" in html


def test_data_files_are_harmless_wherever_they_are_pasted() -> None:
    text = provided("a/b", {"html": "</script>\u2028"})
    assert text == 'vbbench.provide("a/b",{"html":"\\u003c/script>\\u2028"});\n'


def test_only_a_site_is_replaced(made: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "mine.txt").write_text("keep", encoding="utf-8")
    with pytest.raises(VbbenchError, match="not a site"):
        build(out, made)
    assert (out / "mine.txt").read_text("utf-8") == "keep"
    (out / MARKER).write_text("", encoding="utf-8")
    (tmp_path / "out.partial").mkdir()
    (tmp_path / "out.partial" / "thesis.tex").write_text("years of work", encoding="utf-8")
    with pytest.raises(VbbenchError, match=r"out\.partial exists"):
        build(out, made)


@pytest.mark.filterwarnings("always::vbbench.errors.VbbenchWarning")
def test_results_that_cannot_be_used_are_omitted_and_named_and_without_any_the_old_site_stays(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    site, spoilt = tmp_path / "site", results / FILE
    asked = ["leaderboard", "build", "--results", str(results), "--out", str(site)]
    spoilt.with_name("deep.json").write_text("[" * 100_000)
    for value in (np.inf, 3e38, 1.1e7):
        forge(spoilt, recoded(lambda columns, value=value: columns["dx"].__setitem__(slice(None, None, 2), value)))
        assert main(asked) == 0
        said = capsys.readouterr().err
        assert said.count("\n") == said.count("OMITTED from the site: ") == 2
        assert re.search(r"cv\.json: \$\.per_sequence: dx of sequence \d+ is", said)
    assert '"solvers":[{"name":"vb-cv"' in (site / "data/tiny/sequential-ideal.js").read_text("utf-8")
    (site / "index.html").write_text("old", encoding="utf-8")
    (results / RECORD).write_text("{")
    assert main(asked) == 2
    assert "holds no results that can be used" in capsys.readouterr().err
    assert (site / "index.html").read_text("utf-8") == "old"
    assert not (tmp_path / "site.partial").exists()


def test_two_results_differ_as_their_submissions_do(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data", Crowd(scenes=8, frames=24, people=9, seed=3))
    about = About(authors="a", date="2026-11-22", delay=0, trained_on="nothing", tuned_on="nothing")
    rows = []
    for name, noise in (("one", 0.05), ("two", 0.1)):
        submit(tmp_path / name, tmp_path / "data", true_answers(tmp_path / "data", noise, seed=1), solver=name)
        rows.append(Result.of(score(tmp_path / name, tmp_path / "data"), tmp_path / name, about))
    own = rank_apart(rows)  # of two, whose p-values no correction changes
    wanted = compare(tmp_path / "one", tmp_path / "two", tmp_path / "data").differences
    for metric, difference in wanted.items():
        (found,) = own[metric].pairs
        assert found.difference == pytest.approx(difference.difference, rel=1e-5)
        assert found.ci95 == pytest.approx(difference.ci95, rel=1e-4)
        assert found.p == pytest.approx(difference.p_value, rel=1e-3)


def test_a_solvers_page_has_every_board_and_its_facts() -> None:
    other = replace(result("a", ERRORS * 2, trained_on="Zara 1"), board=FIELD)
    html = solver_page(site_of(result("a", ERRORS, code="https://example.org/a"), other), "a")
    page = Outline(html)
    assert not page.open
    boards = [address.removeprefix("#/hotel/") for address in page.values("href") if address.startswith("#/hotel")]
    assert boards == ["sequential-field", "one-step-noisy", "sequential-field"]
    assert "nothing; Zara 1" in html or "Zara 1; nothing" in html
    assert "https://example.org/a" in page.values("href")
    assert "History" not in html
    assert "Regenerated by" not in html


def test_history_is_told() -> None:
    past = replace(result("a", ERRORS * 2, version="0.9").present, date="2026-01-02")
    row = replace(result("a", ERRORS, dataset="f" * 16), history=(past,))
    html = solver_page(site_of(row), "a")
    entries = html.partition('class="entries"')[2].partition("</ol>")[0]
    assert entries.count("<li>") == 2
    assert "0.9, <time>2026-01-02</time>" in entries
    assert "(other data)" in entries


def test_bundled_solvers_lead_to_their_source() -> None:
    site = site_of(result("vb-cv", ERRORS), result("stranger", ERRORS))
    files = pages(site)
    own = bundled_sources(["vb-cv", "stranger"])
    assert list(own) == ["vb-cv"]
    assert "class ConstantVelocityBirdifier" in files[own["vb-cv"].address]
    assert own["vb-cv"].address in Outline(solver_page(site, "vb-cv")).values("href")
    elsewhere = site_of(result("vb-cv", ERRORS, code="https://example.org/fork"))
    assert not [name for name in pages(elsewhere) if name.startswith("code/")]
