"""All studies in one folder: what is done is kept, what cannot be made is said, and the page stands alone."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from tests.cli.test_cli import run
from vbbench.errors import VbbenchError, VbbenchWarning
from vbbench.paper import the_paper
from vbbench.reproduction.everything import DONE, PAGE, reproduce_all
from vbbench.reproduction.making import Making
from vbbench.reproduction.report import Report
from vbbench.reproduction.studies import Part, the_parts
from vbbench.reproduction.tables.table4.report import table4_report
from vbbench.reproduction.tables.table4.study import Table4Study, measure_table4
from vbbench.table import Table

TABLE = Table(title="Of `cv`", head=["who", "Δx < 1 m"], rows=[["**us**", "0.5"], ["the paper", ""]])


class Counted:
    """A study that counts how often it is made."""

    def __init__(self) -> None:
        self.times = 0

    def __call__(self, out: Path, making: Making) -> Report:
        self.times += 1
        picture = Figure((1, 1))
        facts = ["The paper says < 1.", "- one\n- two"]
        values = {"figure": 0.5, "jobs": making.jobs}
        return Report(name="counted", title="A & B", facts=facts, tables=[TABLE], values=values, pictures={"": picture})


def missing(out: Path, making: Making) -> Report:
    raise VbbenchError("hotel: its source is missing; get it with 'vbbench fetch hotel'")


pytestmark = pytest.mark.filterwarnings("ignore:missing is not made")


@pytest.fixture
def counted() -> Counted:
    return Counted()


@pytest.fixture
def parts(counted: Counted) -> dict[str, Part]:
    return {"missing": Part(study="none", make=missing), "counted": Part(study="seed 0", make=counted)}


def test_the_page_shows_every_study_and_needs_no_other_file(parts: dict[str, Part], tmp_path: Path) -> None:
    with pytest.warns(VbbenchWarning, match="missing is not made: hotel: its source is missing"):
        page = reproduce_all(parts, tmp_path / "out")
    html = page.read_text("utf-8")
    assert page == tmp_path / "out" / PAGE
    assert "Not made: hotel: its source is missing; get it with &#x27;vbbench fetch hotel&#x27;" in html
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


def test_a_study_that_is_done_is_kept(parts: dict[str, Part], counted: Counted, tmp_path: Path) -> None:
    first = reproduce_all(parts, tmp_path / "out").read_text("utf-8")
    assert reproduce_all(parts, tmp_path / "out").read_text("utf-8") == first
    assert counted.times == 1
    reproduce_all(parts, tmp_path / "out", Making(overwrite=True))
    assert counted.times == 2
    reproduce_all(parts | {"counted": replace(parts["counted"], study="seed 1")}, tmp_path / "out")
    assert counted.times == 3


def test_a_study_that_waits_for_a_source_is_made_again(counted: Counted, tmp_path: Path) -> None:
    waits = Part(study="seed 0", make=lambda out, making: replace(counted(out, making), whole=False))
    done = tmp_path / "out" / "counted" / DONE
    reproduce_all({"counted": waits}, tmp_path / "out")
    done.write_text(json.dumps(json.loads(done.read_text("utf-8")) | {"seconds": 99.0}), "utf-8")
    html = reproduce_all({"counted": waits}, tmp_path / "out").read_text("utf-8")
    assert counted.times == 2
    assert "<small>99 s</small>" in html  # the second time nearly everything was there


def test_what_was_missing_is_made_once_it_is_there(parts: dict[str, Part], counted: Counted, tmp_path: Path) -> None:
    reproduce_all(parts, tmp_path / "out")
    html = reproduce_all(parts | {"missing": Part(study="none", make=counted)}, tmp_path / "out").read_text("utf-8")
    assert "Not made" not in html


@pytest.mark.slow
def test_a_real_study_on_the_page(tmp_path: Path) -> None:
    study = Table4Study(solvers=("cv",), jitter=(1.0,), sequences=1)
    part = Part(study=study, make=lambda out, making: table4_report(measure_table4(study, out, making)))
    html = reproduce_all({"table4": part}, tmp_path / "out").read_text("utf-8")
    values = json.loads((tmp_path / "out" / "table4" / "table4.json").read_text("utf-8"))
    assert f'<td class="figure">{values["paper"]["ratio"]["dx"]:.2f}</td>' in html
    (ratio,) = (one["tracked"]["dx"] for one in values["ratios"] if one["protocol"] == "one-step")
    assert f'<td class="figure">{ratio["sequences"]:.2f} / {ratio["frames"]:.2f}</td>' in html


def test_numbers_that_are_not_known_are_null() -> None:
    values = {"low": float("nan"), "rows": ({"high": float("inf"), "n": 3},)}
    assert json.loads(Report(name="x", title="x", values=values).json) == {
        "low": None,
        "rows": [{"high": None, "n": 3}],
    }


def test_unknown_studies_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, _, errors = run(capsys, "reproduce", "all", "--study", "table44", "--out", tmp_path / "out")
    assert status == 2
    assert "no study is called 'table44'; did you mean 'table4'?" in errors
    assert list(the_parts(only=("figure-sigma",))) == ["figure-sigma"]
