"""From an audio source to utterances."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from voz.audio import Samples
from voz.audio.endpoint import Segment, Segmenter
from voz.config import Recognition
from voz.errors import AudioError
from voz.events import Utterance
from voz.language.files import LanguageFiles, read_sentences
from voz.recognition.confidence import confidence
from voz.recognition.decoder import Decoder, PhoneLoop


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
        self._phone_loop = PhoneLoop(language)
        self._threshold = settings.threshold
        self._commands = frozenset(read_sentences(language))

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
        segmenter = Segmenter()
        failure = None
        try:
            for block in blocks:
                for segment in segmenter.feed(block):
                    yield self._recognize(segment, source)
        except AudioError as error:
            failure = error
        for segment in segmenter.finish():
            yield self._recognize(segment, source)
        if failure:
            raise failure

    def _recognize(self, segment: Segment, source: str) -> Utterance:
        text = self._decoder.decode(segment.samples)
        sure = confidence(self._phone_loop.ratio(segment.samples, text)) if text else 0.0
        return Utterance(
            t=round(segment.decided, 3),
            text=text,
            confidence=round(sure, 3),
            accepted=text in self._commands and sure >= self._threshold,
            start=round(segment.start, 3),
            end=round(segment.end, 3),
            source=source,
        )
