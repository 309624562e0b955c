"""Commands that another recognizer publishes as ROS 2 texts: what is heard, and what is not."""

from collections.abc import Callable, Iterator
from threading import Thread

import pytest
from programs import Program, wait_until

from voz.events import Utterance
from voz.ros2 import Ros2Robot, listen_to_recognizer
from voz.ros2.node import HISTORY_DEPTH
from voz.settings import Ros2

pytestmark = pytest.mark.usefixtures("domain")


@pytest.fixture
def texts() -> Iterator[list[str]]:
    heard: list[str] = []
    with listen_to_recognizer(Ros2(), heard.append, heard.append):
        yield heard


@pytest.fixture
def other(texts: list[str], own: Callable[..., Program]) -> Program:
    """Another recognizer, that has been heard once."""
    program = own("cyclone_peer.py")

    def heard() -> bool:
        program.say("hello")
        return bool(texts)

    wait_until(heard)
    return program


def test_what_another_program_recognizes_is_heard_in_order(
    texts: list[str], other: Program
) -> None:
    commands = [f"go forward {number}" for number in range(HISTORY_DEPTH)]
    for command in commands:
        other.say(command)
    wait_until(lambda: texts[-1] == commands[-1])
    assert [text for text in texts if text != "hello"] == commands


def test_what_is_no_text_is_passed_over(texts: list[str], other: Program) -> None:
    other.say("señor")
    other.say("stop")
    wait_until(lambda: texts[-1] == "stop")
    assert set(texts) == {"hello", "stop"}


def test_what_this_process_publishes_is_not_heard(texts: list[str], other: Program) -> None:
    robot = Ros2Robot(Ros2(wait=0))
    robot.open()
    robot.receive(Utterance(0.0, "go back", 0.9, True, 0.0, 0.0, "microphone", obeyed=True))
    robot.close()
    other.say("stop")
    wait_until(lambda: texts[-1] == "stop")
    assert "go back" not in texts


def test_the_end_leaves_no_thread(other: Program, begun: Callable[[], list[Thread]]) -> None:
    with listen_to_recognizer(Ros2(), lambda text: None, print):
        pass
    assert begun() == []


def test_that_nothing_is_heard_any_more_is_told(own: Callable[..., Program]) -> None:
    def hear(text: str) -> None:
        raise MemoryError(text)

    told: list[str] = []
    with listen_to_recognizer(Ros2(), hear, told.append):
        program = own("cyclone_peer.py")

        def fails() -> bool:
            program.say("hello")
            return bool(told)

        wait_until(fails)
    assert told == ["recognizer/output is no longer received (MemoryError('hello'))"]
