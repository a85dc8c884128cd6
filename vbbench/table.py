"""Tables of results and studies: rows of marked text, written as Markdown, LaTeX or plain text; rows of values as CSV.

Marked text is text with ``**bold**`` and a code in ````` between. A backslash takes its meaning from the sign after it,
and `unmarked` sets one before every sign of text that comes from a file, so that nobody's name is a mark.
"""

import csv
import io
import math
import re
import textwrap
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from vbbench.errors import one_line

if TYPE_CHECKING:
    from jinja2 import Environment

Write = Callable[[str], str]

Format = Literal["text", "markdown", "latex", "csv", "json"]
"""How results are written: a `Table` in one of three forms, or their values as CSV or JSON."""

TERMINAL = 120
"""Columns that facts below a table on a terminal take at most."""


@dataclass(frozen=True, kw_only=True)
class Table:
    """Rows of marked text; the first ``names`` columns name a row, the others are its figures.

    Parameters
    ----------
    title : what it shows; "" if what stands around it says so.
    facts : conditions and explanations, a paragraph each, above it.
    """

    title: str = ""
    facts: Sequence[str] = ()
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    names: int = 1

    def markdown(self) -> Iterator[str]:
        """Its lines."""
        if self.title:
            yield from (f"## {self.title}", "")
        for fact in self.facts:
            yield from (fact, "")
        yield _markdown_row(self.head)
        yield f"|{'---|' * self.names}{'---:|' * (len(self.head) - self.names)}"
        yield from map(_markdown_row, self.rows)
        yield ""

    def latex(self) -> Iterator[str]:
        r"""Its lines: a ``table`` with title and facts as caption, whose rules are those of the package booktabs."""
        caption = " ".join(f"{part.rstrip('.')}." for part in (self.title, *self.facts) if part)
        yield from (r"% \usepackage{booktabs}", r"\begin{table}", r"  \centering")
        yield from (r"  \scriptsize", r"  \setlength{\tabcolsep}{2.5pt}")
        yield from (f"  \\caption{{{latex(caption)}}}", r"  \medskip", "")
        yield f"  \\begin{{tabular}}{{@{{}}{'l' * self.names}{'r' * (len(self.head) - self.names)}@{{}}}}"
        yield from (r"    \toprule", _latex_row(map(latex, self.head)), r"    \midrule")
        yield from (_latex_row([*map(latex, row[: self.names]), *map(_figure, row[self.names :])]) for row in self.rows)
        yield from (r"    \bottomrule", r"  \end{tabular}", r"\end{table}", "")

    def text(self) -> Iterator[str]:
        """Its lines for a terminal: columns side by side, what is bold with an asterisk after it."""
        lines = [[terminal(cell) for cell in row] for row in (self.head, *self.rows)]
        widths = [max(map(_width, column)) for column in zip(*lines, strict=True)]
        if self.title:
            yield terminal(self.title)
        for line in lines:
            cells = zip(line, widths, strict=True)
            yield "  ".join(_aligned(*cell, left=n < self.names) for n, cell in enumerate(cells)).rstrip()
        for fact in self.facts:
            yield from textwrap.wrap(terminal(fact), TERMINAL, break_on_hyphens=False)


