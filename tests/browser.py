"""A headless Chromium for tests: pages, screenshots, how many colours they have, and what they asked for.

``from browser import needs_chromium, open_page, screenshot, colours``
"""

import io
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
ARGUMENTS = [
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run",
]  # fmt: skip


def needs_chromium():
    """Skip the test where there is no Chromium; on CI that is a failure."""
    if CHROMIUM is None:
        why = "no chromium on the path: install Debian's package `chromium` (make setup does)"
        if os.environ.get("CI") == "true":
            pytest.fail(why)
        pytest.skip(why)


@contextmanager
def open_browser():
    """A headless Chromium (a Playwright browser)."""
    needs_chromium()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def open_page(address, size=(900, 600), offline=False) -> Iterator:
    """The page at an address or path, as a Playwright page with two lists: `requests` and `errors`."""
    with open_browser() as browser:
        context = browser.new_context(
            viewport={"width": size[0], "height": size[1]}, offline=offline
        )
        page = context.new_page()
        watch(page)
        page.goto(address if "://" in str(address) else f"file://{os.path.abspath(address)}")
        yield page


def watch(page):
    """Write down every address that `page` asks for, and every error it meets."""
    page.requests, page.errors = [], []
    page.on("request", lambda request: page.requests.append(request.url))
    page.on("websocket", lambda socket: page.requests.append(socket.url))
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    page.on("console", lambda m: page.errors.append(m.text) if m.type == "error" else None)


def screenshot(page, path=None) -> np.ndarray:
    """What is seen, (height, width, 3) bytes; written to `path` as PNG, too, if there is one."""
    from PIL import Image

    png = page.screenshot(path=path)
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))


def colours(picture) -> int:
    """How many different colours a picture has.

    Leave captions out: the scene of a replay has above 900, an empty room about 540, letters alone 250.
    """
    flat = picture.reshape(-1, 3).astype(np.uint32)
    return len(np.unique(flat[:, 0] << 16 | flat[:, 1] << 8 | flat[:, 2]))
