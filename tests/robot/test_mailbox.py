"""What a robot gets in which order, when it is lost, and how slow work goes on beside that."""

from __future__ import annotations

import ctypes
import dis
import itertools
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType, FunctionType
from typing import Any, TypeAlias

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule
from programs import PATIENCE, wait_until

from voz.errors import RobotError
from voz.events import Event, Reply, SelectedObject, Twist
from voz.robot import mailbox
from voz.robot.base import Robot
from voz.robot.factory import make_user_robot
from voz.robot.mailbox import (
    EVENT_TIMEOUT,
    EVENTS_BEFORE_VELOCITY,
    MAX_MAILBOX_EVENTS,
    EventBox,
    Mailbox,
    SlowRobot,
)
from voz.robot.robot_process import RobotProcess, RobotSpec

TraceFunction: TypeAlias = Callable[[FrameType, str, Any], Any]


class BoxMachine(RuleBasedStateMachine):
    """Whatever comes and goes: the newest velocity is there, and the rest in order."""

    def __init__(self) -> None:
        super().__init__()
        self.box = EventBox()
        self.time = 0.0
        self.newest: Twist | None = None
        self.last: Twist | None = None
        self.others: list[Event] = []
        self.others_taken = 0  # while a velocity waits

    @rule(linear=st.sampled_from([0.0, 0.1, -0.1]))
    def put_velocity(self, linear: float) -> None:
        self.time += 1
        self.newest = Twist(self.time, linear, 0.0)
        self.box.put(self.newest)

    @rule(count=st.sampled_from([1, 2, EVENTS_BEFORE_VELOCITY, MAX_MAILBOX_EVENTS]))
    def put_others(self, count: int) -> None:
        for _ in range(count):
            self.time += 1
            self.others.append(SelectedObject(self.time, 1))
            self.box.put(self.others[-1])
        del self.others[:-MAX_MAILBOX_EVENTS]

    @rule()
    def take_all(self) -> None:
        while self.newest or self.others:
            self.take()

    @rule()
    def take(self) -> None:
        taken = self.box.take()
        if isinstance(taken, Twist):
            assert taken == self.newest
            self.newest, self.last, self.others_taken = None, taken, 0
        elif taken:
            assert taken == self.others.pop(0)
            self.others_taken += self.newest is not None
            assert self.others_taken <= EVENTS_BEFORE_VELOCITY
            assert not (self.newest and stops(self.last, self.newest))
        else:
            assert not self.newest
            assert not self.others

    @invariant()
    def it_is_full_at_the_bound(self) -> None:
        assert self.box.full == (len(self.others) == MAX_MAILBOX_EVENTS)


def stops(last: Twist | None, newest: Twist) -> bool:
    return newest.linear == 0.0 and (last is None or last.linear != 0.0)


TestBox = BoxMachine.TestCase


def order(box: EventBox) -> list[str]:
    """What is taken of it, in this order, each as its time and perhaps its velocity."""
    taken = iter(box.take, None)
    return [f"{e.t:g}: {e.linear:g}" if isinstance(e, Twist) else f"{e.t:g}" for e in taken]


def test_a_velocity_follows_the_command_that_causes_it() -> None:
    box = EventBox()
    for event in (Reply(1, ""), Reply(2, ""), Twist(3, 0.1, 0), Reply(4, "")):
        box.put(event)
    assert order(box) == ["1", "2", "3: 0.1", "4"]


@pytest.mark.parametrize("linear", [0.0, 0.1])
def test_a_robot_that_takes_longer_than_a_beat_gets_its_commands(linear: float) -> None:
    box = EventBox()
    for number in range(3 * EVENTS_BEFORE_VELOCITY):
        box.put(Reply(number, ""))
    taken: list[Event | None] = []
    for number in range(100, 116):
        box.put(Twist(number, linear, 0))
        taken.append(box.take())
    assert [e.t for e in taken if isinstance(e, Reply)] == [*range(3 * EVENTS_BEFORE_VELOCITY)]


class Clock:
    """Time goes on only when a test says so, however long a busy computer takes."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture(autouse=True)
def time_to_close(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a robot close in peace on a busy computer."""
    monkeypatch.setattr(mailbox, "ROBOT_CLOSING_TIME", 30.0)


class Recorder(Robot):
    """Keeps what it gets; what it does with each event may be given."""

    def __init__(self, do: Callable[[Event], None] = lambda _: None) -> None:
        self.got: list[Event] = []
        self.gone: str | None = None
        self.asked = 0  # how often whether it is lost
        self.closed = 0
        self._do = do

    def receive(self, event: Event) -> None:
        self._do(event)
        self.got.append(event)

    def lost(self) -> str | None:
        gone = self.gone
        self.asked += 1
        return gone

    def close(self) -> None:
        self.closed += 1


