"""From a stretch of speech to its sentence, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.denoise import cleaned
from voz.audio.endpoint import MARGIN, Segment
from voz.audio.voice import RUN_UP, VoiceDetector
from voz.config import Recognition
from voz.events import Utterance
from voz.language.files import LanguageFiles, read_pronunciations, read_sentences
from voz.recognition.accents import with_accents
from voz.recognition.adaptation import Aligner, StartVector, teaches
from voz.recognition.confidence import (
    VOICES_AROUND,
    Around,
    Model,
    features,
    in_company,
    load_model,
    probability,
    threshold_for,
    trust_in_speech,
    voices_around,
    with_log_odds,
    with_odds,
)
from voz.recognition.decoder import Decoder, mean_start
from voz.recognition.evidence import Comparison, Evidence
from voz.recognition.profiles import Profile
from voz.recognition.refusal import why_refused

FRAME = 160
"""Samples in a frame of pocketsphinx, 10 ms."""

LONGEST_WORD = 0.7
"""Seconds; who speaks slowly says a word of a command in that."""

PAUSES = 2.0
"""Seconds that a command takes besides its words: silence, hesitation, noise before and after."""


class Heard(NamedTuple):
    """What was understood of a segment, before it is known what follows.

    Attributes:
        segment: the stretch of speech.
        text: the sentence that fits best; empty if none does.
        evidence: what speaks for it and against it; None if it cannot be a command.
        trust: how far the sound is to be trusted to be speech, 0 to 1.
        sure: the probability that it was said, if there is no other speech around it.
        values: the features of that probability; empty without evidence.
    """

    segment: Segment
    text: str
    evidence: Evidence | None = None
    trust: float = 0.0
    sure: float = 0.0
    values: Mapping[str, float] = MappingProxyType({})

    @property
    def spoken_until(self) -> float:
        """Where the last word ends in the stream, s."""
        if self.evidence is None:
            return self.segment.end - MARGIN / SAMPLE_RATE
        last = self.evidence.command.spans[-1]
        return self.segment.start + (last.end + 1) * FRAME / SAMPLE_RATE


class Interpreter:
    """Finds what was said in stretches of speech; made once, used for many.

    Attributes:
        learnt: what is known of the microphone and the speaker; it changes only while learning.
        longest: how long a command may take, s.
    """

    def __init__(
        self,
        language: LanguageFiles,
        settings: Recognition,
        profile: Profile,
        learning: bool,
    ) -> None:
        """Load the models; arguments and errors are those of `Recognizer`."""
        self.learnt = profile.start
        self._aligner = Aligner(language) if learning else None
        self._commands = read_sentences(language)
        self._comparison = Comparison(language, self._commands, settings.never_missed, profile.mllr)
        alone = settings.search == "grammar" and self._comparison.finds_alone
        self._decoder = None if alone else Decoder(language, settings.search, profile.mllr)
        self._phones_of = with_accents(read_pronunciations(language))
        self._model = with_log_odds(load_model(), profile.log_odds)
        most_words = max((len(command.split()) for command in self._commands), default=0)
        self.longest = PAUSES + LONGEST_WORD * most_words
        self._needed = thresholds(self._model, settings, self._commands)
        self._voice = VoiceDetector()

    def understand(self, segment: Segment, learnt: StartVector | None = None) -> Heard:
        """Find the sentence of a segment, and how likely it is that it was said.

        Args:
            segment: the stretch of speech.
            learnt: in place of what is known of the microphone and the speaker.
        """
        if segment.end - segment.start > self.longest:
            return Heard(segment, "")  # no command, and it would take long to find that out
        learnt = self.learnt if learnt is None else learnt
        sound = cleaned(segment.samples)
        start = learnt.moved(mean_start(sound))
        text = self._decoder.decode(sound, start) if self._decoder else ""
        if text and text not in self._commands:  # words of the trigram model that are no command
            return Heard(segment, text)
        evidence = self._comparison.compare(sound, text, start)
        if evidence is None:
            return Heard(segment, text)
        trust = trust_in_speech(self._voice_in(segment.samples, evidence))
        values = features(evidence, self._phones_of)
        values[VOICES_AROUND] = voices_around(segment.above, segment.voices)
        sure = trust * probability(self._model, values)
        return Heard(segment, evidence.text, evidence, trust, sure, values)

    def learn(self, heard: Heard) -> None:
        """Learn from an utterance, or doubt what was learnt if it is understood only without.

        Nothing happens unless it was made to learn.
        """
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
        heard = self.understand(segment, StartVector())
        return teaches(heard.values, heard.trust)

    def _voice_in(self, samples: Samples, evidence: Evidence) -> float:
        """How sure it is that what was taken for the words is speech."""
        words = evidence.command.spans
        begin = max(0, words[0].start * FRAME - RUN_UP)
        return self._voice.probability(samples[begin : words[-1].end * FRAME])

    def accepts(self, heard: Heard, around: Around) -> bool:
        """Tell whether a command is sure enough to be obeyed, by what is around it."""
        return self._accepts(heard.text, in_company(heard.sure, around))

    def may_go_on(self, text: str) -> bool:
        """Tell whether a longer command begins with this one."""
        return any(command.startswith(f"{text} ") for command in self._commands)

    def _accepts(self, text: str, sure: float) -> bool:
        return text in self._needed and sure >= self._needed[text]

    def judge(self, heard: Heard, around: Around, decided: float, source: str) -> Utterance:
        """Decide whether what was heard is obeyed.

        Args:
            heard: what was understood.
            around: what is around it.
            decided: the time of the decision, s.
            source: where it comes from.
        """
        segment, text, evidence, trust, sure, _ = heard
        sure = in_company(sure, around)
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
            latency=round(decided - heard.spoken_until, 3),
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
