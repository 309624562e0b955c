"""The server and its API, without a browser: a real run, and programs that ask it."""

from __future__ import annotations

import io
import json
import os
import socket
import ssl
import stat
import threading
import time
import zipfile
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import httpx
import numpy as np
import pytest
from calls import in_process
from live_robot import moves, rests, warns
from operator_page import Page, PageRobot, heard, opened, page_robot, told
from programs import wait_until
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import voz
from voz.apps.web.page_messages import Record

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def one_run(no_sound_card: dict[str, str]) -> Iterator[PageRobot]:
    with page_robot(no_sound_card, "--listening") as robot:
        yield robot


# What a program asks for


@pytest.mark.realtime
def test_a_command_is_answered_by_what_became_of_it(robot: PageRobot) -> None:
    since = robot.since
    answer = robot.command("Go  Forward").json()
    assert (answer["text"], answer["obeyed"], answer["source"]) == ("go forward", True, "program")
    robot.robot.wait_for(moves, since)
    refused = robot.command("make coffee").json()
    assert (refused["accepted"], refused["reason"]) == (False, "not_a_command")


def test_stop_is_answered_when_zero_velocity_was_sent(robot: PageRobot) -> None:
    robot.drives("go forward")
    since = robot.since
    answer = robot.api.post("/api/stop").raise_for_status().json()
    assert answer["stopped"]
    sent = robot.robot.wait_for(rests, since)
    assert sent.event["t"] == answer["t"]
    assert robot.state["now"]["linear"] == 0.0


def test_stop_needs_no_script(robot: PageRobot) -> None:
    robot.drives("go forward")
    origin = robot.link.rstrip("/")
    answer = robot.api.post("/api/stop", data={"stop": "1"}, headers={"Origin": origin})
    assert answer.json()["stopped"]


@pytest.mark.realtime
def test_the_state_tells_where_the_robot_is(robot: PageRobot) -> None:
    before = robot.state["now"]["pose"][0]
    robot.drives("go forward")
    wait_until(lambda: robot.state["now"]["pose"][0] > before + 0.05)
    robot.api.post("/api/stop")
    answer = robot.state
    assert answer["room"]["room"] == [2.6, 1.8]
    assert answer["commands"][:2] == ["start speech", "stop speech"]
    *_, stop = [event for event in answer["events"] if event["text"] == "stop"]
    assert stop["needed"] < 1


def test_diagnostics_hold_what_happened_and_nothing_secret(robot: PageRobot) -> None:
    robot.drives("fold arm")
    with opened(robot) as page:
        secret = page.welcome["secret"]
        packed = robot.api.get("/api/diagnostics").raise_for_status().content
    with zipfile.ZipFile(io.BytesIO(packed)) as file:
        texts = {name: file.read(name).decode() for name in file.namelist()}
    events = [json.loads(line) for line in texts["events.jsonl"].splitlines()]
    assert "fold arm" in [event.get("text") for event in events]
    assert json.loads(texts["settings.json"])["robot"] == ["simulator"]
    assert texts["versions.txt"].startswith("voz ")
    assert json.loads(texts["state.json"])["now"]
    assert secret not in "".join(texts.values())


def test_a_page_gets_the_events_and_states(robot: PageRobot) -> None:
    with opened(robot) as page:
        robot.drives("point beer")
        utterance = page.wait_for(lambda record: record["type"] == "utterance")
        assert utterance["text"] == "point beer"
        page.wait_for(lambda record: record["type"] == "selected_object")
        page.wait_for(lambda record: record["type"] == "state" and record["selected"] == 1)
        page.wait_for(lambda record: record["type"] == "cmd_vel")


def test_a_page_can_stop_without_driving(robot: PageRobot) -> None:
    with opened(robot) as page:
        robot.drives("go forward")
        page.send("stop", number=7)
        answer = page.wait_for(lambda record: record["type"] == "stop")
        assert (answer["number"], answer["stopped"]) == (7, True)


# Who drives


def test_one_page_drives_and_taking_over_is_seen_by_both(robot: PageRobot) -> None:
    with opened(robot) as first, opened(robot) as second:
        first.start_driving()
        assert not second.drive()
        assert robot.command("go forward", page=second.welcome["secret"]).status_code == 409
        assert robot.command("go forward").status_code == 409
        answer = robot.command("go forward", page=first.welcome["secret"]).json()
        assert (answer["obeyed"], answer["source"]) == (True, "page")
        since = robot.since
        second.send("drive", over=True)
        number = second.welcome["page"]
        for page in (first, second):
            page.wait_for(lambda r: r["type"] == "warning" and "drives now" in r["text"])
            page.wait_for(lambda r: r["type"] == "state" and r["driver"] == number)
        robot.robot.wait_for(rests, since)
        assert robot.command("go forward", page=first.welcome["secret"]).status_code == 409
        second.send("leave")
        second.wait_for(lambda record: record["type"] == "state" and record["driver"] is None)


