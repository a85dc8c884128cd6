"""Extension modules: nothing in them gives other bytes on another machine."""

import re
import shutil
import subprocess
from importlib import import_module

import pytest

MODULES = [f"vbbench_{package}._core" for package in ("generators", "renderers", "baselines")]
FUSED = re.compile(r"\tvfn?m(?:add|sub)|\tfn?m(?:add|sub)\b|\tfml[as]\b")
"""Multiplications and additions that are rounded once, on x86-64 and on aarch64."""
LIBRARY = re.compile(
    r"\b_?((?:a?(?:sin|cos|tan)h?|atan2|sincos(?:pi)?|exp(?:2|10|m1)?|log(?:2|10|1p)?|pow|hypot|cbrt|erfc?|[lt]gamma)[fl]?)\b(?:@|$)",
    re.M,
)
"""Functions that libraries of mathematics round differently."""


@pytest.mark.parametrize(
    ("command", "wrong"),
    [("objdump --disassemble", FUSED), ("nm -D --undefined-only", LIBRARY)],
    ids=["fused", "library"],
)
@pytest.mark.parametrize("module", MODULES)
def test_nothing_is_rounded_as_one_machine_does_it(module: str, command: str, wrong: re.Pattern) -> None:
    """No multiplication and addition is rounded as one, and no function is of the system's library of mathematics."""
    if shutil.which(command.split()[0]) is None:
        pytest.skip(f"needs {command.split()[0]}, of binutils")
    command = [*command.split(), import_module(module).__file__]
    listing = subprocess.run(command, capture_output=True, text=True, check=False)
    if listing.returncode:
        pytest.skip(f"{command[0]} does not read modules of this system")
    assert "malloc" in listing.stdout, "calls are listed"
    assert not wrong.findall(listing.stdout)


@pytest.mark.parametrize(
    ("line", "found"),
    [("U exp@GLIBC_2.29", ["exp"]), ("U sincosf", ["sincosf"]), ("U _atan2", ["atan2"]), ("U fmod@GLIBC_2.2.5", [])],
)
def test_the_search_finds_such_functions(line: str, found: list[str]) -> None:
    assert LIBRARY.findall(line) == found
