"""Messages to all receivers, and what is refused on the way; with time as an argument."""

from __future__ import annotations

import math
from functools import partial

import pytest

import voz
from voz.config import Config, default_commands
from voz.control.bounded_motion import Place
from voz.control.controller import ControllerState, Rules
from voz.control.messages import Beat, ControllerMessage, Halt, StopMotion
from voz.control.state_machine import State
from voz.control.steps import Step
from voz.errors import ConfigError, RobotError
from voz.events import Event, Partial, Receiver, SelectedObject, Twist, Utterance
from voz.run.dispatcher import Dispatcher
from voz.settings import Safety


def heard(text: str, accepted: bool = True, now: float = 0) -> Utterance:
    return Utterance(now, text, 0.9, accepted, now, now, "microphone")


def dispatcher(*receivers: Receiver, config: Config | None = None) -> Dispatcher:
    table = config.table if config else default_commands()
    rules = Rules(table, Safety(motion_time_limit=9))
    return Dispatcher(ControllerState(rules, State(listening=True)), receivers)


def test_everything_reaches_every_receiver_in_order() -> None:
    first: list[Event] = []
    second: list[Event] = []
    controller = dispatcher(first.append, second.append)
    controller.take(heard("point beer"), 0.05)
    controller.take(Beat(), 0.1)
    controller.zero(0.2)
    assert first == second
    assert first[1:] == [SelectedObject(0, 1), Twist(0.1, 0, 0), Twist(0.2, 0, 0)]


@pytest.mark.parametrize("now", [math.nan, math.inf, -math.inf, "3"])
def test_a_time_that_is_no_number_is_refused_and_ends_no_limit(now: float) -> None:
    events: list[Event] = []
    config = Config(commands={"come here": Step(drive=0.1, metres=0.2)})
    controller = dispatcher(events.append, config=config)
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
    controller = dispatcher(events.append)
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
    controller = dispatcher(events.append)
    controller.take(Beat(), 1e12)
    assert events == [Twist(1e12, 0, 0)]
    with pytest.raises(ConfigError, match="the time of the run is 11"):
        controller.take(Beat(), 1.1e12)


@pytest.mark.parametrize(
    "arguments", [("safe",), (Safety(), 1), (Safety(), True, {"stop": Step(stop=True)})]
)
def test_what_is_no_setting_is_refused(arguments: tuple[object, ...]) -> None:
    with pytest.raises(ConfigError, match="Expected"):
        voz.Controller([], *arguments)  # type: ignore[arg-type]


def test_what_one_receiver_raises_keeps_nothing_from_the_others_and_is_raised_then() -> None:
    events: list[Event] = []
    errors = [BrokenPipeError("first"), SystemExit("second")]

    def fail(_: Event) -> None:
        raise errors[min(len(events), 1)]

    controller = dispatcher(fail, events.append, fail)
    with pytest.raises(BrokenPipeError, match="first"):
        controller.zero(1.0)
    assert events == [Twist(1.0, 0, 0)]


def test_in_another_process_than_its_own_it_sends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    events: list[Event] = []
    controller = dispatcher(events.append)
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

    controller = dispatcher()
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

    controller = dispatcher()
    controller.take(heard("go forward"), 0)
    controller.odometry = fail
    with pytest.raises(ValueError, match="no odometry"):
        controller.take(message, 0.1)
    assert not controller.moving
