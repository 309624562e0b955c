"""The operator page in a real browser: what several tests do with it."""

from __future__ import annotations

import re
from pathlib import Path

import soundfile
import soxr
from operator_page import with_noise
from playwright.sync_api import BrowserContext, ConsoleMessage, Locator, Page, Route, expect

from voz.audio import SAMPLE_RATE

AXE = Path(__file__).parent / "apps" / "web" / "node_modules" / "axe-core" / "axe.min.js"

SECONDS = 30_000
"""A busy machine may need that long, ms."""

SAID_AFTER = 2.0
"""So long after the browser has opened its microphone somebody speaks, s."""

SAID_AGAIN = 5.0
"""So long after that it is begun anew, s: on a busy machine what is late is left out."""

SOUND_CARD_RATE = 48_000

HARMLESS = ("ERR_CONNECTION_REFUSED", "ERR_CONNECTION_RESET", "401 (Unauthorized)", "ERR_EMPTY")
"""What a browser writes of a server that is not there, or that wants a token."""


def for_a_browser(clip: Path, path: Path) -> Path:
    """Write a clip in a quiet room as a browser can take it for its microphone."""
    sound = soxr.resample(with_noise(clip, SAID_AFTER, SAID_AGAIN), SAMPLE_RATE, SOUND_CARD_RATE)
    soundfile.write(path, sound, SOUND_CARD_RATE, subtype="PCM_16")
    return path


def opened(context: BrowserContext, address: str) -> Page:
    """Open the page; whatever it complains of fails the test."""
    page = context.new_page()

    def complain(message: ConsoleMessage) -> None:
        if message.type in ("error", "warning") and not any(w in message.text for w in HARMLESS):
            complaints.append(message.text)

    complaints: list[str] = []
    page.on("console", complain)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(address)
    page.complaints = complaints  # type: ignore[attr-defined]
    return page


def patch_link(context: BrowserContext, script: str) -> None:
    """Run a script on the thread that talks to the robot, before that opens a connection."""

    def patch(route: Route) -> None:
        page = route.request.frame.page
        while not page.workers:
            page.wait_for_timeout(10)
        page.workers[0].evaluate(f"() => {{ {script} }}")
        route.continue_()

    context.route("**/api/state", patch)  # what the page asks for before it connects


def drive(page: Page) -> None:
    page.get_by_role("button", name=re.compile("^(Drive|Take over)$")).click()
    yes = page.get_by_role("dialog").get_by_role("button", name="Take over")
    expect(page.locator("#driver", has_text="you drive").or_(yes)).to_be_visible()
    if yes.is_visible():
        yes.click()
    expect(page.locator("#driver")).to_have_text("you drive")


def ear(page: Page) -> Locator:
    """Whether the robot hears, in a word or two."""
    return page.locator("#ear-word")


def tap(page: Page, text: str) -> None:
    page.locator("#commands").get_by_role("button", name=text, exact=True).click()


def barriers(page: Page) -> list[object]:
    """What axe-core finds, and whether there is something to scroll sideways."""
    page.evaluate(AXE.read_text())
    found = page.evaluate("() => axe.run().then((results) => results.violations)")
    told: list[object] = [(e["id"], e["impact"], [n["target"] for n in e["nodes"]]) for e in found]
    too_wide = page.evaluate("() => document.documentElement.scrollWidth - window.innerWidth")
    return told + ([f"{too_wide} px too wide"] if too_wide > 0 else [])