def until(condition: Callable[[], object], seconds: float = PATIENCE) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.002)


class Blocking(Recorder):
    """A robot that takes nothing until it is freed."""

    def __init__(self) -> None:
        super().__init__(self._wait)
        self.begun, self.free = threading.Event(), threading.Event()

    def _wait(self, _: Event) -> None:
        self.begun.set()
        assert self.free.wait(PATIENCE)

    def __enter__(self) -> Blocking:
        return self

    def __exit__(self, *_: object) -> None:
        self.free.set()


def block_with_velocity(robot: Blocking, box: Mailbox, clock: Clock) -> None:
    """Let a robot take a velocity, and no end of that until it is lost."""
    box.receive(Twist(0, 0.1, 0))
    assert robot.begun.wait(PATIENCE)
    clock.now += EVENT_TIMEOUT
    assert box.lost() is None
    clock.now += 0.01
    assert box.lost() == "the robot slow is lost (does not take its events)"


def test_a_robot_gets_everything_in_order_and_is_closed_after_the_last(
    clock: Clock,
) -> None:
    robot = Recorder()
    with Mailbox("mine", robot, clock) as box:
        for number in range(20):
            box.receive(Reply(number, "yes"))
            until(lambda count=number + 1: len(robot.got) == count)
        box.receive(Twist(20, 0, 0))
        assert not robot.closed
    assert [event.t for event in robot.got] == list(range(21))
    assert robot.closed == 1
    assert not box.hangs
    assert box.lost() is None


def test_a_robot_that_blocks_is_lost_and_gets_the_newest_velocity_when_it_is_free(
    clock: Clock,
) -> None:
    with Blocking() as robot, Mailbox("slow", robot, clock) as box:
        block_with_velocity(robot, box, clock)
        for number in range(1, 1000):
            box.receive(Twist(number, 0, 0))
        robot.free.set()
        until(lambda: len(robot.got) == 2)
        assert [event.t for event in robot.got] == [0, 999]
        until(lambda: not box.lost())


def test_a_robot_that_takes_nothing_has_only_so_much_waiting(clock: Clock) -> None:
    with Blocking() as robot, Mailbox("slow", robot, clock) as box:
        for number in range(3 * MAX_MAILBOX_EVENTS):
            box.receive(Reply(number, ""))
        assert box.lost() == "the robot slow is lost (cannot keep up)"
        robot.free.set()
        until(lambda: not box.lost())
    assert [event.t for event in robot.got][-MAX_MAILBOX_EVENTS:] == [
        *range(2 * MAX_MAILBOX_EVENTS, 3 * MAX_MAILBOX_EVENTS)
    ]


def test_a_slow_robot_has_only_so_much_work_waiting() -> None:
    with Blocking() as robot:
        slow = SlowRobot(robot)
        slow.open()
        for number in range(3 * MAX_MAILBOX_EVENTS):
            slow.receive(Reply(number, ""))
        assert slow.lost() == "cannot keep up"
        robot.free.set()
        until(lambda: slow.lost() is None)
        slow.close()
    assert [event.t for event in robot.got][-MAX_MAILBOX_EVENTS:] == [
        *range(2 * MAX_MAILBOX_EVENTS, 3 * MAX_MAILBOX_EVENTS)
    ]


