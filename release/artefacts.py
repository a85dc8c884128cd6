"""Checks the files of a release before a person installs them: wheels and one sdist in a folder.

    python -m release.artefacts dist tree.whl

All must be small, with valid metadata, the same version and a description that renders. The wheels, which are built
from the sdist for each platform, must have the same files as ``tree.whl``, which is built from the source tree: nothing
is lost in the sdist. Compiled modules are compared by their names, since compilers need not write the same bytes.
"""

import sys
import tarfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from markdown_it import MarkdownIt
from packaging.metadata import Metadata

LARGEST = 7_500_000
"""Bytes of a wheel or an sdist; today 7.48 million: 4.1 published results, .9 films, .7 modules, .6 weights."""

COMPILED = (".so", ".pyd")
"""Endings of extension modules; what stands before names Python and platform."""


def check(dist: Path, tree_wheel: Path) -> str:
    """Check the release in the folder ``dist``; say what it is.

    Raises
    ------
    ValueError
        With the first thing that is wrong.
    """
    wheels, sdist = sorted(dist.glob("*.whl")), _only_sdist(dist)
    if not wheels:
        raise ValueError(f"{dist} has no wheel; build one")
    for path in (*wheels, sdist):
        if path.stat().st_size > LARGEST:
            raise ValueError(f"{path.name} has {path.stat().st_size} bytes, more than {LARGEST}; leave something out")
    version, trees = _metadata(_in_sdist(sdist)).version, _contents(tree_wheel)
    for wheel in wheels:
        if (its := _metadata(_in_wheel(wheel)).version) != version:
            raise ValueError(f"{wheel.name} is {its}, the sdist {version}; build all again")
        ours = _contents(wheel)
        if differing := sorted(name for name in {*ours, *trees} if ours.get(name) != trees.get(name)):
            raise ValueError(f"{wheel.name} and the wheel of the tree differ in {', '.join(differing[:5])}")
    sizes = " and ".join(f"{path.stat().st_size / 1e3:.0f} kB" for path in (*wheels, sdist))
    return f"vbbench {version}: {len(wheels)} wheel{'s' * (len(wheels) > 1)} and sdist of {sizes}, {len(trees)} files"


def _only_sdist(folder: Path) -> Path:
    found = sorted(folder.glob("*.tar.gz"))
    if len(found) != 1:
        raise ValueError(f"{folder} has {len(found)} files *.tar.gz; one is wanted")
    return found[0]


def _metadata(text: bytes) -> Metadata:
    """Core metadata, every field checked, with a description that is Markdown for people."""
    try:
        facts = Metadata.from_email(text, validate=True)
    except ExceptionGroup as error:
        raise ValueError(f"the metadata is wrong: {'; '.join(map(str, error.exceptions))}") from error
    html = MarkdownIt("js-default").render(facts.description or "")
    if facts.description_content_type != "text/markdown" or "<h1>" not in html:
        raise ValueError("the long description does not render; it must be Markdown with a title")
    return facts


def _in_wheel(path: Path) -> bytes:
    with zipfile.ZipFile(path) as archive:
        return archive.read(next(name for name in archive.namelist() if name.endswith(".dist-info/METADATA")))


def _in_sdist(path: Path) -> bytes:
    with tarfile.open(path) as archive:
        file = archive.extractfile(f"{path.name.removesuffix('.tar.gz')}/PKG-INFO")
        return file.read() if file else b""


def _contents(path: Path) -> Mapping[str, int]:
    """File → checksum; of compiled modules the name without the platform → 0. RECORD and WHEEL name the platform."""
    found = {}
    with zipfile.ZipFile(path) as archive:
        for facts in archive.infolist():
            if facts.is_dir() or facts.filename.endswith((".dist-info/RECORD", ".dist-info/WHEEL")):
                continue
            if facts.filename.endswith(COMPILED):
                folder, _, name = facts.filename.rpartition("/")
                found[f"{folder}/{name.partition('.')[0]}"] = 0
            else:
                found[facts.filename] = facts.CRC
    return found


if __name__ == "__main__":
    try:
        sys.stdout.write(check(*map(Path, sys.argv[1:3])) + "\n")
    except ValueError as error:
        sys.exit(f"release: {error}")
