"""All ways by which a command comes in."""

from __future__ import annotations

import dataclasses
import queue
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

from driving import robots_part
from promises.fake_time import BEGIN, SteppedInbox, Timeline, fake_time
from promises.live import FLOOD, NONSENSE, Live
from promises.page import Browser
from promises.promises import PROMISES
from promises.run import COMMANDS, LIST, ROS2_SOURCE, Do, Door, Given, Outcome, recognizer_for
from promises.sound import BLOCK, BLOCK_SECONDS, WORKED, Room, speech

import voz
from voz.api.recognizer import SettledUtterances, in_background
from voz.audio import SAMPLE_RATE
from voz.control.messages import End
from voz.events import Utterance
from voz.language.sentences.command_set import plain_commands
from voz.run.clocks import BEATS_PER_SECOND, Source
from voz.run.controller import controller_by
from voz.run.parts import by_items
from voz.run.session import Session
from voz.run.sources import BagContent, BagSentence, TextCommands, bag_items, typed_items
from voz.run.spec import RunSpec
from voz.terminal.keyboard import TypedLine

SPEAKING = 2.5
"""A sentence takes this time from its first sound until it takes effect, s."""

AT_ONCE = 0.25
"""The same of a text: some steps, and the beat."""

LOSSES = ("loss", "loss without safety")
ASKS_NOTHING = "asks nothing: `controller.run(recognizer.microphone())` does"
NO_CLOCK = "a recording has its own time: nothing can be lost in it, and no beat is late"
ONLY_TEXT = "text is never unsure"
NEEDS_NO_NAME = "text needs no name: who types or taps means this robot"


@dataclass(frozen=True)
class LiveDoor:
    """A door of a live run."""

    name: str
    say: Callable[[Live, str], None]  # gives a sentence
    open: Callable[[Live], None] = lambda _: None  # is called when the run has begun
    microphone: bool = False  # whether the robot's own listens
    browser_listens: bool = False  # whether the page's does
    spoken: bool = False
    needs_name: bool = False
    reach: float = AT_ONCE
    watched: bool = True
    loses: str = ""  # what is lost where this door is, as `Live` names it
    cannot: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.name

    def run(self, given: Given, script: Sequence[Do], seconds: float) -> Outcome:
        """Do what the script says in a live run."""
        live = Live(given, microphone=self.microphone, browser_listens=self.browser_listens)
        live.run(self.open, self.say, [self._here(do) for do in script], seconds)
        return live.outcome

    def _here(self, do: Do) -> Do:
        """What a loss is at this door."""
        lost = do.what in ("lose", "find")
        return dataclasses.replace(do, what=f"{do.what} {self.loses}") if lost else do


def _speak(live: Live, text: str) -> None:
    assert live.microphone
    live.microphone.room.say(text)


def _drive(live: Live) -> None:
    live.browser = Browser(live.server, live.timeline)
    live.timeline.at(0.2, live.browser.drive)


def _browser(live: Live) -> Browser:
    assert live.browser
    return live.browser


def _drive_hands_free(live: Live) -> None:
    _drive(live)
    live.timeline.at(0.4, lambda: _browser(live).begin_to_talk(held=False))


def _speak_on_page(live: Live, text: str) -> None:
    _browser(live).room.say(text)


def _hold_and_speak(live: Live, text: str) -> None:
    browser = _browser(live)
    browser.begin_to_talk(held=True)
    browser.room.say(text)
    seconds = len(speech(text)) / SAMPLE_RATE + 0.3
    live.timeline.at(live.timeline.now - BEGIN + seconds, browser.end_to_talk)


def _tap(by_socket: bool) -> Callable[[Live, str], None]:
    def tap(live: Live, text: str) -> None:
        browser = _browser(live)
        browser.stop(by_socket) if text == "stop" else browser.tap(text)

    return tap


def _post(live: Live, text: str) -> None:
    live.server.post("/api/command", {"text": text})


def _type(live: Live, text: str) -> None:
    line = TypedLine(live.continues)
    for key in f"{text}\n":
        done = line.press(key, live.timeline.now)
        if isinstance(done, str):
            live.take_text(done, "text")
        elif done is not None:
            live.inbox.put(done)


def _from_wyoming(live: Live, text: str) -> None:
    assert live.service
    live.server.start(live.service.give(text))


def _from_ros(live: Live, text: str) -> None:
    live.take_text(text, ROS2_SOURCE)


