"""A headless Chromium for the tests of pages; they skip, with the reason, where there is none."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SLOW = 120_000  # ms: a page needs one second of a core that may be shared with ten


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    sync_api = pytest.importorskip(
        "playwright.sync_api", reason="playwright is not installed: pages are not opened"
    )
    program = (
        shutil.which("chromium")
        or shutil.which("chromium-browser")
        or shutil.which("google-chrome")
    )
    if program is None:
        pytest.skip("no Chromium is installed (apt-get install chromium): pages are not opened")
    with sync_api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def opened(chromium) -> Callable[..., Any]:
    """opened(path, width, scheme): a page that is drawn, without network; leaving it asserts that
    the console is silent and that nothing stands out at the side."""

    @contextmanager
    def open_page(path: Path, width: int = 1400, scheme: str = "light") -> Iterator[Any]:
        context = chromium.new_context(
            viewport={"width": width, "height": 900},
            color_scheme=scheme,
            offline=True,
            reduced_motion="reduce",
        )
        page, told = context.new_page(), []
        page.set_default_timeout(SLOW)
        page.on("console", lambda message: told.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: told.append(f"error: {error}"))
        page.on(
            "request",
            lambda request: told.append(request.url) if request.url.startswith("http") else None,
        )
        page.goto(path.resolve().as_uri())
        page.wait_for_selector("html[data-drawn]", state="attached")
        yield page
        beyond = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
        context.close()
        assert told == []
        assert beyond <= 0, f"{beyond} px stand out at the side"

    return open_page
