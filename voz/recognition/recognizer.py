"""From an audio source to utterances."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

from voz.audio import Samples
from voz.audio.denoise import cleaned
from voz.audio.endpoint import Quiet, Segment, follow_closely, segments, sounds
from voz.audio.voice import RUN_UP, VoiceDetector
from voz.config import Recognition
from voz.events import Utterance
from voz.language.files import LanguageFiles, read_pronunciations, read_sentences
from voz.recognition.accents import with_accents
from voz.recognition.adaptation import Aligner, StartVector, teaches
from voz.recognition.confidence import (
    Model,
    among_speech,
    features,
    load_model,
    probability,
    threshold_for,
    trust_in_speech,
    with_log_odds,
    with_odds,
)
from voz.recognition.decoder import Decoder, mean_start
from voz.recognition.evidence import Comparison, Evidence
from voz.recognition.profiles import Profile
from voz.recognition.refusal import why_refused

FRAME = 160
"""Samples in a frame of pocketsphinx, 10 ms."""


class Observation(NamedTuple):
    """What the confidence of an utterance is computed from.

    Attributes:
        text: the sentence heard.
        values: its features.
        trust: how far the sound is to be trusted to be speech, 0 to 1.
        among: whether there is other speech around it.
    """

    text: str
    values: dict[str, float]
    trust: float
    among: bool


class _Heard(NamedTuple):
    """What was understood of a segment, before it is known what follows."""

    segment: Segment
    text: str
    evidence: Evidence | None
    trust: float
    sure: float  # if there is no other speech around it
    values: Mapping[str, float]  # the features; empty without evidence


class Recognizer:
    """Finds the utterances in a stream and what was said in each; made once, used for many.

    Attributes:
        learnt: what is known of the microphone and the speaker; it changes only while learning.
    """

    def __init__(
        self,
        language: LanguageFiles,
        settings: Recognition,
        profile: Profile | None = None,
        learning: bool = False,
    ) -> None:
        """Load the models.

        Args:
            language: the language files.
            settings: which search, and how sure it must be.
            profile: what is known of the speaker and the microphone.
            learning: whether to learn more from each utterance, for those that follow.

        Raises:
            LanguageError: the language files cannot be used.
        """
        profile = profile or Profile()
        self.learnt = profile.start
        self._aligner = Aligner(language) if learning else None
        self._commands = read_sentences(language)
        self._comparison = Comparison(language, self._commands, settings.never_missed, profile.mllr)
        alone = settings.search == "grammar" and self._comparison.finds_alone
        self._decoder = None if alone else Decoder(language, settings.search, profile.mllr)
        self._phones_of = with_accents(read_pronunciations(language))
        self._model = with_log_odds(load_model(), profile.log_odds)
        self._needed = thresholds(self._model, settings, self._commands)
        self._voice = VoiceDetector()

    def utterances(self, blocks: Iterable[Samples], source: str) -> Iterator[Utterance]:
        """Recognise one recording; unless it is learning, as if there were no other.

        Args:
            blocks: its samples, 16 kHz, in blocks of any size.
            source: its name for the utterances.

        Yields:
            Each stretch of speech as soon as its end is known, or if it hangs on that, what
            follows; times are within the recording.

        Raises:
            AudioError: the blocks end in one; what was heard up to there is yielded first.
        """
        waiting: _Heard | None = None
        other: Segment | None = None  # speech just before that was no command
        for sound in sounds(blocks):
            if waiting:
                among = isinstance(sound, Segment) and follow_closely(waiting.segment, sound)
                utterance = self._utterance(waiting, among, sound.decided, source)
                other = None if utterance.accepted else waiting.segment
                yield utterance
                self._learn(waiting)
                waiting = None
            if isinstance(sound, Quiet):
                continue
            heard = self._understand(sound, self.learnt)
            among = other is not None and follow_closely(other, sound)
            if not among and self._hangs_on_what_follows(heard):
                waiting = heard
                continue
            utterance = self._utterance(heard, among, sound.decided, source)
            # What is too long for any command has not been asked about; it is hardly noise.
            is_speech = heard.evidence is None or heard.trust > 0
            other = sound if is_speech and not utterance.accepted else None
            yield utterance
            self._learn(heard)  # afterwards, so that the robot need not wait for it

    def observations(self, blocks: Iterable[Samples]) -> Iterator[Observation]:
        """Find what the confidence is computed from, for those who fit it.

        Args:
            blocks: a recording, as for `utterances`.

        Yields:
            What is known of each utterance that may be a command.
        """
        found = list(segments(blocks))
        after = [follow_closely(one, other) for one, other in pairwise(found)]
        for number, segment in enumerate(found):
            heard = self._understand(segment, self.learnt)
            if heard.evidence:
                among = any(after[max(0, number - 1) : number + 1])
                yield Observation(heard.text, dict(heard.values), heard.trust, among)

    def _understand(self, segment: Segment, learnt: StartVector) -> _Heard:
        """Find the sentence of a segment, and how likely it is that it was said."""
        sound = cleaned(segment.samples)
        start = learnt.moved(mean_start(sound))
        text = self._decoder.decode(sound, start) if self._decoder else ""
        if text and text not in self._commands:  # words of the trigram model that are no command
            return _Heard(segment, text, None, 0.0, 0.0, {})
        evidence = self._comparison.compare(sound, text, start)
        if evidence is None:
            return _Heard(segment, text, None, 0.0, 0.0, {})
        trust = trust_in_speech(self._voice_in(segment.samples, evidence))
        values = features(evidence, self._phones_of)
        sure = trust * probability(self._model, values)
        return _Heard(segment, evidence.text, evidence, trust, sure, values)

    def _learn(self, heard: _Heard) -> None:
        """Learn from an utterance, or doubt what was learnt if it is understood only without."""
        if self._aligner is None:
            return
        if teaches(heard.values, heard.trust):
            sound = cleaned(heard.segment.samples)
            start = mean_start(sound)
            observed = self._aligner.observe(sound, heard.text, start, self.learnt)
            if observed:
                self.learnt = self.learnt.updated(observed)
        elif self.learnt.frames and self._teaches_without(heard.segment):
            self.learnt = self.learnt.doubted()
        else:
            self.learnt = self.learnt.passed()

    def _teaches_without(self, segment: Segment) -> bool:
        """Tell whether it could be learnt from, had nothing been learnt yet."""
        heard = self._understand(segment, StartVector())
        return teaches(heard.values, heard.trust)

    def _voice_in(self, samples: Samples, evidence: Evidence) -> float:
        """How sure it is that what was taken for the words is speech."""
        words = evidence.command.spans
        begin = max(0, words[0].start * FRAME - RUN_UP)
        return self._voice.probability(samples[begin : words[-1].end * FRAME])

    def _hangs_on_what_follows(self, heard: _Heard) -> bool:
        return self._accepts(heard.text, heard.sure) and not self._accepts(
            heard.text, among_speech(heard.sure)
        )

    def _accepts(self, text: str, sure: float) -> bool:
        return text in self._needed and sure >= self._needed[text]

    def _utterance(self, heard: _Heard, among: bool, decided: float, source: str) -> Utterance:
        """Judge what was heard by what is around it."""
        segment, text, evidence, trust, sure, _ = heard
        sure = among_speech(sure) if among else sure
        accepted = self._accepts(text, sure)
        refusal = None if accepted else why_refused(segment.samples, evidence, trust)
        reason, between = refusal or (None, None)
        return Utterance(
            t=round(decided, 3),
            text=text,
            confidence=round(sure, 3),
            accepted=accepted,
            start=round(segment.start, 3),
            end=round(segment.end, 3),
            source=source,
            reason=reason,
            between=between,
        )


def thresholds(model: Model, settings: Recognition, commands: Iterable[str]) -> dict[str, float]:
    """Tell how sure each command must be: the less, the worse it is to miss it.

    Args:
        model: knows how many false alarms there are at each threshold.
        settings: how many there may be, and which commands must not be missed.
        commands: all sentences.

    Returns:
        A threshold from 0 to 1 for each command.
    """
    usual = settings.threshold
    if usual is not None:
        return dict.fromkeys(commands, usual)
    usual = threshold_for(model, settings.false_alarms_per_hour)
    lower = with_odds(usual, 1 / settings.missed_cost)
    return {c: lower if c in settings.never_missed else usual for c in commands}
