"""What drives a robot besides a microphone: recordings, typed lines and bags, by their own time.

Nothing here reads a clock: a recording lasts as long as its samples, a typed line 0.1 s. So a run
is as fast as the computer and gives the same events each time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.sound_files import read_blocks
from voz.control.table import TYPED_HELP
from voz.errors import AudioError
from voz.events import Notice, Utterance, shift_time
from voz.files import shown_path
from voz.inbox import Inbox
from voz.language.sentences.command_set import Commands, Parse
from voz.language.sentences.spelling import normalize, spoken_forms, strip_accents
from voz.recognition.engine import RecognitionEngine
from voz.recognition.interpreter import NO_DETAILS, Details
from voz.run.clocks import BEATS_PER_SECOND, Item, beats_before

TYPED = "text"
"""The source of an utterance that was typed."""

MAX_COMMAND_LENGTH = 200
"""Characters of a line or a message that are read as a command; one has fewer."""

HELP_WORDS = ("help", "commands")
"""What asks what may be said, as a question mark alone does."""

MAX_TEXT_LENGTH = 10_000
"""Characters of a line or a message in which a stop is looked for."""

MAX_STOPS = 100
"""Sentences of each command that stops the robot, the shortest first, which are looked for."""

NO_COMMAND = ("", "-")
"""Typed lines that only let a beat pass."""


@dataclass(frozen=True)
class BagSentence:
    """A sentence that a recognizer published, `t` seconds after the bag begins."""

    t: float
    text: str


@dataclass(frozen=True)
class BagContent:
    """All sentences in a bag, in order, and how long the bag is, s."""

    sentences: list[BagSentence]
    seconds: float


def typed_items(
    lines: Iterable[str],
    commands: Commands,
    halts: Collection[str],
    now: Callable[[], float] = lambda: 0.0,
) -> Iterator[Item]:
    """Yield typed lines, one for each beat; `-` or nothing lets a beat pass.

    The time of the run, `now`, may have gone on while a line was waited for.
    """
    beats = 0
    for line in lines:
        beats = max(beats, beats_before(now()))
        if normalize(line) not in NO_COMMAND:
            yield text_utterance(line, commands, halts, beats / BEATS_PER_SECOND)
        beats += 1
        yield beats / BEATS_PER_SECOND


def recorded_items(
    paths: Iterable[Path],
    recognizer: RecognitionEngine,
    unreadable: list[str],
    details: Details = NO_DETAILS,
) -> Iterator[Item]:
    """Yield what is heard in recordings, one after the other as one stream of time.

    A recording that cannot be read is a Notice, and its message is added to `unreadable`; one that
    is read otherwise than it stands there is a Notice too.
    """
    heard = 0  # samples of all recordings so far

    def count_samples(blocks: Iterator[Samples]) -> Iterator[Samples]:
        nonlocal heard
        for block in blocks:
            heard += len(block)
            yield block

    for path in paths:
        begin = heard / SAMPLE_RATE
        warnings: list[str] = []
        try:
            blocks = count_samples(read_blocks(path, warnings.append))
            for event in recognizer.events(blocks, shown_path(path), details):
                yield shift_time(event, begin)
        except AudioError as error:
            unreadable.append(str(error))
            warnings.append(str(error))
        for warning in warnings:
            yield Notice(beats_before(heard / SAMPLE_RATE) / BEATS_PER_SECOND, warning)
        yield heard / SAMPLE_RATE
    # The last command takes effect.
    yield (beats_before(heard / SAMPLE_RATE) + 1) / BEATS_PER_SECOND


def bag_items(
    path: Path, content: BagContent, commands: Commands, halts: Collection[str]
) -> Iterator[Item]:
    """Yield the sentences in a bag, each at its time."""
    end = content.seconds
    for sentence in content.sentences:
        yield text_utterance(sentence.text, commands, halts, sentence.t, shown_path(path))
        end = max(end, sentence.t + 1 / BEATS_PER_SECOND)  # the last command takes effect
    yield end


def text_utterance(
    text: str, commands: Commands, halts: Collection[str], now: float, source: str = TYPED
) -> Utterance:
    """The utterance of a sentence that comes as text at a time, s, by any door.

    The text may have capitals, digits and a full stop; `halts` are the commands that leave the
    robot at rest.
    """
    return parsed_utterance(text, read_text(text, commands, halts), commands, now, source)


def parsed_utterance(
    text: str, parse: Parse | None, commands: Commands, now: float, source: str
) -> Utterance:
    """Make an utterance of a sentence that `read_text` has read; else as `text_utterance`."""
    if parse is None:
        text = normalize(text[:MAX_COMMAND_LENGTH])
        meant = commands.closest_sentence(text)
        return Utterance(
            now, text, 0.0, False, now, now, source, reason="not_a_command", meant=meant
        )
    return Utterance(
        now,
        parse.text,
        1.0,
        True,
        now,
        now,
        source,
        command=parse.command,
        slots=dict(parse.slots),
    )


def read_text(text: str, commands: Commands, halts: Collection[str]) -> Parse | None:
    """Find the command that a text is; of other text, the one that stops the robot, if it has one.

    "Hey robot, please stop now" stops: a robot that stops for nothing does less harm than one that
    drives on. Of several the longest counts, so that "stop speech, please" ends the listening.
    """
    found = commands.parse(normalize(text[:MAX_COMMAND_LENGTH]))
    if found is None:
        ways = spoken_forms(text[:MAX_TEXT_LENGTH])
        said = strip_accents(f" {' '.join(way[0] for way in ways)} ")
        for stop in _stopping(commands, frozenset(halts)):
            if f" {strip_accents(stop.text)} " in said:
                return stop
        asked = normalize(text[:MAX_COMMAND_LENGTH])
        if asked == TYPED_HELP or asked.rstrip(".!? ") in HELP_WORDS:
            return Parse(asked, TYPED_HELP)
    return found


@lru_cache(maxsize=4)
def _stopping(commands: Commands, halts: frozenset[str]) -> list[Parse]:
    """What leaves the robot at rest, the longest first; its names count in any list."""
    texts = {*commands.named(halts, MAX_STOPS), *halts}
    found = [commands.parse(text) or Parse(text, text) for text in texts]
    return sorted(found, key=lambda parse: (-len(parse.text), parse.text))


MAX_REFUSED_PER_SECOND = 16
"""Texts a second that are reported as no command, at 2 ms each. More are dropped and counted, so
that a `stop` behind them need not wait."""


class TextCommands:
    """Puts commands that come as text into the inbox of a run, on any thread."""

    def __init__(
        self, commands: Callable[[], Commands], inbox: Inbox, now: Callable[[], float]
    ) -> None:
        """Prepare to take texts; `commands` returns those of now, `now` the time of the run, s."""
        self._commands = commands
        self._inbox = inbox
        self._now = now
        self._refused: deque[float] = deque(
            [-1.0] * MAX_REFUSED_PER_SECOND, MAX_REFUSED_PER_SECOND
        )  # when, s

    def take(self, text: str, source: str = TYPED) -> None:
        """Obey a text as if it were spoken; it may have capitals, digits and a full stop."""
        if normalize(text) in NO_COMMAND:
            return
        commands, now = self._commands(), self._now()
        parse = read_text(text, commands, self._inbox.halts)
        if parse is None:
            if now - self._refused[0] < 1:
                self._inbox.dropped += 1
                return
            self._refused.append(now)
        self._inbox.put(parsed_utterance(text, parse, commands, now, source))

    def continues(self, text: str) -> bool:
        """Return whether a space after a text goes on with a command.

        Not after one that stops the robot, though `stop` may become `stop speech`: the space bar
        then means to stop.
        """
        commands = self._commands()
        parse = commands.parse(text)
        return not (parse and parse.command in self._inbox.halts) and commands.is_typed_prefix(text)
