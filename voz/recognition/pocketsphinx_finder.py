"""Finds the command in a segment by pocketsphinx alone, for other languages and small machines."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.denoise import denoise_if_noisy
from voz.audio.segment import SEGMENT_MARGIN, Segment
from voz.audio.voice_detector import RUN_UP, shared_voice_detector
from voz.events import SpokenWord
from voz.recognition.accents import plain_word
from voz.recognition.confidence import features, probability, trust_in_speech, voices_around
from voz.recognition.confidence_model import VOICES_AROUND, Model
from voz.recognition.decoder import Decoder, mean_start
from voz.recognition.evidence import CommandSearch, Evidence, Span
from voz.recognition.hypothesis import Hypothesis, Refusal
from voz.recognition.language import Language
from voz.recognition.refusal import refusal_by_pocketsphinx, unusable_sound
from voz.recognition.speaker.adaptation import StartVector
from voz.recognition.speaker.profiles import Profile
from voz.settings import Recognition

DECODER_FRAME = 160
"""Samples in a frame of pocketsphinx, 10 ms."""

LONG_SEGMENT = 3.0
"""A segment without evidence that is longer than this (s) was not too short."""


class PocketsphinxFinder:
    """Finds commands and their probability by pocketsphinx."""

    def __init__(
        self, language: Language, settings: Recognition, profile: Profile, model: Model
    ) -> None:
        """Load pocketsphinx; LanguageError if it cannot use the language files."""
        self._commands = language.commands
        self._command_search = CommandSearch(language, settings.never_missed, profile.mllr)
        alone = settings.search == "grammar" and self._command_search.finds_alone
        self._decoder = None if alone else Decoder(language, settings.search, profile.mllr)
        self._phones_of = language.pocketsphinx_words
        self._usual = language.spoken.frames
        self._model = model
        self._voice = shared_voice_detector()

    def understand(
        self, segment: Segment, learned: StartVector, answers: Sequence[str] = ()
    ) -> Hypothesis:
        """Find the command, with the probability that it was said; see `CommandFinder`."""
        spoken_until = segment.end - SEGMENT_MARGIN / SAMPLE_RATE
        sound = denoise_if_noisy(segment.samples)
        start = learned.moved(mean_start(sound))
        text = self._decoder.decode(sound, start) if self._decoder else ""
        if text and text not in self._commands:  # words of the trigram model that are no command
            return Hypothesis(segment, text, spoken_until)
        evidence = self._command_search.compare(sound, text, start)
        if evidence is None:
            why = partial(_why_refused, segment, None, 1.0)
            return Hypothesis(segment, text, spoken_until, why_refused=why)
        values = self._features(evidence, segment)
        trust = trust_in_speech(self._voice_in(segment, evidence))
        last = evidence.command.spans[-1]
        return Hypothesis(
            segment,
            evidence.text,
            spoken_until=_end(segment, last),
            values=values,
            trust=trust,
            probability=trust * probability(self._model, values),
            why_refused=partial(_why_refused, segment, evidence, trust),
            next_best=max(evidence.rivals, key=evidence.rivals.__getitem__, default=""),
            words=partial(_words, segment, evidence),
            others=partial(self._others, segment, sound, text, start, evidence.text, trust),
        )

    def _features(self, evidence: Evidence, segment: Segment) -> dict[str, float]:
        values = features(evidence, self._phones_of, self._usual)
        return values | {VOICES_AROUND: voices_around(segment.above, segment.voices)}

    def _others(
        self,
        segment: Segment,
        sound: Samples,
        proposed: str,
        start: str,
        best: str,
        trust: float,
        count: int,
    ) -> list[tuple[str, float]]:
        found = self._command_search.others(sound, proposed, start, best, count)
        return [
            (each.text, trust * probability(self._model, self._features(each, segment)))
            for each in found
        ]

    def _voice_in(self, segment: Segment, evidence: Evidence) -> float:
        words = evidence.command.spans
        begin = max(0, words[0].start * DECODER_FRAME - RUN_UP)
        return self._voice.probability(segment.samples[begin : words[-1].end * DECODER_FRAME])


def _words(segment: Segment, evidence: Evidence) -> tuple[SpokenWord, ...]:
    return tuple(
        SpokenWord(
            plain_word(span.name),
            round(segment.start + span.start * DECODER_FRAME / SAMPLE_RATE, 3),
            round(_end(segment, span), 3),
        )
        for span in evidence.command.spans
    )


def _end(segment: Segment, span: Span) -> float:
    """When a span ends in the stream, s."""
    return segment.start + (span.end + 1) * DECODER_FRAME / SAMPLE_RATE


def _why_refused(segment: Segment, evidence: Evidence | None, trust: float) -> Refusal:
    if reason := unusable_sound(segment.samples, trust):
        return reason, None
    if evidence is None:
        is_long = segment.end - segment.start > LONG_SEGMENT
        return "not_a_command" if is_long else "too_short", None
    return refusal_by_pocketsphinx(evidence)
