"""A maker's list from the build to the page: every line is typed, and some are tapped."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from browser_page import tap
from calls import in_process
from operator_page import PageRobot, page_robot
from playwright.sync_api import Page, expect

pytestmark = [pytest.mark.slow, pytest.mark.realtime]

LIST = """\
wake up, robot!
sleep now
stop
go forward
go back
turn left
turn right
speed up
slow down
drive: drive {far: 0.5..2 by 0.5} metres [please]
spin: spin {angle: 45..180 by 45} degrees
lift: (lift | raise) the arm by {height: 10..30 by 10} percent
lower the arm
turn the {led} LED (on|off)
lamp (on|off)
[please] (open|close) the gripper
bring: bring [me] the {thing}
take a picture
how are you?
reset the GPIO
pump & filter off
go 2 steps
self destruct
yes
no
led = red | green
thing = blue cup | key
"""

SETTINGS = """\
lm = "lm"

[commands]
"Wake up, robot!" = { listen = true }
"sleep now" = { listen = false }
drive = { drive = 0.2, metres = "{far}" }
spin = { rotate = 0.5, degrees = "{angle}" }
lift = { publish = "{height}", topic = "arm" }
"lower the arm" = { publish = "0", topic = "arm" }
"turn the {led} LED on" = { publish = "{led} on", topic = "led" }
"turn the {led} LED off" = { publish = "{led} off", topic = "led" }
"lamp on" = { publish = true, topic = "lamp" }
"lamp off" = { publish = false, topic = "lamp" }
"open the gripper" = { publish = 1, topic = "gripper" }
"close the gripper" = { publish = 0, topic = "gripper" }
bring = { say = "here is the {thing}" }
"take a picture" = { publish = "click", topic = "camera" }
"How are you?" = { say = "fine" }
"reset the GPIO" = { publish = "reset", topic = "pins" }
"pump & filter off" = { publish = false, topic = "pump" }
"go 2 steps" = { publish = 2, topic = "steps" }
"self destruct" = { publish = true, topic = "fuse", confirm = "do you mean it?" }
"yes" = { answer = true }
"no" = { answer = false }
"""

TYPED = {
    "lift the arm by 20 percent": ("arm", "20"),
    "raise the arm by thirty percent": ("arm", "30"),
    "lower the arm": ("arm", "0"),
    "turn the green LED off": ("led", "green off"),
    "turn the red led on": ("led", "red on"),
    "lamp off": ("lamp", False),
    "please close the gripper": ("gripper", 0),
    "open the gripper": ("gripper", 1),
    "take a picture": ("camera", "click"),
    "reset the gpio": ("pins", "reset"),
    "pump and filter off": ("pump", False),
    "go two steps": ("steps", 2),
}
"""What is typed, and the topic and the value that it publishes."""


@pytest.fixture(scope="module")
def robot(
    no_sound_card: dict[str, str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[PageRobot]:
    folder = tmp_path_factory.mktemp("maker")
    (folder / "commands.txt").write_text(LIST)
    (folder / "voz.toml").write_text(SETTINGS)
    built = in_process("build-lm", "commands.txt", "--out", "lm", cwd=folder)
    assert built.code == 0, built.err
    assert 'one line makes 2 commands: "lamp on", "lamp off"' in built.out
    files = ("--lm", folder / "lm", "--config", folder / "voz.toml")
    with page_robot(no_sound_card, *map(str, files), "--no-sound") as robot:
        yield robot


def test_every_line_does_what_it_says(robot: PageRobot) -> None:
    assert "say what to do" not in robot.robot.words
    robot.drives("wake up robot")
    for text, (topic, value) in TYPED.items():
        since = robot.since
        robot.drives(text)
        sent = robot.robot.wait_for(lambda event: event["type"] == "publish", since).event
        assert (sent["topic"], sent["value"]) == (topic, value), text
    for text, reply in {"how are you": "fine", "bring me the key": "here is the key"}.items():
        since = robot.since
        robot.drives(text)
        said = robot.robot.wait_for(lambda event: event["type"] == "reply", since)
        assert said.event["text"] == reply
    for text in ("drive 0.5 metres please", "spin 45 degrees", "go back", "turn left", "stop"):
        robot.drives(text)


def test_the_page_drives_by_taps(robot: PageRobot, page: Page) -> None:
    buttons = page.locator("#commands")
    since = robot.since
    buttons.get_by_role("button", name="turn the").filter(has_text="off").click()
    values = buttons.locator(".values")
    values.get_by_role("button", name="green").click()
    expect(values.locator(".sentence")).to_have_text("turn the green led off")
    values.get_by_role("button", name="Say it").click()
    sent = robot.robot.wait_for(lambda event: event["type"] == "publish", since).event
    assert (sent["topic"], sent["value"]) == ("led", "green off")
    since = robot.since
    tap(page, "self destruct")
    expect(page.locator("#question-text")).to_have_text("do you mean it?")
    assert robot.robot.of("publish", since) == []
    page.locator("#question").get_by_role("button", name="yes").click()
    sent = robot.robot.wait_for(lambda event: event["type"] == "publish", since).event
    assert (sent["topic"], sent["value"]) == ("fuse", True)
    since = robot.since
    tap(page, "close the gripper")
    sent = robot.robot.wait_for(lambda event: event["type"] == "publish", since).event
    assert (sent["topic"], sent["value"]) == ("gripper", 0)
    assert page.complaints == []  # type: ignore[attr-defined]
