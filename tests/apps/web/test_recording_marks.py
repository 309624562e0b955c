"""What was heard is played and marked on the page, and the test set has it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import httpx
import numpy as np
import pytest
from browser_page import barriers, drive, ear, opened
from calls import in_process
from live_robot import moves, rests
from operator_page import Page, PageRobot, heard, page_robot
from operator_page import opened as opened_without_browser
from playwright.sync_api import BrowserContext, expect
from programs import wait_until

from voz.apps.recordings.manifest import MANIFEST_NAME, read_manifest

pytestmark = [pytest.mark.slow, pytest.mark.realtime]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("mine")


@pytest.fixture(scope="module")
def robot(no_sound_card: dict[str, str], folder: Path) -> Iterator[PageRobot]:
    with page_robot(no_sound_card, "--listening", "--record", str(folder)) as robot:
        yield robot


def last(folder: Path) -> tuple[str, str]:
    """What the manifest says of the newest recording."""
    clip = read_manifest(folder / MANIFEST_NAME)[-1]
    return clip.kind, clip.text


def say(robot: PageRobot, page: Page, sound: np.ndarray) -> str:
    """Speak as the page that drives; gives the recording."""
    before = len(robot.state["recordings"])
    with heard(robot, page) as microphone:
        microphone.begin()
        microphone.speak(sound, page)
        microphone.end()
        wait_until(lambda: page.stay(0.1) or len(robot.state["recordings"]) > before)
    return str(robot.state["recordings"][-1]["file"])


@pytest.fixture(scope="module")
def recording(robot: PageRobot, forward: np.ndarray) -> str:
    with opened_without_browser(robot) as page:
        page.start_driving()
        return say(robot, page, forward)


def mark(robot: PageRobot, page: Page, **more: object) -> httpx.Response:
    return robot.api.post("/api/mark", json={"page": page.welcome["secret"], **more})


def test_what_was_heard_is_played_and_marked_on_the_page(
    robot: PageRobot, folder: Path, context: BrowserContext
) -> None:
    context.add_init_script(
        "const made = window.Audio; window.Audio = function () {"
        "  window.played = []; const audio = (window.audio = new made());"
        "  audio.addEventListener('playing', () => window.played.push("
        "    document.getElementById('ear-word').textContent));"
        "  return audio; };"
    )
    page = opened(context, robot.link)
    expect(page.locator("#recording")).to_contain_text(f"recorded in {folder}")
    drive(page)
    since = robot.since
    page.get_by_label("hands-free").check()
    robot.robot.wait_for(moves, since)
    page.keyboard.press("Space")
    expect(page.locator("#stop")).to_have_text("stopped")
    entry = page.locator("#log .entry", has_text="sure").first
    tools = entry.locator("details.marking")
    expect(tools.locator("summary")).to_be_visible()  # once it is recorded
    tools.locator("summary").focus()
    page.keyboard.press("Enter")  # the space bar stops the robot
    tools.get_by_role("button", name="Right", exact=True).focus()
    page.keyboard.press("Enter")
    expect(tools.locator("summary")).to_have_text("marked: right")
    assert last(folder) == ("command", "go forward")
    choice = tools.get_by_role("group", name="what was said")
    first = choice.get_by_role("button").first.text_content()
    assert first != "start speech"  # which has the first button
    expect(entry).to_contain_text(f"might also have been “{first}”")
    choice.get_by_role("button", name="go back").click()
    expect(tools.locator("summary")).to_have_text("marked: “go back” was said")
    assert last(folder) == ("command", "go back")
    tools.get_by_role("button", name="No command").click()
    expect(tools.locator("summary")).to_have_text("marked: no command")
    assert last(folder) == ("near-miss", "")
    tools.get_by_role("button", name="Play").click()
    page.wait_for_function("() => window.audio.ended")
    assert page.evaluate("() => window.audio.error") is None
    assert page.evaluate("() => window.played.length") == 1
    expect(ear(page)).to_have_text("robot speaks")
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        page.set_viewport_size({"width": 390, "height": 844})
        assert barriers(page) == []
    watcher = opened(context, robot.link)
    shown = watcher.locator("#log details.marking").first
    expect(shown.locator("summary")).to_have_text("marked: no command")
    shown.locator("summary").click()
    expect(shown.get_by_role("button", name="Right", exact=True)).to_be_disabled()
    assert page.complaints == watcher.complaints == []  # type: ignore[attr-defined]
    scores = in_process("eval", folder / MANIFEST_NAME, "--jobs", "1")
    assert scores.code == 0
    assert "near-misses" in scores.out


def test_only_the_page_that_drives_may_mark_and_play(
    robot: PageRobot, folder: Path, forward: np.ndarray
) -> None:
    with opened_without_browser(robot) as page, opened_without_browser(robot) as watcher:
        page.start_driving()
        file = say(robot, page, forward)
        marks = {"file": file, "said": "go back"}
        assert mark(robot, watcher, **marks).status_code == 409
        sounds = {"page": watcher.welcome["secret"], "seconds": 1}
        assert robot.api.post("/api/sounding", json=sounds).status_code == 409
        assert last(folder) == ("command", "go forward")
        assert mark(robot, page, **marks).status_code == 200
        told = watcher.wait_for(lambda record: record.get("said") is not None)
        assert (told["file"], told["said"]) == (file, "go back")
        assert last(folder) == ("command", "go back")


@pytest.mark.parametrize(
    ("more", "status", "error"),
    [
        ({"said": "make coffee"}, 400, '"make coffee" is no command: choose one of the list'),
        ({}, 400, "send JSON with page, file and said"),
        ({"file": "../manifest.tsv", "said": None}, 503, "not there any more"),
        ({"file": "x.flac", "said": "go back"}, 503, "not there any more"),
    ],
)
def test_a_mark_that_cannot_be_is_one_line(
    more: dict[str, object],
    status: int,
    error: str,
    robot: PageRobot,
    folder: Path,
    recording: str,
) -> None:
    with opened_without_browser(robot) as page:
        page.start_driving()
        before = (folder / MANIFEST_NAME).read_text()
        answer = mark(robot, page, **{"file": recording, **more})
        assert answer.status_code == status
        assert error in answer.json()["error"]
        assert (folder / MANIFEST_NAME).read_text() == before


def test_a_recording_is_served_to_those_who_may_come_in_and_kept_by_nobody(
    robot: PageRobot, folder: Path, recording: str
) -> None:
    answer = robot.api.get(f"/api/recordings/{recording}").raise_for_status()
    assert answer.content == (folder / recording).read_bytes()
    assert answer.headers["content-type"] == "audio/flac"
    assert answer.headers["cache-control"] == "no-store"
    for other in ("x.flac", "manifest.tsv", "..%2Fmanifest.tsv", "%00"):
        assert robot.api.get(f"/api/recordings/{other}").status_code == 404
    (folder / recording).unlink()
    assert "not there" in robot.api.get(f"/api/recordings/{recording}").json()["error"]


def test_what_a_page_plays_drives_nothing(robot: PageRobot, forward: np.ndarray) -> None:
    with opened_without_browser(robot) as page:
        page.start_driving()
        secret = page.welcome["secret"]
        sounds = {"page": secret, "seconds": 30}
        robot.api.post("/api/sounding", json=sounds).raise_for_status()
        robot.api.post("/api/stop").raise_for_status()
        since = robot.since
        say(robot, page, forward)
        (utterance,) = robot.robot.of("utterance", since)
        assert (utterance["text"], utterance["ignored"]) == ("go forward", "robot_speaking")
        assert all(rests(event) for event in robot.robot.of("cmd_vel", since))
        robot.api.post("/api/sounding", json={**sounds, "seconds": 0}).raise_for_status()
        wait_until(lambda: not robot.state["now"]["speaking"])


def test_without_a_folder_the_page_says_how_to_get_one(
    no_sound_card: dict[str, str], context: BrowserContext
) -> None:
    with page_robot(no_sound_card, "--listening") as robot:
        page = opened(context, robot.link)
        expect(page.locator("#recording")).to_contain_text("voz run --web --record DIR")
        assert robot.state["recordings"] == []
