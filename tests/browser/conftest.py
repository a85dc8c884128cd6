"""A browser, a site, and visitors whose pages must stay without fault. Without a browser: skipped."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from importlib.util import find_spec
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any

import pytest

from tests.lib.made_site import Made, make_site
from vbbench_leaderboards.results.folder import read_results
from vbbench_leaderboards.results.result import Board, Result

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.lib.browsing import Visitor


class WithoutPlaywright(pytest.Module):
    """A file of tests that cannot be imported."""

    def collect(self) -> Iterator[pytest.Item]:
        pytest.skip("no playwright: install the extra dev")
        yield from ()


def pytest_pycollect_makemodule(module_path: Path, parent: pytest.Collector) -> pytest.Module | None:
    """Stand in for the files of tests where there is no playwright."""
    return None if find_spec("playwright") else WithoutPlaywright.from_parent(parent, path=module_path)


@pytest.fixture(scope="package")  # not the session: other tests run event loops of their own
def browser() -> "Iterator[Browser]":
    from playwright.sync_api import sync_playwright

    from tests.lib.browsing import chromium, launch

    if chromium() is None:
        pytest.skip("no browser: install Debian's package chromium")
    with sync_playwright() as playwright:
        opened = launch(playwright)
        yield opened
        opened.close()


@pytest.fixture(scope="package")
def made(browser: "Browser", tmp_path_factory: pytest.TempPathFactory) -> Made:
    return make_site(tmp_path_factory.mktemp("leaderboard"))


@pytest.fixture(scope="package")
def site(made: Made) -> Path:
    return made.site


@pytest.fixture(scope="package")
def boards(made: Made) -> Mapping[Board, tuple[Result, ...]]:
    """What the site shows, as the files of results have it."""
    return read_results(made.results)


@pytest.fixture(scope="package")
def address(site: Path) -> Iterator[str]:
    """The same site, served."""
    with serve(site) as address:
        yield address


@contextmanager
def serve(site: Path) -> Iterator[str]:
    """The address of a site in a folder of a server on this machine."""
    handler = partial(QuietHandler, directory=site.parent)
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/{site.name}"
        server.shutdown()


class QuietHandler(SimpleHTTPRequestHandler):
    """Serves files and keeps no log."""

    def log_message(self, *arguments: Any) -> None:
        """Nothing."""


@pytest.fixture
def visitor(browser: "Browser", site: Path) -> "Iterator[Callable[..., Visitor]]":
    """Makes visitors; none of them may have met a fault by the end of the test."""
    from tests.lib.browsing import visit

    with ExitStack() as visits:
        made: list[Visitor] = []

        def make(place: Path | str = site, **options: Any) -> "Visitor":
            made.append(visits.enter_context(visit(browser, place, **options)))
            return made[-1]

        yield make
        faults = [fault for each in made for fault in each.faults]
    assert not faults, "\n".join(faults)


@pytest.fixture
def open_page(visitor: "Callable[..., Visitor]") -> "Callable[..., Page]":
    """Open the site at an address, as one visitor; options as for :func:`visit`."""

    def open_it(address: str = "", **options: Any) -> "Page":
        return visitor(**options).open(address)

    return open_it