def test_a_robot_that_hangs_for_ever_does_not_keep_the_run_from_its_end(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(mailbox, "ROBOT_CLOSING_TIME", 0.05)
    with Blocking() as robot:
        with Mailbox("dead", robot) as box:
            box.receive(Twist(0, 0, 0))
        assert box.hangs
        assert not robot.closed


@pytest.mark.parametrize(
    ("error", "told"),
    [(RobotError("the cable is out"), "the cable is out"), (ZeroDivisionError(), "ZeroDivision")],
)
def test_a_robot_that_raises_is_lost_and_still_gets_zero_velocities(
    error: Exception, told: str, clock: Clock
) -> None:
    def do(event: Event) -> None:
        if isinstance(event, SelectedObject):
            raise error

    robot = Recorder(do)
    with Mailbox("mine", robot, clock) as box:
        box.receive(SelectedObject(0, 1))
        until(lambda: told in str(box.lost()))
        box.receive(Reply(1, "not for it any more"))
        box.receive(Twist(2, 0.5, 0.5))
        until(lambda: robot.got)
        box.receive(Twist(3, 0, 0))
    assert robot.got == [Twist(2, 0, 0), Twist(3, 0, 0)]
    assert robot.closed == 1


def test_while_a_robot_is_lost_it_is_asked_to_stand_still(clock: Clock) -> None:
    robot = Recorder()
    robot.gone = "no answer"
    with Mailbox("far", robot, clock) as box:
        assert box.lost() == "the robot far is lost (no answer)"
        box.receive(Twist(0, 0.1, 0))
        until(lambda: len(robot.got) == 1)
        robot.gone = None
        box.receive(Twist(1, 0, 0))
        until(lambda: not box.lost())
        box.receive(Twist(2, 0.1, 0))
    assert robot.got == [Twist(0, 0, 0), Twist(1, 0, 0), Twist(2, 0.1, 0)]


def test_a_robot_that_was_lost_for_a_moment_is_stopped_until_all_know(clock: Clock) -> None:
    robot = Recorder()
    with Mailbox("shaky", robot, clock) as box:
        robot.gone = "a loose cable"
        asked = robot.asked
        box.receive(Reply(0, ""))
        until(lambda: robot.asked > asked)
        robot.gone = None
        for number in (1, 2):
            box.receive(Twist(number, 0.1, 0))
            until(lambda count=number + 1: len(robot.got) == count)
        assert robot.got[1:] == [Twist(1, 0, 0), Twist(2, 0, 0)]
        assert box.lost() == "the robot shaky is lost (a loose cable)"
        assert box.lost() is None
        box.receive(Twist(3, 0.1, 0))
        until(lambda: robot.got[-1] == Twist(3, 0.1, 0))


@contextmanager
def interrupted(function: FunctionType, step: int, meanwhile: Callable[[], None]) -> Iterator[None]:
    """Something happens on other threads before one step of Python of a function."""
    steps = itertools.count()

    def trace(frame: FrameType, event: str, _: object) -> TraceFunction | None:
        if frame.f_code is not function.__code__:
            return None
        frame.f_trace_opcodes = True
        if event == "opcode" and next(steps) == step:
            meanwhile()
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        yield
    finally:
        sys.settrace(before)


STEPS = len([*dis.get_instructions(Mailbox.lost)])


def test_a_loss_of_a_moment_is_told_also_if_it_is_just_asked_for(clock: Clock) -> None:
    class Shaky(Recorder):
        def lost(self) -> str | None:
            super().lost()
            return "a loose cable" if len(self.got) == 1 else None

    for step in range(STEPS):
        robot = Shaky()
        with Mailbox("shaky", robot, clock) as box:
            opened = robot.asked

            def is_lost_for_a_moment(robot: Shaky = robot, box: Mailbox = box) -> None:
                box.receive(Reply(0, ""))
                box.receive(Reply(1, ""))
                with suppress(AssertionError):  # what looks may keep it from going on
                    until(lambda: len(robot.got) == 2, 0.05)

            with interrupted(Mailbox.lost, step, is_lost_for_a_moment):
                told = [box.lost()]
            if robot.asked == opened and not robot.got:
                continue  # there are not so many steps on this way
            until(lambda asked=opened + 2, robot=robot: robot.asked == asked)
            told.append(box.lost())
            assert "the robot shaky is lost (a loose cable)" in told, step


def test_a_velocity_is_late_also_if_the_next_one_has_come() -> None:
    now, still = 0.0, threading.Lock()

    def clock() -> float:
        """While the first velocity is on its way to the robot, the whole process stands still."""
        nonlocal now
        if threading.current_thread() is not threading.main_thread() and still.acquire(False):
            now += EVENT_TIMEOUT + 0.01
            box.receive(Twist(1, 0.1, 0))
        return now

    robot = Recorder()
    with Mailbox("mine", robot, clock) as box:
        box.receive(Twist(0, 0.1, 0))
        until(lambda: len(robot.got) == 2)
    assert robot.got == [Twist(0, 0, 0), Twist(1, 0.1, 0)]


def test_an_exception_in_its_thread_loses_the_robot_which_is_still_stopped(
    begun: Callable[[], list[threading.Thread]], clock: Clock
) -> None:
    robot = Recorder()
    with Mailbox("mine", robot, clock) as box:
        box.receive(Twist(0, 0.1, 0))
        until(lambda: robot.got)
        (thread,) = begun()
        raised = ctypes.py_object(KeyboardInterrupt)
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident or 0), raised)
        box.receive(Reply(1, "which lets the thread notice it"))
        until(box.lost)
        box.receive(Twist(2, 0.1, 0))
        until(lambda: robot.got[-1] == Twist(2, 0, 0))
    assert robot.closed == 1


def test_a_robot_that_returns_no_text_when_asked_at_its_opening_is_closed() -> None:
    robot = Recorder()
    robot.lost = object  # type: ignore[assignment,method-assign]
    told = "the robot mine cannot be used here: TypeError: lost.. returned object; return a text"
    with pytest.raises(RobotError, match=told), Mailbox("mine", robot):
        raise AssertionError
    assert robot.closed == 1


