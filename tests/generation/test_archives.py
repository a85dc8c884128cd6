"""Archives that mean harm, or came damaged, are refused in one line, and nothing is ever written."""

import stat
import struct
import zipfile
from pathlib import Path

import pytest

from vbbench.errors import FileError
from vbbench.generation.archives import Limits, open_archive

BODY = b"1,1,10,10,20,20,1,1,1\n" * 50


def zipped(path: Path, members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, body in members.items():
            archive.writestr(name, body)
    return path


def patched(path: Path, old: bytes, new: bytes, *, first: bool = False) -> Path:
    content = path.read_bytes()
    assert old in content
    path.write_bytes(content.replace(old, new, 1 if first else -1))
    return path


def refuse(path: Path, problem: str, name: str | None = None, limits: Limits | None = None) -> None:
    before = sorted(path.parent.rglob("*"))
    with pytest.raises(FileError, match=problem) as caught, open_archive(path, limits) as archive:
        archive.read(name or archive.names[0])
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert sorted(path.parent.rglob("*")) == before


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "a" / "b" / "labels.zip"


@pytest.fixture(autouse=True)
def folders(file: Path) -> None:
    file.parent.mkdir(parents=True)


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_an_honest_archive_is_read(file: Path, method: int) -> None:
    zipped(file, {"./train/": b"", "train/HT21-03/gt/gt.txt": BODY, "train/empty.txt": b""}, method)
    with open_archive(file) as archive:
        assert archive.names == ["train/HT21-03/gt/gt.txt", "train/empty.txt"]
        assert archive.read("train/HT21-03/gt/gt.txt") == BODY
        assert archive.read("train/empty.txt") == b""
    assert sorted(file.parent.iterdir()) == [file]


@pytest.mark.parametrize("name", ["/etc/passwd", "C:/windows/x", "c:\\x", "\\\\server\\x"])
def test_absolute_paths(file: Path, name: str) -> None:
    refuse(zipped(file, {name: BODY}), "absolute path; nothing of the archive is used")


@pytest.mark.parametrize("name", ["../gt.txt", "a/../../gt.txt", "a\\..\\..\\gt.txt", "..", "../"])
def test_paths_that_climb_out(file: Path, name: str) -> None:
    refuse(zipped(file, {"good.txt": BODY, name: BODY}), "climbs out of the archive")


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFIFO, stat.S_IFCHR])
def test_links_and_devices(file: Path, kind: int) -> None:
    info = zipfile.ZipInfo("gt.txt")
    info.external_attr = (kind | 0o777) << 16
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr(info, "/etc/passwd")
    refuse(file, "is a link or another special file")


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("twin", ["a/gt.txt", "a//gt.txt", "./a/gt.txt", "a\\gt.txt", "a/gt.txt/"])
def test_duplicates(file: Path, twin: str) -> None:
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("a/gt.txt", BODY)
        archive.writestr(twin, b"other")
    refuse(file, "is there twice")


def test_names_with_a_newline_stay_on_one_line(file: Path) -> None:
    refuse(zipped(file, {"../a\nb": BODY}), r"a\\nb")


def test_encrypted_members(file: Path) -> None:
    zipped(file, {"gt.txt": BODY})
    patched(file, b"PK\x01\x02\x14\x03\x14\x00\x00\x00", b"PK\x01\x02\x14\x03\x14\x00\x01\x00")
    refuse(file, "is encrypted")


def test_a_bomb_by_its_ratio(file: Path) -> None:
    refuse(zipped(file, {"gt.txt": bytes(10_000_000)}), "grows 10.. times by unpacking, more than 200")


def test_a_bomb_by_its_size(file: Path) -> None:
    refuse(zipped(file, {"gt.txt": BODY}), "unpacks to 1100 bytes, more than 1000", limits=Limits(member_bytes=1000))


def sizes(path: Path, packed: int, unpacked: int) -> Path:
    """Have the list of members tell other sizes of the first one."""
    content = bytearray(path.read_bytes())
    struct.pack_into("<LL", content, content.index(b"PK\x01\x02") + 20, packed, unpacked)
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("told", [len(BODY) - 22, 22, 0, len(BODY) + 1])
def test_a_member_that_unpacks_to_other_than_it_says(file: Path, told: int) -> None:
    zipped(file, {"gt.txt": BODY})
    with zipfile.ZipFile(file) as archive:
        packed = archive.getinfo("gt.txt").compress_size
    refuse(sizes(file, packed, told), "member 'gt.txt' (cannot be unpacked|does not unpack to)")


def test_a_bomb_that_says_to_be_small_is_not_unpacked_further(file: Path) -> None:
    zipped(file, {"gt.txt": bytes(50_000_000)})
    with zipfile.ZipFile(file) as archive:
        packed = archive.getinfo("gt.txt").compress_size
    refuse(sizes(file, packed, 1000), "cannot be unpacked|does not unpack")


def test_too_many_members(file: Path) -> None:
    refuse(zipped(file, {f"{n}.txt": b"" for n in range(11)}), "11 members, more than 10", limits=Limits(members=10))


def test_a_list_of_members_too_large_to_be_read(file: Path) -> None:
    zipped(file, {f"{n}.txt": b"" for n in range(2000)})
    refuse(file, "not a complete zip archive.*list of members", limits=Limits(directory_bytes=70_000))


@pytest.mark.parametrize("kept", [0.02, 0.5, 0.95, 0.999])
def test_truncated_archives(file: Path, kept: float) -> None:
    zipped(file, {f"{n}.txt": BODY * n for n in range(20)})
    content = file.read_bytes()
    file.write_bytes(content[: int(kept * len(content))])
    refuse(file, "not a complete zip archive.*damaged or cut short")


@pytest.mark.parametrize(
    "content", [b"", b"PK", b"not a zip", b"PK\x05\x06" + b"\xff" * 18, b"PK\x05\x06" + b"\0" * 10]
)
def test_what_is_no_archive(file: Path, content: bytes) -> None:
    file.write_bytes(content)
    refuse(file, "not a complete zip archive")


def test_other_ways_of_packing_are_refused(file: Path) -> None:
    refuse(zipped(file, {"gt.txt": BODY}, zipfile.ZIP_LZMA), "packed by method 14; pack it by deflate")


def test_a_damaged_member_is_named(file: Path) -> None:
    zipped(file, {"gt.txt": BODY}, zipfile.ZIP_STORED)
    refuse(patched(file, b"10,10,20", b"10,99,20", first=True), "'gt.txt' cannot be unpacked: Bad CRC-32")


def test_a_missing_file_and_a_folder(file: Path) -> None:
    for path in (file, file.parent):
        with pytest.raises(FileError, match="cannot be read"), open_archive(path):
            pass
