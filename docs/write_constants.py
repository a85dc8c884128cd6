"""The table of the estimator's constants on docs/map-solver.md, from ``baselines/cpp/estimator/constants.hpp``.

python docs/write_constants.py            # writes it
python docs/write_constants.py --check    # fails if the page has another one
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCE, PAGE = ROOT / "baselines" / "cpp" / "estimator" / "constants.hpp", ROOT / "docs" / "map-solver.md"
BEGIN, END = "| constant | value | meaning | source |\n|---|---|---|---|\n", "\n\n"

LINE = r"(?m)^  (?:double|std::array<[^>]*>) (.*?);\s*///< (.*) \[(\w)\]$"


def table(source: str) -> str:
    """The rows of the table: a line of the struct each, with what its comment states."""
    rows = []
    for names, meaning, origin in re.findall(LINE, source):
        pairs = re.findall(r"(\w+)(?:\{([^}]*)\}| = ([^,]+))", names)
        values = "; ".join(braced or plain for _, braced, plain in pairs)
        rows.append(f"| {', '.join(f'`{name}`' for name, _, _ in pairs)} | {values} | {meaning} | {origin} |")
    if len(rows) != source.count("///<"):
        sys.exit(f"{SOURCE.name} has a constant without unit, meaning and source on its line")
    return "\n".join(rows)


def written(page: str, rows: str) -> str:
    """The page with these rows."""
    before, _, rest = page.partition(BEGIN)
    return before + BEGIN + rows + END + rest.partition(END)[2]


if __name__ == "__main__":
    page = PAGE.read_text("utf-8")
    wanted = written(page, table(SOURCE.read_text("utf-8")))
    if "--check" not in sys.argv[1:]:
        PAGE.write_text(wanted, "utf-8")
    elif page != wanted:
        sys.exit("docs/map-solver.md has other constants than constants.hpp: python docs/write_constants.py")
