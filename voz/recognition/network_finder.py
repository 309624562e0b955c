"""Finds the command in a segment: pocketsphinx proposes, the phoneme network decides.

Of a list with more sentences than can be compared, the network searches all of them itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

from voz.audio import SAMPLE_RATE
from voz.audio.denoise import denoise_if_noisy
from voz.audio.segment import CONTEXT_SAMPLES, MAX_PAUSE_SAMPLES, Segment
from voz.audio.voice_detector import RUN_UP, shared_voice_detector
from voz.events import SpokenWord
from voz.language.sentences.automaton import Automaton
from voz.recognition.confidence import probability, trust_in_speech
from voz.recognition.confidence_model import SCORE, Model
from voz.recognition.decoder import Decoder, mean_start
from voz.recognition.hypothesis import Hypothesis, Refusal
from voz.recognition.language import Language
from voz.recognition.name_finder import NAME_THRESHOLD, NameFinder, NameMatch, from_time
from voz.recognition.phoneme_scorer import PhoneLikelihoods, PhonemeScorer, Ranking
from voz.recognition.refusal import refusal_by_network, refusal_by_rival, unusable_sound
from voz.recognition.sentence_search import FoundSentences, SentenceSearch
from voz.recognition.shortlist import Shortlist
from voz.recognition.slot_rivals import Begun, Rival, find_rival, is_too_close
from voz.recognition.speaker.adaptation import StartVector
from voz.recognition.speaker.profiles import Profile
from voz.settings import Recognition

MAX_COMPARED = 160
"""Most commands that the network compares; of more, those that sound like the best one."""

MAX_SEARCHED_WORDS = 2000
"""Most words between states of an automaton that the network searches: 20 ms for a second of sound.
With more, the search for the best command begins with what pocketsphinx proposes.
"""

VOICE_MARGIN = 0.1
"""Voice is looked for this much (s) around a command: a whispered `stop` has little between its
first and last phone."""

MIN_SCORE_AFTER_NAME = 4.0
"""Nats of a command that was nearly surely said after the name; with less the name stands alone."""

MAX_REFINEMENTS = 3
"""How often a long list is searched again around a better command."""


class _Compared(NamedTuple):
    """How well commands fit the phones of a sound.

    Attributes:
        sounds: the phones.
        ranking: None if there was nothing to compare.
        found: by the search of a list that is too long to compare.
    """

    sounds: PhoneLikelihoods
    ranking: Ranking | None
    found: FoundSentences | None


class NetworkFinder:
    """Finds commands by pocketsphinx and the network."""

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
            language: the commands.
            settings: which search, and which commands must not be missed.
            profile: of the speaker.
            model: of the confidence.
            network: for the words of the language.

        Raises:
            LanguageError: pocketsphinx cannot use the language files.
        """
        self._decoder = Decoder(language, settings.search, profile.mllr)
        self._only_proposed = settings.search == "lm"
        self._commands = language.commands
        self._never_missed = frozenset(settings.never_missed)
        self._shortlist = Shortlist(language, settings.never_missed, MAX_COMPARED)
        self._network = network
        self._search = self._sentence_search(language.commands.automaton)
        self._model = model
        self._name = settings.name
        self._name_finder = NameFinder(network, settings.name) if settings.name else None
        self._voice_detector = shared_voice_detector()

    def _sentence_search(self, automaton: Automaton) -> SentenceSearch | None:
        """Prepare to search a list that is too long to compare, or has slots; None if too large."""
        is_plain = self._shortlist.is_whole and not self._commands.have_slots
        if is_plain or sum(map(len, automaton.arcs)) > MAX_SEARCHED_WORDS:
            return None
        return self._network.sentence_search(automaton)

    def understand(
        self, segment: Segment, learned: StartVector, answers: Sequence[str] = ()
    ) -> Hypothesis:
        """Find the command, with the probability that it was said; see `CommandFinder`."""
        sound = denoise_if_noisy(segment.samples)
        proposed = self._decoder.decode(sound, learned.moved(mean_start(sound)))
        if self._only_proposed and proposed not in self._commands:
            return Hypothesis(segment, proposed, segment.end)  # the trigram model's words
        sounds = self._network.phone_likelihoods(segment.with_surroundings)
        name = self._find_name(segment, sounds)
        offset = name.end if name else _earliest_begin(segment)
        heard = self._heard_from(offset, sounds, proposed, answers)
        if name and (heard.ranking is None or not heard.ranking.score >= MIN_SCORE_AFTER_NAME):
            if alone := self._find_name(segment, sounds, alone=True):
                return self._name_alone(segment, alone)
            name, offset = None, _earliest_begin(segment)
            heard = self._heard_from(offset, sounds, proposed, answers)
        ranking = heard.ranking
        if ranking is None:
            return Hypothesis(segment, "", segment.end)
        match = ranking.matches[ranking.text]
        if match.score == -math.inf:  # more phones than moments
            return Hypothesis(segment, "", segment.end, why_refused=lambda: ("too_short", None))
        values = {SCORE: ranking.score}
        likely = probability(self._model, values)
        trust = self._trust(segment, offset + match.begin, offset + match.end, likely)
        other = self._rival(heard, ranking)
        return Hypothesis(
            segment,
            ranking.text,
            spoken_until=_in_stream(segment, offset + match.end),
            values=values,
            trust=trust,
            probability=likely * trust,
            why_refused=partial(self._why_refused, segment, heard.sounds, ranking, trust, other),
            rival=other,
            named=name is not None,
            next_best=ranking.next_best,
            words=partial(self._words, heard.sounds, ranking.text, _sound_start(segment) + offset),
            others=partial(self._others, ranking, trust),
        )

    def hears_name(self, segment: Segment) -> bool:
        """Whether the robot's name is in a segment; costs less than to understand it."""
        sounds = self._network.phone_likelihoods(segment.with_surroundings)
        return self._find_name(segment, sounds) is not None

    def _find_name(
        self, segment: Segment, sounds: PhoneLikelihoods, alone: bool = False
    ) -> NameMatch | None:
        """Where the robot's name was said; None if it was not."""
        if self._name_finder is None:
            return None
        pause = 0 if alone else MAX_PAUSE_SAMPLES
        earliest_end = max(0, len(segment.before) - pause) / SAMPLE_RATE
        found = self._name_finder.find(segment.with_surroundings, sounds, earliest_end, alone)
        return found if found.confidence >= NAME_THRESHOLD else None

    def _heard_from(
        self, begin: float, sounds: PhoneLikelihoods, proposed: str, answers: Sequence[str]
    ) -> _Compared:
        """How well commands fit the phones from a time on, s."""
        said = from_time(sounds, begin)
        found = None if self._shortlist.is_whole else self._searched(said)
        best = found.best if found else ""
        return _Compared(said, self._ranking(said, proposed, best or proposed, answers), found)

    def _searched(self, sounds: PhoneLikelihoods) -> FoundSentences | None:
        return self._search.search(*sounds) if self._search else None

    def _words(
        self, sounds: PhoneLikelihoods, text: str, sound_start: float
    ) -> tuple[SpokenWord, ...]:
        places = self._network.align(sounds, text)
        return tuple(
            SpokenWord(word, round(sound_start + begin, 3), round(sound_start + end, 3))
            for word, (begin, end) in zip(text.split(), places, strict=True)
        )

    def _others(self, ranking: Ranking, trust: float, count: int) -> list[tuple[str, float]]:
        scores = ranking.others(count)
        return [(text, trust * probability(self._model, {SCORE: score})) for text, score in scores]

    def _name_alone(self, segment: Segment, name: NameMatch) -> Hypothesis:
        # Its evidence tells it from noise as well; the voice detector misses some in babble.
        return Hypothesis(
            segment,
            self._name,
            spoken_until=_in_stream(segment, name.end),
            values={SCORE: name.log_odds},
            trust=1.0,
            probability=name.confidence,
            named=True,
        )

    def _rival(self, heard: _Compared, ranking: Ranking) -> Rival | None:
        """The rival of the best command; commands that must not be missed have none."""
        said = self._commands.parse(ranking.text)
        if said is None or not said.slots or said.is_one_of(self._never_missed):
            return None
        found = heard.found or self._searched(heard.sounds)
        begun = Begun(*found.best_begun(said.text)) if found else None
        return find_rival(ranking, self._commands.parse, begun)

    def _ranking(
        self, sounds: PhoneLikelihoods, proposed: str, center: str, answers: Sequence[str]
    ) -> Ranking | None:
        """Score all commands, of a long list those that sound like the best, and the answers.

        None if there is nothing to score.
        """
        ranking = None
        for _ in range(1 + MAX_REFINEMENTS):
            candidates = [*self._shortlist.similar_to(center), *answers]
            if not candidates:
                return None
            ranking = self._network.rank(sounds, candidates, proposed)
            if self._shortlist.is_whole or ranking.text == center:
                break
            center = ranking.text
        return ranking

    def _trust(self, segment: Segment, begin: float, end: float, likely: float) -> float:
        """How surely a part of a sound is speech, 0 to 1, given the probability of its words."""
        first = max(0, math.floor((begin - VOICE_MARGIN) * SAMPLE_RATE) - RUN_UP)
        last = math.ceil((end + VOICE_MARGIN) * SAMPLE_RATE)
        voice = self._voice_detector.probability(segment.with_surroundings[first:last])
        return trust_in_speech(voice, likely)

    def _why_refused(
        self,
        segment: Segment,
        sounds: PhoneLikelihoods,
        ranking: Ranking,
        trust: float,
        other: Rival | None,
    ) -> Refusal:
        if reason := unusable_sound(segment.samples, trust):
            return reason, None
        if is_too_close(other):
            return refusal_by_rival(ranking.text, other)
        words = list(dict.fromkeys(ranking.text.split()))
        alone = self._network.rank(sounds, words)
        fits = {
            word: alone.matches[word].score / self._network.count_phones(word) for word in words
        }
        return refusal_by_network(ranking, self._network.count_phones(ranking.text), fits.values())


def _earliest_begin(segment: Segment) -> float:
    """When a command may begin in a segment with its surroundings, s."""
    return max(0, len(segment.before) - CONTEXT_SAMPLES) / SAMPLE_RATE


def _sound_start(segment: Segment) -> float:
    """Where a segment with its surroundings begins in the stream, s."""
    return segment.start - len(segment.before) / SAMPLE_RATE


def _in_stream(segment: Segment, seconds: float) -> float:
    """The time in the stream of a time in a segment with its surroundings, s."""
    return min(_sound_start(segment) + seconds, segment.decided)  # a moment may end later