def csv_text(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Values as CSV: ``None`` and NaN as an empty cell, numbers with all their digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    for row in rows:
        writer.writerow(
            ["" if cell is None or (isinstance(cell, float) and math.isnan(cell)) else cell for cell in row]
        )
    return text.getvalue()


def environment(folder: Path) -> "Environment":
    """The Jinja templates of a folder: a name that is not given is an error, and what is put into HTML is escaped."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

    look: dict[str, Any] = {
        "trim_blocks": True,
        "lstrip_blocks": True,
        "autoescape": select_autoescape(("html", "svg")),
    }
    return Environment(loader=FileSystemLoader(folder), undefined=StrictUndefined, **look)  # noqa: S701


def decimals(values: Sequence[float]) -> int:
    """Decimals of a column of errors: three, or four if one is below 0.01."""
    return 4 if any(0 < abs(value) < 0.01 for value in values) else 3


def unmarked(text: str) -> str:
    """Text from a file as marked text that reads the same, on one line."""
    return re.sub(r"[\\`*|_<>\[\]~$&#]", r"\\\g<0>", one_line(text))


def best(cells: Sequence[str], values: Sequence[float | None], groups: Sequence[object] = ()) -> list[str]:
    """The cells with the figure of each group's least value in bold: what stands before a space.

    Nothing is marked where a group has no two different values; without ``groups`` all cells are one.
    """
    own = list(groups) or [None] * len(cells)
    known = [(group, value) for group, value in zip(own, values, strict=True) if value is not None and value == value]
    found = {group: {value for other, value in known if other == group} for group, _ in known}
    least = {group: min(values) for group, values in found.items() if len(values) > 1}
    marked = [value is not None and value == least.get(group) for group, value in zip(own, values, strict=True)]
    return [_bold(cell) if mark else cell for cell, mark in zip(cells, marked, strict=True)]


def _bold(cell: str) -> str:
    figure, space, rest = cell.partition(" ")
    return f"**{figure}**{space}{rest}"


def rewritten(text: str, *, plain: Write, code: Write, bold: Write) -> str:
    """Marked text in another notation: each function writes one kind of text; that of ``bold`` is written already."""
    parts, end = [], 0
    for mark in _MARK.finditer(text):
        parts.append(plain(text[end : mark.start()]))
        if mark["sign"]:
            parts.append(plain(mark["sign"]))
        elif mark["code"]:
            parts.append(code(mark["code"]))
        else:
            parts.append(bold(rewritten(mark["bold"], plain=plain, code=code, bold=bold)))
        end = mark.end()
    return "".join([*parts, plain(text[end:])])


_MARK = re.compile(r"\\(?P<sign>[!-/:-@\[-`{-~])|`(?P<code>[^`]+)`|\*\*(?P<bold>(?:\\.|[^*\\])+)\*\*")


def terminal(text: str) -> str:
    """Marked text as a terminal shows it."""
    return rewritten(text, plain=str, code=str, bold=lambda inner: f"{inner}*")


def latex(text: str) -> str:
    """Marked text as LaTeX."""
    return rewritten(
        text, plain=latex_text, code=lambda name: rf"\texttt{{{latex_text(name)}}}", bold=r"\textbf{{{}}}".format
    )


def latex_text(text: str) -> str:
    """Text as LaTeX that prints it; letters of other alphabets than Latin and Greek want LuaLaTeX or XeLaTeX."""
    return _IN_LATEX.sub(_in_latex, unicodedata.normalize("NFC", text))


def _in_latex(found: re.Match[str]) -> str:
    sign = found[0]
    return rf"\ensuremath{{\tilde{{{sign[0]}}}}}" if sign[1:] == _TILDE else _LATEX[sign]


def _pairs(words: str) -> dict[str, str]:
    """Every second word by the one before it."""
    found = words.split()
    return dict(zip(found[::2], found[1::2], strict=True))


_TILDE = "\u0303"
_MATHS = _pairs(r"""
    α \alpha β \beta γ \gamma δ \delta ε \varepsilon ζ \zeta η \eta θ \theta ι \iota κ \kappa λ \lambda μ \mu ν \nu
    ξ \xi π \pi ρ \rho σ \sigma τ \tau υ \upsilon φ \varphi χ \chi ψ \psi ω \omega Γ \Gamma Δ \Delta Θ \Theta Λ \Lambda
    Ξ \Xi Π \Pi Σ \Sigma Φ \Phi Ψ \Psi Ω \Omega ± \pm × \times − - · \cdot ≤ \le ≥ \ge ≈ \approx ≠ \ne → \to √ \surd
    ∞ \infty ‖ \Vert ° ^\circ ′ ' ∈ \in ² ^2 ³ ^3 ½ \frac12 ⁻ ^- ⁶ ^6 ᵀ ^T µ \mu ∝ \propto | \vert
    """)
_SIGNS = _pairs(r"""
    # \# $ \$ % \% & \& _ \_ { \textbraceleft{} } \textbraceright{} \ \textbackslash{}
    ~ \textasciitilde{} ^ \textasciicircum{} ` \textasciigrave{}
    < \textless{} > \textgreater{} " '' [ {[} ] {]} * {*} -- -{}- – -- — --- … \ldots{} ‘ ` ’ ' “ `` ” ''
    """)
_LATEX = _SIGNS | {"\u00a0": "~"} | {sign: rf"\ensuremath{{{maths}}}" for sign, maths in _MATHS.items()}
_IN_LATEX = re.compile("|".join([f"[^\\W_]{_TILDE}", *map(re.escape, sorted(_LATEX, key=len, reverse=True))]))


def _figure(cell: str) -> str:
    """A cell of figures as LaTeX: what follows the first is small."""
    figure, space, rest = cell.partition(" ")
    return rf"{latex(figure)} {{\tiny {latex(rest)}}}" if space else latex(figure)


def _latex_row(cells: Iterable[str]) -> str:
    return f"    {' & '.join(cells)} \\\\"


def _markdown_row(cells: Sequence[str]) -> str:
    return f"|{'|'.join(f' {cell} ' if cell else ' ' for cell in cells)}|"


def _aligned(cell: str, width: int, *, left: bool) -> str:
    space = " " * (width - _width(cell))
    return cell + space if left else space + cell


def _width(text: str) -> int:
    """Columns on a terminal, where a combining mark takes none."""
    return sum(not unicodedata.combining(sign) for sign in text)
