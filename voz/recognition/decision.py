"""Whether a hypothesis is obeyed, by its probability, its context and its rival."""

from __future__ import annotations

from dataclasses import dataclass

from voz.language.sentences.command_set import Commands
from voz.recognition.confidence import Context, discount_for_context, multiply_odds
from voz.recognition.confidence_model import Model
from voz.recognition.hypothesis import Hypothesis
from voz.recognition.name_finder import NAME_THRESHOLD
from voz.recognition.slot_rivals import highest_confidence, is_too_close
from voz.recognition.thresholds import thresholds_of
from voz.settings import Recognition

EXPECTED = 4.0
"""An answer that is waited for may have lower odds than a command by this factor."""

NEARLY_SURE = 3.0
"""The robot asks back where the odds are lower than they need to be by this factor at most."""


@dataclass(frozen=True)
class Decision:
    """What becomes of a hypothesis."""

    confidence: float  # that the command was said and meant, 0 to 1
    accepted: bool
    waits: bool = False  # accepted only if nothing follows, which is not known yet
    for_rival: bool = False  # refused for its rival alone


class DecisionRule:
    """Compares confidences with thresholds, which any thread may change.

    Attributes:
        answers: what else may be said just now.
    """

    def __init__(self, commands: Commands, model: Model, settings: Recognition) -> None:
        """Compute the thresholds of commands by a model and settings."""
        self._commands = commands
        self._model = model
        self._never_missed = frozenset(settings.never_missed)
        self._name = settings.name
        self._asks = settings.ask != "never"
        self.answers: tuple[str, ...] = ()
        self.accept_by(settings)

    def accept_by(self, settings: Recognition) -> None:
        """Use the false alarms, or the threshold, of other settings."""
        self._thresholds = thresholds_of(self._model, settings)

    def threshold(self, text: str) -> float | None:
        """The confidence that a text needs, 0 to 1; None if it cannot be said."""
        if self._name and text == self._name:
            return NAME_THRESHOLD
        if text in self.answers:
            return multiply_odds(self._thresholds.usual, 1 / EXPECTED)
        parse = self._commands.parse(text)
        if parse is None:
            return None
        is_careful = parse.is_one_of(self._never_missed)
        return self._thresholds.never_missed if is_careful else self._thresholds.usual

    def decide(self, heard: Hypothesis, context: Context) -> Decision:
        """Decide whether a hypothesis is obeyed; `QUIET` if nothing follows it so far."""
        sure, meant = heard.probability, highest_confidence(heard.rival)
        if self._name and heard.text == self._name:  # which fits or not, whatever is around it
            return Decision(sure, accepted=sure >= NAME_THRESHOLD)
        said = discount_for_context(sure, context)
        confidence = min(said, meant)
        threshold = self.threshold(heard.text)
        if threshold is None:
            return Decision(confidence, accepted=False)
        if confidence < threshold or is_too_close(heard.rival):
            return Decision(confidence, accepted=False, for_rival=said >= threshold)
        if context is not Context.QUIET:
            return Decision(confidence, accepted=True)
        so_far = discount_for_context(sure, Context.UNKNOWN_AFTER)
        return Decision(confidence, accepted=True, waits=so_far < threshold)

    def is_nearly_sure(self, heard: Hypothesis, decision: Decision) -> bool:
        """Whether the robot may ask about a hypothesis that is not accepted."""
        threshold = self.threshold(heard.text)
        if not self._asks or threshold is None or heard.text in self.answers:
            return False
        return decision.confidence >= multiply_odds(threshold, 1 / NEARLY_SURE)


def confidence_in_quiet(heard: Hypothesis) -> float:
    """The confidence of a hypothesis without other speech around it, 0 to 1."""
    return min(heard.probability, highest_confidence(heard.rival))
