"""A session that was kept is shown at any time of it."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from browser_page import barriers, opened
from calls import VOZ, in_process
from live_robot import signals_as_a_terminal_has_them
from playwright.sync_api import BrowserContext, Page, expect

from voz.apps.web.session_page import session_record
from voz.events import Event, Notice, SelectedObject, Twist, Utterance

LINES = ["start speech", "go forward", *"-----", "make coffee", "point beer", *"-----", "stop", "-"]


def test_there_is_a_state_wherever_something_changed_and_none_elsewhere() -> None:
    events: list[Event] = [
        Twist(0.0, 0.0, 0.0),
        Twist(0.1, 0.0, 0.0),
        Utterance(0.15, "go forward", 0.9, True, 0.0, 0.1, "microphone", obeyed=True),
        Twist(0.2, 0.1, 0.0),
        Twist(0.3, 0.1, 0.0),
        SelectedObject(0.35, 1),
        Twist(0.4, 0.0, 0.0),
        Twist(0.5, 0.0, 0.0),
        Notice(0.6, "the robot stops"),
    ]
    session = session_record("drive.jsonl", events)
    assert session["states"] == [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, None],
        [0.2, 0.0, 0.0, 0.0, 0.1, 0.0, None],
        [0.3, 0.01, 0.0, 0.0, 0.1, 0.0, None],
        [0.4, 0.02, 0.0, 0.0, 0.0, 0.0, 1],
    ]
    assert [event["type"] for event in session["events"]] == ["utterance", "warning"]
    assert (session["begin"], session["end"]) == (0.0, 0.6)


@pytest.fixture(params=["drive.jsonl", "drive.mcap"])
def link(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """A session of some seconds, shown by `voz view`."""
    path = tmp_path / request.param
    kept = ("--events", path) if path.suffix == ".jsonl" else ("--bag", path)
    text = tmp_path / "lines.txt"
    text.write_text("\n".join(LINES) + "\n")
    assert in_process("run", "--no-sound", "--text", text, *kept).code == 0
    process = subprocess.Popen(
        [*VOZ, "view", str(path), "--web-port", "0"],
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=signals_as_a_terminal_has_them,
    )
    assert process.stderr
    found = re.search(r"the session is at (\S+)", process.stderr.readline())
    assert found
    yield found[1]
    process.terminate()
    assert process.wait(20) == 143
    assert process.stderr.read() == ""
    process.stderr.close()


def move(page: Page, seconds: float) -> None:
    page.locator("#time").evaluate(
        "(slider, at) => { slider.value = at; slider.dispatchEvent(new Event('input')); }", seconds
    )


@pytest.mark.slow
def test_a_slider_moves_through_it_and_it_plays(link: str, context: BrowserContext) -> None:
    page = opened(context, link)
    slider, log = page.get_by_label("time", exact=True), page.locator("#log .entry .what")
    expect(page.locator("#clock")).to_contain_text("0.0 s of 1.")
    bag = "mcap" in page.locator("#name").inner_text()
    slider.focus()
    page.keyboard.press("End")
    expect(log.first).to_have_text("stop")
    expect(page.locator("#arm")).to_have_text("points at the beer")
    end = page.locator("#place").inner_text()
    said = ["stop", "point beer", "go forward", "start speech"]
    shown = [text for text in log.all_inner_texts() if text in said]
    assert shown == said
    refused = page.locator("#log .refused", has_text="make coffee")
    expect(refused).to_have_count(0 if bag else 1)
    move(page, 0.5)
    expect(page.locator("#linear")).to_have_text("0.10")
    expect(page.locator("#arm")).not_to_have_text("points at the beer")
    expect(page.locator("#log .entry", has_text="point beer")).to_have_count(0)
    page.get_by_role("button", name="Play").focus()
    page.keyboard.press("Space")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    expect(page.get_by_role("button", name="Play")).to_be_visible()  # it is over
    expect(page.locator("#place")).to_have_text(end)
    expect(log.first).to_have_text("stop")
    slider.focus()
    page.keyboard.press("Home")
    expect(page.locator("#log .entry", has_text="go forward")).to_have_count(0)
    expect(page.locator("#linear")).to_have_text("0.00")
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        for width, height in ((1366, 768), (390, 844)):
            page.set_viewport_size({"width": width, "height": height})
            assert barriers(page) == []
    assert page.complaints == []  # type: ignore[attr-defined]
    assert httpx.get(f"{link}api/session", headers={"Host": "robot.example"}).status_code == 403
    assert httpx.post(f"{link}api/command", json={"text": "go forward"}).status_code in (404, 405)
