"""Follows a stream of audio, and yields each utterance as early as it can be decided."""

from __future__ import annotations

import math
from collections.abc import Iterator

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.levels import FRAME
from voz.audio.segment import Ongoing, Quiet, Segment, SegmenterEvent, belong_together
from voz.audio.segmenter import Segmenter
from voz.events import Partial, Utterance
from voz.recognition.confidence import SCORE, Context, probability
from voz.recognition.decision import Decision
from voz.recognition.interpreter import NO_DETAILS, Details, Interpreter

SAME_END_TOLERANCE = 2 * FRAME / SAMPLE_RATE
"""Two ends of a segment closer than this (s) are the same: nothing was said after the pause."""

PARTIAL_INTERVAL = 1.0
"""The same partial hypothesis is reported at most once in this time, s."""


class Stream:
    """Follows one stream of audio.

    A segment is understood at each pause. An accepted command is reported at once unless a longer
    one begins with it; else at the end of the segment, or, if it depends on what follows, when that
    is known. A sentence with slots that may go on waits for a second segment, and both are
    understood as one. A possible `stop` is reported before a pause.
    """

    def __init__(
        self,
        interpreter: Interpreter,
        source: str,
        early: float,
        spotting: bool,
        details: Details = NO_DETAILS,
    ) -> None:
        self._interpreter = interpreter
        self._spotting = spotting
        self._source = source
        self._details = details
        self._before = interpreter.samples_before
        kept = max(self._before, interpreter.longest_pause)
        self._segmenter = Segmenter(early, interpreter.longest, kept)
        self._paused: Decision | None = None  # of the segment under way, up to its last pause
        self._waiting: Decision | None = None  # hangs on what follows, or may go on
        self._other: Segment | None = None  # speech just before that was no command
        self._name_until = 0.0  # where the robot's name ended that was reported last
        self._partial_text, self._partial_until = "", 0.0  # reported last, and not again before

    @property
    def background(self) -> float:
        """Level of the room, dB over one unit of 16 bits."""
        return self._segmenter.background

    @property
    def in_segment(self) -> bool:
        """Whether somebody speaks just now."""
        return self._segmenter.in_segment

    def feed(self, block: Samples) -> Iterator[Utterance | Partial]:
        """Take the next samples, 16 kHz; yields the events that they decide."""
        for sound in self._segmenter.feed(block):
            yield from self._take(sound)

    def finish(self) -> Iterator[Utterance | Partial]:
        """End the stream; yields what was still open."""
        for sound in self._segmenter.finish():
            yield from self._take(sound)

    def _take(self, sound: SegmenterEvent) -> Iterator[Utterance | Partial]:
        if isinstance(sound, Ongoing):
            if self._spotting:
                yield from self._spot(sound)
            return
        if whole := self._continued(self._waiting, sound):
            yield from self._take_whole(whole)
            return
        if self._waiting:
            decision, self._waiting = self._settled(self._waiting, sound), None
            yield from self._report(decision, sound.decided)
        if isinstance(sound, Segment):
            sound = self._after_name(sound)
            follow = self._over if sound.over else self._pause
            beside = [self._other] if self._other else []
            yield from follow(sound, self._interpreter.context(sound, beside))

    def _after_name(self, segment: Segment) -> Segment:
        """A segment without the name before it that was reported: it is heard once."""
        since = max(0, round((segment.start - self._name_until) * SAMPLE_RATE))
        kept = min(since, self._before)
        return segment._replace(before=segment.before[max(0, len(segment.before) - kept) :])

    def _continued(self, first: Decision | None, segment: SegmenterEvent) -> Decision | None:
        """The decision about both as one sentence; None if the segment does not continue it."""
        if first is None or not isinstance(segment, Segment):
            return None
        begun = first.hypothesis.segment
        may_be_continued = self._interpreter.may_be_continued
        if not (may_be_continued(first) and belong_together(begun, segment)):
            return None
        whole = self._decide(begun.joined(segment), first.context)
        # What was accepted is not all of it, though the rest is not sure.
        fits_better = first.accepted and _score(whole) > _score(first)
        is_one = whole.accepted or may_be_continued(whole) or fits_better
        if not is_one or _words(whole) <= _words(first):
            return None
        alone = self._decide(self._after_name(segment), Context.QUIET)
        return None if self._interpreter.is_never_missed(alone) else whole

    def _take_whole(self, whole: Decision) -> Iterator[Utterance | Partial]:
        """Report a sentence that went on after a pause, or wait for what follows."""
        heard = whole.hypothesis
        if heard.segment.over:
            yield from self._finish(whole, heard.segment.decided)
        elif whole.accepted:
            yield from self._report_at_pause(whole)

    def _spot(self, sound: Ongoing) -> Iterator[Partial]:
        spotter = self._interpreter.spotter
        if spotter and (spotted := spotter.spot(sound.samples)):
            sure = probability(self._interpreter.model, {SCORE: spotted.score})
            yield from self._partial(spotted.text, sure, sound.decided)

    def _partial(self, text: str, sure: float, decided: float) -> Iterator[Partial]:
        if text != self._partial_text or decided >= self._partial_until:
            self._partial_text, self._partial_until = text, decided + PARTIAL_INTERVAL
            command = self._interpreter.command_name(text)
            yield Partial(round(decided, 3), text, round(sure, 3), command)

    def _decide(self, segment: Segment, context: Context) -> Decision:
        return self._interpreter.rule.decide(self._interpreter.understand(segment), context)

    def _pause(self, segment: Segment, context: Context) -> Iterator[Utterance | Partial]:
        self._paused = self._decide(segment, context)
        if self._paused.accepted:
            yield from self._report_at_pause(self._paused)

    def _report_at_pause(self, decision: Decision) -> Iterator[Utterance | Partial]:
        """Report an accepted command, as partial if what follows may change it."""
        heard = decision.hypothesis
        decided = heard.segment.decided
        if decision.waits or self._interpreter.has_continuation(heard.text):
            yield from self._partial(heard.text, heard.confidence, decided)
        else:
            self._segmenter.cut()
            self._paused = self._waiting = None
            yield from self._report(decision, decided)

    def _over(self, segment: Segment, context: Context) -> Iterator[Utterance]:
        decision, self._paused = self._paused and self._paused.within(context), None
        if decision is None or self._has_more(segment, decision):
            decision = self._decide(segment, context)
        yield from self._finish(decision, segment.decided)

    def _finish(self, decision: Decision, decided: float) -> Iterator[Utterance]:
        """Report the decision about a segment that is over, or wait for what follows."""
        may_go_on = self._interpreter.may_be_continued(decision)
        if decision.waits or self._may_be_name(decision) or may_go_on:
            self._waiting = decision
            if may_go_on:
                self._segmenter.expect_rest()
        else:
            self._waiting = None
            yield from self._report(decision, decided)

    def _has_more(self, segment: Segment, decision: Decision) -> bool:
        """Whether more was said since the pause, or a little more sound may change the decision."""
        heard = decision.hypothesis
        if decision.waits or segment.end > heard.segment.end + SAME_END_TOLERANCE:
            return True
        return not heard.named and self._interpreter.hears_name(segment)  # it may end softly

    def _may_be_name(self, decision: Decision) -> bool:
        """Whether what is refused may turn out to be the robot's name, which may end softly."""
        # What is refused amid speech must not be reported as if it were said in quiet.
        is_settled = decision.accepted or decision.context is not Context.QUIET
        if is_settled or decision.hypothesis.named or not self._interpreter.has_name:
            return False
        return not decision.is_nearly_sure

    def _settled(self, waiting: Decision, sound: SegmenterEvent) -> Decision:
        """What becomes of a decision that waits, by what followed; the name may be in that."""
        heard = waiting.hypothesis
        beside = [sound] if isinstance(sound, Segment) else []
        context = self._interpreter.context(heard.segment, beside)
        if isinstance(sound, Quiet) and not heard.named:
            longer = heard.segment._replace(decided=sound.decided, after=sound.samples)
            if self._interpreter.hears_name(longer):
                return self._decide(longer, context)
            if self._may_be_rest(waiting, sound):
                more = self._decide(longer, context)
                if _words(more) > _words(waiting):
                    return more
        # What was sure enough waited only for the rest of a sentence.
        return waiting if waiting.accepted and not waiting.waits else waiting.within(context)

    def _may_be_rest(self, waiting: Decision, quiet: Quiet) -> bool:
        """Whether the rest of a sentence may be in sound that is too soft for a segment."""
        may_go_on = self._interpreter.may_be_continued(waiting)
        return may_go_on and self._interpreter.hears_words(quiet.samples)

    def _report(self, decision: Decision, decided: float) -> Iterator[Utterance]:
        heard = decision.hypothesis
        utterance = self._interpreter.utterance(decision, decided, self._source, self._details)
        # What is too long for any command has not been asked about; it is hardly noise.
        is_speech = not heard.features or heard.speech_probability > 0
        if utterance.accepted:
            self._segmenter.mark_command()
            if decision.required.is_name:
                self._name_until = heard.spoken_until
        self._other = heard.segment if is_speech and not utterance.accepted else None
        yield utterance


def _words(decision: Decision) -> int:
    """How many words were heard, of a sentence or of its beginning."""
    heard = decision.hypothesis
    is_begun = not decision.accepted and heard.rival is not None and heard.rival.is_begun
    return len((heard.rival.text if heard.rival and is_begun else heard.text).split())


def _score(decision: Decision) -> float:
    return decision.hypothesis.features.get(SCORE, -math.inf)
