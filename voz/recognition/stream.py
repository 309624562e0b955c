"""Follows a stream of audio, and yields each utterance as early as it can be decided."""

from __future__ import annotations

from collections.abc import Iterator

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.levels import FRAME
from voz.audio.segment import Ongoing, Quiet, Segment, Sound, belong_together
from voz.audio.segmenter import Segmenter, VoiceFlags
from voz.events import Partial, Utterance
from voz.recognition.confidence import Context, probability
from voz.recognition.confidence_model import SCORE
from voz.recognition.decision import Decision, confidence_in_quiet
from voz.recognition.details import NO_DETAILS, Details
from voz.recognition.hypothesis import Hypothesis
from voz.recognition.interpreter import Interpreter

SAME_END_TOLERANCE = 2 * FRAME / SAMPLE_RATE
"""Two ends of a segment closer than this (s) are the same: nothing was said after the pause."""

PARTIAL_INTERVAL = 1.0
"""The same partial hypothesis is reported at most once in this time, s."""


class Stream:
    """Follows one stream of audio.

    A segment is understood at each pause. An accepted command is reported at once unless a longer
    one begins with it; else at the end of the segment, or, if it depends on what follows, when that
    is known. A possible `stop` is reported before a pause.
    """

    def __init__(
        self,
        interpreter: Interpreter,
        source: str,
        early: float,
        spotting: bool,
        voices: VoiceFlags | None = None,
        details: Details = NO_DETAILS,
        learns: bool = True,
    ) -> None:
        self._interpreter = interpreter
        self._learns = learns
        self._rule = interpreter.rule
        self._spotting = spotting
        self._source = source
        self._details = details
        self._segmenter = Segmenter(early, interpreter.longest, voices, interpreter.samples_before)
        self._paused: Hypothesis | None = None  # of the segment under way, up to its last pause
        self._waiting: Hypothesis | None = None  # hangs on what follows
        self._other: Segment | None = None  # speech just before that was no command
        self._name_until = 0.0  # where the robot's name ended that was reported last
        self._partial_text, self._partial_until = "", 0.0  # reported last, and not again before

    @property
    def background(self) -> float:
        """Level of the room, dB over one unit of 16 bits."""
        return self._segmenter.background

    @property
    def amid_speech(self) -> bool:
        """Whether somebody speaks just now."""
        return self._segmenter.amid_segment

    def feed(self, block: Samples) -> Iterator[Utterance | Partial]:
        """Take the next samples, 16 kHz; yields the events that they decide."""
        for sound in self._segmenter.feed(block):
            yield from self._take(sound)

    def warm_up(self, at: int, before: Samples) -> None:
        """Begin in the midst of a stream where nothing is said; see `Segmenter.warm_up`."""
        self._segmenter.warm_up(at, before)

    def resting_state(self) -> bytes | None:
        """All state that what follows depends on; None while or just after something is said."""
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
            waiting, self._waiting = self._heard_by_now(self._waiting, sound), None
            yield from self._report(waiting, _between(waiting.segment, sound), sound.decided)
        if isinstance(sound, Segment):
            sound = self._after_name(sound)
            follow = self._over if sound.over else self._pause
            context = Context.SPEECH if sound.amid else _between(self._other, sound)
            yield from follow(sound, context)

    def _after_name(self, segment: Segment) -> Segment:
        """A segment without the name before it that was reported: it is heard once."""
        since = max(0, round((segment.start - self._name_until) * SAMPLE_RATE))
        return segment._replace(before=segment.before[max(0, len(segment.before) - since) :])

    def _spot(self, sound: Ongoing) -> Iterator[Partial]:
        if spotted := self._interpreter.spot(sound.samples):
            sure = probability(self._interpreter.model, {SCORE: spotted.score})
            yield from self._partial(spotted.text, sure, sound.decided)

    def _partial(self, text: str, sure: float, decided: float) -> Iterator[Partial]:
        if text != self._partial_text or decided >= self._partial_until:
            self._partial_text, self._partial_until = text, decided + PARTIAL_INTERVAL
            command = self._interpreter.command_name(text)
            yield Partial(round(decided, 3), text, round(sure, 3), command)

    def _pause(self, segment: Segment, context: Context) -> Iterator[Utterance | Partial]:
        heard = self._paused = self._interpreter.understand(segment)
        decision = self._rule.decide(heard, context)
        if not decision.accepted:
            return
        if decision.waits or self._interpreter.has_continuation(heard.text):
            sure = confidence_in_quiet(heard)
            yield from self._partial(heard.text, sure, segment.decided)
        else:
            self._segmenter.cut()
            self._paused = None
            yield from self._report(heard, context, segment.decided)

    def _over(self, segment: Segment, context: Context) -> Iterator[Utterance]:
        heard, self._paused = self._paused, None
        is_same = heard is not None and segment.end <= heard.segment.end + SAME_END_TOLERANCE
        if heard is None or not is_same or self._needs_more(heard, segment, context):
            heard = self._interpreter.understand(segment)  # there may be more to hear by now
        decision = self._rule.decide(heard, context)
        if decision.waits or self._may_be_name(heard, decision, context):
            self._waiting = heard
        else:
            yield from self._report(heard, context, segment.decided)

    def _needs_more(self, heard: Hypothesis, segment: Segment, context: Context) -> bool:
        """Whether a little more sound changes what was heard, or may: the name may end softly."""
        if self._rule.decide(heard, context).waits:
            return True
        return not heard.named and self._interpreter.hears_name(segment)

    def _may_be_name(self, heard: Hypothesis, decision: Decision, context: Context) -> bool:
        """Whether what is refused may turn out to be the robot's name, which may end softly."""
        # What is refused amid speech must not be reported as if it were said in quiet.
        is_settled = heard.named or decision.accepted or context is not Context.QUIET
        if is_settled or not self._interpreter.has_name:
            return False
        return not self._rule.is_nearly_sure(heard, decision)

    def _heard_by_now(self, waiting: Hypothesis, sound: Sound) -> Hypothesis:
        """What waits, or the robot's name if that is in it with what followed."""
        if not isinstance(sound, Quiet) or waiting.named:
            return waiting
        longer = waiting.segment._replace(decided=sound.decided, after=sound.samples)
        named = self._interpreter.hears_name(longer)
        return self._interpreter.understand(longer) if named else waiting

    def _report(self, heard: Hypothesis, context: Context, decided: float) -> Iterator[Utterance]:
        utterance = self._interpreter.utterance(
            heard, context, decided, self._source, self._details
        )
        # What is too long for any command has not been asked about; it is hardly noise.
        is_speech = not heard.values or heard.trust > 0
        if utterance.accepted:
            self._segmenter.mark_command()
            if self._interpreter.is_name(utterance.text):
                self._name_until = heard.spoken_until
        self._other = heard.segment if is_speech and not utterance.accepted else None
        yield utterance
        if self._learns:
            self._interpreter.learn(heard)  # afterward, so that the robot need not wait for it


def _between(one: Segment | None, other: Sound) -> Context:
    near = one is not None and isinstance(other, Segment) and belong_together(one, other)
    return Context.SPEECH if near else Context.QUIET
