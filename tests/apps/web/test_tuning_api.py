"""What the driving page may set, and play, while the robot is driven."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from operator import itemgetter
from pathlib import Path

import httpx
import numpy as np
import pytest
from browser_page import barriers, drive, opened
from hypothesis import given
from hypothesis import strategies as st
from live_robot import warns
from msgspec.structs import replace
from operator_page import Page, PageRobot, heard, page_robot, with_noise
from operator_page import opened as opened_without_browser
from playwright.sync_api import BrowserContext, expect
from programs import wait_until
from recordings import FIXTURES

from voz.api.recognizer import Recognizer
from voz.apps.web.tuning_api import FalseAlarmSetting
from voz.audio import SAMPLE_RATE
from voz.errors import ConfigError
from voz.language.language_files import LanguageFiles
from voz.recognition.confidence import Models, load_models, save_models
from voz.recognition.engine import confidence_model
from voz.recognition.thresholds import thresholds_of
from voz.settings import Recognition

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def robot(no_sound_card: dict[str, str]) -> Iterator[PageRobot]:
    with page_robot(no_sound_card, "--listening", "--false-alarms-per-hour", "0.3") as robot:
        yield robot


@pytest.fixture(scope="module")
def unsure(recognizer: Recognizer) -> tuple[str, np.ndarray]:
    """A near-miss that is accepted at 5 false alarms in an hour and not at 0.3, and its text."""
    some, few = (
        thresholds_of(confidence_model(recognizer), Recognition(false_alarms_per_hour=alarms)).usual
        for alarms in (5, 0.3)
    )

    found = []
    for path in sorted((FIXTURES / "near_misses").glob("*.flac")):
        sound = with_noise(path, 0.0, 1.5)
        for one in recognizer.decode(sound, SAMPLE_RATE):
            if one.text not in Recognition().never_missed:
                off = abs(one.confidence - (some + few) / 2)
                found.append((off, one.text, sound))
    _, text, sound = min(found, key=itemgetter(0))
    return text, sound


def turn(robot: PageRobot, page: Page, alarms: object) -> httpx.Response:
    body = {"page": page.welcome["secret"], "alarms": alarms}
    return robot.api.post("/api/alarms", json=body)


def say(robot: PageRobot, page: Page, sound: np.ndarray) -> dict[str, object]:
    """Speak as the page that drives; gives what was heard."""
    since = robot.since
    with heard(robot, page) as microphone:
        microphone.begin()
        microphone.speak(sound, page)
        microphone.end()
        wait_until(lambda: page.stay(0.1) or robot.robot.of("utterance", since))
    return robot.robot.of("utterance", since)[0]


def test_it_changes_what_is_accepted_at_once_and_all_are_told(
    robot: PageRobot, unsure: tuple[str, np.ndarray]
) -> None:
    text, sound = unsure
    with opened_without_browser(robot) as page:
        page.start_driving()
        refused = say(robot, page, sound)
        since = robot.since
        assert turn(robot, page, 5).json() == {"alarms": 5}
        page.wait_for(lambda record: record["type"] == "state" and record["alarms"] == 5)
        robot.robot.wait_for(warns("false_alarms_per_hour is 5 from now on, for this run"), since)
        accepted = say(robot, page, sound)
        assert turn(robot, page, 0.1).status_code == 200
        again = say(robot, page, sound)
    assert [u["text"] for u in (refused, accepted, again)] == [text] * 3
    assert [u["accepted"] for u in (refused, accepted, again)] == [False, True, False]
    *_, shown = [e for e in robot.state["events"] if e.get("text") == text]
    assert shown["needed"] > 0.9


def test_what_cannot_be_is_one_line_and_changes_nothing(robot: PageRobot) -> None:
    with opened_without_browser(robot) as page, opened_without_browser(robot) as watcher:
        page.start_driving()
        before = robot.state["now"]["alarms"]
        assert turn(robot, watcher, 1).status_code == 409
        assert turn(robot, page, 50).json()["error"] == (
            "choose false alarms per hour from 0.1 to 5"
        )
        for strange in (0, -1, "many", None, 1e9):
            assert turn(robot, page, strange).status_code == 400
        assert robot.state["now"]["alarms"] == before


def test_the_slider_shows_what_it_costs_and_is_moved_by_keys(
    robot: PageRobot, context: BrowserContext
) -> None:
    stops = dict(robot.state["tuning"]["stops"])
    assert list(stops) == [0.1, 0.25, 0.3, 0.5, 1, 2, 5]  # and what it began with
    page, watcher = opened(context, robot.link), opened(context, robot.link)
    page.bring_to_front()
    drive(page)
    for one in (page, watcher):
        one.get_by_text("How sure it must be").click()
    slider = page.get_by_label("false alarms against commands that are missed")
    expect(slider).to_be_enabled()
    slider.focus()
    page.keyboard.press("Home")
    page.keyboard.press("ArrowRight")
    wait_until(lambda: robot.state["now"]["alarms"] == 0.25)
    words = f"0.25 false alarms in an hour of talk, {stops[0.25]:.1%} of commands missed"
    for one in (page, watcher):
        expect(one.locator("#alarms-words")).to_have_text(words.replace("%", " %"))
    expect(slider).to_have_attribute("aria-valuetext", words.replace("%", " %"))
    expect(page.locator("#alarms-line")).to_have_text(
        "[recognition]\nfalse_alarms_per_hour = 0.25", use_inner_text=True
    )
    expect(watcher.locator("#alarms")).to_be_disabled()
    for scheme in ("light", "dark"):
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        page.set_viewport_size({"width": 390, "height": 844})
        assert barriers(page) == []
    assert page.complaints == watcher.complaints == []  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ("threshold = 0.5", "a threshold is set in its place"),
        (
            'confidence = "mine.json"',
            "mine.json does not say how many commands are missed",
        ),
    ],
)
def test_where_it_is_not_known_what_it_costs_the_slider_says_why(
    settings: str,
    why: str,
    no_sound_card: dict[str, str],
    context: BrowserContext,
    tmp_path: Path,
) -> None:
    models = load_models()
    older = Models(
        replace(models.with_network, costs=()), replace(models.without_network, costs=())
    )
    save_models(older, tmp_path / "mine.json")
    config = tmp_path / "voz.toml"
    settings = settings.replace("mine.json", str(tmp_path / "mine.json"))
    config.write_text(f"[recognition]\n{settings}\n")
    with page_robot(no_sound_card, "--config", str(config)) as robot:
        page = opened(context, robot.link)
        drive(page)
        page.get_by_text("How sure it must be").click()
        expect(page.locator("#alarms-note")).to_contain_text(why)
        expect(page.locator("#alarms")).to_be_disabled()
        expect(page.locator("#alarms-words")).to_be_hidden()
        with opened_without_browser(robot) as other:
            other.drive(over=True)
            assert why in turn(robot, other, 1).json()["error"]


@pytest.fixture(scope="module")
def turned(language: LanguageFiles) -> Recognizer:
    return Recognizer(language, Recognition())


@given(alarms=st.floats() | st.integers())
def test_no_number_beyond_what_is_known_is_set(turned: Recognizer, alarms: float) -> None:
    setting = FalseAlarmSetting(turned, Recognition(), lambda _: None)
    with suppress(ConfigError):
        setting.set(alarms)
    known = [cost.alarms for cost in confidence_model(turned).costs]
    assert min(known) <= setting.alarms <= max(known)
    needed = turned.threshold_of("go forward")
    assert needed is not None
    assert 0 < needed < 1


@pytest.mark.parametrize("alarms", [math.nan, math.inf, 0, -1])
def test_a_recognizer_takes_no_such_number_from_a_program_either(
    turned: Recognizer, alarms: float
) -> None:
    before = turned.threshold_of("go forward")
    with pytest.raises(ConfigError, match=r"at `Recognition\.false_alarms_per_hour`"):
        turned.set_false_alarm_rate(alarms)
    assert turned.threshold_of("go forward") == before
