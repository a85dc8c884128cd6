"""Checks the files of a release before anybody installs them: one wheel and one sdist in a folder.

    python -m release.artefacts dist tree.whl

Both must be small, with valid metadata, the same version and a description that renders; the wheel, which is built from
the sdist, must have the same files as ``tree.whl``, which is built from the source tree: nothing is lost in the sdist.
"""

import sys
import tarfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from markdown_it import MarkdownIt
from packaging.metadata import Metadata

LARGEST = 6_000_000
"""Bytes of a wheel or an sdist; today 5.87 and 5.3 million: 3.3 published results, .7 weights that were learned."""


def check(dist: Path, tree_wheel: Path) -> str:
    """Check the release in the folder ``dist``; say what it is.

    Raises
    ------
    ValueError
        With the first thing that is wrong.
    """
    wheel, sdist = _only(dist, "*.whl"), _only(dist, "*.tar.gz")
    for path in (wheel, sdist):
        if path.stat().st_size > LARGEST:
            raise ValueError(f"{path.name} has {path.stat().st_size} bytes, more than {LARGEST}; leave something out")
    facts = [_metadata(_in_wheel(wheel)), _metadata(_in_sdist(sdist))]
    if facts[0].version != facts[1].version:
        raise ValueError(f"the wheel is {facts[0].version}, the sdist {facts[1].version}; build both anew")
    ours, trees = _contents(wheel), _contents(tree_wheel)
    if differing := sorted(name for name in {*ours, *trees} if ours.get(name) != trees.get(name)):
        raise ValueError(f"wheels of the sdist and of the tree differ in {', '.join(differing[:5])}")
    sizes = " and ".join(f"{path.stat().st_size / 1e3:.0f} kB" for path in (wheel, sdist))
    return f"vbbench {facts[0].version}: wheel and sdist of {sizes}, {len(ours)} files"


def _only(folder: Path, pattern: str) -> Path:
    found = sorted(folder.glob(pattern))
    if len(found) != 1:
        raise ValueError(f"{folder} has {len(found)} files {pattern}; one is wanted")
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
    """File → checksum."""
    with zipfile.ZipFile(path) as archive:
        return {facts.filename: facts.CRC for facts in archive.infolist()}


if __name__ == "__main__":
    try:
        sys.stdout.write(check(*map(Path, sys.argv[1:3])) + "\n")
    except ValueError as error:
        sys.exit(f"release: {error}")
