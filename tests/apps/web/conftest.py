"""What the tests of the operator page share: no sound card, and a real browser."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
import soundfile
from browser_page import SECONDS
from operator_page import with_noise
from playwright.sync_api import Browser, BrowserContext, Playwright, expect, sync_playwright
from recordings import FIXTURES

from voz.audio import SAMPLE_RATE

SAID_AFTER = 2.0
"""So long after the browser has opened its microphone somebody speaks, s."""

SAID_AGAIN = 5.0
"""So long after that it is begun anew, s: on a busy machine what is late is left out."""


@pytest.fixture(scope="module")  # it leaves an event loop running, which others cannot do with
def playwright() -> Iterator[Playwright]:
    with sync_playwright() as playwright:
        yield playwright


@pytest.fixture(scope="session")
def said(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Somebody says "go forward" in a quiet room now and then, at a rate of sound cards."""
    import soxr

    clip = FIXTURES / "commands" / "festival_slt__go_forward.flac"
    sound = with_noise(clip, SAID_AFTER, SAID_AGAIN)
    path = tmp_path_factory.mktemp("said") / "said.wav"
    soundfile.write(path, soxr.resample(sound, SAMPLE_RATE, 48_000), 48_000, subtype="PCM_16")
    return path


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
