"""Replies are heard from the page that drives, if it wants that."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from browser_page import drive, ear, opened, tap
from operator_page import PageRobot, heard, page_robot, with_noise
from operator_page import opened as opened_without_browser
from playwright.sync_api import BrowserContext, expect
from programs import wait_until
from recordings import FIXTURES

pytestmark = pytest.mark.slow

REPLY = "bep bep. I am listening you"


@pytest.fixture(scope="module")
def robot(no_sound_card: dict[str, str]) -> Iterator[PageRobot]:
    with page_robot(no_sound_card) as robot:
        yield robot


def test_only_what_the_robot_said_can_be_heard(robot: PageRobot) -> None:
    assert robot.api.get("/api/reply", params={"text": REPLY}).status_code == 404
    with opened_without_browser(robot) as page:
        robot.drives("start speech")  # answered before the pages are told of the reply
        page.wait_for(lambda record: record["type"] == "reply" and record["text"] == REPLY)
    answer = robot.api.get("/api/reply", params={"text": REPLY}).raise_for_status()
    assert answer.content[:4] == b"RIFF"
    assert len(answer.content) > 20_000
    assert robot.api.get("/api/reply", params={"text": "give me a beer"}).status_code == 404
    assert robot.api.get("/api/reply").status_code == 404
    robot.drives("stop speech")


def said_into_the_browser(event: dict[str, Any]) -> bool:
    return event["type"] == "utterance" and event["source"] == "browser"


@pytest.mark.realtime
def test_a_command_said_while_a_page_says_a_reply_is_obeyed(robot: PageRobot) -> None:
    robot.drives("start speech")
    sound = with_noise(FIXTURES / "commands" / "festival_slt__go_forward.flac", 0.3, 0.8)
    with opened_without_browser(robot) as page:
        page.start_driving()
        playing = {"page": page.welcome["secret"], "seconds": 20}
        for reply, ignored in (("never said", "robot_speaking"), (REPLY, None)):
            robot.api.post("/api/sounding", json={**playing, "reply": reply}).raise_for_status()
            since = robot.since
            with heard(robot, page) as microphone:
                microphone.begin()
                microphone.speak(sound, page)
                microphone.end()
                utterance = robot.robot.wait_for(said_into_the_browser, since).event
            assert (utterance["text"], utterance.get("ignored")) == ("go forward", ignored)
            robot.api.post("/api/sounding", json={**playing, "seconds": 0}).raise_for_status()
            wait_until(lambda: page.stay(0.1) or not robot.state["now"]["speaking"])
            page.stay(0.5)  # the room reverberates
        assert robot.robot.commands()[-1] == "go forward"
        page.send("leave")
    robot.drives("stop speech")


def test_replies_are_heard_from_the_page_if_it_wants_so_and_the_robot_knows_which(
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
    with page.expect_request("**/api/sounding") as asked:
        tap(page, "stop speech")
    assert asked.value.post_data_json["reply"] == "bep bep. I stop listening"
    page.wait_for_function("() => window.audio.ended")
    assert page.evaluate("() => window.audio.error") is None
    assert page.evaluate("() => window.asked.filter((a) => a === '/api/sounding').length") == 1
    expect(ear(page)).to_have_text("asleep")
    assert page.complaints == []  # type: ignore[attr-defined]
