"""The operator page in a real browser, whose microphone hears a recording."""

from __future__ import annotations

import re
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import pytest
from browser_page import barriers, drive, ear, opened, patch_link, tap
from live_robot import moves, rests, warns
from operator_page import PageRobot, page_robot
from playwright.sync_api import Browser, BrowserContext, Page, Route, expect
from programs import wait_until
from recordings import ROOT

from voz.language.build import build

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def own_list(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The list that comes with voz but for its last command, where more can be added."""
    folder = tmp_path_factory.mktemp("robot")
    listed = (ROOT / "lm" / "comandos_voz.txt").read_text()
    (folder / "commands.txt").write_text(listed.removesuffix("fold arm\n"))
    build(folder / "commands.txt", folder / "lm")
    return folder / "commands.txt"


@pytest.fixture(scope="module")
def one_run(no_sound_card: dict[str, str], own_list: Path) -> Iterator[PageRobot]:
    lm = str(own_list.parent / "lm")
    with page_robot(no_sound_card, "--listening", "--lm", lm) as robot:
        yield robot


def shown_at(page: Page) -> float:
    """Where the picture shows the robot, along x, m."""
    transform = page.locator("#robot").evaluate("robot => robot.style.transform")
    return float(transform.split("(")[1].split("px")[0])


def hold_to_talk(page: Page) -> None:
    """Hold the button, until the mouse is up."""
    talk = page.get_by_role("button", name="Hold to talk")
    expect(talk).to_be_enabled()
    box = talk.bounding_box()
    assert box
    page.mouse.move(box["x"] + 20, box["y"] + 20)
    page.mouse.down()
    expect(ear(page)).to_have_text("hearing you")


def go_hands_free(page: Page) -> None:
    page.get_by_label("hands-free").check()
    expect(ear(page)).to_have_text("hearing you")


@pytest.mark.realtime
def test_what_is_said_while_the_button_is_held_drives_and_the_picture_shows_it(
    robot: PageRobot, page: Page
) -> None:
    since = robot.since
    before = shown_at(page)
    hold_to_talk(page)
    robot.robot.wait_for(moves, since)
    page.mouse.up()
    assert robot.robot.commands()[-1] == "go forward"
    assert robot.robot.of("utterance")[-1]["source"] == "browser"
    expect(page.locator("#log .entry").first).to_contain_text("go forward")
    expect(page.locator("#heard .what")).to_have_text("go forward")
    expect(page.locator("#heard svg")).to_be_visible()  # the tick
    details = page.locator("#log .entry").first.locator("details")
    expect(details.first).to_contain_text("% sure. A command needs")
    wait_until(lambda: shown_at(page) > before + 0.1)
    expect(page.locator("#motion")).to_have_text("FORWARD 0.10 m/s")
    expect(ear(page)).to_have_text("hold to talk")
    assert page.complaints == []  # type: ignore[attr-defined]


@pytest.mark.realtime
def test_hands_free_hears_until_it_is_switched_off_and_a_stop_switches_it_off(
    robot: PageRobot, page: Page
) -> None:
    since = robot.since
    free = page.get_by_label("hands-free")
    free.check()
    expect(ear(page)).to_have_text("hearing you")
    robot.robot.wait_for(moves, since)
    assert robot.robot.commands()[-1] == "go forward"
    expect(ear(page)).to_have_text("hearing you")
    page.keyboard.press("Space")
    expect(page.locator("#stop")).to_have_text("stopped")
    expect(free).not_to_be_checked()
    expect(ear(page)).to_have_text("hold to talk")
    free.check()
    expect(ear(page)).to_have_text("hearing you")
    free.uncheck()
    expect(ear(page)).to_have_text("hold to talk")
    assert page.complaints == []  # type: ignore[attr-defined]


@pytest.mark.realtime
def test_a_name_is_needed_hands_free_but_not_while_the_button_is_held(
    no_sound_card: dict[str, str], context: BrowserContext
) -> None:
    with page_robot(no_sound_card, "--listening", "--name", "hey computer") as robot:
        page = opened(context, robot.link)
        drive(page)
        since = robot.since
        page.get_by_label("hands-free").check()
        expect(ear(page)).to_have_text("asleep")
        robot.robot.wait_for(lambda e: e.get("ignored") == "asleep", since)
        page.get_by_label("hands-free").uncheck()
        assert robot.robot.commands() == []
        hold_to_talk(page)
        robot.robot.wait_for(moves, since)
        page.mouse.up()
        assert robot.robot.commands() == ["go forward"]
        assert robot.robot.of("utterance")[-1]["named"]


@pytest.mark.realtime
def test_s5_a_microphone_that_goes_silent_while_it_is_hands_free_stops_the_robot(
    robot: PageRobot, context: BrowserContext
) -> None:
    context.add_init_script(
        "const made = window.AudioContext; window.AudioContext = function (how) {"
        "  return (window.context = new made(how)); };"
    )
    page = opened(context, robot.link)
    drive(page)
    go_hands_free(page)
    since = robot.since
    tap(page, "go back")
    robot.robot.wait_for(moves, since)
    page.evaluate("() => window.context.suspend()")
    robot.robot.wait_for(warns("no sound comes from the microphone: the robot stops"), since)
    expect(ear(page)).to_have_text("deaf")


@pytest.mark.realtime
def test_after_a_page_that_was_hands_free_the_next_one_is_not_deaf(
    robot: PageRobot, page: Page, context: BrowserContext
) -> None:
    go_hands_free(page)
    page.close()
    wait_until(lambda: robot.state["now"]["deaf"])  # sound was to come, and does not
    page = opened(context, robot.link)
    expect(page.locator("#driver")).to_have_text("nobody drives")
    expect(ear(page)).to_have_text("microphone off")
    drive(page)
    expect(ear(page)).to_have_text("hold to talk")
    assert page.complaints == []  # type: ignore[attr-defined]


def test_nobody_can_speak_before_the_sound_connection_is_open(
    robot: PageRobot, context: BrowserContext
) -> None:
    patch_link(
        context,
        "const messages = Object.getOwnPropertyDescriptor(WebSocket.prototype, 'onmessage');"
        "const slow = (told) => (message) => setTimeout(() => told(message), 500);"
        "Object.defineProperty(WebSocket.prototype, 'onmessage', { set(told) {"
        "  messages.set.call(this, this.url.endsWith('audio') ? slow(told) : told); } });",
    )
    page = opened(context, robot.link)
    drive(page)
    expect(page.get_by_role("button", name="Hold to talk")).to_be_disabled()
    page.get_by_label("hands-free").check()  # once it is enabled


SOUNDS = (
    "const open = self.WebSocket; self.sounds = [];"
    "self.WebSocket = class extends open { constructor(address) {"
    "  super(address); if (address.endsWith('audio')) self.sounds.push(this); } };"
)
"""Keeps the connections for the sound."""


def test_a_broken_sound_connection_stops_the_robot_and_is_opened_again(
    robot: PageRobot, context: BrowserContext
) -> None:
    patch_link(context, SOUNDS)
    page = opened(context, robot.link)
    drive(page)
    free = page.get_by_label("hands-free")
    free.check()
    expect(ear(page)).to_have_text("hearing you")
    since = robot.since
    page.workers[0].evaluate("() => self.sounds.at(-1).close()")
    robot.robot.wait_for(warns("no sound comes from the microphone: the robot stops"), since)
    expect(free).not_to_be_checked()
    expect(free).to_be_enabled()  # the connection is there again
    free.check()
    expect(ear(page)).to_have_text("hearing you")
    assert page.workers[0].evaluate("() => self.sounds.length") == 2


def test_a_page_that_drives_no_more_says_nothing_of_its_sound(
    robot: PageRobot, context: BrowserContext
) -> None:
    """The robot ends the connection for it, which is not broken."""
    patch_link(context, SOUNDS)
    page = opened(context, robot.link)
    drive(page)
    expect(page.get_by_label("hands-free")).to_be_enabled()
    page.workers[0].evaluate("() => self.sounds.at(-1).close()")
    note = page.locator("#voice-note")
    expect(note).to_have_text("The connection for your sound broke. It is opened again.")
    page.locator("#leave").click()
    expect(page.locator("#leave")).to_be_hidden()
    expect(note).to_have_text("")


def test_stop(robot: PageRobot, page: Page) -> None:
    stop = page.locator("#stop")
    for way in ("tap", "space", "space on a command", "enter"):
        # On a busy machine the page may be silent for so long that the robot stops.
        wait_until(lambda: tap(page, "go back") or robot.state["now"]["linear"])
        if way == "tap":
            stop.click()
        elif way == "enter":
            stop.focus()
            page.keyboard.press("Enter")
        else:
            if way == "space on a command":
                page.locator("#commands button").first.focus()
            page.keyboard.press("Space")
        expect(stop).to_have_text("stopped")
        assert robot.since  # all events until then have arrived
        assert rests(robot.robot.of("cmd_vel")[-1])
        assert set(robot.robot.commands()[-2:]) <= {"stop", "go back"}, way  # and no other button
        expect(stop).to_have_text("STOP")
    expect(page.locator("#stop-note")).to_contain_text("no emergency stop")
    assert page.complaints == []  # type: ignore[attr-defined]


def test_a_tap_that_arrives_after_the_stop_that_followed_it_moves_nothing(
    robot: PageRobot, page: Page
) -> None:
    held: list[Route] = []
    page.route("**/api/command", lambda route: held.append(route))
    tap(page, "go forward")
    page.keyboard.press("Space")
    expect(page.locator("#stop")).to_have_text("stopped")
    wait_until(lambda: page.wait_for_timeout(10) or held)
    held[0].continue_()
    expect(page.get_by_role("alert")).to_contain_text("a stop came after it")
    assert robot.state["now"]["linear"] == 0
    page.unroute("**/api/command")
    tap(page, "go back")
    expect(page.locator("#motion")).to_have_text("BACK 0.10 m/s")


@pytest.mark.parametrize("broken", ["api/stop", "events"])
def test_stop_works_by_either_way_alone(
    broken: str, robot: PageRobot, context: BrowserContext
) -> None:
    if broken == "events":  # the socket gives nothing back
        patch_link(
            context,
            "const send = WebSocket.prototype.send;"
            "WebSocket.prototype.send = function (data) {"
            "  if (!String(data).includes('stop')) send.call(this, data); };",
        )
    if broken == "api/stop":
        context.route("**/api/stop", lambda route: route.abort())
    page = opened(context, robot.link)
    expect(page.locator("#driver")).to_have_text("nobody drives")
    robot.drives("go forward")
    page.keyboard.press("Space")
    expect(page.locator("#stop")).to_have_text("stopped")
    assert robot.state["now"]["linear"] == 0


def test_a_stop_that_nobody_confirms_is_the_largest_thing_until_zero_is_sent(
    robot: PageRobot, context: BrowserContext
) -> None:
    patch_link(context, "WebSocket.prototype.send = () => {};")
    context.route("**/api/stop", lambda route: route.abort())
    page = opened(context, robot.link)
    robot.drives("go forward")
    expect(page.locator("#motion-word")).to_have_text("FORWARD")
    page.keyboard.press("Space")
    stop = page.locator("#stop")
    expect(stop).to_contain_text("NOT STOPPED")
    expect(stop).to_contain_text("Cut its power")
    expect(page.get_by_role("alert")).to_contain_text("did not confirm")
    area = "([one]) => { const box = one.getBoundingClientRect(); return box.width * box.height; }"
    shown = page.viewport_size
    assert shown
    assert page.eval_on_selector_all("#stop", area) > 0.5 * shown["width"] * shown["height"]
    flash = "(stop) => getComputedStyle(stop).animationName"
    assert stop.evaluate(flash) == "flash"
    assert barriers(page) == []
    page.emulate_media(reduced_motion="reduce")
    assert stop.evaluate(flash) == "none"
    context.unroute("**/api/stop")  # it keeps trying
    expect(stop).to_have_text("stopped")
    assert robot.state["now"]["linear"] == 0
    expect(stop).to_have_text("STOP")
    expect(page.get_by_role("alert")).to_be_hidden()


def test_it_comes_back_when_the_server_was_killed(
    no_sound_card: dict[str, str], context: BrowserContext
) -> None:
    with page_robot(no_sound_card, "--listening") as robot:
        port = robot.link.strip("/").rpartition(":")[2]
        page = opened(context, robot.link)
        drive(page)
        robot.robot.process.send_signal(signal.SIGKILL)
        expect(ear(page)).to_have_text("lost")
        expect(page.locator("#ear-more")).to_contain_text("last seen")
        expect(page.locator("#motion-word")).to_have_text("unknown")
        expect(page.locator("#driver")).to_have_text("")
        expect(page.locator("#commands button").first).to_be_disabled()
    with page_robot(no_sound_card, "--listening", "--web-port", port) as robot:
        expect(page.locator("#driver")).to_have_text("you drive")  # as it did before
        tap(page, "go forward")
        robot.robot.wait_for(moves)
        page.keyboard.press("Space")
        expect(page.locator("#stop")).to_have_text("stopped")
        expect(page.get_by_role("alert")).to_be_hidden()


def test_two_pages_one_drives_and_taking_over_is_asked_and_seen(
    robot: PageRobot, context: BrowserContext
) -> None:
    first, second = opened(context, robot.link), opened(context, robot.link)
    first.bring_to_front()
    drive(first)
    expect(second.locator("#driver")).to_have_text(
        re.compile(r"^Linux PC, since \d\d:\d\d, drives$")
    )
    expect(ear(second)).to_have_text("watching")
    assert second.locator("#commands button:enabled").count() == 0
    tap(first, "go forward")
    since = robot.since
    robot.robot.wait_for(moves, since)
    second.get_by_role("button", name="Take over").click()
    asked = second.get_by_role("dialog")
    expect(asked).to_contain_text("drives. Take over? The robot stops.")
    asked.get_by_role("button", name="Keep watching").click()
    expect(asked).to_be_hidden()
    assert robot.state["now"]["linear"] == 0.1
    drive(second)
    robot.robot.wait_for(rests, since)
    banner = first.locator("#notice")
    expect(banner).to_contain_text("took over. The robot was stopped.")
    banner.get_by_role("button").click()
    expect(banner).to_be_hidden()
    assert first.locator("#commands button:enabled").count() == 0
    for page in (first, second):
        expect(page.locator("#log")).to_contain_text("drives now")


@pytest.mark.realtime
@pytest.mark.alone
def test_a_page_that_is_busy_for_half_a_second_again_and_again_speaks_and_drives_on(
    robot: PageRobot, page: Page
) -> None:
    go_hands_free(page)
    since = robot.since
    page.evaluate(
        "() => { const work = () => { const end = Date.now() + 500; while (Date.now() < end); };"
        "window.work = setInterval(work, 550); work(); }"
    )
    robot.robot.wait_for(moves, since)
    assert robot.robot.commands()[-1] == "go forward"
    page.evaluate("() => new Promise((done) => setTimeout(done, 2000))")
    assert robot.state["now"]["linear"] > 0
    assert robot.robot.warnings(since) == []
    page.keyboard.press("Space")
    robot.robot.wait_for(rests, since)
    expect(page.locator("#stop")).to_have_text("stopped")
    assert page.complaints == []  # type: ignore[attr-defined]


HANGS = "() => { const end = Date.now() + 2500; while (Date.now() < end); }"


@pytest.mark.realtime
def test_s5_a_page_that_hangs_stops_the_robot(robot: PageRobot, page: Page) -> None:
    tap(page, "go forward")
    since = robot.since
    robot.robot.wait_for(moves, since)
    page.evaluate(HANGS)
    robot.robot.wait_for(warns("the operator's page is gone"), since)
    robot.robot.wait_for(warns("the operator's page is there"), since)
    assert rests(robot.robot.of("cmd_vel")[-1])


def test_s5_a_page_that_nobody_sees_any_more_stops_the_robot(robot: PageRobot, page: Page) -> None:
    since = robot.since
    tap(page, "go forward")
    robot.robot.wait_for(moves, since)
    page.evaluate(
        "() => { Object.defineProperty(document, 'hidden', { value: true });"
        "document.dispatchEvent(new Event('visibilitychange')); }"
    )
    robot.robot.wait_for(warns("the operator's page is gone"), since)


def test_without_the_token_it_says_what_to_do(
    no_sound_card: dict[str, str], context: BrowserContext
) -> None:
    with page_robot(no_sound_card, "--listening", "--web-host", "0.0.0.0") as robot:
        page = opened(context, robot.link)
        expect(page.get_by_role("alert")).to_contain_text("open the link")
        page.goto(f"{robot.link}#token=wrong")
        page.reload()
        expect(page.get_by_role("alert")).to_contain_text("open the link")
        page = opened(context, f"{robot.link}#token={robot.token}")
        drive(page)
        assert robot.token not in page.url
        tap(page, "go forward")
        robot.robot.wait_for(moves)


def test_a_list_that_is_saved_changes_the_buttons_of_an_open_page(
    robot: PageRobot, page: Page, own_list: Path
) -> None:
    expect(page.locator("#commands").get_by_role("button", name="point beer")).to_be_enabled()
    assert page.get_by_role("button", name="fold arm").count() == 0
    own_list.write_text(own_list.read_text() + "fold arm\n")
    tap(page, "fold arm")
    robot.robot.wait_for(lambda event: event.get("text") == "fold arm" and event["obeyed"])
    assert page.complaints == []  # type: ignore[attr-defined]


def test_a_tick_on_its_way_to_the_robot_stays(robot: PageRobot, context: BrowserContext) -> None:
    patch_link(
        context,
        "const send = WebSocket.prototype.send; self.held = [];"
        "WebSocket.prototype.send = function (data) {"
        "  if (!String(data).includes('rehearse')) send.call(this, data);"
        "  else self.held.push(() => send.call(this, data)); };",
    )
    page = opened(context, robot.link)
    drive(page)
    page.get_by_label("rehearsal").check()
    page.wait_for_timeout(500)  # the page is told five times that there is none yet
    expect(page.get_by_label("rehearsal")).to_be_checked()
    page.workers[0].evaluate("() => self.held.pop()()")
    expect(page.locator("#motion")).to_have_text("REHEARSAL nothing moves")
    page.get_by_label("rehearsal").uncheck()
    page.workers[0].evaluate("() => self.held.pop()()")
    expect(ear(page)).to_have_text("hold to talk")
    expect(page.get_by_label("rehearsal")).not_to_be_checked()


def test_a_page_of_a_stranger_can_neither_drive_nor_read(
    robot: PageRobot, context: BrowserContext
) -> None:
    page = context.new_page()
    page.route("http://stranger.example/", lambda route: route.fulfill(body="<title>x</title>"))
    page.goto("http://stranger.example/")
    tried = page.evaluate(
        """async (link) => {
          const fetched = (path, how) => fetch(link + path, how).then((a) => a.status, () => "no");
          const json = { "Content-Type": "application/json" };
          const body = JSON.stringify({ text: "go forward" });
          const opened = new Promise((done) => {
            const socket = new WebSocket(link.replace("http", "ws") + "api/events");
            socket.onopen = () => done("open");
            socket.onerror = () => done("no");
          });
          return [
            await fetched("api/state"),
            await fetched("api/command", { method: "POST", headers: json, body }),
            (await fetched("api/command", { method: "POST", mode: "no-cors", body })) && "sent",
            await opened,
          ];
        }""",
        robot.link,
    )
    assert tried == ["no", "no", "sent", "no"]
    assert robot.state["now"]["linear"] == 0
    assert robot.state["now"]["pages"] == 0


@pytest.mark.parametrize(
    ("error", "help_text"),
    [
        ("NotAllowedError", "Click the icon left of the address, and switch Microphone on."),
        ("NotFoundError", "Connect one"),
    ],
)
def test_a_microphone_that_is_refused_says_what_to_do(
    error: str, help_text: str, robot: PageRobot, browser: Browser
) -> None:
    context = browser.new_context(permissions=["microphone"])
    context.add_init_script(
        "window.given = navigator.mediaDevices.getUserMedia.bind(navigator.mediaDevices);"
        "navigator.mediaDevices.getUserMedia = () =>"
        f"  Promise.reject(new DOMException('no', '{error}'));"
    )
    page = opened(context, robot.link)
    drive(page)
    expect(page.locator("#voice-note")).to_contain_text(help_text)
    expect(ear(page)).to_have_text("microphone off")
    tap(page, "go forward")  # which needs no microphone
    expect(page.locator("#motion-word")).to_have_text("FORWARD")
    page.evaluate("() => { navigator.mediaDevices.getUserMedia = window.given; }")
    page.get_by_role("button", name="Try again").click()
    expect(page.get_by_role("button", name="Hold to talk")).to_be_enabled()
    expect(page.locator("#voice-note")).to_have_text("")
    context.close()


@pytest.mark.parametrize(("scheme", "width", "height"), [("light", 1366, 768), ("dark", 390, 844)])
def test_nothing_of_it_is_a_barrier(
    scheme: Literal["light", "dark"],
    width: int,
    height: int,
    robot: PageRobot,
    context: BrowserContext,
) -> None:
    page = opened(context, robot.link)
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": width, "height": height})
    robot.command("make coffee")
    assert barriers(page) == []
    drive(page)
    expect(page.get_by_role("button", name="Hold to talk")).to_be_enabled()
    tap(page, "point beer")
    expect(page.locator("#arm")).to_have_text("points at the beer")
    assert barriers(page) == []
    shown = ("#motion", "#ear", "#room", "#heard", "#commands", "#main-button", "#stop")
    for part in shown:  # without scrolling
        expect(page.locator(part)).to_be_in_viewport(ratio=1)
    page.locator("#more").scroll_into_view_if_needed()
    for part in ("#motion", "#ear", "#main-button", "#stop"):
        expect(page.locator(part)).to_be_in_viewport(ratio=1)
    assert page.complaints == []  # type: ignore[attr-defined]
