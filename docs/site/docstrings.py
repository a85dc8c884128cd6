"""Docstrings as they are written here, turned into those that napoleon reads.

Sections of parameters have ``name : meaning`` on a line (types are annotations), and returns are plain sentences.
"""

import re
from typing import Any

_PARAMETER = re.compile(r"(\*{0,2}\w+(?:, \*{0,2}\w+)*) : (.+)")
_UNDERLINE = re.compile(r"-{3,}")
_NAMED = ("Parameters", "Attributes")
_SAID = ("Returns", "Yields")


def numpy_style(lines: list[str]) -> list[str]:
    """The same docstring with every meaning below its name, and what is returned as one field."""
    found: list[str] = []
    section = ""
    for line in lines:
        if _UNDERLINE.fullmatch(line) and found:
            section = found[-1]
            if section in _SAID:
                found[-1:] = [f":{section.lower()}:"]
                continue
        elif section in _NAMED and (named := _PARAMETER.fullmatch(line)):
            found += [named[1], f"    {named[2]}"]
            continue
        elif section in _SAID and line:
            line = f"    {line}"
        found.append(line)
    return found


def _rewrite(_app: Any, _what: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    lines[:] = numpy_style(lines)


def setup(app: Any) -> dict[str, bool]:
    """Before napoleon, whose priority is 500."""
    app.connect("autodoc-process-docstring", _rewrite, priority=400)
    return {"parallel_read_safe": True}
