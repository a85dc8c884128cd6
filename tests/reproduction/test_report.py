"""All studies in one folder: what is done is kept, what cannot be made is said, and the page stands alone."""

import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from tests.cli.test_cli import run
from vbbench.errors import VbbenchError, VbbenchWarning
from vbbench.paper import the_paper
from vbbench.reproduction.grid import Making
from vbbench.reproduction.report import Report
from vbbench.reproduction.studies import DONE, PAGE, chosen_studies, reproduce_all
from vbbench.table import Table

TABLE = Table(title="Of `cv`", head=["who", "Δx < 1 m"], rows=[["**us**", "0.5"], ["the paper", ""]])


@dataclass
class Counted:
    """A study that counts how often it is made."""

    name: str
    times: int = field(default=0, repr=False)
    whole: bool = True

    def run(self, out: Path | str, making: Making) -> Report:
        self.times += 1
        picture = Figure((1, 1))
        facts = ["The paper says < 1.", "- one\n- two"]
        values = {"figure": 0.5, "jobs": making.jobs}
        shown: dict[str, Any] = {"facts": facts, "tables": [TABLE], "values": values, "pictures": {"": picture}}
        return Report(name="counted", title="A & B", whole=self.whole, **shown)


class Missing:
    """A study whose source is missing."""

    def run(self, out: Path | str, making: Making) -> Report:
        raise VbbenchError("hotel: its source is missing; get it with 'vbbench fetch hotel'")


pytestmark = pytest.mark.filterwarnings("ignore:missing is not made")


@pytest.fixture
def counted() -> Counted:
    return Counted("seed 0")


@pytest.fixture
def studies(counted: Counted) -> dict[str, Any]:
    return {"missing": Missing(), "counted": counted}


def test_the_page_shows_every_study_and_needs_no_other_file(studies: dict[str, Any], tmp_path: Path) -> None:
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
    assert "<code>vbbench reproduce counted</code>" in html
    assert re.findall(r'(?:src|href)="(?!data:image/png;base64,|#|https://arxiv)', html) == []
    assert html.count("data:image/png") == 1
    written = sorted(path.name for path in (tmp_path / "out" / "counted").iterdir())
    assert written == ["counted.json", "counted.md", "counted.png", DONE]


def test_a_study_that_is_done_is_kept(studies: dict[str, Any], counted: Counted, tmp_path: Path) -> None:
    first = reproduce_all(studies, tmp_path / "out", Making()).read_text("utf-8")
    assert reproduce_all(studies, tmp_path / "out", Making()).read_text("utf-8") == first
    assert counted.times == 1
    reproduce_all(studies, tmp_path / "out", Making(overwrite=True))
    assert counted.times == 2
    again = Counted("seed 1")
    reproduce_all(studies | {"counted": again}, tmp_path / "out", Making())
    assert again.times == 1


def test_a_study_that_waits_for_a_source_is_made_again(tmp_path: Path) -> None:
    waits = Counted("seed 0", whole=False)
    done = tmp_path / "out" / "counted" / DONE
    reproduce_all({"counted": waits}, tmp_path / "out", Making())
    done.write_text(json.dumps(json.loads(done.read_text("utf-8")) | {"seconds": 99.0}), "utf-8")
    html = reproduce_all({"counted": waits}, tmp_path / "out", Making()).read_text("utf-8")
    assert waits.times == 2
    assert "<small>99 s</small>" in html  # the second time nearly everything was there


def test_what_was_missing_is_made_once_it_is_there(studies: dict[str, Any], counted: Counted, tmp_path: Path) -> None:
    reproduce_all(studies, tmp_path / "out", Making())
    html = reproduce_all(studies | {"missing": counted}, tmp_path / "out", Making()).read_text("utf-8")
    assert "Not made" not in html


def test_numbers_that_are_not_known_are_null() -> None:
    values = {"low": float("nan"), "rows": ({"high": float("inf"), "n": 3},)}
    assert json.loads(Report(name="x", title="x", values=values).json) == {
        "low": None,
        "rows": [{"high": None, "n": 3}],
    }


def test_unknown_studies_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, _, errors = run(capsys, "reproduce", "all", "table44", "--out", tmp_path / "out")
    assert status == 2
    assert "no study is called 'table44'; did you mean 'table4'?" in errors


def test_a_page_of_all_takes_parts_and_options_reach_who_reads_them() -> None:
    every = {name: getattr(study, "every", None) for name, study in chosen_studies(["all"], {"seed": 3}).items()}
    assert "transfer" not in every
    assert (every["table2"], every["table3"], every["figure-posterior"]) == (10, 60, 1)
    table, sheet = chosen_studies(["table2", "figure-trajectories"], {"solver": ("cv",), "every": 4}).values()
    assert (table.every, table.solvers, sheet.solvers) == (4, ("cv",), ("cv",))
