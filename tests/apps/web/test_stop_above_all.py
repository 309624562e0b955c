"""STOP stands above everything, on every screen, and a question of the robot is in clear sight."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from browser_page import barriers, opened, tap
from live_robot import moves, rests
from operator_page import PageRobot, own_list, page_robot
from operator_page import opened as opened_without_browser
from playwright.sync_api import BrowserContext, Page, expect

from voz.apps.web.control_api import PAGE_FILES

pytestmark = pytest.mark.slow

SCREENS = [(320, 568), (390, 844), (568, 320), (844, 390), (1280, 800)]

COMMANDS = """\
start speech
stop speech
stop
go forward
go back
self destruct
sure: yes please
no
"""

SETTINGS = """\
[commands]
"self destruct" = { drive = -0.1, confirm = "do you really mean it?" }
sure = { answer = true }
no = { answer = false }
"""

LONG = "What may be wrong here is so much that it fills a line and one more. " * 6


@pytest.fixture(scope="module")
def robot(
    no_sound_card: dict[str, str], tmp_path_factory: pytest.TempPathFactory
) -> Iterator[PageRobot]:
    given = own_list(tmp_path_factory.mktemp("robot"), COMMANDS, SETTINGS)
    with page_robot(no_sound_card, "--listening", *given) as robot:
        yield robot


def touch_stop(page: Page) -> None:
    """Touch the middle of STOP, whatever stands there."""
    box = page.locator("#stop").bounding_box()
    assert box
    page.touchscreen.tap(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)


def covered(page: Page) -> list[str]:
    """The points of STOP, in its middle and near its corners, at which something else stands."""
    return page.evaluate(
        """() => {
          const stop = document.getElementById("stop");
          const box = stop.getBoundingClientRect();
          const inner = [[.5, .5], [.1, .2], [.9, .2], [.1, .8], [.9, .8]];
          const at = ([x, y]) => [box.x + x * box.width, box.y + y * box.height];
          const found = inner.map((point) => document.elementFromPoint(...at(point)));
          return found.filter((one) => !stop.contains(one)).map((one) => one?.id ?? "nothing")
        }"""
    )


def test_stop_works_while_the_page_asks_whether_to_take_over(
    robot: PageRobot, phone: BrowserContext
) -> None:
    page = opened(phone, robot.link)
    with opened_without_browser(robot) as driver:
        driver.start_driving()
        robot.command("go forward", page=driver.welcome["secret"]).raise_for_status()
        since = robot.since
        robot.robot.wait_for(moves, since)
        page.get_by_role("button", name="Take over").tap()
        asked = page.get_by_role("dialog")
        expect(asked.get_by_role("button", name="Keep watching")).to_be_focused()
        touch_stop(page)
        expect(page.locator("#stop")).to_have_text("stopped")
        robot.robot.wait_for(rests, robot.robot.arrived.index(robot.robot.wait_for(moves, since)))
        assert robot.state["now"]["linear"] == 0
        expect(asked).to_be_visible()  # nothing else can be pressed
        assert page.locator("#log").evaluate("(log) => !!log.closest('[inert]')")
        page.keyboard.press("Escape")
        expect(asked).to_be_hidden()
        assert robot.state["now"]["driver"] == driver.welcome["page"]
    assert page.complaints == []  # type: ignore[attr-defined]


@pytest.mark.parametrize(("width", "height"), SCREENS)
def test_nothing_covers_stop_or_pushes_it_out_of_sight(
    width: int, height: int, robot: PageRobot, context: BrowserContext
) -> None:
    page = opened(context, robot.link)
    page.set_viewport_size({"width": width, "height": height})
    expect(page.locator("#driver")).to_have_text("nobody drives")
    assert covered(page) == []
    dialogs = page.locator("dialog").all()
    with opened_without_browser(robot) as driver:
        driver.start_driving()
        take_over = page.get_by_role("button", name="Take over")
        take_over.click()
        assert [dialog.is_visible() for dialog in dialogs] == [True]  # each that there is
        assert covered(page) == []
        expect(page.get_by_role("dialog").get_by_role("button").last).to_be_in_viewport(ratio=1)
        assert barriers(page) == []
        # All that may be told at once, each in many words.
        page.evaluate(
            """([long, told, hidden]) => {
              for (const id of told) document.getElementById(id).textContent = long;
              for (const id of hidden) document.getElementById(id).hidden = false;
              const answers = document.getElementById("answers");
              for (let n = 0; n < 9; n++) answers.append(document.createElement("button"));
              for (const answer of answers.children) answer.textContent = long;
            }""",
            [LONG, TOLD, ["alarm", "notice", "question"]],
        )
        assert covered(page) == []
        expect(page.locator("#stop")).to_be_in_viewport(ratio=1)
        page.evaluate("() => { document.body.dataset.stop = 'failed'; }")
        assert covered(page) == []
        expect(page.locator("#stop")).to_be_in_viewport(ratio=1)


TOLD = ["alarm", "notice-text", "question-text", "voice-note", "take-over-text"]
"""The elements in which the page says what it does not always say."""

ABOVE_ALL = re.compile(
    r"showModal|popover|requestFullscreen|showPicker|<select|\"select\"|<datalist|"
    r"\b(alert|confirm|prompt)\("
)
"""What a browser draws above everything on a page."""


def test_no_script_of_the_page_shows_what_a_browser_draws_above_everything() -> None:
    scripts = {path for path in PAGE_FILES.glob("*") if not path.stem.startswith("session")}
    assert PAGE_FILES / "take-over.js" in scripts
    found = {
        f"{path.name}: {found[0]}"
        for path in scripts
        for line in path.read_text("utf-8").splitlines()
        if (found := ABOVE_ALL.search(line.partition("//")[0])) and "this.alarm(" not in line
    }
    assert found == set()


def question(page: Page) -> list[str]:
    """What is asked, and what can be answered, all in sight."""
    shown = page.locator("#question")
    expect(shown).to_be_in_viewport(ratio=1)
    buttons = shown.get_by_role("button").all()
    for button in buttons:
        expect(button).to_be_in_viewport(ratio=1)
    return [page.locator("#question-text").inner_text(), *(b.inner_text() for b in buttons)]


def test_a_question_is_in_clear_sight_and_answered_by_a_tap(
    robot: PageRobot, phone: BrowserContext
) -> None:
    page, watcher = opened(phone, robot.link), opened(phone, robot.link)
    page.bring_to_front()
    page.get_by_role("button", name="Drive", exact=True).tap()
    expect(page.locator("#driver")).to_have_text("you drive")
    expect(page.locator("#question")).to_be_hidden()
    tap(page, "self destruct")
    assert question(page) == ["do you really mean it?", "Yes please", "No"]
    assert covered(page) == []
    assert barriers(page) == []
    expect(watcher.locator("#question").get_by_role("button", name="No")).to_be_disabled()
    late = opened(phone, robot.link)
    expect(late.locator("#question-text")).to_have_text("do you really mean it?")
    say_it = {"text": "did you say go back?", "answers": ["yes", "no"], "commands": []}
    late.evaluate(
        "(asked) => import('/page/question.js').then(({ Question }) =>"
        " new Question(() => {}).show(asked, true))",
        say_it,
    )
    assert question(late) == ["did you say go back? Say “yes” or “no”."]
    page.bring_to_front()
    for width, height in SCREENS:
        page.set_viewport_size({"width": width, "height": height})
        question(page)
        assert covered(page) == []
    page.get_by_role("button", name="No", exact=True).last.tap()
    for each in (page, watcher, late):
        expect(each.locator("#question")).to_be_hidden()
    assert robot.state["now"]["linear"] == 0

    tap(page, "self destruct")
    page.locator("#question").get_by_role("button", name="Yes please").tap()
    expect(page.locator("#motion-word")).to_have_text("BACK")
    expect(page.locator("#question")).to_be_hidden()
    assert robot.robot.commands()[-1] == "self destruct"
    tap(page, "self destruct")
    question(page)
    touch_stop(page)
    expect(page.locator("#question")).to_be_hidden()
    assert robot.state["now"]["linear"] == 0
    assert page.complaints == watcher.complaints == []  # type: ignore[attr-defined]
