"""A robot that prints what it would do."""

from __future__ import annotations

from collections.abc import Callable
from typing import TextIO

from voz.events import (
    Attention,
    CallFunction,
    Event,
    Notice,
    Partial,
    Play,
    ProgramEnded,
    Publish,
    Reply,
    SelectedObject,
    StartProgram,
    Twist,
    Utterance,
    evidence_in_words,
    explain_not_obeyed,
)
from voz.printable import printable
from voz.robot.base import Robot


class ConsoleRobot(Robot):
    """Prints a line when something happens or the velocity changes."""

    def __init__(self, stream: TextIO, verbose: bool = False) -> None:
        """Start at rest; `verbose` also prints the evidence for each utterance."""
        self._stream = stream
        self._verbose = verbose
        self._velocity = (0.0, 0.0)
        self._is_news = attention_changes()

    def receive(self, event: Event) -> None:
        """Print the event, unless it is the velocity that the robot already has."""
        if isinstance(event, Twist):
            velocity = (event.linear, event.angular)
            if velocity == self._velocity:
                return
            self._velocity = velocity
        if isinstance(event, Attention) and not self._is_news(event):
            return
        told = in_words(event)
        if self._verbose and isinstance(event, Utterance):
            detail = evidence_in_words(event.score, event.next_best)
            told = f"{told} [{detail}]" if detail else told
        # In one piece: a signal ends the run between two calls, and zero velocity still follows.
        self._stream.write(f"{event.t:7.1f} s  {printable(told)}\n")
        self._stream.flush()


def attention_changes() -> Callable[[Attention], bool]:
    """Return what tells whether people want to know of an attention: not the end of a question."""
    before = True

    def is_news(event: Attention) -> bool:
        nonlocal before
        awake, before = before, event.awake
        return awake != event.awake or bool(event.answers)

    return is_news


def in_words(event: Event) -> str:
    """Describe an event, without its time."""
    if isinstance(event, Utterance):
        return _heard(event)
    if isinstance(event, Partial):
        return f'perhaps  "{event.text}" ({event.confidence:.2f})'
    if isinstance(event, Twist):
        return f"         robot {motion_in_words(event.linear, event.angular)}"
    if isinstance(event, SelectedObject):
        return f"         robot selects object {event.value}"
    if isinstance(event, Attention):
        if event.answers:
            return f"         robot waits for {' or '.join(event.answers)}"
        return f"         robot is {'awake' if event.awake else 'asleep'}"
    if isinstance(event, Reply):
        return f'         robot says "{event.text}"'
    if isinstance(event, Notice):
        return event.text if event.good else f"warning: {event.text}"
    return f"         {_done(event)}"


def _done(event: Publish | Play | StartProgram | CallFunction | ProgramEnded) -> str:
    if isinstance(event, Publish):
        return f"{event.topic}: {event.value}"
    if isinstance(event, Play):
        return f"robot plays {event.sound}"
    if isinstance(event, StartProgram):
        return f"runs {' '.join(event.program)}"
    if isinstance(event, CallFunction):
        return f"calls {event.function}"
    return f"{event.name} has ended{f': {event.problem}' if event.problem else ''}"


def _heard(event: Utterance) -> str:
    undecided = event.accepted and event.obeyed is None and not event.ignored
    if event.obeyed or undecided:
        return f'heard    "{event.text}" ({event.confidence:.2f})'
    if event.text:
        return f'ignored  "{event.text}" ({event.confidence:.2f}), {explain_not_obeyed(event)}'
    return f"ignored  something, {explain_not_obeyed(event)}"


def motion_in_words(linear: float, angular: float) -> str:
    """Describe a motion; velocities in m/s and rad/s."""
    parts = []
    if linear:
        parts.append(f"drives {'forward' if linear > 0 else 'back'} at {abs(linear):.2f} m/s")
    if angular:
        side = "left" if angular > 0 else "right"
        parts.append(f"turns {side} at {abs(angular):.2f} rad/s")
    return " and ".join(parts) or "stands still"
