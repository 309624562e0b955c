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
from voz.texts import ENGLISH, list_texts, text, translate


class ConsoleRobot(Robot):
    """Prints a line when something happens or the velocity changes."""

    def __init__(self, stream: TextIO, verbose: bool = False, language: str = ENGLISH) -> None:
        """Start at rest; `verbose` also prints the evidence for each utterance."""
        self._stream = stream
        self._verbose = verbose
        self._language = language
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
        told = in_words(event, self._language)
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


def in_words(event: Event, language: str = ENGLISH) -> str:
    """Describe an event in a language, without its time."""
    if isinstance(event, Utterance):
        return _heard(event, language)
    if isinstance(event, Partial):
        return f'{_label("perhaps", language)}"{event.text}" ({event.confidence:.2f})'
    if isinstance(event, Notice):
        told = translate(event.text, language)
        return told if event.good else text("warning: {text}", language, text=told)
    return f"{_label('', language)}{_done(event, language)}"


def _label(english: str, language: str) -> str:
    return f"{text(english, language):<8} "


def _done(event: Event, language: str) -> str:
    match event:
        case Twist(linear=linear, angular=angular):
            motion = motion_in_words(linear, angular, language)
            return text("robot {motion}", language, motion=motion)
        case SelectedObject(value=value):
            return text("robot selects object {value}", language, value=value)
        case Attention(answers=answers) if answers:
            either = list_texts("{one} or {other}", answers, language)
            return text("robot waits for {answers}", language, answers=either)
        case Attention(awake=awake):
            return text("robot is awake" if awake else "robot is asleep", language)
        case Reply(text=said):
            return text('robot says "{text}"', language, text=said)
        case Publish(topic=topic, value=published):
            return f"{topic}: {published}"
        case Play(sound=sound):
            return text("robot plays {sound}", language, sound=sound)
        case StartProgram(program=program):
            return text("runs {program}", language, program=" ".join(program))
        case CallFunction(function=function):
            return text("calls {function}", language, function=function)
        case ProgramEnded(name=name, problem=problem):
            ended = "{name} has ended: {problem}" if problem else "{name} has ended"
            return text(ended, language, name=name, problem=translate(problem, language))
    raise TypeError(event)


def _heard(event: Utterance, language: str) -> str:
    said = f'"{event.text}" ({event.confidence:.2f})'
    undecided = event.accepted and event.obeyed is None and not event.ignored
    if event.obeyed or undecided:
        return f"{_label('heard', language)}{said}"
    what = said if event.text else text("something", language)
    return f"{_label('ignored', language)}{what}, {explain_not_obeyed(event, language)}"


def motion_in_words(linear: float, angular: float, language: str = ENGLISH) -> str:
    """Describe a motion in a language; velocities in m/s and rad/s."""
    parts = []
    if linear:
        forward, back = "drives forward at {speed} m/s", "drives back at {speed} m/s"
        parts.append(text(forward if linear > 0 else back, language, speed=f"{abs(linear):.2f}"))
    if angular:
        left, right = "turns left at {speed} rad/s", "turns right at {speed} rad/s"
        parts.append(text(left if angular > 0 else right, language, speed=f"{abs(angular):.2f}"))
    parts = parts or [text("stands still", language)]
    return list_texts("{one} and {other}", parts, language)
