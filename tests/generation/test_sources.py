"""Sources are found, checked and fetched; a bad download leaves nothing behind."""

import hashlib
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from vbbench.errors import FileError, SourceMissingError, VbbenchError, VbbenchWarning
from vbbench.generation.sources import Source, data_folder, fetch, find_source, is_here, locate

BODY = b"0 1 2.0 3.0\n" * 1000
SHA256 = hashlib.sha256(BODY).hexdigest()


class Handler(BaseHTTPRequestHandler):
    asked: list[str]

    def do_GET(self) -> None:
        self.asked.append(self.path)
        body = BODY.replace(b"3", b"4") if self.path == "/corrupted" else BODY
        self.send_response(404 if self.path == "/absent" else 200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body[: len(body) // 2] if self.path == "/truncated" else body)

    def log_message(self, *args: object) -> None:
        """Keep the test output clean."""


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[ThreadingHTTPServer]:
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    Handler.asked = []
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield running
        running.shutdown()
        thread.join()


def source_at(server: ThreadingHTTPServer, page: str = "whole") -> Source:
    return Source("eth/tracks.txt", f"http://127.0.0.1:{server.server_port}/{page}", SHA256)


def local(path: str = "eth/tracks.txt") -> Source:
    return Source(path, "http://127.0.0.1:9/never", SHA256)


def put(folder: Path, name: str, body: bytes = BODY) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(body)
    return path


def test_fetch_downloads_once_what_is_not_there_under_its_bare_name(server: ThreadingHTTPServer, no_data: Path) -> None:
    source = source_at(server)
    assert not is_here(source)
    assert fetch([source]) == fetch([source]) == [no_data / "eth/tracks.txt"]
    assert (no_data / "eth/tracks.txt").read_bytes() == BODY
    assert is_here(source)
    assert Handler.asked == ["/whole"]
    (no_data / "eth/tracks.txt").rename(no_data / "tracks.txt")
    assert fetch([source]) == [no_data / "tracks.txt"]
    assert Handler.asked == ["/whole"]


def test_fetch_draws_a_bar_on_a_terminal_only(
    server: ThreadingHTTPServer, no_data: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (path,) = fetch([source_at(server)])
    assert capfd.readouterr() == ("", "")
    path.unlink()
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    fetch([source_at(server)])
    assert "100%" in capfd.readouterr().err


@pytest.mark.parametrize(("page", "reason"), [("truncated", "cut short"), ("corrupted", "damaged"), ("absent", "404")])
def test_bad_download_leaves_nothing(server: ThreadingHTTPServer, no_data: Path, page: str, reason: str) -> None:
    source = source_at(server, page)
    with pytest.raises(VbbenchError, match=reason) as caught:
        fetch([source])
    message = str(caught.value)
    assert source.path in message
    assert source.url in message
    assert str(no_data / "eth/tracks.txt") in message
    assert "\n" not in message
    assert not [path.name for path in no_data.rglob("*") if path.is_file()]


def test_no_more_is_taken_than_the_file_has(server: ThreadingHTTPServer, no_data: Path) -> None:
    with pytest.raises(VbbenchError, match="damaged or another file"):
        fetch([replace(source_at(server), size=len(BODY) - 1)])
    assert list((no_data / "eth").iterdir()) == []


def test_server_down(no_data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    with pytest.raises(VbbenchError, match=r"eth/tracks\.txt could not be fetched.*no connection"):
        fetch([local()])


def test_a_damaged_file_stays_until_it_is_fetched_again(server: ThreadingHTTPServer, no_data: Path) -> None:
    path = put(no_data, "eth/tracks.txt", b"cut")
    with pytest.warns(VbbenchWarning), pytest.raises(VbbenchError):
        fetch([source_at(server, "truncated")])
    assert path.read_bytes() == b"cut"
    with pytest.warns(VbbenchWarning, match="wrong checksum"):
        fetch([source_at(server)])
    assert path.read_bytes() == BODY


def test_unwritable_folder_is_one_clear_error(server: ThreadingHTTPServer, no_data: Path) -> None:
    put(no_data, "eth", b"a file where a folder should be")
    with pytest.raises(VbbenchError, match=r"eth/tracks\.txt: File exists; choose another place"):
        fetch([source_at(server)])


@pytest.mark.parametrize("name", ["eth/tracks.txt", "tracks.txt"])
def test_search_order(no_data: Path, tmp_path: Path, name: str) -> None:
    assert find_source(local()) is None
    cached = put(tmp_path / "cache/vbbench", name)
    assert find_source(local()) == cached
    in_data = put(no_data, name)
    assert find_source(local()) == in_data
    explicit = put(tmp_path / "explicit", name)
    assert find_source(local(), tmp_path / "explicit") == explicit
    assert find_source(local(), explicit) == explicit


def test_data_folder_is_the_cache_without_the_variable(
    no_data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert data_folder() == no_data
    monkeypatch.delenv("VBBENCH_DATA")
    assert data_folder() == tmp_path / "cache/vbbench"


def test_locate_missing_says_what_to_do(no_data: Path) -> None:
    with pytest.raises(SourceMissingError) as caught:
        locate([local(), local("eth/other.txt")], split="hotel")
    for part in ("vbbench fetch hotel", local().url, str(no_data / "eth/other.txt"), "VBBENCH_DATA"):
        assert part in str(caught.value)


def test_locate_refuses_other_bytes(no_data: Path) -> None:
    path = put(no_data, "eth/tracks.txt", BODY[:-1])
    assert not is_here(local())
    with pytest.raises(FileError, match="SHA-256") as caught:
        locate([local()])
    assert caught.value.path == path


def test_locate_explicit_file_of_another_name(no_data: Path, tmp_path: Path) -> None:
    path = put(tmp_path, "renamed.txt")
    assert locate([local()], path) == [path]
    with pytest.raises(VbbenchError, match="name the folder"):
        locate([local(), local("eth/other.txt")], path)
    with pytest.raises(VbbenchError, match="no such file"):
        locate([local()], tmp_path / "nowhere")
