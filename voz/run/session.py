"""One run of a robot: it opens what the run consists of, drives, and stops the robot at its end.

    microphone, keyboard, ROS ──▶ Inbox ──▶ ┐
    recordings, text, a bag  ──▶ (a Clock) ─┴▶ main_loop ──▶ controller ──▶ receivers

Sources have threads of their own and put messages into an inbox, or are the clock themselves. The
loop writes nothing, opens nothing and waits for nobody: whatever may do so is behind a queue.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, nullcontext
from typing import TYPE_CHECKING, Protocol, TypeAlias

from voz.control.controller import change_rules
from voz.control.messages import Beat, End, Health, StopMotion
from voz.control.safety import zero_at_the_end
from voz.control.table import CommandTable
from voz.events import Notice, ProgramEnded
from voz.inbox import Inbox
from voz.process.signals import defer_signals
from voz.run.clocks import BEATS_PER_SECOND, Clock, warn
from voz.run.spec import RunSpec

if TYPE_CHECKING:
    from voz.hearing.microphone_thread import Hearing, SoundRecorder
    from voz.recognition.engine import RecognitionEngine
    from voz.robot.simulation.room_view import RoomView
    from voz.speech.reply_speaker import ReplySpeaker

MAX_BEAT_GAP = 0.5
"""Longest time between two beats, s; a base has stopped by itself then, and must stay so."""

Check: TypeAlias = Callable[[float], None]

Trouble: TypeAlias = Callable[[], str | None]
"""Returns why something is lost now, without waiting; None if it is not."""


class SpeechInput(Protocol):
    """Where spoken commands come from: a microphone, a page, another recognizer."""

    source: str  # of its utterances

    def trouble(self, moving: bool) -> str | None:
        """Return why nothing is heard now, without waiting; None if all is well."""


class Session:
    """One run: `startup`, a `main_loop` with `on_beat` ten times a second, and `shutdown`."""

    clock: Clock  # the time, and what arrives; there once the robots are open

    def __init__(self, spec: RunSpec) -> None:
        """Prepare a run with the robot at rest; nothing is opened yet."""
        self.spec = spec  # what it consists of
        self.controller = spec.controller
        self.inbox = spec.inbox or Inbox(self.table.halts)  # takes messages on any thread
        # Called with every event, in order; none of them may wait for anything.
        self.receivers = self.controller.receivers
        self.checks: list[Check] = []  # called in each beat with its time, s
        # Prints a line where the robots print, on any thread.
        self.show: Callable[[str], None] = lambda _: None
        self.view: RoomView | None = None  # the simulated room, for a terminal; None without one
        self.speaker: ReplySpeaker | None = None  # says the replies; None if the robot is silent
        # Understands what is said; None without a microphone.
        self.recognizer: RecognitionEngine | None = None
        self.hearing: Hearing | None = None  # the microphone; None without one
        self.recorder: SoundRecorder | None = None  # keeps what is heard; None without one
        self._at_once = False
        self._problems: list[str] = []  # without a real clock they are reported at the end

    def run(self) -> None:
        """Drive until what arrives ends, or a signal comes; zero velocity is sent last (S7).

        Raises SystemExit if a signal came before.
        """
        received = [*self.receivers]
        with ExitStack() as opened:
            opened.callback(self.receivers.__setitem__, slice(None), received)
            self.startup(opened)
            end = defer_signals(lambda: self.inbox.put(End())) if self.in_real_time else None
            with zero_at_the_end(self.shutdown), end or nullcontext():
                self.main_loop()

    def startup(self, opened: ExitStack) -> None:
        """Open the outputs, begin the time of the run, and open everything else."""
        for part in self.spec.outputs:
            opened.enter_context(part(self))
        self.clock = self.spec.clock(self.inbox)
        for part in self.spec.parts:
            opened.enter_context(part(self))

    def main_loop(self) -> None:
        """Take what arrives, and let time pass; raises the error that ends the run, if one does."""
        number, last = 0, self.clock.now()
        while True:
            due = number / BEATS_PER_SECOND
            message = self.clock.next_before(due)
            now = self.clock.now()
            # First of all: a process that was suspended must not drive on.
            if now - last > MAX_BEAT_GAP:
                self.clock.skip(now - due)
                why = f"control loop stalled for {now - last:.1f} s: the robot stops"
                self.controller.take(StopMotion(why), self.clock.now())
                last = now = self.clock.now()
            if message is None:
                self.on_beat(now)
                last = now
                number = max(number, int(now * BEATS_PER_SECOND)) + 1  # missed beats are left out
            elif isinstance(message, End):
                if message.error:
                    raise message.error
                break
            else:
                before = self.controller.velocities
                self.controller.take(message, now)
                now = self.clock.now()
                changed = self.controller.velocities != before
                if self._at_once and changed and now - last <= MAX_BEAT_GAP:
                    self.controller.take(Beat(), now)
        self._report_problems()

    def on_beat(self, now: float) -> None:
        """Stop if something is lost (S5), and send the velocities; `now` in s."""
        for check in self.checks:
            check(now)
        if flood := self.inbox.flood_report(now):
            self.controller.take(Notice(now, flood), now)
        self.controller.take(Beat(), now)

    def shutdown(self) -> None:
        """Send zero velocity."""
        self.controller.zero(self.clock.now())

    @property
    def in_real_time(self) -> bool:
        """Whether the clock is a real one."""
        return self.spec.in_real_time

    @property
    def table(self) -> CommandTable:
        """What each command does."""
        return self.controller.state.rules.table

    @property
    def language(self) -> str:
        """The language of texts for people."""
        return self.controller.state.rules.language

    def add_unwatched(self, source: str) -> None:
        """Limit the motions by commands of a source whose users do not watch the robot."""
        unwatched = self.controller.state.rules.unwatched_sources | {source}
        self.controller.state = change_rules(self.controller.state, unwatched_sources=unwatched)

    def watch(self, name: str, trouble: Trouble, *sources: str) -> None:
        """Stop when `trouble`, called in each beat, returns why something is lost (S5).

        While it is lost the commands that come from its sources move nothing.
        """

        def check(now: float) -> None:
            self.controller.take(Health(name, trouble(), f"{name} is there", sources), now)

        self.checks.append(check)

    def watch_input(self, speech_input: SpeechInput) -> None:
        """Stop when nothing is heard (S5), and send each changed velocity at once."""
        sources = (speech_input.source,)

        def check(now: float) -> None:
            problem = speech_input.trouble(self.controller.moving)
            self.controller.take(Health("hearing", problem, "listening again", sources), now)

        self.checks.insert(0, check)
        self._at_once = True

    def report(self, event: ProgramEnded | Notice) -> None:
        """Take what a part has to say, on any thread."""
        if self.in_real_time:
            self.inbox.put(event)
        else:
            self.controller.emit(event)

    def warn(self, text: str, good: bool = False) -> None:
        """Take a line for people, and whether it is good news, on any thread."""
        if self.in_real_time:
            warn(self.inbox, self.clock, text, good)
        else:
            self._problems.append(text)

    def _report_problems(self) -> None:
        """Report at the end only what a speaker's threads found: they are not on time."""
        if self.speaker and not self.in_real_time:
            self.speaker.close()
        for problem in self._problems:
            self.controller.emit(Notice(self.clock.now(), problem))