def test_a_command_that_stops_is_obeyed_whoever_sends_it_and_however_often(
    robot: PageRobot,
) -> None:
    with opened(robot) as page:
        page.start_driving()
        secret = page.welcome["secret"]
        for sender in ({}, {"page": "nobody"}, {"page": secret, "stops": -1}):
            assert robot.command("go forward", page=secret).json()["obeyed"]
            assert robot.command("stop", **sender).json()["obeyed"]
            assert robot.state["now"]["linear"] == 0
        assert all(robot.command("stop", page=secret).json()["obeyed"] for _ in range(30))
        with voz.Client(robot.link) as other:
            assert other.command("stop speech").obeyed
            assert other.command("stop").obeyed
        assert robot.command("start speech", page=secret).json()["obeyed"]


@pytest.mark.parametrize("way", ["socket", "post", "post of nobody"])
def test_a_command_that_a_stop_has_overtaken_on_its_way_moves_nothing(
    way: str, robot: PageRobot
) -> None:
    with opened(robot) as page:
        page.start_driving()
        secret = page.welcome["secret"]
        if way == "socket":
            page.send("stop", number=1)
            page.wait_for(lambda record: record["type"] == "stop")
        else:
            known = {"X-Voz-Page": secret, "X-Voz-Stop": "1" if way == "post" else "9" * 5000}
            assert robot.api.post("/api/stop", headers=known).json()["stopped"]
        late = robot.command("go forward", page=secret, stops=0)
        if way == "post of nobody":
            assert late.json()["obeyed"]
            return
        assert late.status_code == 409
        assert "a stop came after it" in late.json()["error"]
        assert robot.state["now"]["linear"] == 0
        assert robot.command("go forward", page=secret, stops=1).json()["obeyed"]


def test_s5_the_robot_stops_when_another_page_drives_at_once_in_place_of_one_that_is_closed(
    robot: PageRobot,
) -> None:
    with opened(robot) as second, opened(robot) as first:
        first.start_driving()
        assert robot.command("go forward", page=first.welcome["secret"]).json()["obeyed"]
        first.wait_for(lambda r: r["type"] == "state" and r["linear"] > 0)
        since = robot.since
        first.socket.close()
        second.start_driving()  # before the beat has looked whether the first is there
        robot.robot.wait_for(rests, since)


@pytest.mark.realtime
def test_a_page_that_is_closed_while_the_robot_rests_is_no_trouble(robot: PageRobot) -> None:
    since = robot.since
    with opened(robot) as page:
        page.start_driving()
    robot.robot.wait_for(warns("no page drives any more"), since)
    robot.drives("go forward")
    time.sleep(0.5)
    assert not [text for text in robot.robot.warnings(since) if "gone" in text]
    assert robot.state["now"]["linear"] > 0


# Who may come in


@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "robot.example:80"},
        {"Origin": "https://example.org"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1:1"},
        {"Sec-Fetch-Site": "cross-site"},
    ],
)
def test_strangers_are_refused(robot: PageRobot, headers: dict[str, str]) -> None:
    for answer in (
        robot.api.get("/api/state", headers=headers),
        robot.api.post("/api/command", json={"text": "go forward"}, headers=headers),
    ):
        assert answer.status_code == 403
        assert answer.json()["error"]
    if "Host" not in headers:
        with pytest.raises(InvalidStatus), opened(robot, **headers):
            pass
    assert robot.state["now"]["linear"] == 0


def test_a_command_must_be_json_so_that_no_form_of_others_sends_it(robot: PageRobot) -> None:
    text = json.dumps({"text": "go forward"})
    answer = robot.api.post("/api/command", content=text, headers={"Content-Type": "text/plain"})
    assert answer.status_code == 400


def test_no_page_of_others_can_show_this_one_or_load_anything_into_it(robot: PageRobot) -> None:
    headers = robot.api.get("/").headers
    assert "frame-ancestors 'none'" in headers["content-security-policy"]
    assert "default-src 'none'" in headers["content-security-policy"]
    assert headers["referrer-policy"] == "no-referrer"


