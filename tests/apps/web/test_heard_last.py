"""A new user drives in two touches, and what the robot was not sure of is done by a tap."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import soundfile
from browser_page import opened, tap
from live_robot import moves
from operator_page import PageRobot, heard, page_robot, with_noise
from operator_page import opened as opened_without_browser
from playwright.sync_api import BrowserContext, Page, expect
from synthesis import phrase

from voz.audio import SAMPLE_RATE

pytestmark = pytest.mark.slow


@pytest.fixture
def unsure(tmp_path: Path) -> Path:
    """It sounds like "turn left", and is not sure enough."""
    soundfile.write(tmp_path / "said.wav", phrase("flite_rms", "turn left a little"), SAMPLE_RATE)
    return tmp_path / "said.wav"


@pytest.fixture(scope="module")
def robot(no_sound_card: dict[str, str]) -> Iterator[PageRobot]:
    with page_robot(no_sound_card) as robot:
        yield robot


def in_words(page: Page, event: dict[str, object]) -> list[str]:
    """What the page says of an utterance: its kind, what, and why."""
    script = "(event) => import('/page/words.js').then((words) => words.utterance(event))"
    said: list[str] = page.evaluate(script, {"source": "browser", **event})
    return said


def test_a_new_user_drives_by_two_touches_and_does_by_a_tap_what_was_not_sure(
    robot: PageRobot, phone: BrowserContext, unsure: Path
) -> None:
    page = opened(phone, robot.link)
    expect(page.locator("#heard")).to_have_text("Touch Drive to begin.")
    expect(page.locator("#stop-note .keys")).to_be_hidden()
    page.get_by_role("button", name="Drive", exact=True).tap()
    expect(page.locator("#driver")).to_have_text("you drive")
    first = "Say “start speech” first, or tap a command."
    expect(page.locator("#heard")).to_have_text(first)
    page.get_by_role("button", name="go forward").tap()
    robot.robot.wait_for(moves)
    assert robot.robot.commands() == ["start speech", "go forward"]
    expect(page.locator("#motion")).to_have_text("FORWARD 0.10 m/s")

    with opened_without_browser(robot) as other:
        other.drive(over=True)
        name = r"since \d\d:\d\d"
        banner = re.compile(f"program, {name}, took over. The robot was stopped.")
        expect(page.locator("#notice-text")).to_have_text(banner)
        warned = re.compile(
            f"program, {name}, drives now, no longer iPhone, {name}: the robot stops"
        )
        assert any(warned.match(event.get("text", "")) for event in robot.state["events"])
        with heard(robot, other) as microphone:
            microphone.begin()
            microphone.speak(with_noise(unsure, 0.5, 0.5), other)
            microphone.end()
            robot.robot.wait_for(lambda event: event.get("source") == "browser")
        expect(page.locator("#heard")).to_have_text("turn left?not sure enough")
        assert page.get_by_role("button", name="turn left?").count() == 0  # it only watches
        page.get_by_role("button", name="Take over").tap()
        page.get_by_role("dialog").get_by_role("button", name="Take over").tap()
    offer = page.get_by_role("button", name="turn left?")
    expect(page.locator("#heard")).to_contain_text("not sure enough: tap to do it")
    offer.tap()
    expect(page.locator("#motion")).to_have_text("ROTATING left, 0.10 rad/s")
    expect(page.locator("#heard .what")).to_have_text("turn left")
    page.locator("#stop").tap()
    expect(page.locator("#motion")).to_have_text("STANDING ")
    assert page.complaints == []  # type: ignore[attr-defined]


def test_a_tap_that_wakes_the_robot_moves_nothing_if_a_stop_came_meanwhile(
    robot: PageRobot, phone: BrowserContext
) -> None:
    robot.api.post("/api/stop").raise_for_status()
    robot.drives("stop speech")
    page = opened(phone, robot.link)
    page.get_by_role("button", name="Drive", exact=True).tap()
    expect(page.locator("#ear-word")).to_have_text("asleep")
    since = robot.since
    page.evaluate(
        "() => { const sent = window.fetch; window.fetch = async (address, how) => {"
        "  const answer = await sent(address, how);"
        "  if (how?.body?.includes('start speech')) {"
        "    document.getElementById('stop').dispatchEvent("
        "      new PointerEvent('pointerdown', { isPrimary: true })); }"
        "  return answer; }; }"
    )
    tap(page, "go forward")
    expect(page.locator("#stop")).to_have_text("stopped")
    expect(page.locator("#ear-word")).to_have_text("hold to talk")
    assert robot.since
    assert not any(moves(arrived.event) for arrived in robot.robot.arrived[since:])


def test_talk_is_no_offer(robot: PageRobot, phone: BrowserContext) -> None:
    page = opened(phone, robot.link)
    refused = {"accepted": False, "obeyed": False, "reason": "not_a_command"}
    talk = {"text": "turn right", "confidence": 0.01, **refused}
    assert in_words(page, talk) == ["nothing", "no command", "somebody spoke"]
    doubt = {"text": "turn right", "confidence": 0.4, **refused}
    assert in_words(page, doubt) == ["unsure", "turn right", "not sure enough"]
    between = {**doubt, "reason": "unsure_between", "between": ["turn left", "turn right"]}
    assert in_words(page, between) == ["unsure", "turn left or turn right", "not sure which"]
    asleep = {"text": "stop", "accepted": True, "obeyed": False, "ignored": "not_listening"}
    assert in_words(page, asleep) == ["asleep", "stop", "it is asleep"]
