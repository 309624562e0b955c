"""Who hears what voz publishes: the example on the real rclpy, and who answers."""

from __future__ import annotations

import signal
import subprocess

import pytest
from hypothesis import given
from hypothesis import strategies as st
from programs import wait_until
from recordings import ROOT
from ros2.conftest import RCLPY

from voz.events import Utterance
from voz.ros2 import Ros2Robot
from voz.ros2.subscribers import ACKNOWLEDGE_TIMEOUT, SubscriberLiveness
from voz.settings import Ros2


@pytest.mark.slow
@pytest.mark.usefixtures("domain")
def test_it_prints_what_was_obeyed_and_is_ended_by_ctrl_c() -> None:
    robot = Ros2Robot(Ros2(wait=0))
    robot.open()
    command = [str(RCLPY), str(ROOT / "examples" / "ros2_listener.py")]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as listener:
        try:
            output = next(w for w in robot.writers if w.topic.name == "rt/recognizer/output")
            wait_until(output.get_matched_subscriptions)
            robot.receive(Utterance(0, "go back", 0.9, True, 0, 1, "text", obeyed=True))
            assert listener.stdout
            assert listener.stdout.readline() == "go back\n"
            listener.send_signal(signal.SIGINT)
            assert listener.wait(60) == -signal.SIGINT
            assert listener.stderr
            assert "Traceback" not in listener.stderr.read()
        finally:
            listener.kill()
            robot.close()


CYCLE = 0.1
LONG = round(ACKNOWLEDGE_TIMEOUT / CYCLE) + 2
"""So many cycles are more than its patience."""

Cycle = tuple[frozenset[int], bool]
connected = st.frozensets(st.integers(1, 4))
histories = st.lists(st.tuples(connected, st.booleans()), max_size=40)


def after(*history: Cycle) -> SubscriberLiveness:
    audience = SubscriberLiveness()
    for number, (listeners, answered) in enumerate(history):
        audience.update(number * CYCLE, listeners, answered)
    return audience


def silence(*listeners: int, cycles: int = LONG) -> list[Cycle]:
    return [(frozenset(listeners), False)] * cycles


def test_who_does_not_answer_for_half_a_second_is_not_there() -> None:
    assert after(*silence(1, cycles=LONG - 2)).alive({1}) == {1}
    assert after(*silence(1)).alive({1}) == set()


def test_many_messages_in_no_time_are_no_silence() -> None:
    audience = SubscriberLiveness()
    for _ in range(100):
        audience.update(1.0, {1}, answered=False)
    assert audience.alive({1}) == {1}


def test_who_comes_after_the_silence_is_there() -> None:
    assert after(*silence(1), *silence(1, 2)).alive({1, 2}) == {2}


@given(histories, connected)
def test_an_answer_makes_everybody_present(before: list[Cycle], now: frozenset[int]) -> None:
    assert after(*before, (now, True)).alive(now) == now


@given(histories, connected)
def test_nobody_is_present_who_is_not_connected(before: list[Cycle], now: frozenset[int]) -> None:
    assert after(*before).alive(now) <= now


@given(histories)
def test_without_a_long_silence_all_are_present(before: list[Cycle]) -> None:
    silences = "".join("a" if answered else "-" for _, answered in before).split("a")
    if max(map(len, silences)) * CYCLE <= ACKNOWLEDGE_TIMEOUT:
        assert after(*before).alive({1, 2, 3, 4}) == {1, 2, 3, 4}
