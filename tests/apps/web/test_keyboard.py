"""Everything on the operator page works by keyboard, and space stops wherever the focus is."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser_page import drive, ear, opened
from operator_page import page_robot
from playwright.sync_api import BrowserContext, ElementHandle, Page, expect
from programs import wait_until

pytestmark = pytest.mark.slow

CONTROLS = "a[href], button, input, select, summary"

MAX_TABS = 100

AT_A_WALL = "[simulator]\nstart = [2.42, 0.6, 0.0]\n"
"""A room in which the robot is 1 cm before a wall."""


def controls(page: Page) -> list[ElementHandle]:
    """All that can be used now."""
    found = page.query_selector_all(CONTROLS)
    return [one for one in found if one.is_visible() and one.is_enabled()]


def reached_by_tab(page: Page) -> int:
    """How many controls the Tab key reaches, one after the other."""
    page.evaluate("() => { document.activeElement.blur(); window.reached = new Set(); }")
    for _ in range(MAX_TABS):
        page.keyboard.press("Tab")
        page.evaluate(
            f"() => {{ const at = document.activeElement;"
            f" if (at.matches('{CONTROLS}')) window.reached.add(at); }}"
        )
    return int(page.evaluate("() => window.reached.size"))


def test_tab_reaches_every_control_enter_works_each_and_space_stops_on_each(
    no_sound_card: dict[str, str], context: BrowserContext, tmp_path: Path
) -> None:
    settings = tmp_path / "voz.toml"
    settings.write_text(AT_A_WALL)
    with page_robot(no_sound_card, "--listening", "--config", str(settings)) as robot:
        page = opened(context, robot.link)
        page.keyboard.press("Tab")  # More
        page.keyboard.press("Tab")
        expect(page.get_by_role("button", name="Drive")).to_be_enabled()
        page.get_by_role("button", name="Drive").focus()
        page.keyboard.press("Enter")
        talk = page.get_by_role("button", name="Hold to talk")
        expect(talk).to_be_enabled()
        page.locator(".tuning summary").focus()
        page.keyboard.press("Enter")
        expect(page.locator("#alarms")).to_be_visible()
        usable = controls(page)
        assert len(usable) > 20
        assert reached_by_tab(page) == len(usable)

        stops: list[str] = []
        page.on("request", lambda sent: sent.url.endswith("/api/stop") and stops.append(sent.url))
        for at, control in enumerate(usable, 1):
            control.focus()
            page.keyboard.press("Space")
            wait_until(lambda at=at: page.wait_for_timeout(1) or len(stops) == at)
        expect(page.locator("#stop")).to_have_text("stopped")
        ticks = page.locator("input[type=checkbox]")
        assert not any(tick.is_checked() for tick in ticks.all())
        assert page.locator("#alarms").is_visible()  # nothing was pressed
        assert set(robot.robot.commands()) == {"stop"}

        page.get_by_role("button", name="go forward").focus()
        page.keyboard.press("Enter")
        expect(page.locator("#motion")).to_have_text("FORWARD 0.10 m/s")
        hit = page.get_by_role("alert").filter(has_text="It hit something. Drive away from it.")
        expect(hit).to_be_visible()
        for tick in ticks.all():
            tick.focus()
            page.keyboard.press("Enter")
            expect(tick).to_be_checked()
            page.keyboard.press("Enter")
            expect(tick).not_to_be_checked()
        talk.focus()
        page.keyboard.down("Enter")
        expect(ear(page)).to_have_text("hearing you")
        page.keyboard.up("Enter")
        expect(ear(page)).to_have_text("hold to talk")
        page.get_by_role("button", name="Stop driving").focus()
        page.keyboard.press("Enter")
        expect(page.locator("#driver")).to_have_text("nobody drives")
        drive(page)
        assert page.complaints == []  # type: ignore[attr-defined]
