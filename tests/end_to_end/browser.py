"""Chromium with touch, for tests: one browser, and phones as contexts of it."""

import contextlib
import importlib.util
import shutil
import time

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
ARGUMENTS = (
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip
needs_browser = pytest.mark.skipif(
    CHROMIUM is None or importlib.util.find_spec("playwright") is None,
    reason="needs Chromium and playwright (make test installs both)",
)


class Phone:
    """A page in a context of its own: touch, portrait, a language."""

    def __init__(self, browser, device, link, language="en-GB"):
        self.context = browser.new_context(**device, locale=language)
        self.page = self.context.new_page()
        self.errors = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda message: message.type == "error" and self.errors.append(message.text))
        self.page.goto(link)
        self._touch = self.context.new_cdp_session(self.page)

    def ready(self):
        """Wait until the phone plays and knows the beat; returns itself."""
        self.until("live.ready()")
        return self

    def until(self, expression):
        """Poll until the expression is true in the page, whose security policy forbids long evaluation."""
        deadline = time.monotonic() + 60.0
        while not self.page.evaluate(expression):
            assert time.monotonic() < deadline, f"waited in vain for {expression}: {self.errors}"
            self.page.wait_for_timeout(20)

    def _send(self, kind, *points):
        self._touch.send(
            "Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y, "id": 1} for x, y in points]}
        )

    def at(self, across, down):
        """Page pixels of a surface position given as shares of width and height."""
        box = self.page.locator("#stage").bounding_box()
        return box["x"] + across * box["width"], box["y"] + down * box["height"]

    def drag(self, start, end, steps=6):
        """Put a finger down, move it and leave it down."""
        self._send("touchStart", self.at(*start))
        for step in range(1, steps + 1):
            share = step / steps
            self._send("touchMove", self.at(*(a + share * (b - a) for a, b in zip(start, end, strict=True))))

    def hold(self, place):
        """Put a finger down."""
        self._send("touchStart", self.at(*place))

    def lift(self):
        """Take the finger away."""
        self._send("touchEnd")


@contextlib.contextmanager
def browser(*arguments):
    """Yields (the browser, the device emulated by its phones); `arguments`: further ones for Chromium."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=[*ARGUMENTS, *arguments])
        try:
            yield opened, playwright.devices["Pixel 7"]
        finally:
            opened.close()
