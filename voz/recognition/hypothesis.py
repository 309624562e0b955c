"""What was understood of a segment, and the interface of what understands it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from voz.audio.endpointing.segment import Segment
from voz.events import Reason
from voz.recognition.slot_rivals import Rival
from voz.recognition.speaker.adaptation import StartVector

Refusal = tuple[Reason, tuple[str, str] | None]
"""Why an utterance is refused, and between which two commands if that is the reason."""


def no_command() -> Refusal:
    """The refusal of what was compared with no command."""
    return "not_a_command", None


@dataclass(frozen=True)
class Hypothesis:
    """What was understood of a segment, before it is known what follows.

    Attributes:
        segment: the segment.
        text: the best sentence; empty if none fits.
        spoken_until: end of its last word in the stream, s.
        values: features of its probability; empty if it was compared with no command.
        trust: how surely the sound is speech, 0 to 1.
        probability: that it was said, if there is no other speech around it, and no rival.
        why_refused: returns the reason of a refusal.
        rival: the likeliest other meaning, if it has slots.
        next_best: the second best command; empty if there is no other.
    """

    segment: Segment
    text: str
    spoken_until: float
    values: Mapping[str, float] = field(default_factory=dict)
    trust: float = 0.0
    probability: float = 0.0
    why_refused: Callable[[], Refusal] = no_command
    rival: Rival | None = None
    next_best: str = ""


class CommandFinder(Protocol):
    """Finds the command in a segment."""

    def understand(self, segment: Segment, learned: StartVector) -> Hypothesis:
        """Find the command of a segment, with the probability that it was said.

        Args:
            segment: the segment.
            learned: of the microphone and the speaker.
        """
