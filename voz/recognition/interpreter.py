"""From a stretch of speech to its sentence, and whether it is obeyed."""

from __future__ import annotations

from collections.abc import Collection

from voz.audio import Samples
from voz.audio.denoise import denoise_if_noisy
from voz.audio.endpointing.segment import MAX_WORD_SECONDS, Segment
from voz.events import Utterance
from voz.language.sentences.command_set import Commands
from voz.recognition.call_lock import NonReentrantLock
from voz.recognition.confidence import Context
from voz.recognition.confidence_model import SCORE, load_models, with_log_odds
from voz.recognition.decision import DecisionRule
from voz.recognition.decoder import mean_start
from voz.recognition.hypothesis import CommandFinder, Hypothesis
from voz.recognition.language import Language
from voz.recognition.network_file import UnknownNetworkError
from voz.recognition.network_finder import MAX_COMPARED, NetworkFinder
from voz.recognition.phoneme_scorer import PhonemeScorer, scorer_for
from voz.recognition.pocketsphinx_finder import PocketsphinxFinder
from voz.recognition.shortlist import MOST_NEVER_MISSED
from voz.recognition.speaker.adaptation import Aligner, StartVector, teaches
from voz.recognition.speaker.profiles import Profile
from voz.recognition.spotting import Spotted, Spotter
from voz.settings import Recognition

PAUSES = 2.0
"""Seconds that a command takes besides its words: silence, hesitation, noise before and after."""


class Interpreter:
    """Finds what was said in stretches of speech; made once, used for many, on any thread.

    Attributes:
        learnt: what is known of the microphone and the speaker; it changes only while learning.
        longest: how long a command may take, s.
        commands: what may be said.
        model: what the confidence is computed by.
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
        self.learnt = profile.start
        self.commands = language.commands
        network = _network(language, settings.network) if settings.second_ear else None
        models = load_models(settings.confidence)
        model = models.two_ears if network else models.one_ear
        self.model = with_log_odds(model, profile.log_odds)
        self._ears: CommandFinder = (
            NetworkFinder(language, settings, profile, self.model, network)
            if network
            else PocketsphinxFinder(language, settings, profile, self.model)
        )
        # The network needs none of what pocketsphinx learns of a microphone.
        self._aligner = Aligner(language) if learning and not network else None
        self._spotter = _spotter(network, self.commands, settings.never_missed)
        self.longest = PAUSES + MAX_WORD_SECONDS * self.commands.longest
        self.rule = DecisionRule(self.commands, self.model, settings)
        self._turns = NonReentrantLock()  # pocketsphinx decodes one utterance at a time

    def understand(self, segment: Segment) -> Hypothesis:
        """Find the sentence of a segment, and how likely it is that it was said."""
        with self._turns:
            return self._understand(segment, self.learnt)

    def _understand(self, segment: Segment, learnt: StartVector) -> Hypothesis:
        if segment.end - segment.start > self.longest:
            # No command, and it would take long to find that out.
            return Hypothesis(segment, "", segment.end)
        return self._ears.understand(segment, learnt)

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
            sound = denoise_if_noisy(heard.segment.samples)
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

    def has_continuation(self, text: str) -> bool:
        """Tell whether a longer command begins with this one."""
        return bool(text) and self.commands.has_continuation(text)

    def another_name(self, text: str) -> str | None:
        """Give the name of a sentence's command, where it is not the sentence itself."""
        parse = self.commands.parse(text)
        return parse.command if parse and parse.command != text else None

    def utterance(
        self, heard: Hypothesis, context: Context, decided: float, source: str
    ) -> Utterance:
        """Decide, and make the event that says so.

        Args:
            heard: what was understood.
            context: what is around it.
            decided: the time of the decision, s.
            source: where it comes from.
        """
        segment, text = heard.segment, heard.text
        decision = self.rule.decide(heard, context)
        reason, between = (None, None) if decision.accepted else heard.why_refused()
        parse = self.commands.parse(text) if decision.accepted else None
        score = heard.values.get(SCORE)
        return Utterance(
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
        )


def _network(language: Language, file: str | None) -> PhonemeScorer | None:
    """Load the network, where it knows the language."""
    try:
        return scorer_for(language, file)
    except UnknownNetworkError:
        return None


def _spotter(
    network: PhonemeScorer | None, commands: Commands, never_missed: Collection[str]
) -> Spotter | None:
    """Look for the commands that must not be missed, where there is a network."""
    watched = commands.named(never_missed, MOST_NEVER_MISSED)
    others = commands if len(commands) <= MAX_COMPARED else ()
    return Spotter(network, watched, others) if network and watched else None
