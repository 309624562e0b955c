"""Follows one stream of audio, and tells each utterance as early as it can be told."""

from __future__ import annotations

from collections.abc import Iterator

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.endpointing.frame_levels import FRAME
from voz.audio.endpointing.segment import Ongoing, Segment, Sound, belong_together
from voz.audio.endpointing.segmenter import Segmenter, VoiceFlags
from voz.events import Partial, Utterance
from voz.recognition.confidence import Around, probability
from voz.recognition.confidence_model import SCORE
from voz.recognition.hypothesis import Hypothesis
from voz.recognition.interpreter import Interpreter

SAME_END = 2 * FRAME / SAMPLE_RATE
"""By so much the ends of a segment may differ between its last pause and when it is over, s."""

TOLD_FOR = 1.0
"""What may have been said is told once in so long, s."""


class Stream:
    """Follows one stream of audio.

    A stretch of speech is understood when it pauses for a moment. If it is surely a command, and
    no longer one begins with it, it is told at once; else when it is over; and if it is so unsure
    that it hangs on what follows, when that is known. What may be a `stop` is told in its midst.
    """

    def __init__(
        self,
        interpreter: Interpreter,
        source: str,
        early: float,
        spotting: bool,
        voices: VoiceFlags | None = None,
    ) -> None:
        self._interpreter = interpreter
        self._spotting = spotting
        self._source = source
        self._segmenter = Segmenter(early, interpreter.longest, voices)
        self._paused: Hypothesis | None = None  # of the segment under way, up to its last pause
        self._waiting: Hypothesis | None = None  # hangs on what follows
        self._other: Segment | None = None  # speech just before that was no command
        self._told, self._told_until = "", 0.0  # what may have been said, and until when it is new

    @property
    def background(self) -> float:
        """The level of the room, dB over one unit of the 16 bits."""
        return self._segmenter.background

    def feed(self, block: Samples) -> Iterator[Utterance | Partial]:
        """Take the next samples, 16 kHz; yields what is known by them."""
        for sound in self._segmenter.feed(block):
            yield from self._take(sound)

    def warm_up(self, at: int, before: Samples) -> None:
        """Begin in the midst of a stream where nothing is said; see `Segmenter.warm_up`."""
        self._segmenter.warm_up(at, before)

    def resting_state(self) -> bytes | None:
        """Tell all that what follows hangs on; None while something is said, or just after it."""
        return self._segmenter.resting_state() if self._waiting is None else None

    def finish(self) -> Iterator[Utterance | Partial]:
        """End the stream; yields what was still open."""
        for sound in self._segmenter.finish():
            yield from self._take(sound)

    def _take(self, sound: Sound) -> Iterator[Utterance | Partial]:
        if isinstance(sound, Ongoing):
            if self._spotting:
                yield from self._spot(sound)
            return
        if self._waiting:
            waiting, self._waiting = self._waiting, None
            yield from self._tell(waiting, _between(waiting.segment, sound), sound.decided)
        if isinstance(sound, Segment):
            follow = self._over if sound.over else self._pause
            around = Around.SPEECH if sound.amid else _between(self._other, sound)
            yield from follow(sound, around)

    def _spot(self, sound: Ongoing) -> Iterator[Partial]:
        """Tell of a command that must not be missed before the sound around it pauses."""
        if spotted := self._interpreter.spot(sound.samples):
            sure = probability(self._interpreter.model, {SCORE: spotted.score})
            yield from self._perhaps(spotted.text, sure, sound.decided)

    def _perhaps(self, text: str, sure: float, decided: float) -> Iterator[Partial]:
        """Tell what may have been said, unless that was told just now."""
        if text != self._told or decided >= self._told_until:
            self._told, self._told_until = text, decided + TOLD_FOR
            command = self._interpreter.another_name(text)
            yield Partial(round(decided, 3), text, round(sure, 3), command)

    def _pause(self, segment: Segment, around: Around) -> Iterator[Utterance | Partial]:
        heard = self._paused = self._interpreter.understand(segment)
        if self._surely(heard, around) and not self._interpreter.has_continuation(heard.text):
            self._segmenter.cut()
            self._paused = None
            yield from self._tell(heard, around, segment.decided)
        elif self._interpreter.accepts(heard, around):
            yield from self._perhaps(heard.text, heard.sure, segment.decided)

    def _over(self, segment: Segment, around: Around) -> Iterator[Utterance]:
        paused, self._paused = self._paused, None
        is_same = paused is not None and segment.end <= paused.segment.end + SAME_END
        if paused and is_same and not self._hangs_on_what_follows(paused, around):
            heard = paused
        else:  # of what was unsure the network may have heard more by now
            heard = self._interpreter.understand(segment)
        if self._hangs_on_what_follows(heard, around):
            self._waiting = heard
        else:
            yield from self._tell(heard, around, segment.decided)

    def _hangs_on_what_follows(self, heard: Hypothesis, around: Around) -> bool:
        """Tell whether a command is obeyed only if nothing is said behind it."""
        return self._interpreter.accepts(heard, around) and not self._surely(heard, around)

    def _surely(self, heard: Hypothesis, around: Around) -> bool:
        """Tell whether a command is obeyed whatever follows."""
        so_far = Around.QUIET_SO_FAR if around is Around.QUIET else around
        return self._interpreter.accepts(heard, so_far)

    def _tell(self, heard: Hypothesis, around: Around, decided: float) -> Iterator[Utterance]:
        utterance = self._interpreter.judge(heard, around, decided, self._source)
        # What is too long for any command has not been asked about; it is hardly noise.
        is_speech = not heard.values or heard.trust > 0
        if utterance.accepted:
            self._segmenter.mark_command()
        self._other = heard.segment if is_speech and not utterance.accepted else None
        yield utterance
        self._interpreter.learn(heard)  # afterwards, so that the robot need not wait for it


def _between(one: Segment | None, other: Sound) -> Around:
    """Tell what each of two sounds has near it: the other, or nothing."""
    near = one is not None and isinstance(other, Segment) and belong_together(one, other)
    return Around.SPEECH if near else Around.QUIET
