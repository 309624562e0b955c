"""The operator page as a part of a run: a source, a receiver, and one that may be lost."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from voz.apps.recordings.recorder import Recorder
from voz.apps.web.app import Api, application
from voz.apps.web.asking import Asking
from voz.apps.web.board import Board, Record
from voz.apps.web.browser_microphone import BROWSER, BrowserMicrophone, opened
from voz.apps.web.desk import Desk
from voz.apps.web.dial import Dial
from voz.apps.web.feed import Feed
from voz.apps.web.guard import Guard
from voz.apps.web.marking import Marking
from voz.apps.web.picture import Picture
from voz.apps.web.server import serving, telling
from voz.apps.web.site import Site
from voz.apps.web.sounding import Sounding
from voz.apps.web.tuning import TuningApi
from voz.apps.web.wheel import Wheel
from voz.events import Event
from voz.hearing.half_duplex import Playback
from voz.hearing.microphone_thread import Hearing, SoundSource
from voz.inbox import Halt, Inbox, Rehearsal
from voz.language.sentences.command_set import Commands
from voz.run.clocks import Clock
from voz.run.live import RunParts
from voz.run.session import Ears, warner

NOBODY = "no page drives any more"
"""What is told when the page that was the microphone went while the robot stood still."""

MOST_BUTTONS = 60
"""Of more commands, each has one button, with the shortest of its sentences."""


class OperatorPage:
    """Serves the page."""

    def __init__(
        self,
        site: Site,
        inbox: Inbox,
        clock: Clock,
        commands: Callable[[], Commands],
        picture: Picture,
        listens: bool,
    ) -> None:
        """Prepare to serve.

        Args:
            site: where it is, and who may come.
            inbox: where commands go.
            clock: the time of the run.
            commands: tells what may be said now; the buttons are in their order.
            picture: what is drawn of the robot.
            listens: whether the browser is the microphone.
        """
        self._site = site
        self._inbox = inbox
        self._clock = clock
        self._commands = commands
        self._picture = picture
        self._warn = warner(inbox, clock)
        self._microphone = BrowserMicrophone(self._warn) if listens else None
        self._sounding = Sounding()
        self._feed = Feed()
        self._wheel = Wheel()

    @property
    def sound(self) -> SoundSource | None:
        """The browser as a microphone; None if the robot's own is listened to."""
        return SoundSource(partial(opened, self._microphone), BROWSER) if self._microphone else None

    def beside(self, own: Playback | None) -> Playback:
        """What a microphone hears that nobody says: what the robot says, and what pages play."""
        return self._sounding.beside(own)

    def receive(self, event: Event) -> None:
        """Take an event of the run; it never waits."""
        self._picture.receive(event)
        self._feed.receive(event)

    def trouble(self, moving: bool) -> str | None:
        """Tell that the page is gone that drove the robot (S5)."""
        problem = self._wheel.trouble(time.monotonic(), moving)
        if self._wheel.left_at_rest and self._microphone:
            # What was said last on it may be settled only now, with nobody there who can stop it.
            self._inbox.put(Halt(NOBODY, self._clock.now()))
        return problem

    @contextmanager
    def serving(self, parts: RunParts) -> Iterator[Ears]:
        """Serve the page for the length of a `with` block.

        Args:
            parts: what it shows.

        Yields:
            What listens, whose trouble the page shows.

        Raises:
            ConfigError: its address cannot be had.
        """
        ears = _Watched(parts.hearing)
        asking = Asking(self._inbox, self._clock.now, self._commands)
        desk = Desk(
            asking,
            Board(parts.recognizer.needed),
            self._wheel,
            self._warn,
            self._microphone,
            lambda on: self._inbox.put(Rehearsal(on)),
        )
        recorder = parts.recorder if isinstance(parts.recorder, Recorder) else None
        marking = Marking(recorder, self._commands)
        dial = Dial(parts.recognizer, parts.settings.recognition, self._warn)
        look = partial(self._look, parts, ears, marking, dial)
        about = partial(self._about, parts, marking, dial)
        api = Api(desk, self._site.doors, look, about, parts.settings)
        tuning = TuningApi(desk, marking, dial, self._sounding, parts.settings.speech.voice)
        routes = [*api.routes(), *tuning.routes()]
        pages = application(routes, self._site.authority)
        app = Guard(pages, self._site.doors, self._site.at)
        work = partial(telling, desk, self._feed, look, marking.news, self._site.renew)
        with serving(app, self._site.at, self._site.tls, work, self._warn):
            yield ears

    def _about(self, parts: RunParts, marking: Marking, dial: Dial) -> Record:
        """What a page that is opened has to know besides what it is told as it happens."""
        room = self._picture.about()
        return {
            "commands": _buttons(self._commands()),
            "room": room or None,
            "recordings": marking.known,
            "tuning": dial.about(),
            "microphone": "browser" if self._microphone else parts.hearing.device,
        }

    def _look(self, parts: RunParts, ears: _Watched, marking: Marking, dial: Dial) -> Record:
        """How things are now; on the server's thread."""
        linear, angular = parts.controller.velocities
        busy_until = max(
            self._sounding.busy_until(), parts.mixer.busy_until() if parts.mixer else 0.0
        )
        return {
            "t": self._clock.now(),
            "listening": parts.controller.listening,
            "rehearsing": parts.controller.rehearsing,
            "speaking": busy_until > time.monotonic(),
            "recording": marking.note,
            "alarms": dial.alarms,
            "deaf": ears.problem,
            "talking": bool(self._microphone and self._microphone.expected),
            "linear": linear,
            "angular": angular,
            "peak": round(parts.hearing.peak, 4),
            "background": round(parts.hearing.background, 1),
            **self._picture.look(),
        }


class _Watched:
    """Ears whose trouble somebody else may read, too."""

    def __init__(self, hearing: Hearing) -> None:
        self.source = hearing.source
        self.problem: str | None = None
        self._trouble: Callable[[bool], str | None] = hearing.trouble

    def trouble(self, moving: bool) -> str | None:
        """Tell why nothing is heard right now."""
        self.problem = self._trouble(moving)
        return self.problem


def _buttons(commands: Commands) -> list[str]:
    """The sentences that have a button."""
    if len(commands) <= MOST_BUTTONS:
        return commands.listed
    shortest = [commands.named([name], 1) for name in commands.names[:MOST_BUTTONS]]
    return [sentence for sentences in shortest for sentence in sentences[:1]]
