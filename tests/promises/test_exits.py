"""Each promise at each exit, by a typed command or a spoken one, in a stepped time."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import pytest
from promises.doors import DOORS
from promises.exits import EXITS, Exit
from promises.promises import say
from promises.run import NAME, Do, Given, surely
from ros2_domain import free_domain

from voz.settings import Safety

TYPED = next(door for door in DOORS if door.name == "typed")
SPOKEN = next(door for door in DOORS if door.name == "own microphone")

Must = Callable[[Exit, Sequence[Any]], None]


@dataclasses.dataclass(frozen=True)
class ExitPromise:
    """A promise, and how it is tried at an exit: given, then, must."""

    name: str  # in the table
    says: str  # in words, for people
    # Returns what is done, for the command that comes out there.
    then: Callable[[str], tuple[Do, ...]]
    must: Must  # what must hold then
    given: Given = dataclasses.field(default_factory=Given)  # how the run begins
    spoken: bool = False  # whether the command is spoken; else it is typed
    seconds: float = 5  # how long the run is

    def __str__(self) -> str:
        return self.name


BESIDES = ("stop", "no", "yes", "sure?")
"""What comes out besides the command that is tried."""


def moving(exit_: Exit, got: Sequence[Any]) -> Sequence[Any]:
    """What came out of the command, without velocities that are zero."""
    if exit_.moves:
        return [one for one in got if isinstance(one, tuple) and any(one)]
    return [one for one in got if one not in BESIDES]


def nothing_comes_out(exit_: Exit, got: Sequence[Any]) -> None:
    """Nothing is done, and nothing moves."""
    assert moving(exit_, got) == []


def comes_out(exit_: Exit, got: Sequence[Any]) -> None:
    """It is done once, or moves."""
    assert len(moving(exit_, got)) == 1 if not exit_.moves else moving(exit_, got)


def ends_with_zero(exit_: Exit, got: Sequence[Any]) -> None:
    """It moves, and the last velocity is zero."""
    assert moving(exit_, got)
    assert not any([one for one in got if isinstance(one, tuple)][-1])


def keeps_below(limit: float) -> Must:
    """No velocity is larger, m/s, and that one is reached."""

    def must(_: Exit, got: Sequence[Any]) -> None:
        assert max(abs(one[0]) for one in got if isinstance(one, tuple)) == limit

    return must


PROMISES = (
    ExitPromise("obeyed", "what is obeyed is done, once", lambda it: (say(1, it),), comes_out),
    ExitPromise(
        "not listening",
        "before `start speech` nothing is done",
        lambda it: (say(1, it),),
        nothing_comes_out,
        Given(listening=False),
    ),
    ExitPromise(
        "asleep",
        "what is said without the robot's name is not done",
        lambda it: (say(1, it),),
        nothing_comes_out,
        Given(name=NAME),
        spoken=True,
    ),
    ExitPromise(
        "late",
        "a command begun before a stop is not done",
        lambda it: (say(1, it), Do(1.2, "press space")),
        nothing_comes_out,
        spoken=True,
    ),
    ExitPromise(
        "overtaken",
        "what a `stop` overtakes is not done",
        lambda it: (say(1, it), say(1, "stop")),
        nothing_comes_out,
    ),
    ExitPromise(
        "rehearsal",
        "in a rehearsal nothing is done",
        lambda it: (Do(0.9, "rehearse"), say(1, it)),
        nothing_comes_out,
    ),
    ExitPromise(
        "reload",
        "while new commands are taken nothing is done",
        lambda it: (Do(0.9, "save the list"), say(1, it), Do(2, "use the list")),
        nothing_comes_out,
    ),
    ExitPromise(
        "confirm declined",
        "what asks first is not done without a yes",
        lambda it: (say(1, surely(it)), say(2, "no"), say(3, "yes"), say(4, surely(it))),
        nothing_comes_out,
    ),
    ExitPromise(
        "confirm",
        "what asks first is done after a yes, once",
        lambda it: (say(1, surely(it)), say(2, "yes"), say(3, "yes")),
        comes_out,
    ),
    ExitPromise(
        "limits",
        "velocities stay within their limits",
        lambda it: (say(1, it), say(2, "speed up"), say(3, "speed up")),
        keeps_below(0.15),
        Given(safety=Safety(max_linear=0.15)),
    ),
    ExitPromise(
        "loss",
        "a loss ends the motion",
        lambda it: (say(1, it), Do(2, "lose the robot")),
        ends_with_zero,
    ),
    ExitPromise("zero last", "zero is the last velocity", lambda it: (say(1, it),), ends_with_zero),
    ExitPromise(
        "zero last of an error",
        "zero is the last velocity, whatever another receiver raises",
        lambda it: (say(1, it),),
        ends_with_zero,
        Given(raises=True),
    ),
)

KEPT = [(e, p) for e in EXITS for p in PROMISES if p.name not in e.cannot]


@pytest.fixture(scope="module", autouse=True)
def domain() -> Iterator[None]:
    """A ROS 2 domain of its own."""
    with free_domain() as number, pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", str(number))
        patch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        yield


@contextmanager
def opened(exit_: Exit) -> Iterator[Any]:
    """Open an exit; one that cannot be had on this computer is told in the report."""
    if exit_.name == "ros2":
        pytest.importorskip("cyclonedds", reason="no wheels for this processor")
    with exit_.open() as out:
        yield out


@pytest.mark.parametrize(("exit_", "promise"), KEPT, ids=str)
def test_a_promise_is_kept_at_an_exit(exit_: Exit, promise: ExitPromise) -> None:
    door = SPOKEN if promise.spoken else TYPED
    with opened(exit_) as (receivers, acts):
        given = dataclasses.replace(promise.given, exits=receivers)
        outcome = door.run(given, promise.then(exit_.text), promise.seconds)
        promise.must(exit_, acts(outcome))


def test_no_cell_is_empty() -> None:
    names = {promise.name for promise in PROMISES}
    assert all(exit_.cannot.keys() <= names for exit_ in EXITS)
    assert os.environ["ROS_DOMAIN_ID"]
