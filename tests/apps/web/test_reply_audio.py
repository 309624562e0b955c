"""Replies are heard from the page that drives, if it wants that."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from browser_page import drive, ear, opened, tap
from operator_page import PageRobot, page_robot
from playwright.sync_api import BrowserContext, expect

pytestmark = pytest.mark.slow

REPLY = "bep bep. I am listening you"


@pytest.fixture(scope="module")
def robot(no_sound_card: dict[str, str]) -> Iterator[PageRobot]:
    with page_robot(no_sound_card) as robot:
        yield robot


def test_only_what_the_robot_said_can_be_heard(robot: PageRobot) -> None:
    assert robot.api.get("/api/reply", params={"text": REPLY}).status_code == 404
    robot.drives("start speech")
    answer = robot.api.get("/api/reply", params={"text": REPLY}).raise_for_status()
    assert answer.content[:4] == b"RIFF"
    assert len(answer.content) > 20_000
    assert robot.api.get("/api/reply", params={"text": "give me a beer"}).status_code == 404
    assert robot.api.get("/api/reply").status_code == 404
    robot.drives("stop speech")


def test_replies_are_heard_from_the_page_if_it_wants_so_and_only_stop_is_heard_meanwhile(
    robot: PageRobot, context: BrowserContext
) -> None:
    context.add_init_script(
        "const made = window.Audio;"
        "window.Audio = function () { return (window.audio = new made()); };"
        "window.asked = []; const fetched = window.fetch;"
        "window.fetch = (address, how) => {"
        "  window.asked.push(address); return fetched(address, how); };"
    )
    page = opened(context, robot.link)
    wanted = page.get_by_label("hear replies here")
    expect(wanted).to_be_disabled()
    drive(page)
    tap(page, "start speech")
    expect(page.locator("#log .reply").first).to_contain_text(REPLY)
    assert "/api/sounding" not in page.evaluate("() => window.asked")
    wanted.focus()
    wanted.check()
    tap(page, "stop speech")
    expect(ear(page)).to_have_text("robot speaks")
    page.wait_for_function("() => window.audio.ended")
    assert page.evaluate("() => window.audio.error") is None
    assert page.evaluate("() => window.asked.filter((a) => a === '/api/sounding').length") == 1
    expect(ear(page)).to_have_text("asleep")
    assert page.complaints == []  # type: ignore[attr-defined]
