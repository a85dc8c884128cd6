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


def patched(path: Path, old: bytes, new: bytes) -> Path:
    content = path.read_bytes()
    assert old in content
    path.write_bytes(content.replace(old, new, 1))
    return path


def refuse(path: Path, problem: str, limits: Limits | None = None) -> None:
    before = sorted(path.parent.rglob("*"))
    with pytest.raises(FileError, match=problem) as caught, open_archive(path, limits) as archive:
        archive.read(archive.names[0])
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert sorted(path.parent.rglob("*")) == before


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "a" / "b").mkdir(parents=True)
    return tmp_path / "a" / "b" / "labels.zip"


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_an_honest_archive_is_read(file: Path, method: int) -> None:
    zipped(file, {"./train/": b"", "train/HT21-03/gt/gt.txt": BODY, "train/empty.txt": b""}, method)
    with open_archive(file) as archive:
        assert archive.names == ["train/HT21-03/gt/gt.txt", "train/empty.txt"]
        assert [archive.read(name) for name in archive.names] == [BODY, b""]
    assert sorted(file.parent.iterdir()) == [file]


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        *[(name, "absolute path; nothing of the") for name in ("/etc/passwd", "C:/x", "c:\\x", "\\\\server\\x")],
        *[(name, "climbs out of") for name in ("../gt.txt", "a/../../gt.txt", "a\\..\\..\\gt.txt", "..", "../")],
        ("../a\nb", r"a\\nb"),
        *[(twin, "is there twice") for twin in ("a/gt.txt", "a//gt.txt", "./a/gt.txt", "a\\gt.txt", "a/gt.txt/")],
    ],
)
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_suspicious_names(file: Path, name: str, problem: str) -> None:
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("a/gt.txt", BODY)
        archive.writestr(name, b"other")
    refuse(file, problem)


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFIFO, stat.S_IFCHR])
def test_links_and_devices(file: Path, kind: int) -> None:
    info = zipfile.ZipInfo("gt.txt")
    info.external_attr = (kind | 0o777) << 16
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr(info, "/etc/passwd")
    refuse(file, "is a link or another special file")


@pytest.mark.parametrize(
    ("members", "limits", "problem"),
    [
        ({"gt.txt": bytes(10_000_000)}, None, "grows 10.. times by unpacking, more than 200"),
        ({"gt.txt": BODY}, Limits(member_bytes=1000), "unpacks to 1100 bytes, more than 1000"),
        ({f"{n}.txt": b"" for n in range(11)}, Limits(members=10), "11 members, more than 10"),
        (
            {f"{n}.txt": b"" for n in range(2000)},
            Limits(directory_bytes=70_000),
            "not a complete zip archive.*list of members",
        ),
    ],
    ids=["ratio", "size", "members", "list of members"],
)
def test_bombs(file: Path, members: dict[str, bytes], limits: Limits | None, problem: str) -> None:
    refuse(zipped(file, members), problem, limits)


@pytest.mark.parametrize("stated", [len(BODY) - 22, 22, 0, len(BODY) + 1, None])
def test_a_member_that_unpacks_to_other_than_it_says(file: Path, stated: int | None) -> None:
    """None: 50 MB that are said to be 1000 bytes."""
    zipped(file, {"gt.txt": bytes(50_000_000) if stated is None else BODY})
    with zipfile.ZipFile(file) as archive:
        packed = archive.getinfo("gt.txt").compress_size
    content = bytearray(file.read_bytes())
    unpacked = 1000 if stated is None else stated
    struct.pack_into("<LL", content, content.index(b"PK\x01\x02") + 20, packed, unpacked)
    file.write_bytes(content)
    refuse(file, "member 'gt.txt' (cannot be unpacked|does not unpack to)")


@pytest.mark.parametrize("kept", [0.02, 0.5, 0.95, 0.999])
def test_truncated_archives(file: Path, kept: float) -> None:
    content = zipped(file, {f"{n}.txt": BODY * n for n in range(20)}).read_bytes()
    file.write_bytes(content[: int(kept * len(content))])
    refuse(file, "not a complete zip archive.*damaged or cut short")


@pytest.mark.parametrize(
    "content", [b"", b"PK", b"not a zip", b"PK\x05\x06" + b"\xff" * 18, b"PK\x05\x06" + b"\0" * 10]
)
def test_what_is_no_archive(file: Path, content: bytes) -> None:
    file.write_bytes(content)
    refuse(file, "not a complete zip archive")


def test_members_that_cannot_be_unpacked(file: Path) -> None:
    refuse(zipped(file, {"gt.txt": BODY}, zipfile.ZIP_LZMA), "packed by method 14; pack it by deflate")
    zipped(file, {"gt.txt": BODY}, zipfile.ZIP_STORED)
    refuse(patched(file, b"10,10,20", b"10,99,20"), "'gt.txt' cannot be unpacked: Bad CRC-32")
    zipped(file, {"gt.txt": BODY})
    refuse(patched(file, b"PK\x01\x02\x14\x03\x14\x00\x00", b"PK\x01\x02\x14\x03\x14\x00\x01"), "is encrypted")


def test_a_missing_file_and_a_folder(file: Path) -> None:
    for path in (file, file.parent):
        with pytest.raises(FileError, match="cannot be read"), open_archive(path):
            pass
