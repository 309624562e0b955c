"""Finds the command in a segment.

With the network pocketsphinx proposes and the network decides; of a list with more sentences than
can be compared, the network searches all of them itself. Without it, for other languages and small
machines, pocketsphinx does it alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple, Protocol

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.denoise import denoise_if_noisy
from voz.audio.segment import CONTEXT_SAMPLES, MAX_PAUSE_SAMPLES, SEGMENT_MARGIN, Segment
from voz.audio.voice_detector import RUN_UP, shared_voice_detector
from voz.events import SpokenWord
from voz.language.sentences.automaton import Automaton
from voz.recognition.confidence import (
    SCORE,
    VOICES_AROUND,
    Model,
    discount_for_gap,
    own_word_probability,
    probability,
    speech_probability,
)
from voz.recognition.decision import (
    Begun,
    Hypothesis,
    Refusal,
    Rival,
    find_rival,
    is_too_close,
    meaning,
    refusal_by_network,
    refusal_by_pocketsphinx,
    refusal_by_rival,
    unusable_sound,
)
from voz.recognition.language import Language, Shortlist, plain_word
from voz.recognition.name import NameFinder, NameMatch, from_time
from voz.recognition.network.ctc import FoundSentences, SentenceSearch
from voz.recognition.network.score import PhoneLikelihoods, PhonemeScorer, Ranking
from voz.recognition.pocketsphinx.decoder import Decoder, mean_start
from voz.recognition.pocketsphinx.evidence import (
    CommandSearch,
    Evidence,
    Span,
    features,
    voices_around,
)
from voz.recognition.thresholds import MIN_SCORE_AFTER_NAME, NAME_THRESHOLD
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


MAX_REFINEMENTS = 3
"""How often a long list is searched again around a better command."""


class CommandFinder(Protocol):
    """Finds the command in a segment."""

    def understand(self, segment: Segment, answers: Sequence[str] = ()) -> Hypothesis:
        """Find the command, or the answer, of a segment, with the probability that it was said."""


class _Compared(NamedTuple):
    """How well commands fit the phones of a sound."""

    likelihoods: PhoneLikelihoods  # the phones
    ranking: Ranking | None  # None if there was nothing to compare
    found: FoundSentences | None  # by the search of a list that is too long to compare


class NetworkFinder:
    """Finds commands by pocketsphinx and the network."""

    def __init__(
        self,
        language: Language,
        settings: Recognition,
        model: Model,
        network: PhonemeScorer,
    ) -> None:
        """Load pocketsphinx; LanguageError if it cannot use the language files."""
        self._only_proposed = settings.search == "lm"
        self._commands = language.commands
        self._is_english = not language.ipa
        # By the nearest English phones it hears other languages worse than the network does.
        self._pocketsphinx_has_say = language.commands.have_slots and self._is_english
        self._never_missed = frozenset(settings.never_missed)
        self._shortlist = Shortlist(language, settings.never_missed, MAX_COMPARED)
        # Where the network compares all commands, what pocketsphinx proposes adds a nat, no more.
        self._is_plain = self._shortlist.compares_all and not language.commands.have_slots
        self._decoder = Decoder(language, settings.search, is_wide=not self._is_plain)
        self._network = network
        self._search = self._sentence_search(language.commands.automaton)
        self._model = model
        self._name = settings.name
        self._name_finder = NameFinder(network, settings.name) if settings.name else None
        self._voice_detector = shared_voice_detector()

    def _sentence_search(self, automaton: Automaton) -> SentenceSearch | None:
        """Prepare to search a list that is too long to compare, or has slots; None if too large."""
        if self._is_plain or sum(map(len, automaton.arcs)) > MAX_SEARCHED_WORDS:
            return None
        return self._network.sentence_search(automaton)

    def understand(self, segment: Segment, answers: Sequence[str] = ()) -> Hypothesis:
        """Find the command, with the probability that it was said; see `CommandFinder`."""
        proposed = "" if self._name_finder else self._proposed(segment)
        if self._only_proposed and proposed not in self._commands:
            return Hypothesis(segment, proposed, segment.end)  # the trigram model's words
        likelihoods = self._phones_in(segment)
        name = self._find_name(segment, likelihoods)
        if self._name_finder:
            proposed = self._proposed(segment, name)
        offset = name.end if name else _earlier(segment, CONTEXT_SAMPLES)
        heard = self._heard_from(offset, likelihoods, proposed, answers)
        if name and (heard.ranking is None or not heard.ranking.score >= MIN_SCORE_AFTER_NAME):
            if alone := self._find_name(segment, likelihoods, within=name):
                return self._name_alone(segment, alone)
            name, offset = None, _earlier(segment, CONTEXT_SAMPLES)
            proposed = self._proposed(segment)
            heard = self._heard_from(offset, likelihoods, proposed, answers)
        ranking = heard.ranking
        if ranking is None:
            return Hypothesis(segment, "", segment.end)
        match = ranking.matches[ranking.text]
        if match.score == -math.inf:  # more phones than moments
            return Hypothesis(segment, "", segment.end, why_refused=lambda: ("too_short", None))
        values = {SCORE: ranking.score}
        likely = probability(self._model, values)
        speech = self._speech_probability(segment, offset + match.begin, offset + match.end, likely)
        other = self._rival(heard, ranking)
        return Hypothesis(
            segment,
            ranking.text,
            spoken_until=_in_stream(segment, offset + match.end),
            features=values,
            speech_probability=speech,
            probability=self._discounted(likely * speech, heard, ranking),
            why_refused=partial(
                self._why_refused, segment, heard.likelihoods, ranking, speech, other
            ),
            rival=other,
            named=name is not None,
            next_best=ranking.next_best,
            words=partial(
                self._words, heard.likelihoods, ranking.text, _sound_start(segment) + offset
            ),
            others=partial(self._others, ranking, speech),
        )

    def _proposed(self, segment: Segment, name: NameMatch | None = None) -> str:
        """What pocketsphinx finds behind the name, which its grammar does not have."""
        said = round(name.end * SAMPLE_RATE) - len(segment.before) if name else 0
        sound = denoise_if_noisy(segment.samples[max(0, said) :])
        return self._decoder.decode(sound, mean_start(sound))

    def hears_name(self, segment: Segment) -> bool:
        """Whether the robot's name is in a segment; costs less than to understand it."""
        return self._find_name(segment, self._phones_in(segment)) is not None

    def _phones_in(self, segment: Segment) -> PhoneLikelihoods:
        if self._search:  # its sentences may be long
            return self._network.phones_of_sentence(segment.with_surroundings)
        return self._network.phone_likelihoods(segment.with_surroundings)

    def _find_name(
        self, segment: Segment, likelihoods: PhoneLikelihoods, within: NameMatch | None = None
    ) -> NameMatch | None:
        """Where the robot's name was said; None if it was not.

        `within` is what was found so, and turns out to have no command behind it.
        """
        if self._name_finder is None:
            return None
        samples, earlier = segment.with_surroundings, _earlier(segment, MAX_PAUSE_SAMPLES)
        if within:
            begin = _earlier(segment, 0)
            found = self._name_finder.find_alone(samples, likelihoods, begin, within, earlier)
        else:
            found = self._name_finder.find(samples, likelihoods, earlier)
        return found if found.confidence >= NAME_THRESHOLD else None

    def _heard_from(
        self, begin: float, likelihoods: PhoneLikelihoods, proposed: str, answers: Sequence[str]
    ) -> _Compared:
        """How well commands fit the phones from a time on, s."""
        said = from_time(likelihoods, begin)
        found = None if self._shortlist.compares_all else self._searched(said)
        best = found.best if found else ""
        return _Compared(said, self._ranking(said, proposed, best or proposed, answers), found)

    def _searched(self, likelihoods: PhoneLikelihoods) -> FoundSentences | None:
        return self._search.search(*likelihoods) if self._search else None

    def _words(
        self, likelihoods: PhoneLikelihoods, text: str, sound_start: float
    ) -> tuple[SpokenWord, ...]:
        places = self._network.align(likelihoods, text)
        return tuple(
            SpokenWord(word, round(sound_start + begin, 3), round(sound_start + end, 3))
            for word, (begin, end) in zip(text.split(), places, strict=True)
        )

    def _others(self, ranking: Ranking, speech: float, count: int) -> list[tuple[str, float]]:
        scores = ranking.others(count)
        return [(text, speech * probability(self._model, {SCORE: score})) for text, score in scores]

    def _name_alone(self, segment: Segment, name: NameMatch) -> Hypothesis:
        # Its evidence tells it from noise as well; the voice detector misses some in babble.
        return Hypothesis(
            segment,
            self._name,
            spoken_until=_in_stream(segment, name.end),
            features={SCORE: name.log_odds},
            speech_probability=1.0,
            probability=name.confidence,
            named=True,
        )

    def _rival(self, heard: _Compared, ranking: Ranking) -> Rival | None:
        """The rival of the best command; commands that must not be missed have none."""
        said = self._commands.parse(ranking.text)
        if said is None or not said.slots or self._is_never_missed(ranking.text):
            return None
        found = heard.found or self._searched(heard.likelihoods)
        best = ranking.matches[ranking.text]
        begun = _begun(found, said.text, best.score) if found else None
        return find_rival(ranking, self._commands.parse, begun)

    def _discounted(self, likely: float, heard: _Compared, ranking: Ranking) -> float:
        """The probability of the best command, which rival words and gaps make less likely.

        Commands that must not be missed stay as likely as they are. What sounds like `stop`, as
        "stock", may stop the robot; a `stop` that is taken for it must not drive on.
        """
        if self._is_never_missed(ranking.text):
            return likely
        match = ranking.matches[ranking.text]
        lead = self._network.rival_lead(heard.likelihoods, ranking.text, match)
        gap = self._network.longest_gap(heard.likelihoods, ranking.text, match)
        own = own_word_probability(ranking.text, lead, is_english=self._is_english)
        return discount_for_gap(likely * own, gap)

    def _is_never_missed(self, text: str) -> bool:
        said = self._commands.parse(text)
        return said is not None and said.is_one_of(self._never_missed)

    def _ranking(
        self, likelihoods: PhoneLikelihoods, proposed: str, center: str, answers: Sequence[str]
    ) -> Ranking | None:
        """Score all commands, of a long list those that sound like the best, and the answers.

        None if there is nothing to score.
        """
        ranking = None
        has_say = self._pocketsphinx_has_say and proposed in self._commands
        also = [proposed] if has_say else []
        for _ in range(1 + MAX_REFINEMENTS):
            candidates = dict.fromkeys((*self._shortlist.similar_to(center), *answers, *also))
            if not candidates:
                return None
            ranking = self._network.rank(likelihoods, candidates.keys(), proposed)
            if has_say:
                ranking = self._with_support(ranking, proposed)
            if self._shortlist.compares_all or ranking.text == center:
                break
            also.append(center)
            center = ranking.text
        return ranking

    def _with_support(self, ranking: Ranking, proposed: str) -> Ranking:
        """Let pocketsphinx have a say where the best command has slots."""
        said = self._commands.parse(ranking.text)
        if said is None or not said.slots:
            return ranking
        meant = meaning(self._commands.parse(proposed))
        alike = [each for each in ranking.matches if meaning(self._commands.parse(each)) == meant]
        return Ranking(ranking.matches, alike)

    def _speech_probability(
        self, segment: Segment, begin: float, end: float, likely: float
    ) -> float:
        """How surely a part of a sound is speech, 0 to 1, given the probability of its words."""
        first = max(0, math.floor((begin - VOICE_MARGIN) * SAMPLE_RATE) - RUN_UP)
        last = math.ceil((end + VOICE_MARGIN) * SAMPLE_RATE)
        voice = self._voice_detector.probability(segment.with_surroundings[first:last])
        return speech_probability(voice, likely)

    def _why_refused(
        self,
        segment: Segment,
        likelihoods: PhoneLikelihoods,
        ranking: Ranking,
        speech: float,
        other: Rival | None,
    ) -> Refusal:
        if reason := unusable_sound(segment.samples, speech):
            return reason, None
        if is_too_close(other):
            return refusal_by_rival(ranking.text, other)
        words = list(dict.fromkeys(ranking.text.split()))
        alone = self._network.rank(likelihoods, words)
        fits = {
            word: alone.matches[word].score / self._network.count_phones(word) for word in words
        }
        return refusal_by_network(ranking, self._network.count_phones(ranking.text), fits.values())


