"""The notebooks run as a notebook service runs them, cell by cell in one process, and are those of their scripts."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

HOME = Path(__file__).parents[2] / "docs" / "notebooks"
NOTEBOOKS = sorted(HOME.glob("*.ipynb"))
FIRST_CELL = "%pip install --quiet 'vbbench[pandas]'"
RUN = """import json, matplotlib, sys
matplotlib.use("agg")
for number, cell in enumerate(json.loads(sys.stdin.read())):
    exec(compile(cell, f"cell {number}", "exec"))
"""
"""In the module ``__main__`` without a file, as in a notebook."""


def cells(notebook: Path, kind: str) -> list[str]:
    found = json.loads(notebook.read_text("utf-8"))["cells"]
    return ["".join(cell["source"]) for cell in found if cell["cell_type"] == kind]


def test_every_script_has_its_notebook() -> None:
    assert [path.stem for path in NOTEBOOKS] == [path.stem for path in sorted(HOME.glob("*.py"))]
    assert len(NOTEBOOKS) == 3


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_notebook_is_that_of_its_script(notebook: Path) -> None:
    """Code and text; `make site` compares them byte by byte."""
    first, *code = cells(notebook, "code")
    assert first == FIRST_CELL
    script = notebook.with_suffix(".py").read_text("utf-8")
    for cell in code:
        assert cell.strip() in script
    written = len(re.findall(r"(?m)^(?!#|\s*$)", script.partition('"""\n')[2].partition('"""\n')[2]))
    assert sum(len([line for line in cell.splitlines() if line and line[0] != "#"]) for cell in code) == written
    assert not re.search(r":\w+:`", "".join(cells(notebook, "markdown"))), "a role that only the site knows"


@pytest.mark.slow
@pytest.mark.extra("pandas")
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs_in_a_service(notebook: Path, tmp_path: Path) -> None:
    code, sizes = re.subn(r"limit=\d+", "limit=3", json.dumps(cells(notebook, "code")[1:]))
    assert sizes == 1
    done = subprocess.run(
        [sys.executable, "-c", RUN], input=code, capture_output=True, text=True, encoding="utf-8", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert not list(tmp_path.iterdir())