class Bag:
    """The replay of a bag: what was said then, at its times."""

    name = "bag replay"
    spoken = needs_name = False
    reach = AT_ONCE
    watched = True

    def __init__(self, cannot: dict[str, str]) -> None:
        self.cannot = cannot

    def run(self, given: Given, script: Sequence[Do], seconds: float) -> Outcome:
        """Replay what the script says."""
        said = [BagSentence(do.at, do.text) for do in script if do.what == "say"]
        source = lambda _: bag_items(  # noqa: E731
            Path("a.bag"), BagContent(said, float(seconds)), plain_commands(LIST), given.table.halts
        )
        return self._run(given, source)

    def _run(self, given: Given, source: Source) -> Outcome:
        outcome = Outcome()
        robots = robots_part(*given.receivers(outcome))
        controller = controller_by(given.settings, given.listening)
        spec = RunSpec(controller=controller, settings=given.settings, outputs=[robots])
        try:
            Session(by_items(spec, source, in_real_time=False)).run()
        except BrokenPipeError as error:
            outcome.error = error
        return outcome


class Lines(Bag):
    """The lines of a text, or of a pipe: one a beat."""

    name = "lines of a text"

    def run(self, given: Given, script: Sequence[Do], seconds: float) -> Outcome:
        """Write what the script says, each at its beat."""
        lines = ["-"] * round(seconds * BEATS_PER_SECOND)
        for do in (do for do in script if do.what == "say"):
            beat = round(do.at * BEATS_PER_SECOND)
            lines[beat:beat] = [do.text]
        return self._run(
            given, lambda _: typed_items(lines, plain_commands(LIST), given.table.halts)
        )


class Listening:
    """What `recognizer.microphone()` gives in a room, as a time goes on."""

    def __init__(self, given: Given, timeline: Timeline) -> None:
        self.room = Room()  # where it is
        self._timeline = timeline
        self._next = BEGIN
        self._settled = SettledUtterances()
        self._listener = recognizer_for(given.name, given.ask).listen(SAMPLE_RATE)

    def step(self) -> Iterator[Utterance]:
        """Hear the block that is due."""
        while self._next <= self._timeline.now:
            self._next += BLOCK_SECONDS
            yield from self._settled.of(self._listener.feed(self.room.take(BLOCK)))


class Program:
    """A program of one's own: `voz.Controller` in a loop that sends the velocities."""

    spoken = needs_name = True
    reach = SPEAKING
    watched = False

    def __init__(self, name: str, cannot: dict[str, str]) -> None:
        self.name = name
        self.cannot = cannot

    def run(self, given: Given, script: Sequence[Do], seconds: float) -> Outcome:
        """Do what the script says in the loop of a program."""
        outcome, timeline = Outcome(), Timeline()
        listening = Listening(given, timeline)
        for do in (do for do in script if do.what == "say"):
            timeline.at(do.at, partial(listening.room.say, do.text))
        with fake_time(timeline):
            try:
                with voz.Controller(
                    given.receivers(outcome), given.safety, given.listening, commands=COMMANDS
                ) as controller:
                    timeline.each.append(lambda: self.hear(controller, listening.step()))
                    self._loop(controller, timeline, seconds)
            except BrokenPipeError as error:
                outcome.error = error
        return outcome

    def _loop(self, controller: voz.Controller, timeline: Timeline, seconds: float) -> None:
        beats = 0
        while (now := timeline.now - BEGIN) < seconds:
            if now >= beats / 10:
                controller.send(round(now, 3))
                beats += 1
            timeline.step()

    def hear(self, controller: voz.Controller, heard: Iterator[Utterance]) -> None:
        """Hand over what was heard."""
        for utterance in heard:
            controller.hear(utterance)


class Background(Program):
    """The same, by `listen_in_background`: what is heard comes on a thread of its own."""

    def run(self, given: Given, script: Sequence[Do], seconds: float) -> Outcome:
        """Do what the script says."""
        self._heard: queue.SimpleQueue[tuple[voz.Controller, Utterance] | None] = (
            queue.SimpleQueue()
        )
        self._taken = threading.Semaphore(0)
        utterances: Any = self
        stop = in_background(utterances, self._take)
        outcome = super().run(given, script, seconds)
        with suppress(BrokenPipeError):
            stop()
        return outcome

    def hear(self, controller: voz.Controller, heard: Iterator[Utterance]) -> None:
        """Hand over what was heard, and wait until the function was called."""
        for utterance in heard:
            self._heard.put((controller, utterance))
            self._taken.acquire()

    def __iter__(self) -> Iterator[Any]:
        while heard := self._heard.get():
            yield heard

    def _take(self, heard: Any) -> None:
        controller, utterance = heard
        try:
            controller.hear(utterance)
        finally:
            self._taken.release()

    def close(self) -> None:
        """End what is said."""
        self._heard.put(None)


