"""A browser without a network, and pages that report whatever goes wrong on them."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Page, Playwright, Request, Route, expect

NAMES = ("chromium", "google-chrome")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
DESKTOP = {"width": 1280, "height": 900}
PHONE = {"width": 360, "height": 740}
Open = Callable[..., Page]
"""Opens a page of the site at an address."""

PATIENCE = 60_000.0
"""How long in ms something is awaited: on a busy machine, too, what will come comes within it."""


expect.set_options(timeout=PATIENCE)


def chromium() -> str | None:
    """Where the browser lies, or ``None``."""
    return next(filter(None, map(shutil.which, NAMES)), None)


def launch(playwright: Playwright) -> Browser:
    return playwright.chromium.launch(executable_path=chromium(), args=list(FLAGS))


class Visitor:
    """Someone at the site: opens its pages, and notes what a careful eye would see in the console.

    Parameters
    ----------
    context : a browser's window of its own, without cookies or memory.
    site : the site's folder, or an address on this machine.
    """

    def __init__(self, context: BrowserContext, site: Path | str) -> None:
        self.context = context
        self.root = site if isinstance(site, str) else site.resolve().as_uri()
        self.faults: list[str] = []
        self.asked: list[str] = []
        context.set_default_timeout(PATIENCE)
        context.route("**/*", self._let_pass)
        context.on("page", self._watch)

    def open(self, address: str = "", *, wait: str = "main h1, main h2") -> Page:
        """A new page at that address of the site: ``#/students/one-step-noisy``."""
        page = self.context.new_page()
        page.goto(f"{self.root}/index.html{address}")
        page.wait_for_selector(wait, state="attached")
        return page

    def _let_pass(self, route: Route) -> None:
        self.asked.append(route.request.url)
        address = urlsplit(route.request.url)
        if address.scheme in ("file", "data", "blob") or address.hostname == "127.0.0.1":
            route.continue_()
        else:
            self.faults.append(f"asks for {route.request.url}")
            route.abort()

    def _watch(self, page: Page) -> None:
        page.on("console", self._hear)
        page.on("pageerror", lambda error: self.faults.append(f"page error: {error}"))
        page.on("requestfailed", self._miss)
        page.on("response", lambda answer: answer.status < 400 or self.faults.append(f"{answer.status} {answer.url}"))

    def _hear(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning"):
            self.faults.append(f"console {message.type}: {message.text}")

    def _miss(self, request: Request) -> None:
        if request.failure != "net::ERR_ABORTED":  # what a page leaves unfinished when it is left
            self.faults.append(f"cannot load {request.url}: {request.failure}")


@contextmanager
def visit(browser: Browser, site: Path | str, **options: Any) -> Iterator[Visitor]:
    """A visitor with a window of its own; ``options`` as for Playwright's ``new_context``."""
    usual = {"viewport": DESKTOP, "color_scheme": "light", "reduced_motion": "reduce"}  # no scrolling that takes time
    context = browser.new_context(**{**usual, **options})
    try:
        yield Visitor(context, site)
    finally:
        context.close()
