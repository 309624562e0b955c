"""From a segment to an utterance: the command in it, and whether it is accepted."""

from __future__ import annotations

from collections.abc import Collection
from functools import partial
from typing import Annotated

import msgspec
from msgspec.structs import replace

from voz.audio import Samples
from voz.audio.segment import (
    CONTEXT_SAMPLES,
    MAX_PAUSE_SAMPLES,
    MAX_WORD_SECONDS,
    Segment,
    belong_together,
    is_spoken_with,
)
from voz.errors import ConfigError
from voz.events import Alternative, PossibleCommand, Utterance
from voz.language.sentences.command_set import Commands
from voz.process.call_lock import NonReentrantLock
from voz.recognition.confidence import (
    SCORE,
    Context,
    discount_for_context,
    load_models,
    probability,
    with_log_odds,
)
from voz.recognition.decision import Decision, DecisionRule, Hypothesis, is_too_close
from voz.recognition.finders import MAX_COMPARED, CommandFinder, NetworkFinder, PocketsphinxFinder
from voz.recognition.language import MAX_NEVER_MISSED, Language
from voz.recognition.name import NAME_SAMPLES_BEFORE, advice_on_name
from voz.recognition.network.phoneme_network import UnknownNetworkError
from voz.recognition.network.score import PhonemeScorer, scorer_for
from voz.recognition.profiles import Profile
from voz.recognition.spotting import KeywordSpotter, SpottedCommand
from voz.records import CheckedRecord
from voz.settings import Recognition

PAUSE_ALLOWANCE = 2.0
"""Seconds that a command may take besides its words."""


MIN_PHONES_OF_WORDS = 3
"""Phones in a pause that may be the rest of a sentence, as `with`."""


MIN_ABOVE_TALK = 7.0
"""Talk that goes on is itself the background; a part of it rises less above that than this, dB."""

MAX_BEST = 100
"""Most alternatives of an utterance."""


class Details(CheckedRecord, frozen=True):
    """What an utterance has besides the command; it costs time."""

    words: bool = False  # when each word was said
    best: Annotated[int, msgspec.Meta(ge=0, le=MAX_BEST)] = 0  # how many alternatives


NO_DETAILS = Details()