def test_others_need_the_token(no_sound_card: dict[str, str]) -> None:
    with page_robot(no_sound_card, "--web-host", "0.0.0.0", "--listening") as robot:
        assert len(robot.token) == 32
        assert robot.api.get("/").status_code == 200
        assert robot.api.get("/api/state").status_code == 401
        assert robot.api.post("/api/stop").status_code == 401
        with pytest.raises(InvalidStatus), opened(robot):
            pass
        assert robot.api.post("/api/login", json={"token": "x" * 32}).status_code == 403
        bearer = {"Authorization": f"Bearer {robot.token}"}
        assert robot.api.get("/api/state", headers=bearer).status_code == 200
        answer = robot.api.post("/api/login", json={"token": robot.token})
        cookie = answer.headers["set-cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=strict" in cookie
        assert robot.token not in cookie
        assert robot.api.get("/api/state").status_code == 200
        (name, value), *_ = robot.api.cookies.items()
        with opened(robot, Cookie=f"{name}={value}") as page:
            page.start_driving()
        assert robot.robot.words.count(robot.token) == 1  # the link, and no log


def test_with_https_the_certificate_it_offers_is_all_that_a_phone_needs(
    no_sound_card: dict[str, str], tmp_path: Path
) -> None:
    environment = no_sound_card | {"XDG_DATA_HOME": str(tmp_path)}
    with page_robot(environment, "--web-host", "0.0.0.0", "--https", "--listening") as robot:
        assert robot.link.startswith("https://")
        authority = robot.api.get("/api/authority.crt").raise_for_status().text
        trusting = ssl.create_default_context(cadata=authority)
        bearer = {"Authorization": f"Bearer {robot.token}"}
        for name in ("127.0.0.1", "localhost"):
            address = robot.link.replace("127.0.0.1", name)
            with httpx.Client(base_url=address, verify=trusting, headers=bearer) as client:
                assert client.get("/api/state").status_code == 200
        address = robot.link.replace("https", "wss") + "api/events"
        with connect(address, ssl=trusting, additional_headers=bearer) as socket:
            Page(socket).start_driving()
        (certificate := tmp_path / "authority.crt").write_text(authority)
        with pytest.raises(voz.RobotError, match=r"verify failed.*; give its /api/authority.crt"):
            voz.Client(robot.link)
        with pytest.raises(voz.RobotError, match="open the link that `voz run` shows: it has the"):
            voz.Client(robot.link, "wrong", certificate)
        client = voz.Client(f"{robot.link}#token={robot.token}", authority=certificate)
        entered = robot.api.post("/api/login", json={"token": robot.token})
        assert "; Secure" in entered.headers["set-cookie"]
        wait_until(lambda: not robot.state["now"]["driver"])  # the page before is known to be gone
        assert client.command("go forward").obeyed
    with pytest.raises(voz.RobotError, match="the connection is lost, and the robot has stopped"):
        client.command("go forward")
    client.close()
    kept = (tmp_path / "voz" / "certificates" / "authority.key").stat()
    assert stat.S_IMODE(kept.st_mode) == 0o600


# What must not harm it


@pytest.mark.parametrize(
    "garbage",
    [
        "",
        "{",
        "[]",
        '{"type":"nobody"}',
        '{"type":"drive","over":3}',
        "[" * 10_000,
        b"\x00\xff" * 9,
    ],
)
def test_garbage_ends_the_socket_and_nothing_else(robot: PageRobot, garbage: str | bytes) -> None:
    with opened(robot) as page:
        page.socket.send(garbage)
        with pytest.raises(ConnectionClosed):
            page.wait_for(lambda _: False)
    for body in (garbage, b"{" + bytes(5000)):
        json_type = {"Content-Type": "application/json"}
        answer = robot.api.post("/api/command", content=body, headers=json_type)
        assert answer.status_code in (400, 413)
    robot.drives("go forward")


def test_a_flood_leaves_the_beat_and_the_stop_alone(robot: PageRobot) -> None:
    over = threading.Event()

    def flood() -> None:
        with httpx.Client(base_url=robot.link) as client:
            while not over.is_set():
                client.post("/api/command", json={"text": "go back"})

    threads = [threading.Thread(target=flood) for _ in range(4)]
    for thread in threads:
        thread.start()
    try:
        time.sleep(1.0)
        assert robot.api.post("/api/stop").json()["stopped"]
    finally:
        over.set()
        for thread in threads:
            thread.join()
    robot.drives("go forward")  # the limits let one in again
    assert robot.api.post("/api/stop").json()["stopped"]
    assert robot.state["now"]["linear"] == 0


@pytest.mark.parametrize(
    ("begin", "frame"),
    [
        (b"", b"\x89\xfd" + bytes(4) + b"x" * 125),
        (b"", b"\x8a\x80" + bytes(4)),
        (b"\x01\x80" + bytes(4), b"\x00\x80" + bytes(4)),
    ],
    ids=["pings", "pongs", "parts of a message"],
)
def test_a_page_that_sends_frames_without_end_is_let_go(
    robot: PageRobot, begin: bytes, frame: bytes
) -> None:
    def flood(size: int) -> None:
        with socket.socket(fileno=os.dup(page.socket.fileno())) as bare:
            bare.sendall(begin)
            for _ in range(size // (1000 * len(frame))):
                bare.sendall(frame * 1000)

    with told(robot) as page, pytest.raises(ConnectionError):
        flood(20_000_000)
    robot.drives("go forward")


def test_the_stops_of_many_pages_do_not_hold_up_the_page_that_drives(robot: PageRobot) -> None:
    with opened(robot) as driver, ExitStack() as stack:
        driver.start_driving()
        pages = [stack.enter_context(opened(robot)) for _ in range(5)]
        for number in range(100):
            for page in pages:
                page.send("stop", number=number + 1)
        for page in pages:
            page.wait_for(lambda record: record["type"] == "stop" and record["number"] == 100)
        told: list[str] = []

        def is_later(record: Record) -> bool:
            told.append(record["type"])
            return told.count("state") == 20  # ten in a second

        driver.wait_for(is_later)
        assert driver.drive()
    assert told.count("utterance") < 100  # of 500, ten in a second


def test_commands_of_pages_that_watch_use_up_none_of_the_page_that_drives(
    robot: PageRobot,
) -> None:
    with opened(robot) as driver, opened(robot) as watcher:
        driver.start_driving()
        for _ in range(30):
            assert robot.command("go back", page=watcher.welcome["secret"]).status_code == 409
        assert robot.command("go forward", page=driver.welcome["secret"]).json()["obeyed"]


def test_more_pages_than_it_serves_are_turned_away(robot: PageRobot) -> None:
    with ExitStack() as pages:
        for _ in range(100):
            pages.enter_context(opened(robot))
        with pytest.raises(ConnectionClosed), opened(robot):
            pass
        assert robot.api.post("/api/stop").json()["stopped"]


# Sound


@pytest.mark.realtime
def test_a_command_that_is_spoken_drives(robot: PageRobot, forward: np.ndarray) -> None:
    with opened(robot) as page, heard(robot, page) as microphone_of_a_watcher:
        with suppress(ConnectionClosed):  # it does not drive, and may be sent away before
            microphone_of_a_watcher.begin()
        assert microphone_of_a_watcher.told() is None
        page.start_driving()
        with heard(robot, page) as microphone:
            microphone.begin()
            microphone.speak(forward, page)
            microphone.end()
            # A sure command drives while its silence is still talked.
            page.wait_for(lambda r: r["type"] == "state" and r["linear"] > 0 and not r["talking"])
    assert robot.since  # all events until then have arrived
    said = robot.robot.of("utterance")[-1]
    assert (said["text"], said["obeyed"]) == ("go forward", True)
    assert said["latency"] > 0


@pytest.mark.realtime
def test_sound_that_comes_late_does_not_drive_and_is_told(
    robot: PageRobot, forward: np.ndarray
) -> None:
    since = robot.since
    with opened(robot) as page:
        page.start_driving()
        with heard(robot, page) as microphone:
            microphone.begin()
            microphone.speak(forward, page, late=0.5)
            late = microphone.told()
            assert late
            assert late["type"] == "late"
            assert late["seconds"] > 0.4
            microphone.end()
            page.stay(1.0)
    assert not robot.robot.of("utterance", since)
    robot.robot.wait_for(warns("late and is dropped"), since)


@pytest.mark.realtime
def test_words_around_a_gap_do_not_drive(robot: PageRobot, forward: np.ndarray) -> None:
    since = robot.since
    middle = len(forward) // 3
    with opened(robot) as page:
        page.start_driving()
        with heard(robot, page) as microphone:
            microphone.begin()
            microphone.speak(forward[:middle], page)
            microphone.skip()
            microphone.speak(forward[middle:], page)
            microphone.end()
            page.stay(1.0)
    obeyed = [event["text"] for event in robot.robot.of("utterance", since) if event["obeyed"]]
    assert "go forward" not in obeyed


def test_garbage_in_place_of_sound_ends_its_socket(robot: PageRobot) -> None:
    for garbage in (b"", b"\x00", bytes(17), bytes(40_000), "[]", json.dumps({"type": "hello"})):
        with opened(robot) as page:
            page.start_driving()
            with heard(robot, page) as microphone:
                microphone.begin()
                microphone.socket.send(garbage)
                assert microphone.told() is None
    robot.api.post("/api/stop")


# What is said before anything moves


def test_an_address_that_is_taken_is_one_line(no_sound: dict[str, str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = in_process("run", "--web", "--web-port", port, env=no_sound)
    assert f"the operator page cannot be at 127.0.0.1, port {port}" in done.complaint


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--web", "--text", "-"], "--web shows a live run"),
        (["--https"], "add --web"),
        (["--web-host", "0.0.0.0"], "add --web"),
    ],
)
def test_options_that_do_not_fit(
    arguments: list[str], complaint: str, request: pytest.FixtureRequest
) -> None:
    call = request.getfixturevalue("voz")  # a name that the package has here
    assert complaint in call("run", "--no-sound", *arguments).complaint
