"""The command in a stretch of speech, by both ears: pocketsphinx proposes, the network decides."""

from __future__ import annotations

import math
from collections.abc import Collection
from functools import partial

from voz.audio import SAMPLE_RATE
from voz.audio.denoise import denoise_if_noisy
from voz.audio.endpointing.segment import Segment
from voz.audio.endpointing.voice_detector import RUN_UP, shared_voice_detector
from voz.recognition.confidence import probability, trust_in_speech
from voz.recognition.confidence_model import SCORE, Model
from voz.recognition.decoder import Decoder, mean_start
from voz.recognition.hypothesis import Hypothesis, Refusal
from voz.recognition.language import Language
from voz.recognition.phoneme_scorer import PhoneLikelihoods, PhonemeScorer, Ranking
from voz.recognition.refusal import too_little, why_unheard
from voz.recognition.shortlist import Shortlist
from voz.recognition.slot_rivals import Rival, is_too_close, rival
from voz.recognition.speaker.adaptation import StartVector
from voz.recognition.speaker.profiles import Profile
from voz.settings import Recognition

MOST_COMPARED = 160
"""Commands that the network compares; of longer lists, those that sound most like what pocketsphinx
found, and that."""

MARGIN = 0.1
"""Seconds around a command in which its voice is looked for: the network tells the midst of phones,
and a whispered `stop` has hardly a voice between its first and its last."""

MOST_MOVES = 3
"""In a long list, if another command fits better than the one around which it searched, it searches
around that one, so often at most."""


class NetworkFinder:
    """Compares the commands that pocketsphinx proposes by the network; made once, used for many."""

    def __init__(
        self,
        language: Language,
        settings: Recognition,
        profile: Profile,
        model: Model,
        network: PhonemeScorer,
    ) -> None:
        """Load pocketsphinx.

        Args:
            language: whose commands are compared.
            settings: which search, and which commands must not be missed.
            profile: what is known of the speaker.
            model: what the confidence is computed by.
            network: knows the words of the language.

        Raises:
            LanguageError: pocketsphinx cannot use the language files.
        """
        self._decoder = Decoder(language, settings.search, profile.mllr)
        self._only_proposed = settings.search == "lm"
        self._commands = language.commands
        self._careful = frozenset(settings.never_missed)
        self._shortlist = Shortlist(language, settings.never_missed, MOST_COMPARED)
        self._network = network
        self._model = model
        self._voice = shared_voice_detector()

    def understand(self, segment: Segment, learnt: StartVector) -> Hypothesis:
        """Find the sentence of a segment, and how likely it is that it was said."""
        sound = denoise_if_noisy(segment.samples)
        proposed = self._decoder.decode(sound, learnt.moved(mean_start(sound)))
        if self._only_proposed and proposed not in self._commands:
            return Hypothesis(segment, proposed, segment.end)  # the trigram model's words
        candidates = self._shortlist.around(proposed)
        if not candidates:
            return Hypothesis(segment, "", segment.end)
        sounds = self._network.phone_likelihoods(segment.with_surroundings)
        ranking = self._ranking(sounds, candidates, proposed)
        match = ranking.matches[ranking.text]
        if match.score == -math.inf:  # each command has more phones than there are moments
            return Hypothesis(segment, "", segment.end, why_refused=lambda: ("too_short", None))
        heard_from = segment.start - len(segment.before) / SAMPLE_RATE
        values = {SCORE: ranking.score}
        likely = probability(self._model, values)
        trust = trust_in_speech(self._voice_in(segment, match.begin, match.end), likely)
        other = self._rival(ranking)
        return Hypothesis(
            segment,
            ranking.text,
            spoken_until=min(heard_from + match.end, segment.decided),  # a moment may end later
            values=values,
            trust=trust,
            sure=likely * trust,
            why_refused=partial(self._why_refused, segment, sounds, ranking, trust, other),
            rival=other,
            next_best=ranking.next_best,
        )

    def _rival(self, ranking: Ranking) -> Rival | None:
        """What else may have been meant; whatever that is, what must not be missed is obeyed."""
        said = self._commands.parse(ranking.text)
        is_careful = said is not None and said.is_one_of(self._careful)
        return None if is_careful else rival(ranking, self._commands.parse)

    def _ranking(
        self, sounds: PhoneLikelihoods, candidates: Collection[str], proposed: str
    ) -> Ranking:
        """Compare all commands of a short list; of a long one, those around what is found there."""
        ranking = self._network.rank(sounds, candidates, proposed)
        around = proposed
        for _ in range(0 if self._shortlist.is_whole else MOST_MOVES):
            if ranking.text == around:
                break
            around = ranking.text
            ranking = self._network.rank(sounds, self._shortlist.around(around), proposed)
        return ranking

    def _voice_in(self, segment: Segment, begin: float, end: float) -> float:
        """How sure it is that there is speech where a command fits best."""
        first = max(0, math.floor((begin - MARGIN) * SAMPLE_RATE) - RUN_UP)
        return self._voice.probability(
            segment.with_surroundings[first : math.ceil((end + MARGIN) * SAMPLE_RATE)]
        )

    def _why_refused(
        self,
        segment: Segment,
        sounds: PhoneLikelihoods,
        ranking: Ranking,
        trust: float,
        other: Rival | None,
    ) -> Refusal:
        if reason := too_little(segment.samples, trust):
            return reason, None
        if is_too_close(other):
            return "unsure_between", (ranking.text, other.text)
        words = list(dict.fromkeys(ranking.text.split()))
        alone = self._network.rank(sounds, words)
        fits = {word: alone.matches[word].score / self._network.phones(word) for word in words}
        return why_unheard(ranking, self._network.phones(ranking.text), fits.values())
