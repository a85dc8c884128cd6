"""The notebooks run as a notebook service runs them, cell by cell in one process.

That each is the one of its script is checked by `make site`.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

HOME = Path(__file__).parents[2] / "docs" / "notebooks"
NOTEBOOKS = sorted(HOME.glob("*.ipynb"))
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
