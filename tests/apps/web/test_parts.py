"""The pure parts of the operator page, each by itself."""

from __future__ import annotations

import asyncio
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.datastructures import Headers

from voz.apps.web.access_control import MAX_SESSIONS, AccessControl, new_token
from voz.apps.web.driver_lock import DRIVER_TIMEOUT, RELEASE_TIMEOUT, DriverLock
from voz.apps.web.page_messages import MAX_REMEMBERED, EventHistory, encode_record
from voz.apps.web.page_registry import MAX_PENDING_RECORDS, OpenPage
from voz.apps.web.page_sound import BLOCK_HEADER, MAX_BLOCK_SAMPLES, PageClock, read_block
from voz.apps.web.picture import DeadReckoningPicture
from voz.apps.web.websocket_api import device_name
from voz.events import Attention, Notice, Reply, Twist, Utterance

# Who drives


def test_the_first_page_that_asks_drives_until_another_takes_over() -> None:
    lock = DriverLock()
    assert lock.acquire(1, False, 0.0)
    assert not lock.acquire(2, False, 0.0)
    assert lock.driver == 1
    assert lock.acquire(2, True, 0.0)
    assert lock.driver == 2
    assert not lock.release(1)


def test_a_robot_that_no_page_drives_misses_none() -> None:
    lock = DriverLock()
    assert not lock.released_at_rest
    assert lock.trouble(99.0, moving=True) is None


def test_a_page_that_gives_no_sign_is_missed_only_by_a_robot_that_moves() -> None:
    lock = DriverLock()
    lock.acquire(1, False, 0.0)
    assert lock.trouble(DRIVER_TIMEOUT, moving=True) is None
    assert lock.trouble(DRIVER_TIMEOUT + 0.01, moving=False) is None
    assert lock.trouble(DRIVER_TIMEOUT + 0.01, moving=True)
    assert lock.trouble(DRIVER_TIMEOUT + 0.02, moving=False)  # until it is back
    lock.keep_alive(1, 1.0)
    assert lock.trouble(1.0, moving=True) is None


def test_a_page_that_closes_is_missed_until_somebody_drives_again() -> None:
    lock = DriverLock()
    lock.acquire(1, False, 0.0)
    assert lock.release(1)
    assert lock.just_released
    assert lock.trouble(0.1, moving=True)
    assert not lock.just_released
    assert lock.trouble(9.0, moving=False)
    assert lock.acquire(2, False, 10.0)
    assert lock.trouble(10.0, moving=True) is None


def test_a_page_that_closes_beside_a_robot_at_rest_is_forgotten() -> None:
    lock = DriverLock()
    lock.acquire(1, False, 0.0)
    lock.release(1)
    assert lock.trouble(0.1, moving=False) is None
    assert lock.released_at_rest
    assert lock.trouble(0.2, moving=True) is None  # somebody else drives by voice
    assert not lock.released_at_rest


def test_the_place_of_a_silent_page_is_free_after_a_while() -> None:
    lock = DriverLock()
    lock.acquire(1, False, 0.0)
    assert not lock.release_if_silent(RELEASE_TIMEOUT)
    assert lock.release_if_silent(RELEASE_TIMEOUT + 0.1)
    assert lock.driver is None
    assert not lock.release_if_silent(99.0)


# Sound


def block(number: int, heard: float, samples: list[int]) -> bytes:
    return struct.pack("<IId", number, 0, heard) + np.array(samples, "<i2").tobytes()


def test_a_block_is_read_as_it_was_sent() -> None:
    read = read_block(block(7, 1234.5, [0, 16384, -32768]))
    assert read
    assert (read.number, read.heard) == (7, 1234.5)
    assert read.sound.tolist() == [0.0, 0.5, -1.0]
    assert read.sound.dtype == np.float32


@given(st.binary(max_size=64))
def test_whatever_comes_in_place_of_a_block_raises_nothing(data: bytes) -> None:
    read = read_block(data)
    assert read is None or len(read.sound) == (len(data) - BLOCK_HEADER.size) // 2


