"""From a segment to a command, and whether it is obeyed."""

from __future__ import annotations

from collections.abc import Collection
from functools import partial

from voz.audio import Samples
from voz.audio.denoise import denoise_if_noisy
from voz.audio.echo import Cleaned
from voz.audio.segment import CONTEXT_SAMPLES, MAX_WORD_SECONDS, Segment
from voz.errors import ConfigError
from voz.events import PossibleCommand, Utterance
from voz.language.sentences.command_set import Commands
from voz.recognition.call_lock import NonReentrantLock
from voz.recognition.confidence import Context, probability
from voz.recognition.confidence_model import SCORE, load_models, with_log_odds
from voz.recognition.decision import Decision, DecisionRule
from voz.recognition.decoder import mean_start
from voz.recognition.details import NO_DETAILS, Details, with_details
from voz.recognition.hypothesis import CommandFinder, Hypothesis, Refusal
from voz.recognition.language import Language
from voz.recognition.name_finder import NAME_SAMPLES_BEFORE
from voz.recognition.network_file import UnknownNetworkError
from voz.recognition.network_finder import MAX_COMPARED, NetworkFinder
from voz.recognition.phoneme_scorer import PhonemeScorer, scorer_for
from voz.recognition.pocketsphinx_finder import PocketsphinxFinder
from voz.recognition.refusal import refusal_by_rival
from voz.recognition.robot_name import advice_on_name
from voz.recognition.shortlist import MAX_NEVER_MISSED
from voz.recognition.speaker.adaptation import Aligner, StartVector, teaches
from voz.recognition.speaker.profiles import Profile
from voz.recognition.spotting import KeywordSpotter, SpottedCommand
from voz.settings import Recognition

PAUSE_ALLOWANCE = 2.0
"""Seconds that a command may take besides its words."""


