"""Tables: marked text in every notation, whatever a name holds; LaTeX that TeX reads, CSV that reads back."""

import csv
import io
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from markdown_it import MarkdownIt

from vbbench.scoring.metrics import METRICS
from vbbench.table import Table, best, csv_text, latex, latex_text, terminal, unmarked

NASTY = r"""a|b **bold** `code` $x$ 5% #1 c_d ~^\ {x} <i> & "q" [2] *x* \input{x} --out Δx̃ ±σ é …"""
TABLE = Table(
    title="Of `vb_cv`",
    facts=["At 5 % of **all**."],
    head=["solver", "Δx̃ (m)", "µs/frame"],
    rows=[["vb-cv", "**0.052** (0.041–0.063)", "12"], [unmarked(NASTY), "1.000 (0.900–1.100)", ""]],
)
printable = st.text(st.characters(exclude_categories=["Cs", "Cc", "Cf", "Zl", "Zp"]), max_size=40)

_KNOWN = re.compile(
    r"\\(text(bf|tt|backslash|asciitilde|asciicircum|asciigrave|less|greater|braceleft|braceright)|ensuremath|tilde|ldots)"
)


def check_latex(text: str) -> None:
    """Balanced braces, no bare sign that TeX obeys, ``^`` within mathematics alone, no command that is not ours."""
    maths = re.compile(r"\\ensuremath\{(?:[^{}]|\{[^{}]*\})*\}")
    outside = maths.sub("", text)
    assert not re.search(r"(?<!\\)[#$%&_^]", outside), text
    for command in re.findall(r"\\[A-Za-z]+", outside):
        assert _KNOWN.fullmatch(command), command
    assert not re.search(r"\\(?![A-Za-z#$%&_])", outside), text
    depth = 0
    for sign in re.findall(r"[{}]", text):
        depth += 1 if sign == "{" else -1
        assert depth >= 0, text
    assert depth == 0, text


@given(printable)
def test_any_name_is_safe_in_latex_and_the_same_on_a_terminal(name: str) -> None:
    check_latex(latex_text(name))
    check_latex(latex(unmarked(name)))
    assert terminal(unmarked(name)) == name
    assert terminal(f"**{unmarked(name)}**") == (f"{name}*" if name else "****")


@given(printable.filter(lambda name: name.strip() == name and name != ""))
def test_any_name_is_one_cell_of_a_markdown_table(name: str) -> None:
    table = "\n".join(Table(head=["solver", "Δx"], rows=[[unmarked(name), "1"]]).markdown())
    html = MarkdownIt("js-default", {"linkify": False}).parse(table)
    cells = [token.children for token in html if token.type == "inline"]
    assert len(cells) == 4
    assert [child.type for child in cells[2] or []] == ["text"] * len(cells[2] or [])
    assert "".join(child.content for child in cells[2] or []) == name


@pytest.mark.parametrize(
    "words", [*(metric.label for metric in METRICS.values()), *(m.meaning for m in METRICS.values())]
)
def test_what_tables_say_of_metrics_is_plain_ascii_in_latex(words: str) -> None:
    check_latex(latex(words))
    assert latex(words).isascii()


@pytest.mark.parametrize(
    ("marked", "wanted"),
    [
        ("Δx̃ (m)", r"\ensuremath{\Delta}\ensuremath{\tilde{x}} (m)"),
        ("5 % ± σ_h", r"5 \% \ensuremath{\pm} \ensuremath{\sigma}\_h"),
        ("**0.1** (0.0–0.2)", r"\textbf{0.1} (0.0--0.2)"),
        ("`solve --out`", r"\texttt{solve -{}-out}"),
        (r"a\*\*b\|c", r"a{*}{*}b\ensuremath{\vert}c"),
        ("[2] \\ {", r"{[}2{]} \textbackslash{} \textbraceleft{}"),
        ("−1 °", r"\ensuremath{-}1 \ensuremath{^\circ}"),
    ],
)
def test_marks_and_signs_in_latex(marked: str, wanted: str) -> None:
    assert latex(marked) == wanted


def test_a_table_on_a_terminal() -> None:
    small = Table(
        head=["solver", "Δx̃ (m)"], rows=[["vb-cv", "**0.05** (0.04–0.06)"], ["sf", "1"]], title="T", facts=["F"]
    )
    assert list(small.text()) == [
        "T",
        "solver             Δx̃ (m)",
        "vb-cv   0.05* (0.04–0.06)",
        "sf                      1",
        "F",
    ]


def test_the_best_of_each_group_is_marked() -> None:
    cells = ["2 (1–3)", "1 (0–2)", "1 (0–2)", "–", "5"]
    assert best(cells, [2.0, 1.0, 1.0, None, 5.0]) == ["2 (1–3)", "**1** (0–2)", "**1** (0–2)", "–", "5"]
    assert best(cells, [2.0, 1.0, 1.0, float("nan"), 5.0], "aabbb") == [
        cells[0],
        "**1** (0–2)",
        "**1** (0–2)",
        "–",
        "5",
    ]
    assert best(cells[:1], [2.0]) == cells[:1], "nobody is the best of one"
    assert best(cells[1:3], [1.0, 1.0]) == cells[1:3], "nor of equals"


@given(st.lists(st.tuples(printable, st.floats(allow_infinity=False) | st.none())))
def test_csv_reads_back_to_the_last_bit(rows: list[tuple[str, float | None]]) -> None:
    head, *found = csv.reader(io.StringIO(csv_text(("name", "value"), rows)))
    assert head == ["name", "value"]
    assert [row[0] for row in found] == [name for name, _ in rows]
    for (_, value), (_, text) in zip(rows, found, strict=True):
        assert text == "" if value is None or value != value else float(text) == value


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no pdflatex here")
def test_tex_sets_the_table(tmp_path: Path) -> None:
    lines = [
        r"\documentclass{article}",
        r"\usepackage{booktabs}",
        r"\begin{document}",
        *TABLE.latex(),
        r"\end{document}",
    ]
    (tmp_path / "table.tex").write_text("\n".join(lines), encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "table.tex"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, errors="replace", check=False)
    assert done.returncode == 0, done.stdout[-3000:]
    assert "Missing character" not in done.stdout
