"""Nothing of the operator page is cut or covered, on any screen, in any language."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import page_layout
import pytest
from browser_page import SECONDS, barriers, opened
from operator_page import page_robot
from page_layout import LISTS, SCREENS, scenes
from playwright.sync_api import Browser, Page, expect

from voz.texts import text

pytestmark = [pytest.mark.slow, pytest.mark.realtime]

SAID = {
    "motion-word": ("FORWARD", "BACK", "ROTATING", "STANDING", "REHEARSAL", "unknown"),
    "ear-word": (
        "deaf", "watching", "microphone off", "robot speaks", "asleep", "not listening",
        "listening", "hearing you", "hold to talk", "lost", "no entry", "connecting",
    ),
    "main-button": (
        "Drive", "Take over", "Allow microphone", "Allow the microphone …", "Try again",
        "Hold to talk", "Speak …", "No connection",
    ),
    "stop-word": ("stopping …", "stopped"),
}  # fmt: skip
"""What stands in places whose size is fixed."""

SAY_ALL = f"""(said) => {{
  const faults = {page_layout.FAULTS};
  document.body.dataset.stop = "stopped";
  return said.flatMap(([place, text]) => {{
    document.getElementById(place).textContent = text;
    return faults();
  }});
}}"""


@pytest.fixture(params=LISTS)
def page(
    request: pytest.FixtureRequest,
    no_sound_card: dict[str, str],
    tmp_path: Path,
    browser: Browser,
) -> Iterator[Page]:
    """The page of a robot with one of the lists, in its language."""
    expect.set_options(timeout=SECONDS)
    language = page_layout.language(request.param)
    context = browser.new_context(locale=language, permissions=["microphone"])
    context.set_default_timeout(SECONDS)
    given = page_layout.options(request.param, tmp_path)
    with page_robot(no_sound_card, "--no-sound", *given) as robot:
        yield opened(context, robot.link)
    context.close()


def on_each_screen(page: Page) -> Iterator[str]:
    """Show the page on one screen after the other."""
    for screen, (width, height) in SCREENS.items():
        page.set_viewport_size({"width": width, "height": height})
        yield screen


def in_sight(page: Page) -> None:
    """Expect the robot and a command to be in sight."""
    expect(page.locator("#room")).to_be_in_viewport(ratio=1)
    expect(page.locator("#robot .body").last).to_be_in_viewport(ratio=0.6)  # its box is turned
    expect(page.locator("#commands button").first).to_be_in_viewport(ratio=1)


def see_the_last_command_beside_the_robot(page: Page) -> None:
    """Scroll to the end of the list: the robot stays in sight."""
    page.evaluate("document.querySelector('main').scrollTop = 0")
    last = page.locator("#commands button").last
    last.scroll_into_view_if_needed()
    expect(last).to_be_in_viewport(ratio=0.95)  # it may end between two pixels
    expect(page.locator("#room")).to_be_in_viewport(ratio=1)
    page.evaluate("document.querySelector('.orders').scrollTop = 0")


def test_nothing_is_cut_or_covered_and_the_robot_and_commands_are_in_sight(page: Page) -> None:
    for scene in scenes(page):
        for screen in on_each_screen(page):
            assert (scene, screen, page_layout.faults(page)) == (scene, screen, [])
            if not scene.startswith("values"):  # which are scrolled to
                in_sight(page)
        if scene == "first":  # no button is enabled, and what scrolls can be reached by keys
            assert barriers(page) == []
    for _ in on_each_screen(page):
        see_the_last_command_beside_the_robot(page)
    language = page.locator("html").get_attribute("lang") or ""
    said = [(place, text(each, language)) for place, texts in SAID.items() for each in texts]
    for screen in on_each_screen(page):
        assert (screen, page.evaluate(SAY_ALL, said)) == (screen, [])
    assert page.complaints == []  # type: ignore[attr-defined]


def test_what_is_cut_and_what_is_covered_is_found(browser: Browser) -> None:
    page = browser.new_page()
    page.set_content(
        "<button style='width: 4em; overflow: hidden; white-space: nowrap'>far too long</button>"
        "<button style='height: 1em; padding: 0; width: 5em; display: block'>one two three</button>"
        "<button style='width: 4em; overflow-wrap: anywhere'>microphone</button>"
        "<a style='position: absolute; left: 0; top: 0'>above it</a>"
    )
    kinds = [fault.partition(":")[0] for fault in page_layout.faults(page)]
    assert kinds == ["cut at a side", "cut above or below", "broken word", "overlap"]
    page.close()
