"""Whether a robot with a name is awake, and what it has asked back. Pure.

    what is said             asleep              awake
    the name                 awake for 8 s       awake for 8 s
    the name and a command   awake, obeyed       awake, obeyed
    a command that stops     obeyed              obeyed
    another command          nothing             obeyed
    an answer in time        nothing             what was asked is done, or forgotten
    what is not sure enough  nothing             perhaps a question

A robot without a name is always awake. One that has asked something stays awake for the answer.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import takewhile

import msgspec
from msgspec.structs import replace

from voz.control.table import CommandTable, can_move
from voz.events import NO, YES, PossibleCommand, Utterance
from voz.settings import Ask
from voz.texts import ENGLISH, text

AWAKE_SECONDS = 8.0
"""After its name a robot is awake for this time."""

ANSWER_SECONDS = 4.0
"""A question can be answered for this time after it was said."""

SECONDS_PER_LETTER = 0.07
"""How long festival takes to say a letter of a question."""

NOTHING = PossibleCommand("", "")
"""What a no means."""


class Question(msgspec.Struct, frozen=True):
    """What was asked, the command that each answer means, and until when one counts, s."""

    text: str
    answers: Mapping[str, PossibleCommand]
    until: float


class AttentionState(msgspec.Struct, frozen=True):
    """Until when a robot with a name is awake, s, and what was asked."""

    awake_until: float = -math.inf
    question: Question | None = None


def is_asleep(attention: AttentionState, t: float) -> bool:
    """Whether a robot with a name is asleep at a time, s."""
    return t > attention.awake_until


def wake(attention: AttentionState, said: Utterance) -> AttentionState:
    """Be awake after an utterance with the name."""
    return stay_awake(attention, said.end + AWAKE_SECONDS)


def stay_awake(attention: AttentionState, until: float) -> AttentionState:
    """Be awake until a time at least, s."""
    return replace(attention, awake_until=max(attention.awake_until, until))


def put_question(attention: AttentionState, question: Question) -> AttentionState:
    """Put a question, and be awake for the answer."""
    return AttentionState(max(attention.awake_until, question.until), question)


def forget_question(attention: AttentionState) -> AttentionState:
    """Take no answer any more."""
    return replace(attention, question=None) if attention.question else attention


def forget_old_question(attention: AttentionState, t: float) -> AttentionState:
    """Take no answer any more if the time for it is over at `t`, s."""
    asked = attention.question
    return forget_question(attention) if asked and t > asked.until else attention


def answer(attention: AttentionState, said: Utterance) -> PossibleCommand | None:
    """The command that an utterance means as an answer; `NOTHING` for a no; else None."""
    asked = attention.question
    if asked is None or said.start > asked.until:
        return None
    return asked.answers.get(said.text)


def question_about(
    said: Utterance, ask: Ask, table: CommandTable, language: str = ENGLISH
) -> Question | None:
    """What to ask in a language about an utterance that is not sure enough; None if nothing."""
    possible = said.perhaps
    if ask == "never" or not possible or any(p.command in table.halts for p in possible):
        return None
    if ask == "standing" and any(can_move(table, p.command) for p in possible):
        return None
    no = text(NO, language)
    if len(possible) == 1:
        asked = text("did you say {command}?", language, command=possible[0].text)
        answers = {text(YES, language): possible[0], no: NOTHING}
    else:
        one, other = differing_words(possible[0].text, possible[1].text)
        asked = text("{one} or {other}?", language, one=one, other=other)
        answers = {one: possible[0], other: possible[1], no: NOTHING}
    until = said.t + len(asked) * SECONDS_PER_LETTER + ANSWER_SECONDS
    return Question(asked, answers, until)


def differing_words(one: str, other: str) -> tuple[str, str]:
    """The words by which two sentences differ, as few as tell them apart."""
    first, second = one.split(), other.split()
    begin, end = shared_ends(first, second)
    if begin + end in (len(first), len(second)):  # one has no word that the other lacks
        if end:
            end -= 1
        else:
            begin -= 1
    return " ".join(first[begin : len(first) - end]), " ".join(second[begin : len(second) - end])


def shared_ends(first: Sequence[str], second: Sequence[str]) -> tuple[int, int]:
    """Count the words that two sentences share at their beginning, and behind these at their end.

    Both counts together are at most the length of the shorter one.
    """
    begin = _shared(first, second)
    return begin, _shared(reversed(first[begin:]), reversed(second[begin:]))


def _shared(first: Iterable[str], second: Iterable[str]) -> int:
    same = (one == other for one, other in zip(first, second, strict=False))
    return sum(1 for _ in takewhile(bool, same))
