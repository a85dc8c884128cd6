"""A solver's own page, and two solvers side by side: the statistics of ``vbbench compare``, history, and code."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.answers import submit, true_answers
from tests.board_results import BOARD, result
from tests.make_dataset import Crowd, write_dataset
from tests.test_leaderboard_page import ERRORS, HOSTILE, Outline, pages, site_of  # the pages of made results
from vbbench.scoring import score
from vbbench.scoring.comparison import compare
from vbbench_leaderboards.page.comparing import comparison_values
from vbbench_leaderboards.page.sources import bundled_sources
from vbbench_leaderboards.results.about import About
from vbbench_leaderboards.results.comparing import contrasts
from vbbench_leaderboards.results.result import Board, Result

FIELD = Board(split="hotel", tier="field", protocol="sequential")


def solver_page(site: Any, solver: str) -> str:
    text = pages(site)[f"data/pages/solver/{solver}.js"]
    values: dict[str, str] = json.loads(text.partition(",")[2].removesuffix(");\n"))
    return values["html"]


def test_two_results_differ_as_their_submissions_do(tmp_path: Path) -> None:
    write_dataset(tmp_path / "data", Crowd(scenes=8, frames=24, people=9, seed=3))
    about = About(authors="a", date="2026-11-22", delay=0, trained_on="nothing", tuned_on="nothing")
    rows = []
    for name, noise in (("one", 0.05), ("two", 0.1)):
        submit(tmp_path / name, tmp_path / "data", true_answers(tmp_path / "data", noise, seed=1), solver=name)
        rows.append(Result.of(score(tmp_path / name, tmp_path / "data"), tmp_path / name, about))
    own = contrasts(rows).pairs[0, 1]
    wanted = compare(tmp_path / "one", tmp_path / "two", tmp_path / "data").differences
    for metric, difference in wanted.items():
        found = own[metric]
        assert found.difference == pytest.approx(difference.difference, rel=1e-5)
        assert (found.low, found.high) == pytest.approx(difference.ci95, rel=1e-4)
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
    assert "has taken the place of another" in html


def test_history_is_drawn_and_told() -> None:
    past = replace(result("a", ERRORS * 2, version="0.9").present, date="2026-01-02")
    row = replace(result("a", ERRORS, dataset="f" * 16), history=(past,))
    html = solver_page(site_of(row), "a")
    entries = html.partition('class="entries"')[2].partition("</ol>")[0]
    assert entries.count("<li>") == 2
    assert "0.9, <time>2026-01-02</time>" in entries
    assert "(other data)" in entries
    assert html.count("<circle") == 2


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
