"""Runs tests with extension modules that were built with sanitizers: ``python -m tests.lib.sanitized FOLDER TESTS…``.

``make sanitize`` builds them, and sets what the sanitizers need.
"""

import importlib
import importlib.util
import sys
from pathlib import Path

import pytest


def use(folder: Path) -> None:
    """Put the modules of the folder in the place of those of the packages."""
    for file in folder.glob("vbbench_*/_core*.so"):
        package = file.parent.name
        spec = importlib.util.spec_from_file_location(f"{package}._core", file)
        if spec is None or spec.loader is None:
            raise ImportError(f"{file} is no extension module")
        module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        importlib.import_module(package)._core = module


if __name__ == "__main__":
    use(Path(sys.argv[1]))
    sys.exit(pytest.main(["-p", "no:cacheprovider", *sys.argv[2:]]))