def test_what_a_robot_says_of_its_loss_is_one_line() -> None:
    robot = Recorder()
    robot.gone = "the port caf\udce9\nis\x1b[2J gone"
    with Mailbox("mine", robot) as box:
        assert box.lost() == r"the robot mine is lost (the port caf\udce9 is\x1b[2J gone)"


MODULE = """
import time
from pathlib import Path
from voz.events import SelectedObject, Reply, Twist
from voz.robot.base import Robot

class Arm(Robot):
    slow = True
    def open(self):
        self.log = open("log", "w", buffering=1)
    def receive(self, event):
        if isinstance(event, Twist):
            self.log.write(f"{event.linear}\\n")
        elif isinstance(event, SelectedObject):
            self.log.write("works\\n")
            while not Path("done").exists():
                time.sleep(0.01)
            self.log.write(f"has {event.value}\\n")
        elif isinstance(event, Reply):
            raise OSError(event.text)
    def close(self):
        self.log.write("closed\\n")
        self.log.close()
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "arms.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "arms", raising=False)


def apart() -> Robot:
    return RobotProcess(RobotSpec("arms:Arm"), print)


def here_too() -> Robot:
    return make_user_robot("arms:Arm", {})


@contextmanager
def boxed(robot: Robot) -> Iterator[Mailbox]:
    try:
        with Mailbox("arm", robot) as box:
            yield box
    finally:
        if isinstance(robot, RobotProcess):
            robot.end()


def got() -> list[str]:
    return Path("log").read_text().splitlines()


def drive(box: Mailbox, linear: float) -> None:
    box.receive(Twist(0.0, linear, 0.0))
    time.sleep(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("make", [apart, here_too])
def test_while_it_works_velocities_go_on_and_a_stop_comes(make: Callable[[], Robot]) -> None:
    with boxed(make()) as box:
        box.receive(SelectedObject(0.0, 1))
        wait_until(lambda: "works" in got())
        wait_until(lambda: drive(box, 0.1) or "0.1" in got())
        time.sleep(2 * EVENT_TIMEOUT)
        wait_until(lambda: drive(box, 0.0) or got()[-1] == "0.0")
        wait_until(lambda: drive(box, 0.0) or box.lost() is None)
        assert "has 1" not in got()
        Path("done").touch()
        wait_until(lambda: got()[-1] == "has 1")
    assert got()[-1] == "closed"
    assert not box.hangs


@pytest.mark.parametrize("make", [apart, here_too])
def test_work_comes_one_after_the_other_and_what_waits_is_done_at_the_end(
    make: Callable[[], Robot],
) -> None:
    with boxed(make()) as box:
        for number in (1, 2, 100):
            box.receive(SelectedObject(0.0, number))
        wait_until(lambda: "works" in got())
        Path("done").touch()
    assert [line for line in got() if line != "works"] == ["has 1", "has 2", "has 100", "closed"]


@pytest.mark.realtime
def test_work_that_never_ends_does_not_keep_the_run_from_its_end() -> None:
    with boxed(apart()) as box:
        box.receive(SelectedObject(0.0, 1))
        wait_until(lambda: "works" in got())
        drive(box, 0.0)
    assert not box.hangs
    assert got() == ["works", "0.0", "closed"]


@pytest.mark.parametrize("make", [apart, here_too])
def test_what_its_work_raises_loses_it_and_it_is_stopped(make: Callable[[], Robot]) -> None:
    with boxed(make()) as box:
        drive(box, 0.1)
        box.receive(Reply(0.0, "the gripper is jammed"))
        wait_until(lambda: drive(box, 0.1) or box.lost())
        assert "the gripper is jammed (arms.py, line 20)" in (box.lost() or "")
        drive(box, 0.1)
        wait_until(lambda: got()[-1] == "0.0")


def test_what_its_work_raised_does_not_grow_as_it_is_raised_again_and_again() -> None:
    robot = here_too()
    robot.open()
    with suppress(OSError):  # it may have failed before this returns
        robot.receive(Reply(0.0, "the gripper is jammed"))

    def frames() -> int:
        try:
            robot.receive(Twist(0.0, 0.1, 0.0))
        except OSError as error:
            return len(traceback.extract_tb(error.__traceback__))
        return 0

    wait_until(frames)
    assert len({frames() for _ in range(10)}) == 1
    assert got()[-1] == "0.0"
    robot.close()


def test_too_much_work_loses_it_until_some_is_done() -> None:
    with boxed(here_too()) as box:
        for _ in range(2 * MAX_MAILBOX_EVENTS):
            box.receive(SelectedObject(0.0, 1))
            time.sleep(0.001)
        wait_until(lambda: "cannot keep up" in (box.lost() or ""))
        Path("done").touch()
        wait_until(lambda: got().count("has 1") >= MAX_MAILBOX_EVENTS)
        wait_until(lambda: drive(box, 0.0) or box.lost() is None)
