"""Puts the parts together: utterances in, events out, with time as the audio or the lines tell it.

Nothing here reads a clock: a recording lasts as long as its samples, a typed line 0.1 s. So a run
goes as fast as it can and gives the same events each time.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path

from msgspec.structs import replace

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.files import printable, read_blocks
from voz.config import Safety
from voz.control.controller import REPLIES, State, halt
from voz.control.safety import motion_has_expired, obey_safely, zero_at_the_end
from voz.errors import AudioError
from voz.events import Event, Reason, Reply, SelectedObject, Twist, Utterance, Warning
from voz.language.commands import normalise
from voz.recognition.recognizer import Recognizer
from voz.speech.speaker import Speaker

CYCLES_PER_SECOND = 10
"""How often `cmd_vel` goes out, also while nothing is said."""

NO_COMMAND = ("", "-")
"""Typed lines that only let a cycle pass."""


class Pipeline:
    """Obeys utterances and sends the velocities, cycle by cycle, to all that receive events."""

    def __init__(self, receivers: Sequence[Callable[[Event], None]], safety: Safety) -> None:
        """Start with the robot at rest and not listening.

        Args:
            receivers: called with every event, in order.
            safety: the safety rules' settings.
        """
        self._receivers = receivers
        self._safety = safety
        self._state = State()
        self._cycles = 0
        self._last_command = 0.0

    @property
    def now(self) -> float:
        """When the next cycle is, s."""
        return self._cycles / CYCLES_PER_SECOND

    def hear(self, utterance: Utterance) -> None:
        """Let the cycles before an utterance pass, then obey it if it is accepted."""
        while self.now < utterance.t:
            self.cycle()
        self.emit(utterance)
        if not utterance.accepted:
            return
        self._last_command = utterance.t
        self._state, selected, reply = obey_safely(self._state, utterance.text, self._safety)
        if selected is not None:
            self.emit(SelectedObject(utterance.t, selected))
        if reply is not None:
            self.emit(Reply(utterance.t, reply))

    def cycle(self) -> None:
        """Send the velocities once, and go on by 0.1 s."""
        if motion_has_expired(self._state, self.now - self._last_command, self._safety):
            self._state = halt(self._state)
            limit = self._safety.motion_time_limit
            self.emit(Warning(self.now, f"no command for {limit:g} s: the robot stops"))
        self.emit(Twist(self.now, *self._state.velocities()))
        self._cycles += 1

    def zero(self) -> None:
        """Send zero velocity once."""
        self.emit(Twist(self.now, 0.0, 0.0))

    def emit(self, event: Event) -> None:
        """Hand an event to all receivers."""
        for receive in self._receivers:
            receive(event)


@contextmanager
def running(
    receivers: Sequence[Callable[[Event], None]], safety: Safety, voice: str | None
) -> Iterator[Pipeline]:
    """A pipeline for the length of a `with` block; whatever ends it, zero velocity is sent last.

    Args:
        receivers: called with every event, in order.
        safety: the safety rules' settings.
        voice: who speaks the replies; None keeps the robot silent.
    """
    speaker = Speaker(voice, REPLIES) if voice else None
    with speaker or nullcontext():
        if speaker:
            receivers = [*receivers, _replies_to(speaker)]
        pipeline = Pipeline(receivers, safety)
        with zero_at_the_end(pipeline.zero):
            yield pipeline
            if speaker:
                # Only now: when a thread meets a problem hangs on the machine, events must not.
                speaker.close()
                for problem in speaker.drain_warnings():
                    pipeline.emit(Warning(pipeline.now, problem))


def drive_by_text(pipeline: Pipeline, lines: Iterable[str], commands: Collection[str]) -> None:
    """Obey typed lines, one in each cycle; `-` or nothing lets a cycle pass.

    Args:
        pipeline: what obeys.
        lines: the typed text.
        commands: the sentences of the command list; any other text is not accepted.
    """
    for line in lines:
        text = normalise(line)
        if text not in NO_COMMAND:
            known = text in commands
            now = pipeline.now
            pipeline.hear(_typed(text, known, now))
        pipeline.cycle()


def drive_by_recordings(
    pipeline: Pipeline, paths: Iterable[Path], recognizer: Recognizer
) -> list[str]:
    """Obey recordings, one after the other as one stream of time.

    Args:
        pipeline: what obeys.
        paths: the recordings.
        recognizer: what understands them.

    Returns:
        What could not be read, one line each; each was a Warning too.
    """
    errors = []
    heard = 0  # samples of all recordings so far

    def counted(blocks: Iterator[Samples]) -> Iterator[Samples]:
        nonlocal heard
        for block in blocks:
            heard += len(block)
            yield block

    for path in paths:
        begin = heard / SAMPLE_RATE
        try:
            for utterance in recognizer.utterances(counted(read_blocks(path)), printable(path)):
                pipeline.hear(_later(utterance, begin))
        except AudioError as error:
            errors.append(str(error))
            pipeline.emit(Warning(pipeline.now, str(error)))
        while pipeline.now < heard / SAMPLE_RATE:
            pipeline.cycle()
    pipeline.cycle()  # the last command takes effect
    return errors


def _typed(text: str, known: bool, now: float) -> Utterance:
    reason: Reason | None = None if known else "not_a_command"
    return Utterance(now, text, float(known), known, now, now, "text", reason)


def _later(utterance: Utterance, seconds: float) -> Utterance:
    return replace(
        utterance,
        t=round(utterance.t + seconds, 3),
        start=round(utterance.start + seconds, 3),
        end=round(utterance.end + seconds, 3),
    )


def _replies_to(speaker: Speaker) -> Callable[[Event], None]:
    def receive(event: Event) -> None:
        if isinstance(event, Reply):
            speaker.say(event.text)

    return receive
