"""The operator page of a live run: a source of commands, a receiver, and one that may be lost."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial

import msgspec

from voz.apps.command_buttons import button_sentences, command_buttons
from voz.apps.recordings.recorder import Recorder
from voz.apps.servers.command_bridge import CommandBridge, EventQueue
from voz.apps.web.control_api import ControlApi, application
from voz.apps.web.driver_lock import DriverLock
from voz.apps.web.page_messages import PAGE_SOURCE, PROGRAM_SOURCE, EventHistory, Record
from voz.apps.web.page_registry import PageRegistry
from voz.apps.web.page_sound import BROWSER_SOURCE, BrowserMicrophone, PagePlayback
from voz.apps.web.picture import DeadReckoningPicture, RoomPicture
from voz.apps.web.tuning_api import FalseAlarmSetting, RecordingMarks, TuningApi
from voz.apps.web.web_server import PageAddress, start_background_tasks
from voz.apps.web.websocket_api import WebSocketApi
from voz.control.messages import Halt, Rehearsal
from voz.control.table import CommandTable
from voz.events import Event
from voz.hearing.half_duplex import Playback
from voz.hearing.microphone_thread import Hearing, SoundSource
from voz.language.sentences.command_set import Commands
from voz.run.controller import Controller
from voz.run.session import Session, SpeechInput

NO_DRIVER = "no page drives any more"
"""The warning when the page that was the microphone has left a robot at rest."""


class LivePage:
    """Serves the operator page of a live run."""

    unwatched_source = PROGRAM_SOURCE  # of commands that are posted without a page

    def __init__(
        self,
        session: Session,
        address: PageAddress,
        *,
        browser_listens: bool,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare to serve a page of a run at an address.

        By `now`, s, a page that is silent counts as gone.
        """
        self._session = session
        self._address = address
        view = session.view
        self._picture = RoomPicture(view.settings, view.state) if view else DeadReckoningPicture()
        self._microphone = BrowserMicrophone(session.warn) if browser_listens else None
        self._playback = PagePlayback()
        self._events = EventQueue()
        self.driver_lock = DriverLock()  # knows which page drives, and whether it is there
        self._now = now

    @property
    def sources(self) -> list[str]:
        """The sources of the commands of the page that drives."""
        return [PAGE_SOURCE, *([BROWSER_SOURCE] if self._microphone else [])]

    @property
    def sound(self) -> SoundSource | None:
        """The browser as a microphone; None if the robot's own is used."""
        microphone = self._microphone
        return SoundSource(lambda: nullcontext(microphone), BROWSER_SOURCE) if microphone else None

    @property
    def driven(self) -> bool:
        """Whether somebody drives from it."""
        return self.driver_lock.driver is not None

    def audible_playback(self, own: Playback | None) -> Playback:
        """All playback that a microphone may pick up: the robot's and the browsers'."""
        self._playback.robot = own
        return self._playback

    def receive(self, event: Event) -> None:
        """Take an event of the run; it never waits."""
        self._picture.receive(event)
        self._events.receive(event)

    def trouble(self, moving: bool) -> str | None:
        """Report that the page that drove the robot is gone (S5)."""
        problem = self.driver_lock.trouble(self._now(), moving)
        if self.driver_lock.released_at_rest and self._microphone:
            # What was said last may be recognized only now, with nobody there who can stop it.
            self._session.inbox.put(Halt(NO_DRIVER, self._session.clock.now()))
        return problem

    @contextmanager
    def serving(self) -> Iterator[SpeechInput]:
        """Serve the page for a `with` block; gives what listens, whose trouble the page shows."""
        session, inbox = self._session, self._session.inbox
        recognizer, settings = session.recognizer, session.spec.settings
        assert session.hearing
        assert recognizer

        def commands() -> Commands:
            return recognizer.commands

        hearing = _WatchedHearing(session.hearing)
        registry = PageRegistry(
            CommandBridge(inbox, session.clock.now, commands),
            EventHistory(recognizer.threshold_of),
            self.driver_lock,
            warn=session.warn,
            microphone=self._microphone,
            set_rehearsal=lambda on: inbox.put(Rehearsal(on)),
            now=self._now,
        )
        recorder = session.recorder if isinstance(session.recorder, Recorder) else None
        marks = RecordingMarks(recorder, commands)
        report = partial(session.warn, good=True)
        false_alarms = FalseAlarmSetting(recognizer, settings.recognition, report)
        given = _CurrentCommands(commands, session.controller)
        shown = _Shown(hearing, given, marks, false_alarms, registry)
        snapshot = partial(self._snapshot, shown)
        voice = settings.speech.voice
        routes = [
            *ControlApi(registry, self._address.access, snapshot, settings).routes(),
            *WebSocketApi(registry, snapshot).routes(),
            *TuningApi(registry, marks, false_alarms, self._playback, voice).routes(),
        ]
        start_tasks = partial(
            start_background_tasks,
            registry,
            self._events,
            partial(self._state, shown),
            lambda: [*marks.take_new(), *given.take_new()],
            self._address.renew_certificate,
        )
        app = application(routes, self._address.authority)
        with self._address.serving(app, start_tasks, session.warn):
            yield hearing

    def _snapshot(self, shown: _Shown) -> Record:
        """All that a page that is opened now has to know."""
        return {
            **shown.commands.record(),
            "room": self._picture.room() or None,
            "recordings": shown.marks.known,
            "tuning": shown.false_alarms.choices(),
            "microphone": "browser" if self._microphone else shown.hearing.device,
            "events": shown.registry.remembered,
            "now": {**self._state(shown), **shown.registry.status},
        }

    def _state(self, shown: _Shown) -> Record:
        """The current state, on the server's thread."""
        controller, speaker = self._session.controller, self._session.speaker
        linear, angular = controller.velocities
        needs_name = self._microphone is None or self._microphone.is_hands_free
        awake = controller.awake or not needs_name
        busy_until = max(
            self._playback.busy_until(), speaker.mixer.busy_until() if speaker else 0.0
        )
        return {
            "t": self._session.clock.now(),
            "listening": controller.listening,
            "asleep": "" if awake else controller.name,
            "rehearsing": controller.state.rehearsing,
            "question": shown.registry.question,
            # A reply that the page plays is known: whoever speaks meanwhile is heard.
            "speaking": busy_until > time.monotonic() and self._playback.replies() is None,
            "recording": shown.marks.note,
            "alarms": shown.false_alarms.alarms,
            "deaf": shown.hearing.problem,
            "talking": bool(self._microphone and self._microphone.is_expected),
            "linear": linear,
            "angular": angular,
            "peak": round(shown.hearing.peak, 4),
            "background": round(shown.hearing.background, 1),
            **self._picture.state(),
        }


