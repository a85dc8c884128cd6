"""Fixtures that every test module may use, and how all of them are run."""

import gc
import os
import re
import signal
from collections.abc import Callable, Generator
from importlib.util import find_spec
from pathlib import Path

import pytest
from hypothesis import settings

from tests.lib.installing import Install, Installed
from vbbench.cli import main
from vbbench.registry import registered

Report = pytest.CollectReport | pytest.TestReport
pytest_plugins = ["pytester"]
settings.load_profile("ci")  # the same examples in every run, however long one takes


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--no-skips", action="store_true", help="a test that is skipped fails: all it needs must be here")
    parser.addoption("--reverse", action="store_true", help="the last test first: none may need another before it")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """A file that lacks a mark which is wanted, or has for all of it one which is not, is not imported."""
    wanted = config.option.markexpr
    if not wanted or not collection_path.name.startswith("test_"):
        return None
    text = collection_path.read_text("utf-8")
    lacks = any(f"mark.{name}" not in text for name in re.findall(r"(?<!not )\b(slow|extra)\b", wanted))
    spared = "not extra" in wanted and "\npytestmark = pytest.mark.extra" in text
    return True if lacks or spared else None


def installed(package: str) -> bool:
    try:
        return find_spec(package) is not None
    except ModuleNotFoundError:
        return False


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("reverse"):
        items.reverse()
    for item in items:
        for package in (name for mark in item.iter_markers("extra") for name in mark.args):
            if not installed(package):
                item.add_marker(pytest.mark.skip(reason=f"{package} is not installed: make test-extras"))


def pytest_collection_finish() -> None:
    """Thousands of tests stay in memory to the end: no search for garbage goes through them."""
    gc.collect()
    gc.freeze()


def pytest_sessionstart() -> None:
    """Started in the background of a shell, this process ignores SIGINT, and so would the commands that tests stop."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Generator[None, pytest.CollectReport, Report]:
    return without_skips(collector.config, (yield))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, Report]:
    return without_skips(item.config, (yield))


def without_skips(config: pytest.Config, report: Report) -> Report:
    """The report; with ``--no-skips``, a skip in it is a failure."""
    if report.skipped and not hasattr(report, "wasxfail") and config.getoption("no_skips"):
        report.outcome = "failed"
        report.longrepr = f"skipped, where --no-skips wants every test to run: {report.longrepr}"
    return report


@pytest.fixture(scope="session", autouse=True)
def sources_read_once() -> Generator[None]:
    """Solvers of the repository are read and hashed once: no test changes them. Those that a test writes always are."""
    from vbbench.solving import provenance, submissions

    known: dict[str, str] = {}

    def digest(solver: str) -> str:
        package = provenance._package(solver)
        if package not in ("tests", "vbbench_baselines"):
            return provenance.source_digest(solver)
        if package not in known:
            known[package] = provenance.source_digest(solver)
        return known[package]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(submissions, "source_digest", digest)
        yield


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Generator[Install]:
    """Installs a package with an entry point; called again, it adds another."""
    yield lambda group, name, value: Installed(monkeypatch, tmp_path / "site-packages", group, name, value)
    monkeypatch.undo()
    registered.cache_clear()


@pytest.fixture
def mistake(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs a command that is a mistake: status 2 and nothing on stdout; gives the one line on stderr."""

    def run(*words: object) -> str:
        capsys.readouterr()
        assert main([str(word) for word in words]) == 2
        said = capsys.readouterr()
        assert said.out == ""
        assert said.err.startswith("vbbench: ")
        assert said.err.count("\n") == 1, said.err
        return said.err

    return run


@pytest.fixture
def data_folder() -> Path:
    """The folder with the real recordings, or a skip that says how to get them."""
    folder = os.environ.get("VBBENCH_DATA")
    if not folder or not Path(folder, "eth", "biwi_hotel.txt").is_file():
        pytest.skip("no recordings: set $VBBENCH_DATA to the folder that `vbbench fetch` fills")
    return Path(folder)


@pytest.fixture
def no_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty $VBBENCH_DATA, with an empty cache folder behind it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    folder = tmp_path / "data"
    folder.mkdir()
    monkeypatch.setenv("VBBENCH_DATA", str(folder))
    return folder


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Write a text file into an empty folder and return its path."""

    def write_text(text: str, name: str = "tracks.txt") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write_text
