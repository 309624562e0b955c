"""From a stretch of speech to its sentence, and how sure that is."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from functools import partial
from types import MappingProxyType
from typing import NamedTuple

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.denoise import cleaned
from voz.audio.endpointing.open_segment import MARGIN
from voz.audio.endpointing.segment import LONGEST_WORD, Segment
from voz.audio.endpointing.voice import RUN_UP, voice_detector
from voz.events import Ear, Reason, RefusedBy, Utterance
from voz.language.templates.commands import Commands, Parse
from voz.recognition.confidence import (
    CONVINCED,
    Around,
    features,
    in_company,
    probability,
    trust_in_speech,
    two_ears,
    voices_around,
)
from voz.recognition.confidence_model import VOICES_AROUND, load_models, with_log_odds
from voz.recognition.decoder import Decoder, mean_start
from voz.recognition.evidence import MOST_NEVER_MISSED, MOST_RIVALS, Comparison, Evidence
from voz.recognition.language import Language
from voz.recognition.meaning import Rival, most_sure, rival, stands_in_the_way
from voz.recognition.network_file import UnknownNetworkError
from voz.recognition.refusal import why_refused
from voz.recognition.second_ear import SecondEar, second_ear_for
from voz.recognition.speaker.adaptation import Aligner, StartVector, teaches
from voz.recognition.speaker.profiles import Profile
from voz.recognition.spotting import Spotted, Spotter
from voz.recognition.thresholds import needed
from voz.recognition.turns import Turns
from voz.settings import Recognition

DECODER_FRAME = 160
"""Samples in a frame of pocketsphinx, 10 ms."""

PAUSES = 2.0
"""Seconds that a command takes besides its words: silence, hesitation, noise before and after."""


class Hypothesis(NamedTuple):
    """What was understood of a segment, before it is known what follows.

    Attributes:
        segment: the stretch of speech.
        text: the sentence that fits best; empty if none does.
        evidence: what speaks for it and against it; None if it cannot be a command.
        trust: how far the sound is to be trusted to be speech, 0 to 1.
        sure: the probability that it was said, if there is no other speech around it.
        values: the features of that probability; empty without evidence.
        against: what else may have been meant, if it has slots.
    """

    segment: Segment
    text: str
    evidence: Evidence | None = None
    trust: float = 0.0
    sure: float = 0.0
    values: Mapping[str, float] = MappingProxyType({})
    against: Rival | None = None

    @property
    def spoken_until(self) -> float:
        """Where the last word ends in the stream, s."""
        if self.evidence is None:
            return self.segment.end - MARGIN / SAMPLE_RATE
        last = self.evidence.command.spans[-1]
        return self.segment.start + (last.end + 1) * DECODER_FRAME / SAMPLE_RATE


class Interpreter:
    """Finds what was said in stretches of speech; made once, used for many, on any thread.

    Attributes:
        learnt: what is known of the microphone and the speaker; it changes only while learning.
        longest: how long a command may take, s.
        commands: what may be said.
        model: what the confidence is computed by.
    """

    def __init__(
        self,
        language: Language,
        settings: Recognition,
        profile: Profile,
        learning: bool,
    ) -> None:
        """Load the models; arguments and errors are those of `Recognizer`."""
        profile.check_model(language.spoken.model)
        self.learnt = profile.start
        self._aligner = Aligner(language) if learning else None
        self.commands = language.commands
        self._comparison = Comparison(language, settings.never_missed, profile.mllr)
        alone = settings.search == "grammar" and self._comparison.finds_alone
        self._decoder = None if alone else Decoder(language, settings.search, profile.mllr)
        self._phones_of = language.pronunciations
        self._usual = language.spoken.frames
        self._second = _second_ear(language, settings.network) if settings.second_ear else None
        self._spotter = _spotter(self._second, self.commands, settings.never_missed)
        models = load_models(settings.confidence)
        model = models.two_ears if self._second else models.one_ear
        self.model = with_log_odds(model, profile.log_odds)
        self.longest = PAUSES + LONGEST_WORD * self.commands.longest
        self._needed = needed(self.model, settings)
        self._never_missed = frozenset(settings.never_missed)
        self._voice = voice_detector()
        self._turns = Turns()  # pocketsphinx decodes one utterance at a time

    def accept_by(self, settings: Recognition) -> None:
        """Accept by other settings from now on; any thread may ask for it."""
        self._needed = needed(self.model, settings)

    def understand(self, segment: Segment) -> Hypothesis:
        """Find the sentence of a segment, and how likely it is that it was said."""
        with self._turns:
            return self._understand(segment, self.learnt)

    def _understand(self, segment: Segment, learnt: StartVector) -> Hypothesis:
        if segment.end - segment.start > self.longest:
            return Hypothesis(segment, "")  # no command, and it would take long to find that out
        sound = cleaned(segment.samples)
        start = learnt.moved(mean_start(sound))
        text = self._decoder.decode(sound, start) if self._decoder else ""
        if text and text not in self.commands:  # words of the trigram model that are no command
            return Hypothesis(segment, text)
        second, samples = self._second, segment.samples
        ask = partial(second.opinion, samples) if second else None
        evidence = self._comparison.compare(sound, text, start, ask)
        if evidence is None:
            return Hypothesis(segment, text)
        # What goes on and is as loud as the command is no noise that the command drowns in.
        above = math.inf if segment.amid else segment.above
        values = features(evidence, self._phones_of, self._usual) | two_ears(evidence, above)
        values[VOICES_AROUND] = voices_around(segment.above, segment.voices)
        sure = probability(self.model, values)
        trust = trust_in_speech(self._voice_in(samples, evidence), sure if second else 0.0)
        sure *= trust
        careful = self._is_careful(self.commands.parse(evidence.text))
        against = None if careful else rival(evidence, self.commands.parse)
        sure = min(sure, most_sure(against))
        return Hypothesis(segment, evidence.text, evidence, trust, sure, values, against)

    def spot(self, so_far: Samples) -> Spotted | None:
        """Tell which command that must not be missed may have been said just now, if any.

        Args:
            so_far: what stands out of the room, up to now, 16 kHz.
        """
        if self._spotter is None:
            return None
        with self._turns:
            return self._spotter.spot(so_far)

    def learn(self, heard: Hypothesis) -> None:
        """Learn from an utterance, or doubt what was learnt if it is understood only without.

        Nothing happens unless it was made to learn.
        """
        if self._aligner:
            with self._turns:
                self._learn(heard, self._aligner)

    def _learn(self, heard: Hypothesis, aligner: Aligner) -> None:
        if teaches(heard.values, heard.trust):
            sound = cleaned(heard.segment.samples)
            start = mean_start(sound)
            observed = aligner.observe(sound, heard.text, start, self.learnt)
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
        begin = max(0, words[0].start * DECODER_FRAME - RUN_UP)
        return self._voice.probability(samples[begin : words[-1].end * DECODER_FRAME])

    def accepts(self, heard: Hypothesis, around: Around) -> bool:
        """Tell whether a command is sure enough to be obeyed, by what is around it."""
        return self._accepts(heard.text, in_company(heard.sure, around))

    def may_go_on(self, text: str) -> bool:
        """Tell whether a longer command begins with this one."""
        return bool(text) and self.commands.may_go_on(text)

    def another_name(self, text: str) -> str | None:
        """Give the name of a sentence's command, where it is not the sentence itself."""
        parse = self.commands.parse(text)
        return parse.command if parse and parse.command != text else None

    def needed(self, text: str) -> float | None:
        """How sure a command must be to be accepted, 0 to 1; None if the text is none."""
        parse = self.commands.parse(text)
        if parse is None:
            return None
        return self._needed.careful if self._is_careful(parse) else self._needed.usual

    def _is_careful(self, parse: Parse | None) -> bool:
        """Whether it is worse to miss a command than others."""
        return parse is not None and bool(self._never_missed & {parse.text, parse.command})

    def _accepts(self, text: str, sure: float) -> bool:
        least = self.needed(text)
        return least is not None and sure >= least

    def judge(self, heard: Hypothesis, around: Around, decided: float, source: str) -> Utterance:
        """Decide whether what was heard is obeyed.

        Args:
            heard: what was understood.
            around: what is around it.
            decided: the time of the decision, s.
            source: where it comes from.
        """
        segment, text, evidence = heard.segment, heard.text, heard.evidence
        sure = in_company(heard.sure, around)
        accepted = self._accepts(text, sure)
        reason, between = (None, None) if accepted else _why(heard)
        ears = _ears(evidence, heard.values["worst word"]) if evidence else None
        parse = self.commands.parse(text) if accepted else None
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
            above=round(segment.above, 1),
            ears=ears,
            refused_by=self._refused_by(heard, around) if reason and ears and heard.trust else None,
            command=parse.command if parse else None,
            slots=dict(parse.slots) if parse else {},
        )

    def _refused_by(self, heard: Hypothesis, around: Around) -> RefusedBy:
        """Tell which ear stands against a command: if it were convinced, it would be obeyed."""
        would: dict[RefusedBy, bool] = {}
        for ear, convinced in CONVINCED.items():
            sure = heard.trust * probability(self.model, {**heard.values, **convinced})
            would[ear] = self._accepts(heard.text, in_company(sure, around))
        if would["first_ear"] == would["second_ear"]:
            return "both_ears"
        return "first_ear" if would["first_ear"] else "second_ear"


