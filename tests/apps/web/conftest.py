"""What the tests of the operator page share: no sound card, and a real browser."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from browser_page import SECONDS, drive, for_a_browser, opened
from operator_page import PageRobot, with_noise
from playwright.sync_api import (
    Browser,
    BrowserContext,
    Page,
    Playwright,
    expect,
    sync_playwright,
)
from recordings import FIXTURES


@pytest.fixture(scope="module")  # it leaves an event loop running, which others cannot do with
def playwright() -> Iterator[Playwright]:
    with sync_playwright() as playwright:
        yield playwright


@pytest.fixture(scope="session")
def said(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Somebody says "go forward" in a quiet room now and then."""
    clip = FIXTURES / "commands" / "festival_slt__go_forward.flac"
    return for_a_browser(clip, tmp_path_factory.mktemp("said") / "said.wav")


@pytest.fixture(scope="session")
def forward() -> np.ndarray:
    """Somebody says "go forward" in a quiet room, once."""
    return with_noise(FIXTURES / "commands" / "festival_slt__go_forward.flac", 0.0, 0.5)


@pytest.fixture(scope="module")
def browser(playwright: Playwright, said: Path) -> Iterator[Browser]:
    """A browser whose microphone hears somebody speak."""
    sound = f"--use-file-for-fake-audio-capture={said}"
    browser = launched(playwright, "--use-fake-ui-for-media-stream", sound)
    yield browser
    browser.close()


@pytest.fixture
def context(browser: Browser) -> Iterator[BrowserContext]:
    expect.set_options(timeout=SECONDS)
    context = browser.new_context(permissions=["microphone"], ignore_https_errors=True)
    context.set_default_timeout(SECONDS)
    yield context
    context.close()


@pytest.fixture
def phone(browser: Browser) -> Iterator[BrowserContext]:
    """A browser on a phone, of the smallest that there are."""
    context = browser.new_context(
        permissions=["microphone"],
        viewport={"width": 320, "height": 568},
        is_mobile=True,
        has_touch=True,
        user_agent="Mozilla/5.0 (iPhone; CPU iPhone OS 18_0 like Mac OS X) AppleWebKit/605.1.15",
    )
    yield context
    context.close()


@pytest.fixture
def robot(one_run: PageRobot) -> PageRobot:
    """The run of a module, with the robot at rest at the beginning of each test."""
    one_run.api.post("/api/stop").raise_for_status()
    return one_run


@pytest.fixture
def page(robot: PageRobot, context: BrowserContext) -> Page:
    """A page that drives the robot of a module."""
    page = opened(context, robot.link)
    drive(page)
    return page


def launched(playwright: Playwright, *arguments: str) -> Browser:
    """Start Debian's chromium."""
    path = shutil.which("chromium")
    assert path, "there is no chromium: `sh tools/install.sh tests` installs it"
    usual = [
        "--no-sandbox",
        "--disable-gpu",
        "--disable-quic",
        "--use-fake-device-for-media-stream",
    ]
    return playwright.chromium.launch(executable_path=path, args=[*usual, *arguments])
