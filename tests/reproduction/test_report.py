"""All studies in one folder: what cannot be made is said, and the page stands alone."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from vbbench.errors import VbbenchError, VbbenchWarning
from vbbench.paper import the_paper
from vbbench.reproduction.grid import Making
from vbbench.reproduction.report import Report
from vbbench.reproduction.studies import PAGE, chosen_studies, reproduce_all
from vbbench.table import Table

TABLE = Table(title="Of `cv`", head=["who", "Δx < 1 m"], rows=[["**us**", "0.5"], ["the paper", ""]])


class Small:
    """A study that is made at once."""

    def run(self, out: Path | str, making: Making) -> Report:
        facts, picture = ["The paper says < 1.", "- one\n- two"], Figure((1, 1))
        shown: dict[str, Any] = {
            "facts": facts,
            "tables": [TABLE],
            "values": {"figure": 0.5},
            "pictures": {"": picture},
        }
        return Report(name="small", title="A & B", **shown)


class Missing:
    """A study whose source is missing."""

    def run(self, out: Path | str, making: Making) -> Report:
        raise VbbenchError("hotel: its source is missing; get it with 'vbbench fetch hotel'")


def test_the_page_shows_every_study_and_needs_no_other_file(tmp_path: Path) -> None:
    studies: dict[str, Any] = {"missing": Missing(), "small": Small()}
    with pytest.warns(VbbenchWarning, match="missing is not made: hotel: its source is missing"):
        page = reproduce_all(studies, tmp_path / "out", Making())
    html = page.read_text("utf-8")
    assert page == tmp_path / "out" / PAGE
    assert "Not made: hotel: its source is missing; get it with &#39;vbbench fetch hotel&#39;" in html
    assert "<h2>A &amp; B</h2>" in html
    assert "<p>The paper says &lt; 1.</p>" in html
    assert "<ul><li>one</li><li>two</li></ul>" in html
    assert '<th>who</th><th class="figure">Δx &lt; 1 m</th>' in html
    assert '<td><b>us</b></td><td class="figure">0.5</td>' in html
    assert the_paper().link in html
    assert "<code>vbbench reproduce small</code>" in html
    assert re.findall(r'(?:src|href)="(?!data:image/png;base64,|#|https://arxiv)', html) == []
    assert html.count("data:image/png") == 1
    written = sorted(path.name for path in (tmp_path / "out" / "small").iterdir())
    assert written == ["small.json", "small.md", "small.png"]


def test_numbers_that_are_not_known_are_null() -> None:
    values = {"low": float("nan"), "rows": ({"high": float("inf"), "n": 3},)}
    assert json.loads(Report(name="x", title="x", values=values).json) == {
        "low": None,
        "rows": [{"high": None, "n": 3}],
    }


def test_a_page_of_all_takes_parts_and_options_reach_who_reads_them() -> None:
    every = {name: getattr(study, "every", None) for name, study in chosen_studies(["all"], {"seed": 3}).items()}
    assert "transfer" not in every
    assert (every["table2"], every["table3"], every["figure-posterior"]) == (10, 60, 1)
    table, sheet = chosen_studies(["table2", "figure-trajectories"], {"solver": ("cv",), "every": 4}).values()
    assert (table.every, table.solvers, sheet.solvers) == (4, ("cv",), ("cv",))
