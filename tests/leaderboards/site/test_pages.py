"""The site: whole or not at all, the same bytes every time, small, self-contained, safe from strangers; its pages."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.lib.answers import submit, true_answers
from tests.lib.board_results import BOARD, record_of, result
from tests.lib.colours import contrast
from tests.lib.made_results import KITTI_CAUTION, SOLVERS, made_results
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.errors import VbbenchError
from vbbench.protocol import PROTOCOLS
from vbbench.scoring import score
from vbbench.scoring.comparison import compare
from vbbench_leaderboards.results.ranking import contrasts, rank_apart
from vbbench_leaderboards.results.result import About, Board, Result
from vbbench_leaderboards.site import words
from vbbench_leaderboards.site.pages import MARKER, Site, build, bundled_sources, comparison_values, site_files
from vbbench_leaderboards.site.words import is_web_address, provided

HOSTILE = "\"><img src=x onerror=alert(1)></script><!--&'"
FIRST_PAGE, AIM = 300_000, 200_000
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
    assert size < AIM < FIRST_PAGE


def test_nothing_is_asked_of_other_places(committed: Path) -> None:
    for path in committed.rglob("*"):
        if path.suffix in (".css", ".js") and "data" not in path.parts:
            text = path.read_text("utf-8")
            assert not re.search(r"https?://(?!www\.w3\.org/)|@import|url\(|\bfetch\(|\bimport\b[ (]", text), path.name
    page = Outline((committed / "index.html").read_text("utf-8"))
    needed = [*page.values("src"), *(attributes["href"] or "" for attributes in page.all("link"))]
    assert all(address.startswith(("assets/", "data:")) for address in needed)


def test_the_page_is_well_formed_and_has_its_landmarks(committed: Path) -> None:
    page = Outline((committed / "index.html").read_text("utf-8"))
    assert not page.open
    names = [name for name, _ in page.elements]
    assert [names.count(name) for name in ("h1", "main", "header", "footer", "noscript")] == [1, 1, 1, 1, 1]
    assert page.all("html")[0]["lang"] == "en"
    ids = page.values("id")
    assert len(ids) == len(set(ids))
    explained = (
        words.error_terms(),
        words.drift_terms(),
        words.COLUMNS,
        words.SUMMARIES,
        words.PROTOCOLS,
        words.tiers(),
    )
    assert {f"def-{key}" for terms in explained for key in terms} <= set(ids)
    assert tuple(words.PROTOCOLS) == PROTOCOLS
    headings = [int(name[1]) for name in names if re.fullmatch(r"h\d", name)]
    assert all(after - before <= 1 for before, after in pairwise(headings))


def test_boards_are_well_formed_and_explain_their_columns(committed: Path) -> None:
    front = Outline((committed / "index.html").read_text("utf-8")).values("id")
    for path in sorted((committed / "data").glob("hotel/*-*.js")):
        html = provided_html(path.read_text("utf-8"))
        board = Outline(html)
        assert not board.open
        ids = board.values("id")
        assert len(ids) == len(set(ids))
        assert not set(ids) & set(front)
        assert set(board.values("data-def")) <= set(front)
        rows = re.findall(r"<tr.*?</tr>", html.partition("</table>")[0], re.S)
        assert len({_width(row) for row in rows}) == 1, path.name


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
    odd = result(
        "a",
        ERRORS,
        reference=HOSTILE,
        version=HOSTILE,
        hardware=HOSTILE,
        code="javascript:alert(1)",
        authors=HOSTILE,
        trained_on=HOSTILE,
    )
    files = pages(site_of(odd, result(HOSTILE, ERRORS * 2)))
    assert "<img" not in files["index.html"]
    assert "</script><!--" not in files["index.html"]
    data = files["data/hotel/one-step-noisy.js"]
    assert "<" not in data
    html = board_of(site_of(odd, result(HOSTILE, ERRORS * 2)))
    page = Outline(html)
    assert not page.all("img")
    assert not page.all("script")
    assert not [address for address in page.values("href") if not address.startswith(("#/", "tables/"))]
    assert HOSTILE in page.values("data-solver")


@pytest.mark.parametrize(
    "address",
    [
        "javascript:alert(1)",
        "data:text/html,x",
        "//example.org",
        "file:///etc",
        "https:",
        "java\nscript:x",
        "ftp://a",
        "",
        "http://[",
    ],
)
def test_nothing_else_becomes_a_link(address: str) -> None:
    assert not is_web_address(address)


def test_the_papers_rows_stand_apart() -> None:
    html = board_of(site_of(result("a", ERRORS, board=PAPERS)), PAPERS)
    quoted = html.partition('<tbody class="quoted">')[2].partition("</tbody>")[0]
    assert quoted.count("<tr>") == 5
    assert "not measured here, not ranked" in quoted
    assert "data-ranks" not in quoted
    assert "VB-CV" not in html.partition('<section class="charts"')[2]
    assert "quoted" not in board_of(site_of(result("a", ERRORS)))


def headline_of(site: Site) -> str:
    table = re.search(r'<table class="headline[ "].*?</table>', pages(site)["index.html"], re.S)
    assert table
    return table[0]


def test_a_caution_stands_at_its_board_and_below_the_headline() -> None:
    spoilt = result("a", ERRORS, board=FIELD, score={"caution": "saturated truth"})
    files = pages(site_of(spoilt))
    assert "saturated truth" in board_of(site_of(spoilt), FIELD)
    assert "saturated truth" in files["index.html"].partition('id="boards"')[0]


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


def test_bold_is_who_leads_alone_and_a_tie_is_a_sentence() -> None:
    def bold(**far: float) -> list[bool]:
        site = site_of(*(result(name, ERRORS + more, board=FIELD) for name, more in far.items()))
        rows = re.findall(r"<tr><th scope=\"row\">.*?</tr>", headline_of(site), re.S)
        tie = "does not separate the best of its 3 causal solvers: one and two share rank 1."
        assert (tie in pages(site)["index.html"]) == (not any("first" in row for row in rows))
        return ["first" in row for row in rows]

    assert bold(one=0.0, two=0.0, worse=0.1) == [False, False, False]
    assert bold(one=0.0, two=0.1, worse=0.2) == [True, False, False]


def test_a_row_says_who_made_it_and_what_it_has_seen() -> None:
    facts = {
        "authors": "A. Somebody",
        "date": "2026-02-03",
        "trained_on": "Zara 1",
        "tuned_on": "Hotel",
        "rerun_by": "B. Else, 2026-03-04",
        "code": "https://example.org/code",
        "delay": 2,
    }
    html = board_of(site_of(result("a", ERRORS, **facts)))
    who = html.partition('id="who"')[2].partition("</table>")[0]
    for fact in ("2 frames late", "A. Somebody", "2026-02-03", "Zara 1", "Hotel", "B. Else, 2026-03-04"):
        assert f">{fact}<" in who
    assert 'href="https://example.org/code"' in who
    assert "Regenerated by" not in board_of(site_of(result("a", ERRORS)))


def test_diagnostics_are_marked_and_the_papers_splits_stand_apart(committed: Path) -> None:
    for name, is_one in (
        ("hotel/one-step-ideal", True),
        ("students/one-step-ideal", True),
        ("hotel/sequential-field", False),
    ):
        html = provided_html((committed / "data" / f"{name}.js").read_text("utf-8"))
        assert ('id="diagnostic"' in html) == is_one
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


def test_figures_that_are_not_there_are_dashes() -> None:
    nothing = result("a", np.full(5, np.nan), score={"seconds_per_frame": None, "coverage": 0.5})
    html = board_of(site_of(nothing, result("b", np.ones(5))))
    assert "nan" not in html.lower().replace("finance", "")
    assert "50 %" in html


def test_data_files_are_harmless_wherever_they_are_pasted() -> None:
    text = provided("a/b", {"html": "</script>\u2028"})
    assert text == 'vbbench.provide("a/b",{"html":"\\u003c/script>\\u2028"});\n'


def test_colours_can_be_told_from_the_paper(committed: Path) -> None:
    css = (committed / "assets" / "page.css").read_text("utf-8")
    pairs = re.findall(r"--([\w-]+): light-dark\((#\w{6}), (#\w{6})\)", css)
    for colours in ({name: shades[n] for name, *shades in pairs} for n in (0, 1)):
        for name in ("ink", "faint", "accent"):
            for ground in ("paper", "raised"):
                assert contrast(colours[name], colours[ground]) >= 4.5
        assert contrast(colours["warn"], colours["warn-paper"]) >= 4.5


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


def test_a_build_that_fails_leaves_the_old_site(tmp_path: Path) -> None:
    out, results = tmp_path / "out", tmp_path / "results"
    results.mkdir()
    out.mkdir()
    (out / MARKER).write_text("", encoding="utf-8")
    (out / "index.html").write_text("old", encoding="utf-8")
    with pytest.raises(VbbenchError, match="holds no results"):
        build(out, results)
    assert (out / "index.html").read_text("utf-8") == "old"
    assert not (tmp_path / "out.partial").exists()


def test_two_results_differ_as_their_submissions_do(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data", Crowd(scenes=8, frames=24, people=9, seed=3))
    about = About(authors="a", date="2026-11-22", delay=0, trained_on="nothing", tuned_on="nothing")
    rows = []
    for name, noise in (("one", 0.05), ("two", 0.1)):
        submit(tmp_path / name, tmp_path / "data", true_answers(tmp_path / "data", noise, seed=1), solver=name)
        rows.append(Result.of(score(tmp_path / name, tmp_path / "data"), tmp_path / name, about))
    own = contrasts(rows)[0, 1]
    wanted = compare(tmp_path / "one", tmp_path / "two", tmp_path / "data").differences
    for metric, difference in wanted.items():
        found = own[metric]
        assert found.difference == pytest.approx(difference.difference, rel=1e-5)
        assert found.ci95 == pytest.approx(difference.ci95, rel=1e-4)
        assert found.p == pytest.approx(difference.p_value, rel=1e-3)
        assert found.sequences == difference.sequences


def test_solvers_that_do_not_compete_are_compared_too() -> None:
    site = site_of(result("causal", ERRORS), result("offline", ERRORS / 2, delay="offline"))
    values = comparison_values(site, BOARD)
    (a, b, figures), *others = values["pairs"]
    assert not others
    assert [values["solvers"][n] for n in (a, b)] == ["causal", "offline"]
    difference, low, high, p, count, won = figures["dx"]
    assert low < difference < high
    assert difference == pytest.approx(float(np.mean(ERRORS / 2)), rel=1e-4)
    assert (count, won) == (len(ERRORS), 0)
    assert p < 0.05
    assert values["metrics"]["dx"]["errors"][0] == pytest.approx(ERRORS.tolist(), rel=1e-5)


def test_sequences_that_one_of_them_lacks_have_no_difference() -> None:
    site = site_of(result("a", np.full(5, np.nan)), result("b", np.ones(5)))
    values = comparison_values(site, BOARD)
    assert values["pairs"][0][2]["dx"] == [None, None, None, None, 0, 0]
    assert json.loads(json.dumps(values, allow_nan=False)) == values


def test_a_solvers_page_has_every_board_and_its_facts() -> None:
    other = replace(result("a", ERRORS * 2, trained_on="Zara 1"), board=FIELD)
    html = solver_page(site_of(result("a", ERRORS, code="https://example.org/a"), other), "a")
    page = Outline(html)
    assert not page.open
    assert [address for address in page.values("href") if address.startswith("#/hotel")] == [
        "#/hotel/sequential-field",
        "#/hotel/one-step-noisy",
        "#/hotel/sequential-field",
    ]
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


def test_strangers_words_stay_words_on_their_page() -> None:
    odd = result("a", ERRORS, reference=HOSTILE, version=HOSTILE, code="javascript:alert(1)", authors=HOSTILE)
    page = Outline(solver_page(site_of(odd), "a"))
    assert not page.all("img")
    assert not page.all("script")
    assert all(address.startswith("#/") for address in page.values("href"))


def test_bundled_solvers_lead_to_their_source() -> None:
    site = site_of(result("vb-cv", ERRORS), result("stranger", ERRORS))
    files = pages(site)
    own = bundled_sources(["vb-cv", "stranger"])
    assert list(own) == ["vb-cv"]
    assert "class ConstantVelocityBirdifier" in files[own["vb-cv"].address]
    assert own["vb-cv"].address in Outline(solver_page(site, "vb-cv")).values("href")
    elsewhere = site_of(result("vb-cv", ERRORS, code="https://example.org/fork"))
    assert not [name for name in pages(elsewhere) if name.startswith("code/")]
