"""Provenance of a submission: version of the solver, digest of its source, and hardware, without importing the solver.

The source is the solver's package with all its files (learned parameters, compiled extensions), or its single module,
and likewise every module imported by name that is not an installed package. Installed packages are identified by their
version, except the solver's own, which is always read.
"""

import hashlib
import inspect
import os
import platform
import re
import sys
import sysconfig
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.machinery import ModuleSpec
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from vbbench.errors import VbbenchError, VbbenchWarning
from vbbench.registry import Kind, load_all, make_solver, registered
from vbbench.solver import FrameSolver, SequenceSolver

READ_WHOLE = 1 << 24
"""Bytes up to which a file is hashed; larger ones are identified by size and time of the last change."""

IMPORT = re.compile(r"(?:^|[:;])[ \t]*(?:from[ \t]+(\w+)|import[ \t]+([\w.,  \t]+))", re.MULTILINE)
"""``from one import …`` or ``import several, of, them``."""


def source_digest(name: str, kind: Kind = "solver") -> str:
    """A hash, 16 hex digits, of the files of a solver (a registered name, or ``module:attribute``); see above.

    ``kind`` selects another registry, such as that of generators.
    """
    package = _package(name, kind)
    digest, seen, left = hashlib.sha256(), {package}, [package]
    while left:
        name = left.pop(0)
        for label, path in sorted(_files(name)):
            digest.update(f"{name} {label} ".encode() + _content(path))
            fresh = _imports(path) - seen
            seen |= fresh
            left += sorted(filter(_is_own, fresh))
    return digest.hexdigest()[:16]


def source_places(solver: str) -> list[Path]:
    """The file of a solver's top-level module, or the folders of its package; none if it cannot be found."""
    return [path.resolve() for path in _places(_spec(_package(solver)))]


def _package(name: str, kind: Kind = "solver") -> str:
    point = registered(kind).get(name)
    return (point.value if point else name).partition(":")[0].partition(".")[0]


def _places(spec: ModuleSpec | None) -> list[Path]:
    if spec is None:
        return []
    folders = spec.submodule_search_locations
    return [Path(folder) for folder in folders] if folders else [Path(spec.origin)] if spec.origin else []


def _files(name: str) -> Iterator[tuple[str, Path]]:
    """The files of a top-level module or package, each with a name that does not depend on its location."""
    for place in _places(_spec(name)):
        if not place.is_dir():
            yield place.name, place
        for path in place.rglob("*"):
            relative = path.relative_to(place)
            if path.is_file() and not any(part.startswith((".", "__pycache__")) for part in relative.parts):
                yield relative.as_posix(), path


def _content(path: Path) -> bytes:
    """The hash of a file's content, or for a large file its size and time."""
    try:
        facts = path.stat()
        if facts.st_size > READ_WHOLE:
            return f"{facts.st_size} {facts.st_mtime_ns}".encode()
        return hashlib.sha256(path.read_bytes()).digest()
    except OSError:
        return b"unreadable"


def _imports(path: Path) -> frozenset[str]:
    """Top-level names that a Python file imports, found by a pattern; a false match does no harm."""
    if path.suffix != ".py" or not path.is_file():
        return frozenset()
    return _imported(path.read_bytes())


@lru_cache(maxsize=4096)
def _imported(source: bytes) -> frozenset[str]:
    found = IMPORT.findall(source.decode("utf-8", "replace"))
    names = [name for one, several in found for name in (one, *several.split(","))]
    return frozenset(name.split()[0].partition(".")[0] for name in names if name.strip())


def _is_own(name: str) -> bool:
    """Whether a module belongs neither to Python nor to an installed package."""
    if name in sys.stdlib_module_names:
        return False
    places = [place.resolve() for place in _places(_spec(name))]
    return bool(places) and not any(place.is_relative_to(folder) for place in places for folder in _installed())


@cache
def _installed() -> tuple[Path, ...]:
    """The folders of Python's modules and of packages."""
    return tuple(Path(sysconfig.get_path(kind)).resolve() for kind in ("stdlib", "platstdlib", "purelib", "platlib"))


def _spec(name: str) -> ModuleSpec | None:
    """The spec of a top-level module, found without running its code."""
    try:
        return find_spec(name)
    except (ImportError, ValueError):
        return None


def solver_version(solver: str) -> str:
    """Version of the distribution that a solver comes from, or ``unknown``."""
    point = registered("solver").get(solver)
    names = [point.dist.name] if point and point.dist else _distributions().get(_package(solver), [])
    try:
        return version(names[0]) if names else "unknown"
    except PackageNotFoundError:
        return "unknown"


@cache
def _distributions() -> Mapping[str, list[str]]:
    """The distributions of each top-level module; cached, as it reads the records of all distributions."""
    return packages_distributions()


def hardware() -> str:
    """A line that describes this machine's hardware, for readers of the seconds per frame."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text("utf-8", "replace").splitlines() if path.is_file() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor() or platform.machine()}, {os.cpu_count()} cores"


@dataclass(frozen=True, kw_only=True)
class SolverCard:
    """Facts of a solver that is not imported yet.

    Parameters
    ----------
    name : its registered name.
    package : the distribution that registers it, with its version.
    kind : ``frame by frame``, or ``whole sequence``.
    summary : the first line of its docstring, if it has one.
    """

    name: str
    package: str
    kind: str
    summary: str


def solver_cards() -> list[SolverCard]:
    """The cards of all solvers, by name; warns of solvers that cannot be loaded."""
    cards = []
    for name, factory in sorted(load_all("solver").items()):
        try:
            cards.append(_card(name, factory))
        except VbbenchError as error:
            warnings.warn(str(error), VbbenchWarning, stacklevel=2)
    return cards


def describe_solvers() -> str:
    """All solvers as text."""
    return "\n".join(
        f"{card.name}: {card.summary} [{', '.join(filter(None, (card.kind, card.package)))}]" for card in solver_cards()
    )


def _card(name: str, factory: Any) -> SolverCard:
    solver = factory if inspect.isclass(factory) else make_solver(name)
    distribution = registered("solver")[name].dist
    return SolverCard(
        name=name,
        package=f"{distribution.name} {distribution.version}" if distribution else "",
        kind=_kind(name, solver),
        summary=(inspect.getdoc(factory) or "").partition("\n")[0],
    )


def _kind(name: str, solver: Any) -> str:
    for protocol, kind in ((FrameSolver, "frame by frame"), (SequenceSolver, "whole sequence")):
        if all(callable(getattr(solver, method, None)) for method in vars(protocol) if not method.startswith("_")):
            return kind
    raise VbbenchError(f"solver '{name}' has neither start and step nor solve")
