"""What was understood of a segment, whether that is accepted, and why not.

A decision is made once, when a segment is understood, and the utterance carries it from the pause
to the event. Only what is known later, what stands around the segment, is decided again, by the
threshold that held then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeGuard

from voz.audio import SAMPLE_RATE, Samples
from voz.audio.denoise import frame_energies
from voz.audio.levels import quantile
from voz.audio.segment import Segment
from voz.events import Reason, SpokenWord
from voz.language.sentences.command_set import Commands, Parse
from voz.recognition.confidence import Context, Model, discount_for_context, multiply_odds
from voz.recognition.network.score import Ranking
from voz.recognition.pocketsphinx.evidence import Evidence, word_ratio
from voz.recognition.thresholds import (
    ANSWER_ODDS_FACTOR,
    MIN_MEANING_SHARE,
    NAME_THRESHOLD,
    asked_from,
    thresholds_of,
)
from voz.settings import Recognition

Refusal = tuple[Reason, tuple[str, str] | None]
"""Why an utterance is refused, and between which two commands if that is the reason."""


def no_command() -> Refusal:
    """The refusal of what was compared with no command."""
    return "not_a_command", None


def no_others(_: int) -> Sequence[tuple[str, float]]:
    """The rivals of what was compared with no command."""
    return ()


@dataclass(frozen=True)
class Hypothesis:
    """What was understood of a segment, before it is known what follows."""

    segment: Segment
    text: str  # the best sentence; empty if none fits
    spoken_until: float  # end of its last word in the stream, s
    # Of the confidence, by name; empty if it was compared with no command
    features: Mapping[str, float] = field(default_factory=dict)
    speech_probability: float = 0.0  # how surely the sound is speech, 0 to 1
    probability: float = 0.0  # that it was said, without other speech around it and without a rival
    why_refused: Callable[[], Refusal] = no_command
    rival: Rival | None = None  # the likeliest other meaning, if it has slots
    named: bool = False  # whether it begins with the robot's name, or is the name
    next_best: str = ""  # the second best command; empty if there is no other
    words: Callable[[], tuple[SpokenWord, ...]] = tuple  # aligned when it is called
    # Returns the n next best (text, probability)
    others: Callable[[int], Sequence[tuple[str, float]]] = no_others

    @property
    def confidence(self) -> float:
        """The confidence without other speech around it, 0 to 1."""
        return min(self.probability, highest_confidence(self.rival))


RIVAL_SCALE = 2.0
"""Nats of the network that count as one: scores of neighboring symbols err together
(`benchmarks/intents.py`)."""


BEGUN_AHEAD = 1.0
"""A beginning that fits better by so many nats is as likely as the whole sentence, and each nat
more or less counts whole: what both have in common errs alike (`benchmarks/slots.py`)."""

MOST_AHEAD = 100.0
"""What is ahead by more, in the powers of e, is sure in any case."""

ODDS_OF_SHARE = 2.0
"""How much higher the odds of a meaning are than those of its share (`benchmarks/intents.py`)."""


@dataclass(frozen=True)
class Begun:
    """The likeliest words that begin a sentence, but not the best one, and their score, nats."""

    text: str
    score: float


@dataclass(frozen=True)
class Rival:
    """The likeliest sentence of another meaning, and the share (0 to 1) of the best one."""

    text: str
    share: float
    is_begun: bool = False  # it is not a whole sentence: its end was not heard, or is not yet said


def find_rival(
    ranking: Ranking, parse: Callable[[str], Parse | None], begun: Begun | None = None
) -> Rival | None:
    """Find the likeliest sentence of another meaning than the best one, for one with slots.

    Of the sentence `begun` only the beginning may have been heard.
    """
    said = parse(ranking.text)
    if said is None or not said.slots:
        return None
    best: dict[object, tuple[float, str]] = {}
    for text in ranking.matches:
        key, scored = meaning(parse(text)), (ranking.rank_score(text), text)
        best[key] = max(best.get(key, scored), scored)
    highest, _ = best.pop(meaning(said))
    ahead = [((score - highest) / RIVAL_SCALE, text, False) for score, text in best.values()]
    if begun and begun.text:
        ahead.append((begun.score - highest - BEGUN_AHEAD, begun.text, True))
    if not ahead:
        return None
    others = sum(math.exp(min(each, MOST_AHEAD)) for each, _, _ in ahead)
    _, nearest, is_begun = max(ahead)
    return Rival(nearest, 1 / (1 + others), is_begun)


def is_too_close(other: Rival | None) -> TypeGuard[Rival]:
    """Whether a command is refused for its rival."""
    return other is not None and other.share < MIN_MEANING_SHARE


def highest_confidence(other: Rival | None) -> float:
    """The confidence that a rival leaves to a command at most, 0 to 1."""
    return 1.0 if other is None else multiply_odds(other.share, ODDS_OF_SHARE)


def meaning(parse: Parse | None) -> object:
    """What is equal for sentences of the same meaning; None for what is no command."""
    return parse and (parse.command, tuple(sorted(parse.slots.items())))


class Requirement(NamedTuple):
    """What a text needed to be accepted when it was understood."""

    threshold: float | None  # confidence, 0 to 1; None if the text cannot be said
    is_name: bool  # whether it is the robot's name, which fits or not, whatever is around it
    may_ask: bool  # whether the robot may ask about it where it is not accepted


@dataclass(frozen=True)
class Decision:
    """Whether a hypothesis is accepted."""

    hypothesis: Hypothesis
    required: Requirement
    context: Context  # `QUIET` if nothing follows it so far
    confidence: float  # that the command was said and meant, 0 to 1
    accepted: bool
    waits: bool = False  # accepted only if nothing follows, which is not known yet
    for_rival: bool = False  # refused for its rival alone

    @property
    def is_nearly_sure(self) -> bool:
        """Whether the robot may ask about the hypothesis, unless it is accepted."""
        threshold, _, may_ask = self.required
        if threshold is None or not may_ask:
            return False
        return self.confidence >= asked_from(threshold)

    @property
    def why_refused(self) -> Refusal:
        """Why the hypothesis is not accepted."""
        heard = self.hypothesis
        if self.for_rival and heard.rival:
            return refusal_by_rival(heard.text, heard.rival)
        return heard.why_refused()

    def within(self, context: Context) -> Decision:
        """The same decision when more is known of what is around the hypothesis."""
        if context is self.context:
            return self
        return decide(self.hypothesis, self.required, context)


def decide(heard: Hypothesis, required: Requirement, context: Context) -> Decision:
    """Decide whether a hypothesis is accepted by what is around it; `QUIET` if that is nothing."""

    def decided(confidence: float, **outcome: bool) -> Decision:
        return Decision(heard, required, context, confidence, **outcome)

    threshold, sure = required.threshold, heard.probability
    if required.is_name and threshold is not None:
        return decided(sure, accepted=sure >= threshold)
    said = discount_for_context(sure, context)
    confidence = min(said, highest_confidence(heard.rival))
    if threshold is None:
        return decided(confidence, accepted=False)
    if confidence < threshold or is_too_close(heard.rival):
        return decided(confidence, accepted=False, for_rival=said >= threshold)
    if context is not Context.QUIET:
        return decided(confidence, accepted=True)
    so_far = discount_for_context(sure, Context.UNKNOWN_AFTER)
    return decided(confidence, accepted=True, waits=so_far < threshold)


class DecisionRule:
    """The thresholds of commands, which any thread may change."""

    def __init__(self, commands: Commands, model: Model, settings: Recognition) -> None:
        """Compute the thresholds of commands by a model and settings."""
        self._commands = commands
        self._model = model
        self._never_missed = frozenset(settings.never_missed)
        self._name = settings.name
        self._asks = settings.ask != "never"
        self.answers: tuple[str, ...] = ()  # what else may be said just now
        self.set_false_alarm_rate(settings)

    def set_false_alarm_rate(self, settings: Recognition) -> None:
        """Use the false alarms, or the threshold, of other settings."""
        self._thresholds = thresholds_of(self._model, settings)

    def threshold(self, text: str) -> float | None:
        """The confidence that a text needs, 0 to 1; None if it cannot be said."""
        return self._required(text).threshold

    def accepts(self, text: str, confidence: float) -> bool:
        """Whether a text of this confidence is accepted; what cannot be said is not."""
        threshold = self.threshold(text)
        return threshold is not None and confidence >= threshold

    def decide(self, heard: Hypothesis, context: Context) -> Decision:
        """Decide whether a hypothesis is accepted; `QUIET` if nothing follows it so far."""
        return decide(heard, self._required(heard.text), context)

    def _required(self, text: str) -> Requirement:
        if self._name and text == self._name:
            return Requirement(NAME_THRESHOLD, is_name=True, may_ask=self._asks)
        usual = self._thresholds.usual
        if text in self.answers:
            threshold = multiply_odds(usual, 1 / ANSWER_ODDS_FACTOR)
            return Requirement(threshold, is_name=False, may_ask=False)
        parse = self._commands.parse(text)
        if parse is None:
            return Requirement(None, is_name=False, may_ask=False)
        never_missed = parse.is_one_of(self._never_missed)
        threshold = self._thresholds.never_missed if never_missed else usual
        return Requirement(threshold, is_name=False, may_ask=self._asks)


MIN_LEVEL = 40.0
"""Level of a far microphone, dB over one unit of 16 bits: 50 dB below full scale."""

MIN_DURATION = 0.35
"""Duration of the shortest command with the margins of its segment, s."""

TIE_RATIO = 0.3
"""Two commands closer than this fit about as well, nats per frame."""

WORD_PRESENT_RATIO = -2.0
"""A word above this was said, nats per frame; 9 of 10 words of right commands are."""

WORD_ABSENT_RATIO = -3.0
"""A word below this was not said, nats per frame; 1 of 20 words of right commands is."""

TIE_SCORE = 3.0
"""Two commands closer than this fit about as well by the network, nats."""

WORD_PRESENT_SCORE, WORD_ABSENT_SCORE = 1.0, 0.0
"""Scores per phone, nats, above which a word was said, and below which it was not."""


def unusable_sound(samples: Samples, speech_probability: float) -> Reason | None:
    """Why a sound of 16 kHz cannot be judged; None if it can."""
    loudness = frame_energies(samples)
    if len(loudness) and quantile(loudness, 0.95) < MIN_LEVEL:
        return "too_quiet"
    if len(samples) < MIN_DURATION * SAMPLE_RATE:
        return "too_short"
    return None if speech_probability else "no_speech"


def refusal_by_pocketsphinx(evidence: Evidence) -> Refusal:
    """The reason by the evidence for the best command."""
    ratios = [word_ratio(word, evidence.phones) for word in evidence.command.spans]
    if max(ratios) > WORD_PRESENT_RATIO and min(ratios) < WORD_ABSENT_RATIO:
        return "part_of_a_command", None
    rival = max(evidence.rivals, key=evidence.rivals.__getitem__, default="")
    if min(ratios) > WORD_ABSENT_RATIO and rival:
        behind = (evidence.command.score - evidence.rivals[rival]) / evidence.phones.frames
        if abs(behind) < TIE_RATIO:
            return "unsure_between", (evidence.text, rival)
    return "not_a_command", None


def refusal_by_rival(text: str, other: Rival) -> Refusal:
    """The reason for a command whose rival came too near."""
    return ("part_of_a_command", None) if other.is_begun else ("unsure_between", (text, other.text))


def refusal_by_network(ranking: Ranking, phones: int, words: Collection[float]) -> Refusal:
    """The reason by the scores of the commands, and of each word of the best, nats per phone."""
    best, other = ranking.matches[ranking.text], ranking.matches.get(ranking.next_best)
    if max(words) > WORD_PRESENT_SCORE and min(words) < WORD_ABSENT_SCORE:
        return "part_of_a_command", None
    if other and best.score > WORD_PRESENT_SCORE * phones and best.score - other.score < TIE_SCORE:
        return "unsure_between", (ranking.text, ranking.next_best)
    return "not_a_command", None