def _begun(found: FoundSentences, text: str, score: float) -> Begun:
    """The likeliest beginning of another sentence, or of the best where that cannot be whole."""
    if score < 0:
        of_itself = Begun(*found.best_begun(text, itself=True))
        if of_itself.score > 0:
            return of_itself
    return Begun(*found.best_begun(text))


def _earlier(segment: Segment, samples: int) -> float:
    """So many samples before a segment, but not before its surroundings, in which it lies, s."""
    return max(0, len(segment.before) - samples) / SAMPLE_RATE


def _sound_start(segment: Segment) -> float:
    """Where a segment with its surroundings begins in the stream, s."""
    return segment.start - len(segment.before) / SAMPLE_RATE


def _in_stream(segment: Segment, seconds: float) -> float:
    """The time in the stream of a time in a segment with its surroundings, s."""
    return min(_sound_start(segment) + seconds, segment.decided)  # a moment may end later


DECODER_FRAME = 160
"""Samples in a frame of pocketsphinx, 10 ms."""

LONG_SEGMENT = 3.0
"""A segment without evidence that is longer than this (s) was not too short."""


class PocketsphinxFinder:
    """Finds commands and their probability by pocketsphinx."""

    def __init__(self, language: Language, settings: Recognition, model: Model) -> None:
        """Load pocketsphinx; LanguageError if it cannot use the language files."""
        self._commands = language.commands
        self._command_search = CommandSearch(language, settings.never_missed)
        alone = settings.search == "grammar" and self._command_search.finds_alone
        self._decoder = None if alone else Decoder(language, settings.search)
        self._phones_of = language.pocketsphinx_words
        self._usual = language.spoken.frames
        self._model = model
        self._voice = shared_voice_detector()

    def understand(self, segment: Segment, answers: Sequence[str] = ()) -> Hypothesis:
        """Find the command, with the probability that it was said; see `CommandFinder`."""
        spoken_until = segment.end - SEGMENT_MARGIN / SAMPLE_RATE
        sound = denoise_if_noisy(segment.samples)
        start = mean_start(sound)
        text = self._decoder.decode(sound, start) if self._decoder else ""
        if text and text not in self._commands:  # words of the trigram model that are no command
            return Hypothesis(segment, text, spoken_until)
        evidence = self._command_search.compare(sound, text, start)
        if evidence is None:
            why = partial(_why_refused, segment, None, 1.0)
            return Hypothesis(segment, text, spoken_until, why_refused=why)
        values = self._features(evidence, segment)
        speech = speech_probability(self._voice_in(segment, evidence))
        last = evidence.command.spans[-1]
        return Hypothesis(
            segment,
            evidence.text,
            spoken_until=_end(segment, last),
            features=values,
            speech_probability=speech,
            probability=speech * probability(self._model, values),
            why_refused=partial(_why_refused, segment, evidence, speech),
            next_best=max(evidence.rivals, key=evidence.rivals.__getitem__, default=""),
            words=partial(_words, segment, evidence),
            others=partial(
                self._others,
                segment=segment,
                sound=sound,
                proposed=text,
                start=start,
                best=evidence.text,
                speech=speech,
            ),
        )

    def _features(self, evidence: Evidence, segment: Segment) -> dict[str, float]:
        values = features(evidence, self._phones_of, self._usual)
        return values | {VOICES_AROUND: voices_around(segment.above, segment.voices)}

    def _others(
        self,
        count: int,
        *,
        segment: Segment,
        sound: Samples,
        proposed: str,
        start: str,
        best: str,
        speech: float,
    ) -> list[tuple[str, float]]:
        found = self._command_search.others(sound, proposed, start, best, count)
        return [
            (each.text, speech * probability(self._model, self._features(each, segment)))
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


def _why_refused(segment: Segment, evidence: Evidence | None, speech: float) -> Refusal:
    if reason := unusable_sound(segment.samples, speech):
        return reason, None
    if evidence is None:
        is_long = segment.end - segment.start > LONG_SEGMENT
        return "not_a_command" if is_long else "too_short", None
    return refusal_by_pocketsphinx(evidence)
