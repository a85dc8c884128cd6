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


@pytest.mark.parametrize("module", MODULES)
@pytest.mark.skipif(shutil.which("objdump") is None, reason="needs objdump, of binutils")
def test_no_multiplication_and_addition_are_rounded_as_one(module: str) -> None:
    file = import_module(module).__file__
    listing = subprocess.run(["objdump", "--disassemble", file], capture_output=True, text=True, check=False)
    if listing.returncode:
        pytest.skip("objdump does not read modules of this system")
    assert len(listing.stdout) > 100_000
    assert not FUSED.findall(listing.stdout)


@pytest.mark.parametrize("module", MODULES)
@pytest.mark.skipif(shutil.which("nm") is None, reason="needs nm, of binutils")
def test_no_function_is_of_the_systems_library_of_mathematics(module: str) -> None:
    file = import_module(module).__file__
    listing = subprocess.run(["nm", "-D", "--undefined-only", file], capture_output=True, text=True, check=False)
    if listing.returncode:
        pytest.skip("nm does not read modules of this system")
    assert "malloc" in listing.stdout
    assert not LIBRARY.findall(listing.stdout)


@pytest.mark.parametrize(
    ("line", "found"),
    [("U exp@GLIBC_2.29", ["exp"]), ("U sincosf", ["sincosf"]), ("U _atan2", ["atan2"]), ("U fmod@GLIBC_2.2.5", [])],
)
def test_the_search_finds_such_functions(line: str, found: list[str]) -> None:
    assert LIBRARY.findall(line) == found
