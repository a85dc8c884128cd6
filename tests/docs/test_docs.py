"""The documentation is true: examples run, links and pictures exist, every command is shown."""

import re
import runpy
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from vbbench.camera import PanoramaCamera
from vbbench.cli import all_commands
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.registry import registered
from vbbench.scoring import score
from vbbench.solving import solve

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
LARGEST_PICTURE = 400_000
GUIDE = ROOT / "docs" / "writing-a-solver.md"
_LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")


def without_code(page: Path) -> str:
    """Prose only: neither fenced nor indented blocks, nor code in a line."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.M | re.S)
    return re.sub(r"`[^`]*`", "code", re.sub(r"^    .*$", "", text, flags=re.M))


def python_blocks(page: Path) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", page.read_text("utf-8"), flags=re.M | re.S)


def anchors(page: Path) -> set[str]:
    """Anchors of the headings, as the usual forges make them."""
    titles = re.findall(r"^#+ (.+)$", page.read_text("utf-8"), flags=re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles}


def links() -> Iterator[tuple[Path, str]]:
    for page in PAGES:
        for target in _LINK.findall(without_code(page)):
            if not target.startswith(("http:", "https:")):
                yield page, target


def test_links_resolve() -> None:
    def leads(page: Path, target: str) -> bool:
        name, _, anchor = target.partition("#")
        path = page.parent / name if name else page
        return path.is_file() and (not anchor or anchor in anchors(path))

    found = list(links())
    assert len(found) > 100
    assert not [f"{page.name} links to {target}" for page, target in found if not leads(page, target)]


def test_pictures_are_small_and_shown() -> None:
    shown = {(page.parent / target).resolve() for page, target in links()}
    pictures = {path for path in (ROOT / "docs" / "images").iterdir() if path.suffix in (".png", ".webp")}
    assert pictures <= shown
    assert all(picture.stat().st_size < LARGEST_PICTURE for picture in pictures)


def test_constants_of_the_page_are_those_of_the_code() -> None:
    done = subprocess.run(
        [sys.executable, ROOT / "docs" / "write_constants.py", "--check"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


def test_every_command_has_an_example_and_every_solver_its_description() -> None:
    text = "".join(page.read_text("utf-8") for page in (ROOT / "docs").glob("commands-*.md"))
    shown = re.findall(r"^    \$ (?:\w+=\S+ )?vbbench (.*)", text, flags=re.M)
    for command in all_commands():
        assert f"## `vbbench {command}`" in text
        assert any(line.split()[: len(command.split())] == command.split() for line in shown), command
    solvers = (ROOT / "docs" / "solvers.md").read_text("utf-8")
    assert not [solver for solver in registered("solver") if f"`{solver}`" not in solvers]


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if python_blocks(page)], ids=lambda page: page.name)
def test_python_blocks_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each block by itself; README's in a process of its own, as whoever pastes it runs it."""
    generate("demo", tmp_path / "tiny", Options(camera=PanoramaCamera(), limit=2))
    monkeypatch.chdir(tmp_path)
    for number, block in enumerate(python_blocks(page)):
        if page.parent == ROOT:
            done = subprocess.run([sys.executable, "-c", block], capture_output=True, text=True)
            assert done.returncode == 0, f"{block}\n{done.stderr}"
        else:
            script = tmp_path / f"block_{number}.py"
            script.write_text(block, encoding="utf-8")
            runpy.run_path(str(script), run_name="__main__")


@pytest.mark.slow
@pytest.mark.parametrize(("module", "name"), [("still", "StandStill"), ("line", "StraightLines")])
def test_example_solvers_answer(module: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    block = next(block for block in python_blocks(GUIDE) if f"class {name}" in block)
    unique = f"docs_example_{module}"
    (tmp_path / f"{unique}.py").write_text(block, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    dataset = generate("demo", tmp_path / "crowd", Options(camera=PanoramaCamera(), limit=2))
    for protocol in ("one-step", "sequential"):
        submission = solve(dataset, f"{unique}:{name}", protocol, tmp_path / protocol)
        assert score(submission, dataset.folder).coverage == 1.0