def _why(heard: Hypothesis) -> tuple[Reason, tuple[str, str] | None]:
    if heard.trust and stands_in_the_way(heard.against):
        return "unsure_between", (heard.text, heard.against.text)
    return why_refused(heard.segment.samples, heard.evidence, heard.trust)


def _ears(evidence: Evidence, worst_word: float) -> tuple[Ear, Ear] | None:
    """Tell what each ear makes of an utterance; nothing if there is one ear."""
    opinion, text = evidence.opinion, evidence.text
    if opinion is None:
        return None
    first = max({**evidence.rivals, text: evidence.command.score}.items(), key=lambda item: item[1])
    second = max(opinion.fits, key=lambda command: opinion.fits[command].score)
    return Ear(first[0], round(worst_word, 2)), Ear(second, round(opinion.fit(text), 2))


def _second_ear(language: Language, network: str | None) -> SecondEar | None:
    """Load the second ear, where it can be had."""
    try:
        return second_ear_for(language, network)
    except UnknownNetworkError:
        return None


def _spotter(
    ear: SecondEar | None, commands: Commands, never_missed: Collection[str]
) -> Spotter | None:
    """Look for the commands that must not be missed, where there is a second ear."""
    watched = commands.named(never_missed, MOST_NEVER_MISSED)
    others = commands if len(commands) <= MOST_RIVALS else ()
    return Spotter(ear, watched, others) if ear and watched else None
