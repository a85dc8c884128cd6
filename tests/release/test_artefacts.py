"""What is wrong with the files of a release is found before anybody installs them."""

import io
import tarfile
import zipfile
from pathlib import Path

import pytest

from release.artefacts import check

FACTS = """Metadata-Version: 2.4
Name: vbbench
Version: {}
Description-Content-Type: text/markdown

# vbbench

It walks.
"""


def wheel(path: Path, facts: str, **files: str) -> Path:
    path.parent.mkdir(exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in {"vbbench-0.4.0.dist-info/METADATA": facts, "vbbench/__init__.py": "", **files}.items():
            archive.writestr(name, text)
    return path


def sdist(path: Path, facts: str) -> None:
    with tarfile.open(path, "w:gz") as archive:
        entry = tarfile.TarInfo(f"{path.name.removesuffix('.tar.gz')}/PKG-INFO")
        entry.size = len(facts)
        archive.addfile(entry, io.BytesIO(facts.encode()))


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """A sound release in ``dist``, and the wheel of its source tree."""
    wheel(tmp_path / "dist" / "vbbench-0.4.0-py3-none-any.whl", FACTS.format("0.4.0"))
    sdist(tmp_path / "dist" / "vbbench-0.4.0.tar.gz", FACTS.format("0.4.0"))
    wheel(tmp_path / "tree" / "tree.whl", FACTS.format("0.4.0"))
    return tmp_path


def test_a_sound_release_is_told_with_its_size(room: Path) -> None:
    assert check(room / "dist", room / "tree" / "tree.whl") == (
        "vbbench 0.4.0: 1 wheel and sdist of 0 kB and 0 kB, 2 files"
    )


def complaint(room: Path) -> str:
    with pytest.raises(ValueError, match=r".") as found:
        check(room / "dist", room / "tree" / "tree.whl")
    return str(found.value)


def test_a_file_that_the_sdist_lost_is_named(room: Path) -> None:
    wheel(room / "tree" / "tree.whl", FACTS.format("0.4.0"), **{"vbbench/paper.toml": "a"})
    assert complaint(room) == ("vbbench-0.4.0-py3-none-any.whl and the wheel of the tree differ in vbbench/paper.toml")


def test_two_versions_are_refused(room: Path) -> None:
    sdist(room / "dist" / "vbbench-0.4.0.tar.gz", FACTS.format("0.3.9"))
    assert complaint(room) == "vbbench-0.4.0-py3-none-any.whl is 0.4.0, the sdist 0.3.9; build all again"


def compiled(ending: str, bytes_: str) -> dict[str, str]:
    return {
        f"vbbench/_core{ending}": bytes_,
        "vbbench-0.4.0.dist-info/WHEEL": f"Tag: {ending}",
        "vbbench-0.4.0.dist-info/RECORD": bytes_,
    }


def test_wheels_of_several_platforms_have_modules_of_one_name(room: Path) -> None:
    (room / "dist" / "vbbench-0.4.0-py3-none-any.whl").unlink()
    for platform, ending in (("linux", ".cpython-311-x86_64-linux-gnu.so"), ("mac", ".abi3.so"), ("win", ".pyd")):
        wheel(room / "dist" / f"{platform}.whl", FACTS.format("0.4.0"), **compiled(ending, platform))
    wheel(room / "tree" / "tree.whl", FACTS.format("0.4.0"), **compiled(".so", "tree"))
    assert "3 wheels and sdist" in check(room / "dist", room / "tree" / "tree.whl")
    wheel(room / "dist" / "mac.whl", FACTS.format("0.4.0"))
    assert complaint(room) == "mac.whl and the wheel of the tree differ in vbbench/_core"


@pytest.mark.parametrize(
    ("facts", "said"),
    [
        (FACTS.format("0.4.0").replace("text/markdown", "text/x-rst"), "does not render"),
        (FACTS.format("0.4.0").replace("# vbbench", ""), "does not render"),
        (FACTS.format("no version"), "the metadata is wrong: 'no version'"),
    ],
)
def test_metadata_that_an_index_refuses_is_refused(room: Path, facts: str, said: str) -> None:
    wheel(room / "dist" / "vbbench-0.4.0-py3-none-any.whl", facts)
    assert said in complaint(room)
