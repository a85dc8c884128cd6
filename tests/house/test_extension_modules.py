"""Extension modules: nothing in them gives other bytes on another machine, and bindings refuse what does not fit."""

import re
import shutil
import subprocess
from importlib import import_module
from typing import Any

import numpy as np
import pytest

from vbbench.errors import VbbenchError
from vbbench_generators import _core
from vbbench_generators.social_force import Model, model_numbers

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


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"scenes": np.array([[0, 3, 0, 2, 0, 1]])}, "scenes must have people who are in states"),
        ({"scenes": np.array([[0, 2, 0, 3, 0, 1]])}, "scenes must have a goal for everybody"),
        ({"scenes": np.array([[0, 2, 0, 2, 0, 2]])}, "scenes must have groups that are in groups"),
        ({"groups": np.array([0, 3])}, "groups must be where members start"),
        ({"members": np.array([0, 2])}, "members must be people of their scene"),
        ({"speeds": np.ones(3)}, r"speeds must have the shape \[2\], not \[3\]"),
        ({"threads": 0}, "threads must be at least 1"),
    ],
)
def test_crowds_that_do_not_fit_are_refused(changes: dict[str, Any], problem: str) -> None:
    crowds = {
        "scenes": np.array([[0, 2, 0, 2, 0, 1]]),
        "states": np.arange(8.0).reshape(4, 2),
        "speeds": np.ones(2),
        "goals": np.ones((2, 2)),
        "members": np.array([0, 1]),
        "groups": np.array([0, 2]),
        "walls": np.empty((0, 4)),
        "numbers": model_numbers(Model()),
        "dt": 0.1,
        "substeps": 1,
        "paths": np.empty((2, 2, 2)),
        "threads": 1,
        "large": False,
    }
    _core.march(**crowds)
    with pytest.raises(VbbenchError, match=problem):
        _core.march(**{**crowds, **changes})