class Iterated:
    """`controller.run(utterances)`, which waits for them on a thread of its own."""

    name = "controller.run(iterable)"
    spoken = needs_name = True
    reach = SPEAKING
    watched = True

    def __init__(self, cannot: dict[str, str]) -> None:
        self.cannot = cannot

    def run(self, given: Given, script: Sequence[Do], seconds: float) -> Outcome:
        """Do what the script says; what is lost here is what the utterances come from."""
        outcome, timeline = Outcome(), Timeline()
        inbox = SteppedInbox(timeline, given.table.halts)
        listening = Listening(given, timeline)
        said: queue.SimpleQueue[Utterance | BaseException | None] = queue.SimpleQueue()
        waits = threading.Semaphore(0)

        def utterances() -> Iterator[Utterance]:
            while True:
                waits.release()
                heard = said.get()
                if isinstance(heard, BaseException):
                    raise heard
                if heard is None:
                    return
                yield heard

        def put(item: Utterance | BaseException | None) -> None:
            waits.acquire()
            said.put(item)
            until = time.perf_counter() + WORKED
            while not isinstance(item, Utterance) and inbox.is_empty:
                assert time.perf_counter() < until, "nobody is told that the utterances have ended"
                time.sleep(0.0001)
            if isinstance(item, Utterance):
                waits.acquire()
                waits.release()

        def do_now(do: Do) -> None:
            if do.what == "say":
                listening.room.say(do.text)
            elif do.what == "stall":
                timeline.stall(1.0)
            elif do.what == "lose":
                put(SystemExit(3))

        def hear() -> None:
            for utterance in listening.step():
                put(utterance)

        for do in script:
            timeline.at(do.at, partial(do_now, do))
        timeline.at(seconds, lambda: put(None))
        timeline.each.append(hear)
        with fake_time(timeline), mock.patch("voz.run.session.Inbox", return_value=inbox):
            controller = voz.Controller(
                given.receivers(outcome), given.safety, given.listening, commands=COMMANDS
            )
            try:
                controller.run(utterances())
            except BaseException as error:
                outcome.error = error
        return outcome


class Ros1:
    """A string on ROS 1, as the node takes it; rospy and a real master are in `tests/ros1`."""

    name = "string on ROS 1"
    spoken = needs_name = False
    reach = AT_ONCE
    watched = True
    source = "/recognizer/output"

    def __init__(self, cannot: dict[str, str]) -> None:
        self.cannot = cannot
        self.loss: str | None = None

    def trouble(self, moving: bool) -> str | None:
        """Return why nobody publishes."""
        return self.loss

    def run(self, given: Given, script: Sequence[Do], seconds: float) -> Outcome:
        """Do what the script says in the session of a node."""
        outcome, timeline = Outcome(), Timeline()
        inbox = SteppedInbox(timeline, given.table.halts)
        self.loss = None

        @contextmanager
        def connect(session: Session) -> Iterator[None]:
            commands = plain_commands(LIST)
            texts = TextCommands(lambda: commands, session.inbox, session.clock.now)
            done = {
                "lose": lambda _: setattr(self, "loss", "it is gone"),
                "find": lambda _: setattr(self, "loss", None),
                "say": lambda text: texts.take(text, self.source),
                "flood": lambda _: [texts.take(NONSENSE, self.source) for _ in range(FLOOD)],
                "stall": lambda _: timeline.stall(1.0),
            }
            for do in script:
                timeline.at(do.at, partial(done.get(do.what, lambda _: None), do.text))
            timeline.at(seconds, lambda: inbox.put(End()))
            session.watch_input(self)
            yield

        spec = RunSpec(
            controller=controller_by(given.settings, given.listening),
            settings=given.settings,
            inbox=inbox,
            outputs=[robots_part(*given.receivers(outcome))],
            parts=[connect],
        )
        with fake_time(timeline):
            try:
                Session(spec).run()
            except BrokenPipeError as error:
                outcome.error = error
        return outcome


