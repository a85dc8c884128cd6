"""The notes of a release: its section of CHANGELOG.md, once the tag, the section and the version agree.

python -m release.notes v0.4.0
"""

import re
import sys
from pathlib import Path

from release.version import ROOT, VERSION, released, version


def notes(tag: str, root: Path = ROOT) -> str:
    """The section of the release ``tag``.

    Raises
    ------
    ValueError
        Where the tag, the newest section and the version of the source tree do not agree.
    """
    number = tag.removeprefix("v")
    if not (tag.startswith("v") and re.fullmatch(VERSION, number)):
        raise ValueError(f"{tag} is no tag of a release; they look like v0.4.0")
    newest, found = released(root)[0], version(root)
    if number != newest:
        raise ValueError(f"CHANGELOG.md: the newest section is {newest}, not {number}; give {number} its section")
    if number != found:
        raise ValueError(f"the source tree is {found}, not {number}; check out the tag, with nothing changed")
    text = (root / "CHANGELOG.md").read_text("utf-8")
    section = re.search(rf"(?ms)^## \[{re.escape(number)}\][^\n]*\n(.*?)(?=^## |\Z)", text)
    return section[1].strip() if section else ""


if __name__ == "__main__":
    try:
        sys.stdout.write(notes("".join(sys.argv[1:2])) + "\n")
    except ValueError as error:
        sys.exit(f"release: {error}")
