"""The operator page in a real browser: what several tests do with it."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.sync_api import BrowserContext, ConsoleMessage, Locator, Page, Route, expect

AXE = Path(__file__).parent / "apps" / "web" / "node_modules" / "axe-core" / "axe.min.js"

SECONDS = 30_000
"""A busy machine may need that long, ms."""

HARMLESS = ("ERR_CONNECTION_REFUSED", "ERR_CONNECTION_RESET", "401 (Unauthorized)", "ERR_EMPTY")
"""What a browser writes of a server that is not there, or that wants a token."""


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