TEXT_OF_A_RUN = {"question": ONLY_TEXT, "question declined": ONLY_TEXT, "name": NEEDS_NO_NAME}
NO_TEXT = {"escaped": "sounds have no control characters: what is shown is of the list"}
SAID = {**NO_TEXT, "overtaken": "a voice says one thing after the other: see late"}
OWN_TIME = {
    **TEXT_OF_A_RUN,
    **dict.fromkeys(("late", "rehearsal", "reload", *LOSSES, "robot lost", "stall"), NO_CLOCK),
    "stop in a flood": NO_CLOCK,
}
OWN_LOOP = {
    **SAID,
    "question": ASKS_NOTHING,
    "question declined": ASKS_NOTHING,
    "late": "it has no keys and no page that stop beside what is said",
    "rehearsal": "a rehearsal is begun on the page",
    "reload": "the list is loaded once",
    "robot lost": "the receivers are functions of the program itself",
    "stop in a flood": "calls come one after the other, from the program itself",
}
PROGRAMS_LOOP = {
    **OWN_LOOP,
    **dict.fromkeys(LOSSES, "what is heard is the program's: it calls `stop`"),
    "stall": "the program sends the velocities itself; a robot's own watchdog is behind them",
    "unwatched": "the program sends each velocity itself",
}


class Elsewhere:
    """A door that needs a network and a real time, with the place of its tests."""

    spoken = needs_name = False
    reach = AT_ONCE
    watched = True

    def __init__(self, name: str, why: str) -> None:
        self.name = name
        self.cannot = {promise.name: why for promise in PROMISES}

    def run(self, given: Given, script: Sequence[Do], seconds: float) -> Outcome:
        """Never called: no cell is tried here."""
        raise NotImplementedError


DOORS: tuple[Door, ...] = (
    LiveDoor(
        "own microphone",
        _speak,
        microphone=True,
        spoken=True,
        needs_name=True,
        reach=SPEAKING,
        loses="the microphone",
        cannot=SAID,
    ),
    LiveDoor(
        "hands-free page",
        _speak_on_page,
        _drive_hands_free,
        browser_listens=True,
        spoken=True,
        needs_name=True,
        reach=SPEAKING,
        loses="the page",
        cannot=SAID,
    ),
    LiveDoor(
        "held button",
        _hold_and_speak,
        _drive,
        browser_listens=True,
        spoken=True,
        reach=SPEAKING,
        loses="the page",
        cannot=SAID,
    ),
    LiveDoor("tap, by WebSocket", _tap(True), _drive, loses="the page", cannot=TEXT_OF_A_RUN),
    LiveDoor("tap, by POST", _tap(False), _drive, loses="the page", cannot=TEXT_OF_A_RUN),
    LiveDoor(
        "POST /api/command",
        _post,
        watched=False,
        cannot={**TEXT_OF_A_RUN, **dict.fromkeys(LOSSES, "nobody is watched: see unwatched")},
    ),
    Elsewhere("voz.Client", "a real page, in `tests/promises/test_client_door.py`"),
    LiveDoor(
        "typed",
        _type,
        cannot={
            **TEXT_OF_A_RUN,
            **dict.fromkeys(
                LOSSES, "a keyboard has no sign of life; a pipe's end: `test_real_processes.py`"
            ),
        },
    ),
    LiveDoor(
        "Wyoming",
        _from_wyoming,
        watched=False,
        cannot={**TEXT_OF_A_RUN, **dict.fromkeys(LOSSES, "nobody is watched: see unwatched")},
    ),
    LiveDoor("string on ROS 2", _from_ros, loses="the recognizer", cannot=TEXT_OF_A_RUN),
    Ros1(
        {
            **TEXT_OF_A_RUN,
            "late": "the node has no keys",
            "rehearsal": "the node has no page",
            "reload": "the node's list is loaded at its start",
            "robot lost": "the node's robot is ROS, whose loss is in `tests/ros1`",
        }
    ),
    Bag(OWN_TIME),
    Lines({**OWN_TIME, "overtaken": "a line is obeyed in its beat, before the next is read"}),
    Program("controller.hear", PROGRAMS_LOOP),
    Iterated(OWN_LOOP),
    Background("listen_in_background", PROGRAMS_LOOP),
)
