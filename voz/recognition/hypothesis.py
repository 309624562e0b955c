"""What was understood of a stretch of speech, and who finds it out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple, Protocol

from voz.audio.endpointing.segment import Segment
from voz.events import Reason
from voz.recognition.slot_rivals import Rival
from voz.recognition.speaker.adaptation import StartVector

NO_VALUES: Mapping[str, float] = MappingProxyType({})

Refusal = tuple[Reason, tuple[str, str] | None]
"""Why an utterance is not accepted, and the two commands that it may be if that is why."""


def no_command() -> Refusal:
    """The refusal of what was not compared with any command."""
    return "not_a_command", None


class Hypothesis(NamedTuple):
    """What was understood of a segment, before it is known what follows.

    Attributes:
        segment: the stretch of speech.
        text: the sentence that fits best; empty if none does.
        spoken_until: where its last word ends in the stream, s.
        values: the features of its probability; empty if it was compared with no command.
        trust: how far the sound is to be trusted to be speech, 0 to 1.
        probability: that that it was said, if there is no other speech around it, and no rival.
        why_refused: tells why, if it is.
        rival: what else may have been meant, if it has slots.
        next_best: the command that fits next best; empty if there is no other.
    """

    segment: Segment
    text: str
    spoken_until: float
    values: Mapping[str, float] = NO_VALUES
    trust: float = 0.0
    probability: float = 0.0
    why_refused: Callable[[], Refusal] = no_command
    rival: Rival | None = None
    next_best: str = ""


class CommandFinder(Protocol):
    """Finds the command in a stretch of speech."""

    def understand(self, segment: Segment, learnt: StartVector) -> Hypothesis:
        """Find the sentence of a segment, and how likely it is that it was said.

        Args:
            segment: the stretch of speech.
            learnt: what is known of the microphone and the speaker.
        """
