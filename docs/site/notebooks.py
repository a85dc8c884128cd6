"""Writes docs/notebooks/*.ipynb from the scripts next to them, as notebook services in a browser open them.

``python docs/site/notebooks.py`` writes them; ``--check`` fails where one is not that of its script. The extra ``docs``
is needed.
"""

import json
import sys
from pathlib import Path

NOTEBOOKS = Path(__file__).parents[1] / "notebooks"
FIRST_CELL = "%pip install --quiet 'vbbench[pandas]'"
"""What a machine without vbbench runs first."""


def notebook_of(script: Path) -> str:
    """The notebook of a script, as JSON."""
    from sphinx_gallery.gen_gallery import DEFAULT_GALLERY_CONF
    from sphinx_gallery.notebook import jupyter_notebook
    from sphinx_gallery.py_source_parser import split_code_and_text_blocks

    _, blocks = split_code_and_text_blocks(str(script))
    conf = {**DEFAULT_GALLERY_CONF, "first_notebook_cell": FIRST_CELL}
    notebook = jupyter_notebook(blocks, conf, str(script.parent))
    del notebook["metadata"]["language_info"]  # of this machine's Python
    return json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"


def main(arguments: list[str]) -> int:
    """Write the notebooks, or check them; the exit status."""
    wanted = {script.with_suffix(".ipynb"): notebook_of(script) for script in sorted(NOTEBOOKS.glob("*.py"))}
    if arguments != ["--check"]:
        for path, text in wanted.items():
            path.write_text(text, encoding="utf-8")
        return 0
    stale = [path.name for path, text in wanted.items() if not path.is_file() or path.read_text("utf-8") != text]
    if stale:
        sys.stderr.write(f"{', '.join(stale)}: not those of the scripts; run: python docs/site/notebooks.py\n")
    return int(bool(stale))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
