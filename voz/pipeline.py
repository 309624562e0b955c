"""Drives by recordings or typed lines, with time as the audio or the lines tell it.

Nothing here reads a clock: a recording lasts as long as its samples, a typed line 0.1 s. So a run
goes as fast as it can and gives the same events each time.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TypeVar

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.files import read_blocks
from voz.bags import Sayings
from voz.config import Safety
from voz.control.controller import REPLIES
from voz.control.safety import zero_at_the_end
from voz.drive import CYCLES_PER_SECOND, Drive
from voz.errors import AudioError
from voz.events import Event, Partial, Reason, Receiver, Reply, Utterance, Warning, later
from voz.files import printable
from voz.language.commands import normalise
from voz.recognition.recognizer import Recognizer
from voz.speech.speaker import Speaker

Item = TypeVar("Item")

TYPED = "text"
"""The source of an utterance that was typed."""

NO_COMMAND = ("", "-")
"""Typed lines that only let a cycle pass."""


class Pipeline(Drive):
    """Drives by a time of its own, that of the recordings or lines: cycle by cycle."""

    def __init__(
        self,
        receivers: Sequence[Receiver],
        safety: Safety,
        listening: bool = False,
    ) -> None:
        """Start with the robot at rest, at time 0; the arguments are those of `Drive`."""
        super().__init__(receivers, safety, listening)
        self._cycles = 0

    @property
    def now(self) -> float:
        """When the next cycle is, s."""
        return self._cycles / CYCLES_PER_SECOND

    def hear(self, event: Utterance | Partial) -> None:
        """Let the cycles before something was heard pass, then take it."""
        self.pass_until(event.t)
        super().hear(event)

    def pass_until(self, t: float) -> None:
        """Let the cycles before a time pass, s."""
        while self.now < t:
            self.cycle()

    def awaited(self, items: Iterable[Item]) -> Iterator[Item]:
        """Give what is to be obeyed as it comes; here nothing happens while it does."""
        yield from items

    def cycle(self) -> None:
        """Send the velocities once, and go on by 0.1 s."""
        self.send(self.now)
        self._cycles += 1


@contextmanager
def running(
    receivers: Sequence[Receiver],
    safety: Safety,
    voice: str | None,
    listening: bool = False,
    make: Callable[[Sequence[Receiver], Safety, bool], Pipeline] = Pipeline,
) -> Iterator[Pipeline]:
    """A pipeline for the length of a `with` block; whatever ends it, zero velocity is sent last.

    Args:
        receivers: called with every event, in order.
        safety: the safety rules' settings.
        voice: who speaks the replies; None keeps the robot silent.
        listening: whether commands are obeyed before a `start speech`.
        make: makes the pipeline, if it is to be another kind.
    """
    speaker = Speaker(voice, REPLIES) if voice else None
    with speaker or nullcontext():
        if speaker:
            receivers = [*receivers, replies_to(speaker)]
        pipeline = make(receivers, safety, listening)
        with zero_at_the_end(lambda: pipeline.zero(pipeline.now)):
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
    for line in pipeline.awaited(lines):
        text = normalise(line)
        if text not in NO_COMMAND:
            known = text in commands
            now = pipeline.now
            pipeline.hear(typed(text, known, now))
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
    for heard in pipeline.awaited(_heard(paths, recognizer)):
        if isinstance(heard, AudioError):
            errors.append(str(heard))
            pipeline.emit(Warning(pipeline.now, str(heard)))
        elif isinstance(heard, float):
            pipeline.pass_until(heard)
        else:
            pipeline.hear(heard)
    pipeline.cycle()  # the last command takes effect
    return errors


def _heard(
    paths: Iterable[Path], recognizer: Recognizer
) -> Iterator[Utterance | Partial | AudioError | float]:
    """What is heard, what cannot be read, and when each recording ends, s."""
    heard = 0  # samples of all recordings so far

    def counted(blocks: Iterator[Samples]) -> Iterator[Samples]:
        nonlocal heard
        for block in blocks:
            heard += len(block)
            yield block

    for path in paths:
        begin = heard / SAMPLE_RATE
        try:
            for event in recognizer.events(counted(read_blocks(path)), printable(path)):
                yield later(event, begin)
        except AudioError as error:
            yield error
        yield heard / SAMPLE_RATE


def drive_by_bag(
    pipeline: Pipeline, path: Path, sayings: Sayings, commands: Collection[str]
) -> None:
    """Obey the sentences in a bag, each at its time.

    Args:
        pipeline: what obeys.
        path: the bag.
        sayings: what it holds.
        commands: the sentences of the command list; any other is not accepted.
    """
    end = sayings.seconds
    for t, said in pipeline.awaited(sayings.said):
        text = normalise(said)
        pipeline.hear(typed(text, text in commands, t, printable(path)))
        end = max(end, t + 1 / CYCLES_PER_SECOND)  # the last command takes effect
    pipeline.pass_until(end)


def typed(text: str, known: bool, now: float, source: str = TYPED) -> Utterance:
    """Make an utterance of a sentence that comes as text.

    Args:
        text: the sentence, normalised.
        known: whether it is in the command list; else it is not accepted.
        now: the time, s.
        source: where it comes from.
    """
    reason: Reason | None = None if known else "not_a_command"
    return Utterance(now, text, float(known), known, now, now, source, reason=reason)


def replies_to(speaker: Speaker) -> Receiver:
    """Make a receiver that lets a speaker say the replies."""

    def receive(event: Event) -> None:
        if isinstance(event, Reply):
            speaker.say(event.text)

    return receive
