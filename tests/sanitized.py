"""Runs tests with an extension module that was built with sanitizers: ``python -m tests.sanitized FOLDER TESTS…``.

``make sanitize`` builds it, and sets what the sanitizers need.
"""

import importlib.util
import sys
from pathlib import Path

import pytest

import vbbench_baselines

NAME = "vbbench_baselines._core"


def use(folder: Path) -> None:
    """Put the module of the folder in the place of that of the package."""
    file = next(folder.glob("_core*.so"))
    spec = importlib.util.spec_from_file_location(NAME, file)
    if spec is None or spec.loader is None:
        raise ImportError(f"{file} is no extension module")
    module = sys.modules[NAME] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    vbbench_baselines._core = module


if __name__ == "__main__":
    use(Path(sys.argv[1]))
    sys.exit(pytest.main(["-p", "no:cacheprovider", *sys.argv[2:]]))
