"""What was understood of a segment, and the interface of what understands it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from voz.audio.segment import Segment
from voz.events import Reason, SpokenWord
from voz.recognition.slot_rivals import Rival
from voz.recognition.speaker.adaptation import StartVector

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
    # Features; empty if it was compared with no command
    values: Mapping[str, float] = field(default_factory=dict)
    trust: float = 0.0  # how surely the sound is speech, 0 to 1
    probability: float = 0.0  # that it was said, without other speech around it and without a rival
    why_refused: Callable[[], Refusal] = no_command
    rival: Rival | None = None  # the likeliest other meaning, if it has slots
    named: bool = False  # whether it begins with the robot's name, or is the name
    next_best: str = ""  # the second best command; empty if there is no other
    words: Callable[[], tuple[SpokenWord, ...]] = tuple  # aligned when it is called
    # So many other commands, the best first, with their probabilities as that of `text`
    others: Callable[[int], Sequence[tuple[str, float]]] = no_others


class CommandFinder(Protocol):
    """Finds the command in a segment."""

    def understand(
        self, segment: Segment, learned: StartVector, answers: Sequence[str] = ()
    ) -> Hypothesis:
        """Find the command, or the answer, of a segment, with the probability that it was said."""
