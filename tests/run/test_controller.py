"""A robot that is driven by messages, or by utterances of one's own."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from functools import partial

import pytest
from msgspec.structs import replace
from programs import wait_until

import voz
from voz.config import Config
from voz.control.messages import Beat, ControllerMessage, Halt, StopMotion
from voz.control.motion import Place
from voz.control.steps import Step
from voz.errors import ConfigError, RobotError
from voz.events import Event, Notice, Partial, Receiver, SelectedObject, Twist, Utterance
from voz.run.controller import Controller
from voz.run.parts import take_utterances
from voz.run.session import Session
from voz.settings import Safety


def heard(text: str, accepted: bool = True, now: float = 0) -> Utterance:
    return Utterance(now, text, 0.9, accepted, now, now, "microphone")


def by_receivers(*receivers: Receiver, **commands: Step) -> Controller:
    """A controller of functions that listens, and knows these commands too."""
    table = Config(commands={name.replace("_", " "): step for name, step in commands.items()}).table
    return Controller(receivers, Safety(motion_time_limit=9), listening=True, table=table)


def test_everything_reaches_every_receiver_in_order() -> None:
    first: list[Event] = []
    second: list[Event] = []
    controller = by_receivers(first.append, second.append)
    controller.take(heard("point beer"), 0.05)
    controller.take(Beat(), 0.1)
    controller.zero(0.2)
    assert first == second
    assert first[1:] == [SelectedObject(0, 1), Twist(0.1, 0, 0), Twist(0.2, 0, 0)]


@pytest.mark.parametrize("now", [math.nan, math.inf, -math.inf, "3"])
def test_a_time_that_is_no_number_is_refused_and_ends_no_limit(now: float) -> None:
    events: list[Event] = []
    controller = by_receivers(events.append, come_here=Step(drive=0.1, metres=0.2))
    controller.take(heard("come here", now=1), 1)
    for take_time in (partial(controller.take, Beat()), controller.zero):
        with pytest.raises(ConfigError):
            take_time(now)
    controller.take(Beat(), 2.9)
    assert controller.velocities == (0.1, 0)
    controller.take(Beat(), 3.0)
    assert events[-1] == Twist(3.0, 0, 0)


@pytest.mark.parametrize("stop", [StopMotion("a key"), Halt("a key"), Halt("a key", math.nan)])
def test_a_stop_at_no_time_stops_all_the_same(stop: ControllerMessage) -> None:
    events: list[Event] = []
    controller = by_receivers(events.append)
    controller.take(heard("go forward"), 0)
    with pytest.raises(ConfigError, match="the time of the run is nan; give seconds"):
        controller.take(stop, math.nan)
    controller.take(Beat(), 0.1)
    assert events[-1] == Twist(0.1, 0, 0)
    controller.take(StopMotion("lost"), 5.0)
    controller.take(heard("go forward", now=4), 5.0)  # said before
    assert controller.velocities == (0, 0)


def test_a_run_lasts_no_longer_than_a_time_can_be_written() -> None:
    events: list[Event] = []
    controller = by_receivers(events.append)
    controller.take(Beat(), 1e12)
    assert events == [Twist(1e12, 0, 0)]
    with pytest.raises(ConfigError, match="the time of the run is 11"):
        controller.take(Beat(), 1.1e12)


def test_what_one_receiver_raises_keeps_nothing_from_the_others_and_is_raised_then() -> None:
    events: list[Event] = []
    errors = [BrokenPipeError("first"), SystemExit("second")]

    def fail(_: Event) -> None:
        raise errors[min(len(events), 1)]

    controller = by_receivers(fail, events.append, fail)
    with pytest.raises(BrokenPipeError, match="first"):
        controller.zero(1.0)
    assert events == [Twist(1.0, 0, 0)]


def test_in_another_process_than_its_own_it_sends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    events: list[Event] = []
    controller = by_receivers(events.append)
    assert not controller.is_forked
    monkeypatch.setattr("os.getpid", lambda: -1)
    with pytest.raises(RobotError, match="a forked process does not drive"):
        controller.zero(1.0)
    assert events == []


def test_odometry_is_asked_for_the_time_of_what_was_said_and_of_the_beat() -> None:
    asked: list[float] = []

    def odometry(t: float) -> Place | None:
        asked.append(t)
        return None

    controller = by_receivers()
    controller.odometry = odometry
    controller.take(Partial(0.1, "stop", 0.9), 0.15)  # it stands
    controller.take(heard("go back", accepted=False, now=0.2), 0.25)
    controller.take(heard("go back", now=0.3), 0.35)
    controller.take(Partial(0.4, "go back", 0.9), 0.45)
    controller.take(Beat(), 0.5)
    controller.take(StopMotion("lost"), 0.6)
    assert asked == [0.3, 0.4, 0.5]


@pytest.mark.parametrize("message", [heard("stop"), Partial(0, "stop", 0.9), Beat()])
def test_a_mistake_in_the_odometry_stops_the_robot(message: ControllerMessage) -> None:
    def fail(_: float) -> Place | None:
        raise ValueError("no odometry")

    controller = by_receivers()
    controller.take(heard("go forward"), 0)
    controller.odometry = fail
    with pytest.raises(ValueError, match="no odometry"):
        controller.take(message, 0.1)
    assert not controller.moving


class Wheels(voz.Robot):
    """Keeps what it was asked to do."""

    def __init__(self) -> None:
        self.velocities: list[tuple[float, float]] = []
        self.commands: list[str] = []
        self.is_open = False

    def open(self) -> None:
        self.is_open = True

    def move(self, linear: float, angular: float) -> None:
        self.velocities.append((linear, angular))

    def command(self, name: str, slots: object) -> None:
        self.commands.append(name)

    def close(self) -> None:
        self.is_open = False


def said(*texts: str, to: Wheels | None = None) -> Iterator[voz.Utterance]:
    """Commands; the next comes, or none more, when a robot drives otherwise, or after 0.3 s."""
    for number, text in enumerate(texts):
        before = {(0.0, 0.0), *to.velocities} if to else set()
        yield voz.Utterance(number, text, 1.0, True, number, number, "test")
        if to:
            wait_until(partial(drives_otherwise, to, before))
        else:
            time.sleep(0.3)


def drives_otherwise(robot: Wheels, before: set[tuple[float, float]]) -> bool:
    return not before.issuperset(robot.velocities)


def test_utterances_drive_a_robot_and_it_stands_when_they_end() -> None:
    robot = Wheels()
    with voz.Controller(robot, listening=True) as controller:
        assert robot.is_open
        controller.run(said("go forward", to=robot))
    assert (0.1, 0.0) in robot.velocities
    assert robot.commands == ["go forward"]
    assert robot.velocities[-1] == (0.0, 0.0)
    assert not robot.is_open


def test_a_robot_has_one_controller_at_a_time() -> None:
    robot = Wheels()
    with voz.Controller(robot, listening=True) as first:
        with pytest.raises(voz.RobotError, match="another controller drives this robot already"):
            voz.Controller(robot, listening=True).__enter__()
        assert robot.is_open
        with voz.Controller(Wheels()):
            first.run(said("go forward", to=robot))
    assert (0.1, 0.0) in robot.velocities
    with voz.Controller(robot, listening=True) as second:
        second.run(said("go back", to=robot))
    assert (-0.1, 0.0) in robot.velocities


def test_commands_do_what_the_program_says() -> None:
    robot = Wheels()
    commands = {"fly": {"drive": 0.15}, "go back": {"rotate": 0.5}}
    with voz.Controller(robot, listening=True, commands=commands) as controller:
        controller.run(said("fly", "go back", to=robot))
    moved = [velocity for velocity in dict.fromkeys(robot.velocities) if velocity != (0.0, 0.0)]
    assert moved == [(0.15, 0.0), (0.0, 0.5)]


@pytest.mark.parametrize(
    "error", [ValueError, asyncio.CancelledError, SystemExit, KeyboardInterrupt, GeneratorExit]
)
def test_whatever_ends_the_utterances_stops_the_robot_and_is_raised(
    error: type[BaseException],
) -> None:
    def ending() -> Iterator[voz.Utterance]:
        yield from said("go forward", to=robot)
        raise error

    robot = Wheels()
    with voz.Controller(robot, listening=True) as controller, pytest.raises(error):
        controller.run(ending())
    assert (0.1, 0.0) in robot.velocities
    assert robot.velocities[-1] == (0.0, 0.0)


def fail_while_moving(controller: voz.Controller) -> None:
    controller.hear(next(said("go forward")))
    controller.send(0.1)
    raise ValueError("mine")


def test_an_error_in_the_block_stops_the_robot() -> None:
    robot = Wheels()
    with (
        pytest.raises(ValueError, match="mine"),
        voz.Controller(robot, listening=True) as controller,
    ):
        fail_while_moving(controller)
    assert robot.velocities[-1] == (0.0, 0.0)


def test_what_cannot_be_is_one_line() -> None:
    with pytest.raises(voz.ConfigError, match="is not open; use `with"):
        voz.Controller(Wheels()).run([])
    with pytest.raises(voz.ConfigError, match="commands: "):
        voz.Controller(Wheels(), commands={"fly": {"no_such_step": 1}})
    with pytest.raises(voz.ConfigError):
        voz.Controller(Wheels(), commands={"stop": {"drive": 0.1}})


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Controller([1]),  # type: ignore[list-item]
        lambda: Controller([], safety=1),  # type: ignore[arg-type]
        lambda: Controller([], table=1),  # type: ignore[arg-type]
        lambda: Controller([], odometry=1),  # type: ignore[arg-type]
        lambda: Controller([], listening=1),  # type: ignore[arg-type]
        lambda: Controller([]).hear(1),  # type: ignore[arg-type]
        lambda: Controller([]).hear(heard("stop"), late=1),  # type: ignore[arg-type]
        lambda: Controller([]).send("1"),  # type: ignore[arg-type]
        lambda: Controller([]).run(1),  # type: ignore[arg-type]
    ],
)
def test_an_argument_of_another_type_is_an_error_of_voz(wrong: Callable[[], object]) -> None:
    with pytest.raises(ConfigError, match=r"^(Expected .*, got `int` - at|the time of the run is)"):
        wrong()


def test_a_loop_of_ones_own_hears_sends_and_stops() -> None:
    events: list[Event] = []
    with Controller([events.append], listening=True) as controller:
        controller.hear(heard("go forward", now=0.2), late=True)
        controller.send(0.3)
        controller.hear(heard("go forward", now=0.4))
        controller.send(0.5)
        controller.stop(0.6, "a wall")
        controller.send(0.7)
        controller.hear(heard("go back", now=0.8))
        with pytest.raises(ConfigError):
            controller.send(math.nan)
    sent = [event for event in events if isinstance(event, Twist)]
    assert sent == [Twist(0.3, 0, 0), Twist(0.5, 0.1, 0), Twist(0.7, 0, 0), Twist(0.7, 0, 0)]
    assert [event.text for event in events if isinstance(event, Notice)] == ["a wall"]
    assert not controller.moving


def test_zero_goes_out_last_at_the_time_that_was_reached() -> None:
    events: list[Event] = []
    with Controller([events.append], listening=True) as controller:
        pass
    assert events == [Twist(0, 0, 0)]
    with controller:
        controller.run(said("go forward"))
    assert events[-1].t >= 0.3
    assert events[-1] == Twist(events[-1].t, 0, 0)


def test_after_the_block_the_robot_is_not_open() -> None:
    with Controller(Wheels()) as controller:
        pass
    with pytest.raises(ConfigError, match="is not open"):
        controller.run([])


def test_a_robot_knows_where_it_is_and_that_it_is_lost() -> None:
    class Cable(Wheels):
        def place(self, t: float) -> Place | None:
            asked.append(t)
            return None

        def lost(self) -> str | None:
            return "its cable is out" if (0.1, 0.0) in self.velocities else None

    def until_told() -> Iterator[voz.Utterance]:
        yield from said("go forward")
        wait_until(lambda: any(isinstance(event, Notice) for event in events))

    asked: list[float] = []
    events: list[Event] = []
    with Controller(Cable(), listening=True) as controller:
        controller.receivers.append(events.append)
        controller.run(until_told())
    told = [event.text for event in events if isinstance(event, Notice)]
    assert told == ["the robot robot is lost (its cable is out): the robot stops"]
    assert asked


def test_a_forked_process_leaves_the_robot_to_the_one_that_it_comes_from(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    robot = Wheels()
    controller = Controller(robot)
    with controller:
        monkeypatch.setattr("os.getpid", lambda: -1)
    assert robot.is_open
    assert robot.velocities == []


class Microphone:
    """Hears texts, after the robot's name, and nothing more."""

    def __init__(self, recognizer: voz.Recognizer, *texts: str, to: Wheels | None = None) -> None:
        self.recognizer = recognizer
        self.is_closed = False
        self._texts = texts
        self._robot = to

    def __iter__(self) -> Iterator[voz.Utterance]:
        return (replace(each, named=True) for each in said(*self._texts, to=self._robot))

    def close(self) -> None:
        self.is_closed = True

    def drive_session(self, session: Session) -> AbstractContextManager[None]:
        assert self.is_closed  # nobody else listens
        return take_utterances(session, self)


def test_a_microphone_brings_the_list_and_what_the_robot_is_called() -> None:
    recognizer = voz.load(["fly", "stop"], settings=voz.Recognition(name="hey robot", ask="always"))
    robot = Wheels()
    commands = {"FLY": {"drive": 0.15}}
    with voz.Controller(robot, listening=True, commands=commands) as controller:
        controller.run(Microphone(recognizer, "fly", to=robot))
        assert controller.name == "hey robot"
        assert controller.state.rules.ask == "always"
    assert (0.15, 0.0) in robot.velocities


def test_a_list_that_cannot_begin_or_stop_is_one_line() -> None:
    told = 'no command begins the listening; add "start speech" to the list, or give listening=True'
    recognizer = voz.load(["go forward", "stop"])
    with voz.Controller(Wheels()) as controller, pytest.raises(voz.ConfigError, match=told):
        controller.run(Microphone(recognizer))
    with (
        voz.Controller(Wheels(), listening=True) as controller,
        pytest.raises(voz.ConfigError, match="the list"),
    ):
        controller.run(Microphone(voz.load(["go forward"])))