@dataclass(frozen=True)
class _Shown:
    """What a page shows of a run."""

    hearing: _WatchedHearing
    commands: _CurrentCommands
    marks: RecordingMarks
    false_alarms: FalseAlarmSetting
    registry: PageRegistry


class _CurrentCommands:
    """What may be given on a page, which may change during a run.

    Event-loop thread only; buttons are made on another, for a long list takes a while.
    """

    def __init__(self, commands: Callable[[], Commands], controller: Controller) -> None:
        self._commands = commands
        self._controller = controller
        self._taken = self._now()
        self._record = _commands_record(*self._taken)
        self._making: Future[Record] | None = None
        self._worker = ThreadPoolExecutor(1, "voz-buttons")

    def _now(self) -> tuple[Commands, CommandTable]:
        return self._commands(), self._controller.state.rules.table

    def record(self) -> Record:
        """The sentences that have a button, the buttons, and what begins the listening."""
        return self._record

    def take_new(self) -> list[Record]:
        """Return what pages are to be sent, if the commands were renewed since the last call."""
        now = self._now()
        same = all(one is other for one, other in zip(now, self._taken, strict=True))
        if not same and self._making is None:
            self._taken = now
            self._making = self._worker.submit(_commands_record, *now)
        if self._making is None or not self._making.done():
            return []
        self._record, self._making = self._making.result(), None
        return [{"type": "commands", **self._record}]


def _commands_record(commands: Commands, table: CommandTable) -> Record:
    return {
        "commands": button_sentences(commands),
        "buttons": msgspec.to_builtins(command_buttons(commands, table)),
        "wake": table.wake,
    }


class _WatchedHearing:
    """Passes on a microphone's trouble, and keeps it for the page."""

    def __init__(self, hearing: Hearing) -> None:
        self.source = hearing.source
        self.device = hearing.device
        self.problem: str | None = None
        self._hearing = hearing

    @property
    def peak(self) -> float:
        """Highest sample of the last block, 0 to 1."""
        return self._hearing.peak

    @property
    def background(self) -> float:
        """Level of the room, dBFS."""
        return self._hearing.background

    def trouble(self, moving: bool) -> str | None:
        """Report why nothing is heard right now."""
        self.problem = self._hearing.trouble(moving)
        return self.problem