def test_a_block_has_bounds() -> None:
    assert read_block(block(0, 0.0, [])) is None
    assert read_block(block(0, 0.0, [0] * (MAX_BLOCK_SAMPLES + 1))) is None
    assert read_block(block(0, float("nan"), [0])) is None


@given(
    ahead=st.floats(-1e6, 1e9),
    ways=st.lists(st.tuples(st.floats(0, 2), st.floats(0, 2)), min_size=1, max_size=20),
    age=st.floats(0, 10),
)
def test_the_age_of_sound_is_known_to_half_of_the_shortest_way(
    ahead: float, ways: list[tuple[float, float]], age: float
) -> None:
    clock, now = PageClock(), 100.0
    for there, back in ways:
        clock.add_answer(now, now + there + back, now + there + ahead)
        now += there + back + 1
    shortest = min(there + back for there, back in ways[-8:])
    assert abs(clock.age(now - age + ahead, now) - age) <= shortest / 2 + 1e-5


# Pages


def test_a_page_that_takes_nothing_is_too_slow_and_keeps_only_the_newest_state() -> None:
    async def watch() -> tuple[list[str], bool]:
        page = OpenPage(1, "secret", "127.0.0.1")
        for number in range(MAX_PENDING_RECORDS):
            page.put(str(number))
            page.put_state(f"state {number}")
        assert not page.too_slow
        page.put("one more")
        return await page.take(), page.too_slow

    records, too_slow = asyncio.run(watch())
    assert too_slow
    assert records[-1] == f"state {MAX_PENDING_RECORDS - 1}"
    assert len(records) == MAX_PENDING_RECORDS + 1


def test_the_history_says_why_and_remembers_what_matters() -> None:
    history = EventHistory({"stop": 0.5}.get)
    refused = Utterance(1.0, "stop", 0.4, False, 0.0, 1.0, "browser", reason="too_short")
    record = history.add(refused)
    assert (record["needed"], record["why"]) == (0.5, "too short")
    history.add(Twist(1.0, 0.0, 0.0))
    history.add(Attention(1.0, awake=True))  # which has no words
    assert [remembered["type"] for remembered in history.remembered] == ["utterance"]
    for number in range(2 * MAX_REMEMBERED):
        history.add(Notice(2.0, str(number)))
    assert len(history.remembered) == MAX_REMEMBERED
    assert history.remembered[-1]["text"] == str(2 * MAX_REMEMBERED - 1)


def test_a_question_is_known_until_nothing_can_be_answered() -> None:
    history = EventHistory(lambda _: None)
    history.add(Reply(1.0, "do you mean it?"))
    assert (history.question, history.answers) == ("", ())
    history.add(Attention(1.0, awake=True, answers=("yes", "no")))
    assert (history.question, history.answers) == ("do you mean it?", ("yes", "no"))
    history.add(Attention(2.0, awake=True))
    assert history.question == ""


def test_what_is_no_text_can_be_sent() -> None:
    assert encode_record({"text": "\ud800"}) == '{"text":"\\ud800"}'


def test_a_robot_that_nobody_sees_is_where_its_velocities_bring_it() -> None:
    picture = DeadReckoningPicture()
    for beat in range(11):
        picture.receive(Twist(beat / 10, 0.1, 0.0))
    assert picture.state()["pose"] == [0.1, 0.0, 0.0]
    picture.receive(Twist(99.0, 0.0, 0.0))  # a base stops by itself
    assert picture.state()["pose"] == [0.15, 0.0, 0.0]


# Who may come in


HERE = [(b"host", b"robot.local:8737")]


