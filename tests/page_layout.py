"""The operator page on screens of every size, with lists of every kind."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from playwright.sync_api import Page, expect
from programs import wait_until

from voz.language.build import build

SCREENS = {
    "small-phone": (320, 568),
    "phone": (390, 844),
    "landscape": (844, 390),
    "laptop": (1280, 800),
}

DRIVING = """\
start speech
stop speech
stop
go forward
go back
turn left
turn right
rotate left
rotate right
speed up
slow down
"""

MORE = {
    "forty": """\
point beer
point cocacola
fold arm
open the gripper
close the gripper
raise the arm
lower the arm
pick up the screwdriver
put it down
hand it over
look at the camera
take a picture
go to the kitchen
go to the charging station
go to the living room
go to the laboratory
follow me
wait for me here
come back to the start
light on
light off
open the door
close the door
play some music
say hello
tell me the time
what is your name
count to ten
dance
""",
    "slots": """\
far: go {far: 0.5..3 by 0.5} metres
bring: bring the {thing} to {place}
thing = (red | green | yellow) cup | screwdriver | key
place = kitchen | laboratory | charging station
""",
}
"""What lists have beside these."""

TABLES = {
    "forty": """\
"open the gripper" = { publish = true, topic = "gripper" }
"close the gripper" = { publish = false, topic = "gripper" }
"go to the kitchen" = { publish = "kitchen", topic = "place" }
"go to the charging station" = { publish = "dock", topic = "place" }
"go to the living room" = { publish = "living room", topic = "place" }
"go to the laboratory" = { publish = "laboratory", topic = "place" }
"light on" = { publish = true, topic = "living_room/lamp" }
"light off" = { publish = false, topic = "living_room/lamp" }
"say hello" = { say = "hello" }
"what is your name" = { say = "my name is voz" }
""",
    "slots": """\
far = { say = "{far} it is" }
bring = { publish = "{thing} {place}", topic = "errand" }
""",
}

LANGUAGES = {"spanish": "es", "french": "fr"}
"""Lists that come with voz, the fourteen in another language."""

LISTS = ("fourteen", "forty", "slots", *LANGUAGES)

SHOWN_AFTER = 300
"""The page shows how the robot moves ten times a second, ms."""

FAULTS = Path(__file__).with_name("page_faults.js").read_text("utf-8")


def language(name: str) -> str:
    """The language of a list, and of the browser that shows it."""
    return LANGUAGES.get(name, "en")


def options(name: str, folder: Path) -> list[str]:
    """What `voz run` takes for a list, of which it writes what there is to write."""
    if name in LANGUAGES:
        return ["--language", language(name)]
    if name not in TABLES:
        return []
    (folder / "commands.txt").write_text(DRIVING + MORE[name])
    build(folder / "commands.txt", folder / "lm")
    (folder / "voz.toml").write_text(f"[commands]\n{TABLES[name]}")
    return ["--lm", str(folder / "lm"), "--config", str(folder / "voz.toml")]


def turns(page: Page) -> bool:
    """Let the robot drive and turn; whether it does: that of a page which hung is stopped."""
    for direction in ("forward", "turn-left"):
        page.locator(f".pad button[style*='{direction};']").click()
    page.wait_for_timeout(SHOWN_AFTER)
    return page.locator("#motion[data-kind=turn-left]").count() == 1


def scenes(page: Page) -> Iterator[str]:
    """Lead a page from its first screen through driving, and name each scene once it is there.

    When all are seen, nobody drives, and the robot is asleep again.
    """
    main = page.locator("#main-button")
    expect(main).to_be_enabled()
    yield "first"
    main.click()
    expect(page.locator("#main-button[data-action=talk]")).to_be_enabled()
    yield "asleep"
    wait_until(lambda: turns(page))
    yield "driving"
    page.locator("#stop").click()
    expect(page.locator("#motion")).to_have_attribute("data-kind", "standing")
    yield "stopped"
    for opener in page.locator("#commands [aria-expanded]").all():
        opener.click()
        yield f"values-{opener.inner_text().split()[0]}"
    listening = page.locator("#commands .group").first
    listening.get_by_role("button").nth(1).click()
    expect(page.locator("body")).to_have_attribute("data-asleep", "true")
    page.locator("#leave").click()
    expect(page.locator("#leave")).to_be_hidden()


def faults(page: Page) -> list[str]:
    """What is cut, and which controls overlap."""
    found: list[str] = page.evaluate(FAULTS)
    return found
