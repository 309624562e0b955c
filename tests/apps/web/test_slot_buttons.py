"""Commands with slots on the operator page, in a real browser: values are chosen by taps."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from browser_page import barriers, drive, opened, tap
from operator_page import PageRobot, own_list, page_robot
from playwright.sync_api import BrowserContext, Locator, Page, expect

pytestmark = [pytest.mark.slow, pytest.mark.realtime]

LIST = """\
wake up
stop
nothing here
go: go {far: 0.5..3 by 0.5} metres
bring: bring the {thing} to {place}
thing = (red | green) cup | key
place = kitchen | desk
"""

SETTINGS = """\
[commands]
"Wake up" = { listen = true }
go = { say = "{far} it is" }
bring = { publish = "{thing} {place}", topic = "errand" }
"""


@pytest.fixture(scope="module")
def robot(
    no_sound_card: dict[str, str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[PageRobot]:
    given = own_list(tmp_path_factory.mktemp("robot"), LIST, SETTINGS)
    with page_robot(no_sound_card, *given, "--no-sound") as robot:
        yield robot


def values(page: Page) -> Locator:
    return page.locator("#commands .values")


def open_values(page: Page, begin: str) -> Locator:
    """Tap the button of a template."""
    button = page.locator("#commands").get_by_role("button", name=re.compile(f"^{begin}"))
    button.click()
    expect(button).to_have_attribute("aria-expanded", "true")
    return button


def test_words_are_chosen_by_chips_and_the_sentence_is_shown_before_it_is_given(
    robot: PageRobot, page: Page
) -> None:
    since = robot.since
    button = open_values(page, "bring the")
    expect(values(page).locator(".sentence")).to_have_text("bring the key to kitchen")
    things = values(page).get_by_role("group", name="thing")
    assert things.get_by_role("button").all_inner_texts() == ["key", "red cup", "green cup"]
    things.get_by_role("button", name="green cup").click()
    values(page).get_by_role("button", name="desk").click()
    expect(values(page).locator(".sentence")).to_have_text("bring the green cup to desk")
    pressed = values(page).locator("[aria-pressed=true]")
    assert pressed.all_inner_texts() == ["green cup", "desk"]
    assert robot.robot.of("utterance", since) == []
    values(page).get_by_role("button", name="Say it").click()
    sent = robot.robot.wait_for(lambda event: event["type"] == "publish", since)
    assert sent.event["value"] == "green cup desk"
    said = [event["text"] for event in robot.robot.of("utterance", since)]
    assert said == ["wake up", "bring the green cup to desk"]  # asleep, it is woken first
    button.click()
    expect(values(page)).to_have_count(0)
    expect(button).to_have_attribute("aria-expanded", "false")
    assert page.complaints == []  # type: ignore[attr-defined]


def test_a_number_is_chosen_by_a_slider_also_by_keys(robot: PageRobot, page: Page) -> None:
    since = robot.since
    open_values(page, "bring the")
    open_values(page, "go ")
    expect(values(page)).to_have_count(1)  # those of the other are closed
    slider = values(page).get_by_role("slider", name="far")
    expect(slider).to_have_attribute("aria-valuetext", "0.5")
    slider.press("End")
    slider.press("ArrowLeft")
    expect(slider).to_have_attribute("aria-valuetext", "2.5")
    expect(values(page).locator(".sentence")).to_have_text("go 2.5 metres")
    values(page).get_by_role("button", name="Say it").click()
    reply = robot.robot.wait_for(lambda event: event["type"] == "reply", since)
    assert reply.event["text"] == "2.5 it is"


def test_what_does_nothing_comes_last(robot: PageRobot, context: BrowserContext) -> None:
    page = opened(context, robot.link)
    groups = page.locator("#commands .group h3")
    expect(groups.last).to_have_text("Others")
    assert groups.all_inner_texts() == ["Listening", "Replies", "Errand", "Others"]
    drive(page)
    tap(page, "nothing here")


@pytest.mark.parametrize(("width", "height"), [(320, 640), (390, 844), (1280, 800)])
def test_values_have_no_barriers(
    robot: PageRobot, context: BrowserContext, width: int, height: int
) -> None:
    page = opened(context, robot.link)
    page.set_viewport_size({"width": width, "height": height})
    drive(page)
    for begin in ("bring the", "go "):
        open_values(page, begin)
        assert barriers(page) == []
