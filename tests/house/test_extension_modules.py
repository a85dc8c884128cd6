"""Extension modules: nothing in them gives other bytes on another machine."""

import re
import shutil
import subprocess
from importlib import import_module

import pytest

MODULES = [f"vbbench_{package}._core" for package in ("generators", "renderers", "baselines")]
FUSED = re.compile(r"\tvfn?m(?:add|sub)|\tfn?m(?:add|sub)\b|\tfml[as]\b")
"""Multiplications and additions that are rounded once, on x86-64 and on aarch64."""


@pytest.mark.parametrize("module", MODULES)
@pytest.mark.skipif(shutil.which("objdump") is None, reason="needs objdump, of binutils")
def test_no_multiplication_and_addition_are_rounded_as_one(module: str) -> None:
    file = import_module(module).__file__
    assert file is not None
    listing = subprocess.run(["objdump", "--disassemble", file], capture_output=True, text=True, check=False)
    if listing.returncode:
        pytest.skip("objdump does not read modules of this system")
    assert len(listing.stdout) > 100_000
    assert not FUSED.findall(listing.stdout)