class Interpreter:
    """Finds and judges commands in segments, on any thread.

    Attributes:
        longest: duration of the longest command, s.
        samples_before: samples that it needs from before each segment.
        longest_pause: samples within a sentence that may be said in two segments; 0 if none may.
        rule: decides what is accepted.
        spotter: finds commands amid other sound; None without the network.
    """

    def __init__(
        self,
        language: Language,
        settings: Recognition,
        profile: Profile,
    ) -> None:
        """Load the models; arguments and errors are those of `Recognizer`."""
        profile.check_model(language.spoken.model)
        self.commands = language.commands
        network = _network(language, settings.network) if settings.use_network else None
        if settings.more_than_commands and not network:
            why = "`name` and `ask` of [recognition]: each needs the phoneme network"
            raise ConfigError(why, "leave use_network on")
        models = load_models(settings.confidence)
        model = models.with_network if network else models.without_network
        self.model = with_log_odds(model, profile.log_odds)
        finder = NetworkFinder(language, settings, self.model, network) if network else None
        self._finder: CommandFinder = finder or PocketsphinxFinder(language, settings, self.model)
        self._name_finder = finder if settings.name else None
        self._name = settings.name
        self._network = network
        self._never_missed = frozenset(settings.never_missed)
        self.longest_pause = MAX_PAUSE_SAMPLES if self.commands.have_slots else 0
        self.samples_before = CONTEXT_SAMPLES + (NAME_SAMPLES_BEFORE if settings.name else 0)
        self._name_advice = (
            partial(advice_on_name, language, network, settings.name)
            if network and settings.name
            else None
        )
        words = self.commands.longest + len(settings.name.split())
        self.longest = PAUSE_ALLOWANCE + MAX_WORD_SECONDS * words
        self.rule = DecisionRule(self.commands, self.model, settings)
        self._lock = NonReentrantLock()  # pocketsphinx decodes one utterance at a time
        self.spotter = _spotter(network, self.commands, settings.never_missed, self._lock)

    def understand(self, segment: Segment) -> Hypothesis:
        """Find the command of a segment; see `CommandFinder`."""
        with self._lock:
            if self._is_too_long(segment):
                # No command, and it would take long to find that out.
                return Hypothesis(segment, "", segment.end)
            return self._finder.understand(segment, self.rule.answers)

    def context(self, segment: Segment, beside: Collection[Segment]) -> Context:
        """What is around a segment, given those beside it.

        pocketsphinx alone takes talk of others for commands more often than the network, whatever
        its level.
        """
        if self._network:
            is_talk = segment.within_talk and segment.above < MIN_ABOVE_TALK
            among = is_talk or any(is_spoken_with(segment, other) for other in beside)
        else:
            among = segment.within_talk or any(belong_together(segment, each) for each in beside)
        return Context.SPEECH if among else Context.QUIET

    def _is_too_long(self, segment: Segment) -> bool:
        return segment.end - segment.start > self.longest

    def hears_name(self, segment: Segment) -> bool:
        """Whether the robot has a name, and it is in a segment."""
        if self._name_finder is None or self._is_too_long(segment):
            return False
        with self._lock:
            return self._name_finder.hears_name(segment)

    def spotted(self, said: SpottedCommand, decided: float, source: str) -> Utterance:
        """Make the event of a command that was found amid other sound."""
        sure = probability(self.model, {SCORE: said.score})
        return Utterance(
            t=round(decided, 3),
            text=said.text,
            confidence=round(max(sure, self.rule.threshold(said.text) or 0.0), 3),
            accepted=True,
            start=round(said.begin, 3),
            end=round(said.end, 3),
            source=source,
            latency=round(decided - said.end, 3),
            score=round(said.score, 2),
            command=self.command_name(said.text),
        )

    @property
    def has_name(self) -> bool:
        """Whether the robot has a name."""
        return bool(self._name)

    @property
    def name_advice(self) -> str:
        """What would make the robot's name better; empty if it is good, or there is none."""
        return self._name_advice() if self._name_advice else ""

    def has_continuation(self, text: str) -> bool:
        """Whether a longer command begins with this one, or a command follows: it is the name."""
        return bool(text) and (text == self._name or self.commands.has_continuation(text))

    def may_be_continued(self, decision: Decision) -> bool:
        """Whether what comes after a pause may belong to the same sentence."""
        heard = decision.hypothesis
        if decision.accepted:
            return self.commands.may_be_extended(heard.text)
        return is_too_close(heard.rival) and heard.rival.is_begun

    def hears_words(self, samples: Samples) -> bool:
        """Whether the network finds phones in samples of 16 kHz."""
        if self._network is None:
            return False
        with self._lock:
            return self._network.count_heard(samples) >= MIN_PHONES_OF_WORDS

    def is_never_missed(self, decision: Decision) -> bool:
        """Whether a command of `never_missed` was accepted."""
        parse = self.commands.parse(decision.hypothesis.text)
        return decision.accepted and parse is not None and parse.is_one_of(self._never_missed)

    def command_name(self, text: str) -> str | None:
        """The name of a sentence's command, if it is not the sentence itself."""
        parse = self.commands.parse(text)
        return parse.command if parse and parse.command != text else None

    def utterance(
        self, decision: Decision, decided: float, source: str, details: Details = NO_DETAILS
    ) -> Utterance:
        """Make the event of a decision about a segment of a source, made at a time, s."""
        heard = decision.hypothesis
        segment, text = heard.segment, heard.text
        reason, between = (None, None) if decision.accepted else decision.why_refused
        parse = self.commands.parse(text) if decision.accepted else None
        score = heard.features.get(SCORE)
        utterance = Utterance(
            t=round(decided, 3),
            text=text,
            confidence=round(decision.confidence, 3),
            accepted=decision.accepted,
            start=round(segment.start, 3),
            end=round(segment.end, 3),
            source=source,
            latency=round(decided - heard.spoken_until, 3),
            reason=reason,
            between=between,
            above=round(segment.above, 1),
            score=None if score is None else round(score, 2),
            next_best=heard.next_best or None,
            command=parse.command if parse else None,
            slots=dict(parse.slots) if parse else {},
            named=self._is_said_with(decision) if self._name else None,
            perhaps=self._perhaps(decision, between),
        )
        if details == NO_DETAILS:
            return utterance
        with self._lock:  # pocketsphinx may have to search again
            return with_details(utterance, decision, details)

    def _is_said_with(self, decision: Decision) -> bool:
        """Whether the robot's name was said with a hypothesis, surely enough if it is all."""
        heard = decision.hypothesis
        return heard.named and (decision.accepted or not decision.required.is_name)

    def _perhaps(
        self, decision: Decision, between: tuple[str, str] | None
    ) -> tuple[PossibleCommand, ...]:
        """The one or two commands that a hypothesis may nearly surely be."""
        if decision.accepted or not decision.is_nearly_sure:
            return ()
        parsed = [self.commands.parse(text) for text in between or (decision.hypothesis.text,)]
        return tuple(PossibleCommand(p.text, p.command, p.slots) for p in parsed if p)


def _network(language: Language, file: str | None) -> PhonemeScorer | None:
    """The network, if it knows the language."""
    try:
        return scorer_for(language, file)
    except UnknownNetworkError:
        return None


def _spotter(
    network: PhonemeScorer | None,
    commands: Commands,
    never_missed: Collection[str],
    lock: NonReentrantLock,
) -> KeywordSpotter | None:
    watched = commands.named(never_missed, MAX_NEVER_MISSED)
    others = commands if len(commands) <= MAX_COMPARED else ()
    return KeywordSpotter(network, watched, others, lock) if network and watched else None


def with_details(utterance: Utterance, decision: Decision, details: Details) -> Utterance:
    """Add to an utterance what is asked for."""
    return replace(
        utterance,
        words=decision.hypothesis.words() if details.words else (),
        best=_best(utterance, decision, details.best),
    )


def _best(utterance: Utterance, decision: Decision, count: int) -> tuple[Alternative, ...]:
    """The utterance and its rivals; none has more confidence than the ones before it leave."""
    heard = decision.hypothesis
    if not count or not heard.features:
        return ()
    found = [Alternative(utterance.text, utterance.confidence)]
    left = 1 - utterance.confidence
    for text, likely in heard.others(count - 1):
        sure = discount_for_context(likely, decision.context)
        sure = min(sure, found[-1].confidence, left)
        found.append(Alternative(text, round(sure, 3)))
        left = max(0.0, left - found[-1].confidence)
    return tuple(found)
