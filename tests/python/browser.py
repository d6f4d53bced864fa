"""A headless Chromium for tests of pages; without one they are skipped."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")


@contextmanager
def opened(path: Path, **options: Any) -> Iterator[Any]:
    """Open a page in a browser without network, and fail where it logs an error."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = next(filter(None, map(shutil.which, NAMES)), None)
    with api.sync_playwright() as playwright:
        kind = playwright.chromium
        if program is None and not Path(kind.executable_path).exists():
            pytest.skip("no Chromium is installed")
        browser = kind.launch(executable_path=program, args=["--no-sandbox"])
        try:
            context = browser.new_context(offline=True, **options)
            page = context.new_page()
            errors: list[str] = []
            page.on("pageerror", lambda error: errors.append(str(error)))
            page.on(
                "console",
                lambda told: (
                    errors.append(told.text) if told.type in ("error", "warning") else None
                ),
            )
            page.on(
                "request",
                lambda one: (
                    None if one.url.startswith(("file:", "data:")) else errors.append(one.url)
                ),
            )
            page.goto(path.as_uri())
            yield page
            assert errors == []
        finally:
            browser.close()


def ready(page: Any) -> None:
    """Wait until the player has unpacked its data."""
    page.wait_for_selector(".player[data-ready]", timeout=60_000)


def shown_time(page: Any) -> float:
    """The time that the player shows [s]."""
    return float(page.evaluate("document.querySelector('.player').player.time"))
