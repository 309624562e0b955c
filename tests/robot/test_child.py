"""What stops a robot while its run is silent, without a process and in no time."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.events import Event, Reply, Twist, to_json
from voz.robot import child
from voz.robot.base import Robot
from voz.robot.child import WatchedRobot
from voz.robot.robot_process import EventAnswer

AHEAD, LEFT, REST = Twist(1, 0.1, 0), Twist(2, 0, 0.1), Twist(3, 0, 0)
SILENT = EventAnswer(trouble="nothing came for 0.5 s")


class Base(Robot):
    """Takes everything, or fails."""

    def __init__(self) -> None:
        self.got: list[Event] = []
        self.failure: BaseException | None = None

    def receive(self, event: Event) -> None:
        if self.failure:
            raise self.failure
        self.got.append(event)


def watched(only_zero: bool = False) -> tuple[WatchedRobot, list[Event]]:
    base = Base()
    return WatchedRobot(base, only_zero), base.got


@pytest.mark.parametrize("velocity", [AHEAD, LEFT])
def test_after_a_silence_only_a_zero_of_the_run_gives_it_back(velocity: Twist) -> None:
    robot, got = watched()
    assert robot.take(velocity) == EventAnswer()
    robot.stop()
    assert robot.take(velocity) == SILENT
    assert robot.take(Reply(2.5, "well")) == SILENT
    assert robot.take(REST) == EventAnswer()
    assert robot.take(velocity) == EventAnswer()
    zero = Twist(velocity.t, 0, 0)
    assert got == [velocity, zero, zero, Reply(2.5, "well"), REST, velocity]


def test_before_the_first_velocity_nothing_is_lost() -> None:
    robot, got = watched()
    assert robot.take(Reply(0, "well")) == EventAnswer()
    assert not robot.watches
    robot.stop()
    assert robot.take(AHEAD) == EventAnswer()
    assert robot.watches
    assert got == [Reply(0, "well"), Twist(0, 0, 0), AHEAD]


def test_a_watchdog_watches_from_the_beginning_and_sends_nothing_but_zero() -> None:
    robot, got = watched(only_zero=True)
    assert robot.watches
    assert robot.take(AHEAD) == EventAnswer()
    assert got == []
    robot.stop()
    assert robot.take(AHEAD) == SILENT
    assert got == [Twist(1, 0, 0)]


@pytest.mark.parametrize("error", [SystemExit(3), KeyboardInterrupt(), RuntimeError("3")])
def test_what_a_robot_raises_is_told_and_it_is_still_stopped(error: BaseException) -> None:
    base = Base()
    robot = WatchedRobot(base, only_zero=False)
    robot.take(AHEAD)
    base.failure = error
    assert type(error).__name__ in (robot.take(LEFT).failure or "")
    robot.stop()
    base.failure = None
    robot.stop()
    assert base.got == [AHEAD, Twist(2, 0, 0)]


@given(st.lists(st.sampled_from([AHEAD, LEFT, REST, None]), max_size=20))
def test_it_moves_only_by_what_came_since_the_last_silence_and_a_zero_after_it(
    moments: list[Twist | None],
) -> None:
    robot, got = watched()
    lost = driven = False
    for moment in moments:
        if moment:
            driven = True
            lost = lost and moment != REST
            robot.take(moment)
            assert got[-1] == (Twist(moment.t, 0, 0) if lost else moment)
        else:
            lost = driven
            robot.stop()
            assert isinstance(got[-1], Twist)
            assert (got[-1].linear, got[-1].angular) == (0, 0)


class Link:
    """The run's end of a connection: what comes from it, and None for a time without."""

    def __init__(self, *moments: Event | bytes | None) -> None:
        self._moments = [*moments]
        self.waited: list[float | None] = []
        self.answers: list[EventAnswer] = []

    def poll(self, timeout: float | None) -> bool:
        self.waited.append(timeout)
        if self._moments and self._moments[0] is None:
            assert timeout is not None
            self._moments.pop(0)
            return False
        return True

    def recv_bytes(self) -> bytes:
        if not self._moments:
            raise EOFError
        moment = self._moments.pop(0)
        return moment if isinstance(moment, bytes) else to_json(moment).encode()  # type: ignore[arg-type]

    def send_bytes(self, answer: bytes) -> None:
        self.answers.append(msgspec.json.decode(answer, type=EventAnswer))


def test_half_a_second_after_the_last_event_it_is_stopped_ten_times_a_second() -> None:
    robot, got = watched()
    link: Any = Link(Reply(0, "well"), AHEAD, None, None, AHEAD, REST, b"")
    child.serve(link, robot)
    assert link.waited == [None, None, 0.5, 0.1, 0.1, 0.5, 0.5]
    assert link.answers == [EventAnswer(), EventAnswer(), SILENT, EventAnswer()]
    zero = Twist(1, 0, 0)
    assert got == [Reply(0, "well"), AHEAD, zero, zero, zero, REST]


def test_a_watchdog_waits_half_a_second_for_the_first_velocity_and_says_when_the_run_ends() -> None:
    robot, got = watched(only_zero=True)
    link: Any = Link(None, None)
    with pytest.raises(EOFError):
        child.serve(link, robot)
    assert link.waited == [0.5, 0.1, 0.1]
    assert got == [Twist(0, 0, 0)] * 2


def test_after_the_run_it_is_stopped_for_half_a_second_and_prints_nowhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    slept: list[float] = []
    monkeypatch.setattr("time.sleep", slept.append)
    robot, got = watched()
    robot.take(AHEAD)
    nowhere = os.open(tmp_path / "nowhere", os.O_CREAT | os.O_WRONLY)
    kept = {descriptor: os.dup(descriptor) for descriptor in (1, 2)}
    try:
        child.stop_after_run(robot, nowhere)
        assert all(os.path.sameopenfile(descriptor, nowhere) for descriptor in kept)
    finally:
        for descriptor, copy in kept.items():
            os.dup2(copy, descriptor)
            os.close(copy)
        os.close(nowhere)
    assert got == [AHEAD, *[Twist(1, 0, 0)] * 5]
    assert slept == [0.1] * 5
