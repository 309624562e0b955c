"""From an audio source to utterances."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from voz.audio import Samples
from voz.audio.endpoint import Segment, segments
from voz.audio.voice import VoiceDetector
from voz.config import Recognition
from voz.events import Utterance
from voz.language.files import LanguageFiles, count_phones, read_sentences
from voz.recognition.confidence import features, load_model, probability, trust_in_speech
from voz.recognition.decoder import Decoder
from voz.recognition.evidence import Comparison, Evidence

FRAME = 160
"""Samples in a frame of pocketsphinx, 10 ms."""


class Observation(NamedTuple):
    """What the confidence of an utterance is computed from.

    Attributes:
        text: the sentence heard.
        values: its features.
        trust: how far the sound is to be trusted to be speech, 0 to 1.
    """

    text: str
    values: dict[str, float]
    trust: float


class Recognizer:
    """Finds the utterances in a stream and what was said in each; made once, used for many."""

    def __init__(self, language: LanguageFiles, settings: Recognition) -> None:
        """Load the models.

        Args:
            language: the language files.
            settings: which search, and the confidence that is needed.

        Raises:
            LanguageError: the language files cannot be used.
        """
        self._decoder = Decoder(language, settings.search)
        self._threshold = settings.threshold
        self._commands = read_sentences(language)
        self._comparison = Comparison(language, self._commands)
        self._phones_in = count_phones(language)
        self._model = load_model()
        self._voice = VoiceDetector()

    def utterances(self, blocks: Iterable[Samples], source: str) -> Iterator[Utterance]:
        """Recognise one recording, as if there were no other.

        Args:
            blocks: its samples, 16 kHz, in blocks of any size.
            source: its name for the utterances.

        Yields:
            Each stretch of speech as soon as its end is known; times are within the recording.

        Raises:
            AudioError: the blocks end in one; what was heard up to there is yielded first.
        """
        for segment in segments(blocks):
            yield self._recognize(segment, source)

    def observations(self, blocks: Iterable[Samples]) -> Iterator[Observation]:
        """Find what the confidence is computed from, for those who fit it.

        Args:
            blocks: a recording, as for `utterances`.

        Yields:
            What is known of each utterance that may be a command.
        """
        for segment in segments(blocks):
            text, evidence = self._evidence(segment.samples)
            if evidence:
                voice = self._voice_in(segment.samples, evidence)
                yield Observation(text, features(evidence, self._phones_in), trust_in_speech(voice))

    def _recognize(self, segment: Segment, source: str) -> Utterance:
        text, sure = self._understand(segment.samples)
        return Utterance(
            t=round(segment.decided, 3),
            text=text,
            confidence=round(sure, 3),
            accepted=text in self._commands and sure >= self._threshold,
            start=round(segment.start, 3),
            end=round(segment.end, 3),
            source=source,
        )

    def _understand(self, samples: Samples) -> tuple[str, float]:
        """Find the sentence of an utterance, and how likely it is that it was said."""
        text, evidence = self._evidence(samples)
        if evidence is None:
            return text, 0.0
        sure = probability(self._model, features(evidence, self._phones_in))
        # Whether it is speech takes as long as all the rest, so it is asked last.
        if sure >= self._threshold:
            sure *= trust_in_speech(self._voice_in(samples, evidence))
        return text, sure

    def _evidence(self, samples: Samples) -> tuple[str, Evidence | None]:
        """Find the sentence, and what speaks for it if it is a command."""
        text = self._decoder.decode(samples)
        if text and text not in self._commands:
            return text, None  # words of the trigram model that are no command
        # Without a result, the comparison is the second try: nothing is pruned in it.
        evidence = self._comparison.compare(samples, text)
        return (evidence.text if evidence else text), evidence

    def _voice_in(self, samples: Samples, evidence: Evidence) -> float:
        """How sure it is that what was taken for the words is speech."""
        words = evidence.command.spans
        return self._voice.probability(samples[words[0].start * FRAME : words[-1].end * FRAME])
