"""What voz promises of each door: given, then, must."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass, field

from promises.run import NAME, Do, Door, Given, Outcome
from promises.sound import UNSURE
from rich.console import Console

from voz.robot.console import ConsoleRobot
from voz.settings import Safety
from voz.terminal.display import Display

Must = Callable[[Outcome, Door], None]

BEAT = 0.12
"""A beat and two steps, s."""

METERS = 0.25
"""No further than this it comes until it stands, at 0.5 m/s."""

EVIL = "go \x1b[31mforward\x07 \x9b2J <b>\u202e"
"""What would change a terminal or a page if it was shown as it is."""


@dataclass(frozen=True)
class Promise:
    """A promise, and how it is tried at a door."""

    name: str  # in the table
    says: str  # in words, for people
    then: tuple[Do, ...]  # what is done
    must: tuple[Must, ...]  # what must hold then
    given: Given = field(default_factory=Given)  # how the run begins
    seconds: float = 8.0  # how long the run is


def say(at: float, text: str) -> Do:
    """Give a sentence by the door, at a time, s."""
    return Do(at, "say", text)


def moves(begin: float, end: float) -> Must:
    """It moves between two times, by a command given at the first."""

    def must(outcome: Outcome, _: Door) -> None:
        assert outcome.moving(begin, end), "it does not move"

    return must


def moves_if_it_needs_no_name(outcome: Outcome, door: Door) -> None:
    """It stands if its name has to be said, else it moves."""
    if door.needs_name:
        never_moves(outcome, door)
    else:
        assert outcome.moving(1), "it does not move"


def moves_again(begin: float, end: float) -> Must:
    """It moves between two times; a run that a loss ends has zero as its last velocity."""

    def must(outcome: Outcome, door: Door) -> None:
        (ends_with_zero if outcome.error else moves(begin, end))(outcome, door)

    return must


def stands(since: float, reach: bool = True, until: float = float("inf")) -> Must:
    """It stands from a time on, s: at once, or as soon as a command that is given then is heard."""

    def must(outcome: Outcome, door: Door) -> None:
        begin = since + (door.reach if reach else BEAT)
        wrong = outcome.moving(begin, until)
        assert not wrong, f"it moves at {wrong[0].t:g} s"

    return must


def never_moves(outcome: Outcome, _: Door) -> None:
    """It stands from the beginning to the end."""
    stands(0, reach=False)(outcome, _)


def obeys(*names: str) -> Must:
    """These commands take effect, and no others."""

    def must(outcome: Outcome, _: Door) -> None:
        assert outcome.obeyed == [*names]

    return must


def ends_with_zero(outcome: Outcome, _: Door) -> None:
    """The last velocity is zero, though it moved before."""
    assert outcome.moving(0), "it does not move"
    last = outcome.twists[-1]
    assert (last.linear, last.angular) == (0, 0)


def ends_if_unwatched(outcome: Outcome, door: Door) -> None:
    """It stands 5 s after the command if nobody watches it, else it goes on."""
    if not door.watched:
        stands(6 + BEAT, reach=False)(outcome, door)
        assert any("nobody there" in text for text in outcome.warnings)
    else:
        assert outcome.moving(8, 10), "it does not go on"


def keeps_below(limit: float) -> Must:
    """No velocity is larger, m/s, and that one is reached."""

    def must(outcome: Outcome, _: Door) -> None:
        assert max(abs(t.linear) for t in outcome.twists) == limit

    return must


def is_shown_escaped(outcome: Outcome, _: Door) -> None:
    """Console and panel show no control character of it."""
    console, stream = io.StringIO(), io.StringIO()
    robot = ConsoleRobot(console)
    display = Display(Sound(), Sound(), lambda: "")
    for event in outcome.events:
        robot.receive(event)
        display.receive(event)
    Console(file=stream, width=300, force_terminal=False).print(display)
    for shown in (console.getvalue(), stream.getvalue()):
        assert "forward" in shown
        assert all(c.isprintable() or c == "\n" for c in shown), repr(shown)


class Sound:
    """What a display shows of a microphone."""

    device, name = "none", ""
    peak = background = 0.0
    listening = awake = True
    speaking = False


PROMISES = (
    Promise(
        "stop",
        "`stop` stops the robot at once, and nothing that was said before moves it again",
        (say(1, "go forward"), say(4.5, "stop")),
        (moves(1, 4.5), stands(4.5)),
    ),
    Promise(
        "stop repeated",
        '"stop stop stop" stops it',
        (say(1, "go forward"), say(4.5, "stop stop stop")),
        (moves(1, 4.5), stands(4.5)),
    ),
    Promise(
        "stop, please",
        '"please stop" stops it',
        (say(1, "go forward"), say(4.5, "please stop")),
        (moves(1, 4.5), stands(4.5)),
    ),
    Promise(
        "stop with the name",
        '"hey robot, stop" stops it',
        (say(1, f"{NAME} go forward"), say(4, "go forward"), say(7, f"{NAME} stop")),
        (moves(1, 7), stands(7)),
        Given(name=NAME),
        11,
    ),
    Promise(
        "stop in a flood",
        "it stops as soon amid hundreds of texts at once",
        (say(1, "go forward"), Do(4.5, "flood"), say(4.5, "stop"), Do(4.5, "flood")),
        (moves(1, 4.5), stands(4.5)),
    ),
    Promise(
        "stop speech",
        "what ends the listening stops it, and nothing moves it then",
        (say(1, "go forward"), say(4.5, "stop speech"), say(7.5, "go back")),
        (moves(1, 4.5), stands(4.5)),
        seconds=11,
    ),
    Promise(
        "not listening",
        "before `start speech` nothing moves it",
        (say(1, "go forward"), say(4, "start speech"), say(7, "go back")),
        (stands(0, until=7), moves(7, 11), obeys("start speech", "go back")),
        Given(listening=False),
        11,
    ),
    Promise(
        "asleep",
        "a command without its name moves nothing; one that is typed, tapped or said with a "
        "button held needs none",
        (say(1, "go forward"), say(4.5, "go back")),
        (moves_if_it_needs_no_name,),
        Given(name=NAME),
    ),
    Promise(
        "stop asleep",
        "a robot that fell asleep in motion is stopped without its name",
        (say(1, f"{NAME} go forward"), say(4, "go forward"), say(16, "stop")),
        (moves(4, 8), stands(16)),
        Given(name=NAME),
        20,
    ),
    Promise(
        "name",
        "its name and a command move it, whoever says them",
        (say(1, f"{NAME} go forward"),),
        (moves(1, 5),),
        Given(name=NAME),
    ),
    Promise(
        "confirm",
        "a command that asks first is done only after a yes, whatever does it",
        (
            say(1, "make coffee"),
            say(4, "no"),
            say(7, "fly away"),
            say(10, "stop"),
            say(13, "make coffee"),
            say(16, "yes"),
        ),
        (never_moves, obeys("no", "stop", "make coffee")),
        seconds=20,
    ),
    Promise(
        "question",
        "a command that is nearly sure moves it after a yes",
        (say(1, UNSURE), say(5, "yes")),
        (stands(0, until=5), moves(5, 9)),
        Given(ask="always"),
        9,
    ),
    Promise(
        "question declined",
        "after a no, or without an answer in time, it does not",
        (say(1, UNSURE), say(5, "no"), say(8, "yes")),
        (never_moves, obeys("no")),
        Given(ask="always"),
        12,
    ),
    Promise(
        "late",
        "a command begun before a stop, and understood after it, moves nothing",
        (say(1, "go forward"), Do(1.4, "press space")),
        (stands(1.4, reach=False),),
    ),
    Promise(
        "overtaken",
        "a `stop` overtakes what waits",
        (say(1, "go forward"), say(1, "stop")),
        (never_moves,),
        seconds=5,
    ),
    Promise(
        "rehearsal",
        "in a rehearsal only what stops is obeyed",
        (
            Do(0.9, "rehearse"),
            say(1, "go forward"),
            say(4, "stop"),
            Do(7, "rehearsed"),
            say(7.5, "go back"),
        ),
        (stands(0, until=7), moves(7, 11), obeys("stop", "go back")),
        seconds=11,
    ),
    Promise(
        "reload",
        "while new commands are taken it stands, only what stops is obeyed, and what was said "
        "meanwhile moves nothing",
        (
            say(1, "go forward"),
            Do(4.5, "save the list"),
            say(5, "go back"),
            say(8, "stop"),
            Do(11, "use the list"),
            say(12, "go back"),
        ),
        (
            moves(1, 4.5),
            stands(4.5, reach=False, until=12),
            moves(12, 16),
            obeys("go forward", "stop", "go back"),
        ),
        seconds=16,
    ),
    Promise(
        "loss",
        "a loss where commands come from ends the motion within half a second; what is said "
        "meanwhile moves nothing, and a new command is needed when it is back",
        (
            say(1, "go forward"),
            Do(4.5, "lose"),
            say(5.5, "go forward"),
            Do(9, "find"),
            say(13, "go back"),
        ),
        (moves(1, 4.5), stands(5, reach=False, until=13), moves_again(13, 17)),
        seconds=17,
    ),
    Promise(
        "loss without safety",
        "neither `--no-safety` nor any setting switches that off",
        (say(1, "go forward"), Do(4.5, "lose"), say(5.5, "go forward")),
        (moves(1, 4.5), stands(5, reach=False)),
        Given(safety=Safety(enabled=False)),
        9,
    ),
    Promise(
        "robot lost",
        "a robot that cannot be reached is asked to stand, and needs a new command",
        (
            say(1, "go forward"),
            Do(4.5, "lose the robot"),
            Do(6, "find the robot"),
            say(9, "go back"),
        ),
        (moves(1, 4.5), stands(4.9, reach=False, until=9), moves(9, 13)),
        seconds=13,
    ),
    Promise(
        "stall",
        "a process that was held up does not drive on",
        (say(1, "go forward"), Do(4.5, "stall"), say(7, "go back")),
        (moves(1, 4.5), stands(5.5, reach=False, until=7), moves(7, 11)),
        seconds=11,
    ),
    Promise(
        "unwatched",
        "a motion that nobody watches ends after 5 s, others go on",
        (say(1, "go forward"),),
        (moves(1, 5.5), ends_if_unwatched),
        seconds=10,
    ),
    Promise(
        "limits",
        "velocities stay within their limits",
        (say(1, "go forward"), say(4, "speed up"), say(7, "speed up"), say(10, "speed up")),
        (keeps_below(0.15),),
        Given(safety=Safety(max_linear=0.15)),
        13,
    ),
    Promise(
        "zero last",
        "zero is the last velocity, when a run ends",
        (say(1, "go forward"),),
        (ends_with_zero,),
        seconds=5,
    ),
    Promise(
        "zero last of an error",
        "zero reaches every receiver last, whatever one of them raises",
        (say(1, "go forward"),),
        (ends_with_zero,),
        Given(raises=True),
        5,
    ),
    Promise(
        "escaped",
        "what comes from outside is shown without its control characters",
        (say(1, EVIL),),
        (never_moves, is_shown_escaped),
        seconds=3,
    ),
)