@pytest.mark.parametrize(
    ("headers", "allowed"),
    [
        (HERE, True),
        ([], False),
        ([*HERE, *HERE], False),
        ([(b"host", b"ROBOT.local")], True),
        ([(b"host", b"robot.local.example.org")], False),
        ([(b"host", b"[::1")], False),
        ([(b"host", b"[::1]:80")], True),
        ([(b"host", b"192.168.1.7:8737")], True),
        ([(b"host", b"192.168.1.7.example.org")], False),
        ([*HERE, (b"origin", b"http://robot.local:8737")], True),
        ([*HERE, (b"origin", b"http://robot.local")], False),
        ([*HERE, (b"origin", b"null")], False),
        ([*HERE, (b"sec-fetch-site", b"same-origin")], True),
        ([*HERE, (b"sec-fetch-site", b"cross-site")], False),
    ],
)
def test_requests_from_other_sites_are_refused(
    headers: list[tuple[bytes, bytes]], allowed: bool
) -> None:
    refusal = AccessControl(["robot.local"]).refusal(Headers(raw=headers))
    assert (refusal is None) == allowed


@given(st.lists(st.tuples(st.sampled_from([b"host", b"origin", b"cookie"]), st.binary())))
def test_strange_headers_raise_nothing(headers: list[tuple[bytes, bytes]]) -> None:
    access = AccessControl(["robot.local"], "token")
    access.refusal(Headers(raw=headers))
    assert not access.is_authenticated(Headers(raw=headers))


def test_the_token_is_changed_for_a_session() -> None:
    token = new_token()
    access = AccessControl(["robot.local"], token, "voz-1")
    assert access.log_in("") is None
    assert access.log_in("\udcff") is None
    session = access.log_in(token)
    assert session
    assert access.is_authenticated(Headers({"cookie": f"a=b; voz-1={session}"}))
    assert not access.is_authenticated(Headers({"cookie": f"voz-2={session}"}))
    assert not access.is_authenticated(Headers({"cookie": f"voz-1={token}"}))
    assert not access.is_authenticated(Headers({"cookie": f"voz-1=a; voz-1={session}"}))
    assert access.is_authenticated(Headers({"authorization": f"Bearer {token}"}))
    for _ in range(MAX_SESSIONS):
        access.log_in(token)
    assert not access.is_authenticated(Headers({"cookie": f"voz-1={session}"}))


SAFARI = "AppleWebKit/605.1.15 (KHTML, like Gecko) Version/18.0 Mobile/15E148 Safari/604.1"
CHROME = "AppleWebKit/537.36 (KHTML, like Gecko) Chrome/130.0.0.0"


@pytest.mark.parametrize(
    ("user_agent", "name"),
    [
        (f"Mozilla/5.0 (iPhone; CPU iPhone OS 18_0 like Mac OS X) {SAFARI}", "iPhone"),
        (f"Mozilla/5.0 (iPad; CPU OS 18_0 like Mac OS X) {SAFARI}", "iPad"),
        (f"Mozilla/5.0 (Linux; Android 10; K) {CHROME} Mobile Safari/537.36", "Android phone"),
        (f"Mozilla/5.0 (Linux; Android 10; K) {CHROME} Safari/537.36", "Android tablet"),
        ("Mozilla/5.0 (Android 15; Mobile; rv:132.0) Gecko/132.0 Firefox/132.0", "Android phone"),
        (f"Mozilla/5.0 (X11; CrOS x86_64 14541.0.0) {CHROME} Safari/537.36", "Chromebook"),
        (f"Mozilla/5.0 (Windows NT 10.0; Win64; x64) {CHROME} Safari/537.36", "Windows PC"),
        (f"Mozilla/5.0 (Macintosh; Intel Mac OS X 10_15_7) {CHROME} Safari/537.36", "Mac"),
        ("Mozilla/5.0 (X11; Linux x86_64; rv:132.0) Gecko/20100101 Firefox/132.0", "Linux PC"),
        ("Mozilla/5.0 (Haiku)", "browser"),
        ("Python/3.11 websockets/15.0", "program"),
        ("", "program"),
    ],
)
def test_a_page_is_named_by_its_device(user_agent: str, name: str) -> None:
    assert device_name(user_agent) == name