class Interpreter:
    """Finds and judges commands in segments, on any thread.

    Attributes:
        learned: of the microphone and the speaker; it changes only while learning.
        longest: duration of the longest command, s.
        samples_before: samples that it needs from before each segment.
        rule: decides what is obeyed.
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
        self.learned = profile.start
        self.commands = language.commands
        network = _network(language, settings.network) if settings.second_ear else None
        if settings.more_than_commands and not network:
            why = "`name` and `ask` of [recognition]: each needs the phoneme network"
            raise ConfigError(why, "leave second_ear on")
        models = load_models(settings.confidence)
        model = models.two_ears if network else models.one_ear
        self.model = with_log_odds(model, profile.log_odds)
        finder = (
            NetworkFinder(language, settings, profile, self.model, network) if network else None
        )
        self._finder: CommandFinder = finder or PocketsphinxFinder(
            language, settings, profile, self.model
        )
        self._name_finder = finder if settings.name else None
        # The network needs none of what pocketsphinx learns of a microphone.
        self._aligner = Aligner(language) if learning and not network else None
        self._spotter = _spotter(network, self.commands, settings.never_missed)
        self._name = settings.name
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

    def understand(self, segment: Segment) -> Hypothesis:
        """Find the command of a segment; see `CommandFinder`."""
        with self._lock:
            return self._understand(segment, self.learned)

    def _understand(self, segment: Segment, learned: StartVector) -> Hypothesis:
        if self._is_too_long(segment):
            # No command, and it would take long to find that out.
            return Hypothesis(segment, "", segment.end)
        return self._finder.understand(segment, learned, self.rule.answers)

    def _is_too_long(self, segment: Segment) -> bool:
        return segment.end - segment.start > self.longest

    def hears_name(self, segment: Segment) -> bool:
        """Whether the robot has a name, and it is in a segment."""
        if self._name_finder is None or self._is_too_long(segment):
            return False
        with self._lock:
            return self._name_finder.hears_name(segment)

    def spot(self, so_far: Samples) -> SpottedCommand | None:
        """Find a command that must not be missed in the latest sound, 16 kHz."""
        if self._spotter is None:
            return None
        with self._lock:
            return self._spotter.spot(so_far)

    @property
    def spots(self) -> bool:
        """Whether it can find commands amid other sound."""
        return self._spotter is not None

    def look(self, sound: Cleaned, sought: str | None = None) -> SpottedCommand | None:
        """Find a command, or the likeliest that must not be missed; see `KeywordSpotter.look`."""
        if self._spotter is None:
            return None
        with self._lock:
            return self._spotter.look(sound, sought)

    def is_within(self, samples: Samples, text: str) -> bool:
        """Whether a command may be among the words of a sound, 16 kHz; False if not known."""
        if self._spotter is None:
            return False
        with self._lock:
            return self._spotter.is_within(samples, text)

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

    def learn(self, heard: Hypothesis) -> None:
        """If it is learning, learn from an utterance, or doubt what was learned."""
        if self._aligner:
            with self._lock:
                self._learn(heard, self._aligner)

    def _learn(self, heard: Hypothesis, aligner: Aligner) -> None:
        if teaches(heard.values, heard.trust):
            sound = denoise_if_noisy(heard.segment.samples)
            start = mean_start(sound)
            observed = aligner.observe(sound, heard.text, start, self.learned)
            if observed:
                self.learned = self.learned.updated(observed)
        elif self.learned.frames and self._teaches_without(heard.segment):
            self.learned = self.learned.doubted()
        else:
            self.learned = self.learned.passed()

    def _teaches_without(self, segment: Segment) -> bool:
        heard = self._understand(segment, StartVector())
        return teaches(heard.values, heard.trust)

    @property
    def has_name(self) -> bool:
        """Whether the robot has a name."""
        return bool(self._name)

    @property
    def name_advice(self) -> str:
        """What would make the robot's name better; empty if it is good, or there is none."""
        return self._name_advice() if self._name_advice else ""

    def is_name(self, text: str) -> bool:
        """Whether a text is the robot's name."""
        return bool(text) and text == self._name

    def has_continuation(self, text: str) -> bool:
        """Whether a longer command begins with this one, or a command follows: it is the name."""
        return bool(text) and (self.is_name(text) or self.commands.has_continuation(text))

    def command_name(self, text: str) -> str | None:
        """The name of a sentence's command, if it is not the sentence itself."""
        parse = self.commands.parse(text)
        return parse.command if parse and parse.command != text else None

    def utterance(
        self,
        heard: Hypothesis,
        context: Context,
        decided: float,
        source: str,
        details: Details = NO_DETAILS,
    ) -> Utterance:
        """Decide, and make the event.

        Args:
            heard: the hypothesis.
            context: what is around it.
            decided: time of the decision, s.
            source: name of the stream.
            details: what is told besides.
        """
        segment, text = heard.segment, heard.text
        decision = self.rule.decide(heard, context)
        reason, between = (None, None) if decision.accepted else _why_refused(heard, decision)
        parse = self.commands.parse(text) if decision.accepted else None
        score = heard.values.get(SCORE)
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
            named=self._is_said_with(heard, decision) if self._name else None,
            perhaps=self._perhaps(heard, decision, between),
        )
        if details == NO_DETAILS:
            return utterance
        with self._lock:  # pocketsphinx may have to search again
            return with_details(utterance, heard, context, details)

    def _is_said_with(self, heard: Hypothesis, decision: Decision) -> bool:
        """Whether the robot's name was said with a hypothesis, surely enough if it is all."""
        return heard.named and (decision.accepted or heard.text != self._name)

    def _perhaps(
        self, heard: Hypothesis, decision: Decision, between: tuple[str, str] | None
    ) -> tuple[PossibleCommand, ...]:
        """The one or two commands that a hypothesis may nearly surely be."""
        if decision.accepted or not self.rule.is_nearly_sure(heard, decision):
            return ()
        parsed = [self.commands.parse(text) for text in between or (heard.text,)]
        return tuple(PossibleCommand(p.text, p.command, p.slots) for p in parsed if p)


def _why_refused(heard: Hypothesis, decision: Decision) -> Refusal:
    if decision.for_rival and heard.rival:
        return refusal_by_rival(heard.text, heard.rival)
    return heard.why_refused()


def _network(language: Language, file: str | None) -> PhonemeScorer | None:
    """The network, if it knows the language."""
    try:
        return scorer_for(language, file)
    except UnknownNetworkError:
        return None


def _spotter(
    network: PhonemeScorer | None, commands: Commands, never_missed: Collection[str]
) -> KeywordSpotter | None:
    watched = commands.named(never_missed, MAX_NEVER_MISSED)
    others = commands if len(commands) <= MAX_COMPARED else ()
    return KeywordSpotter(network, watched, others) if network and watched else None
