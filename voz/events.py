"""What passes between the parts of voz, and out of it: one small type for each event.

Written as JSON, every event is one line with its `type` and the time `t` in seconds since the
run began, for instance `{"type":"cmd_vel","t":1.2,"linear":0.1,"angular":0.0}`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Annotated, Literal, TypeAlias

import msgspec
from msgspec.structs import replace

from voz.records import CheckedRecord, Finite, Fraction, Int16, Int64
from voz.texts import ENGLISH, text

YES, NO = "yes", "no"
"""What may be said to a question."""

Reason = Literal[
    "not_a_command",
    "part_of_a_command",
    "unsure_between",
    "too_short",
    "too_quiet",
    "no_speech",
]
"""Why an utterance is not accepted; `unsure_between` comes with two commands."""

Ignored = Literal[
    "not_listening",
    "asleep",
    "robot_speaking",
    "too_late",
    "not_now",
    "asked_first",
    "nothing_asked",
    "rehearsal",
]
"""Why an accepted utterance is not obeyed: by the rules, not for doubt of what was said."""


class SpokenWord(CheckedRecord, frozen=True):
    """A word of an utterance.

    Attributes:
        word: the word, lower case.
        start: where it begins in its source, s.
        end: where it ends in its source, s.
    """

    word: str
    start: Finite
    end: Finite


class Alternative(CheckedRecord, frozen=True):
    """A sentence that may have been said.

    Attributes:
        text: the sentence.
        confidence: how sure it is, 0 to 1; those of all alternatives together are 1 at most.
    """

    text: str
    confidence: Fraction


class PossibleCommand(CheckedRecord, frozen=True, omit_defaults=True):
    """A command that may have been said.

    Attributes:
        text: the sentence.
        command: its name, by which a robot knows what to do.
        slots: the values in it by name: words, numbers, true or false.
    """

    text: str
    command: str
    slots: Mapping[str, bool | str | Int64 | Finite] = {}


class Utterance(CheckedRecord, frozen=True, tag_field="type", tag="utterance", omit_defaults=True):
    """A stretch of speech, or a typed line, and what was understood of it.

    Attributes:
        t: when it was decided, s.
        text: the sentence heard, lower case; empty if no command fits what was said.
        confidence: how sure it is that `text` was said, 0 to 1; 1 for a typed command, 0 for
            other typed text.
        accepted: whether it was recognized surely enough; whether it took effect says `obeyed`.
        start: where the speech begins in its source, s.
        end: where the speech ends in its source, s.
        source: a recording's path, "microphone", "browser", "text", "page", "program" (a `POST`
            without a page), "wyoming", "ros2" or a topic of ROS.
        reason: why it is not accepted, if it is not.
        between: the two commands that it may be, if that is the reason.
        latency: from the end of the last word to `t`, s; None for typed text.
        obeyed: whether it took effect; None where nothing is driven that could obey.
        ignored: why it did not though it is accepted.
        above: how far it stood out of the room, dB; None for typed text.
        score: the evidence for it by the phoneme network, nats; None where there is none.
        next_best: the command that fits next best; None if there is no other.
        command: the name of what it means, by which a robot knows what to do: of a plain list the
            sentence itself, of templates that of the template; None if it is not accepted.
        slots: the values in it by name: words, numbers, true or false.
        meant: of typed text that is no command the one that is nearest to it, if any is.
        words: when each word of `text` was said, if asked for.
        best: the sentences that fit best, `text` first, as many as were asked for.
        named: whether the robot's name was said before it, or is all that was said, or a button to
            talk to the robot was held meanwhile; None if the robot that hears it has no name.
        perhaps: where the robot asks back, the one or two commands that it may nearly surely be.
        say_first: of one that is not obeyed as the robot does not listen, what begins the
            listening; empty if nothing does, None where that is `start speech`.
    """

    t: Finite
    text: str
    confidence: Fraction
    accepted: bool
    start: Finite
    end: Finite
    source: str
    reason: Reason | None = None
    between: tuple[str, str] | None = None
    latency: Finite | None = None
    obeyed: bool | None = None
    ignored: Ignored | None = None
    above: float | None = None
    score: Finite | None = None
    next_best: str | None = None
    command: str | None = None
    slots: Mapping[str, bool | str | Int64 | Finite] = {}
    meant: str | None = None
    words: tuple[SpokenWord, ...] = ()
    best: tuple[Alternative, ...] = ()
    named: bool | None = None
    perhaps: tuple[PossibleCommand, ...] = ()
    say_first: str | None = None

    def __post_init__(self) -> None:
        """An accepted sentence is its own command unless it has another name."""
        super().__post_init__()
        if self.command is None and self.accepted:
            msgspec.structs.force_setattr(self, "command", self.text)

    def __hash__(self) -> int:
        """Hash without the slots, which cannot be hashed."""
        return hash((self.t, self.text, self.source))

    def __bool__(self) -> bool:
        """Whether it is accepted."""
        return self.accepted

    def __str__(self) -> str:
        """What was said."""
        return self.text

    def __repr__(self) -> str:
        """What was said, when, and whether it is accepted, in a line."""
        why = "accepted" if self.accepted else explain(self.reason or "not_a_command", self.between)
        when = f"{self.start:.2f}-{self.end:.2f} s"
        return f"<Utterance {self.text!r}, {why}, confidence {self.confidence:.2f}, {when}>"

    def _repr_html_(self) -> str:
        """What a notebook shows: what was said, and both opinions."""
        from voz.notebook import utterance_html

        return utterance_html(self)

    @property
    def name(self) -> str:
        """The name of the command, also of one that is not accepted."""
        return self.command or self.text

    @property
    def spoken(self) -> bool:
        """Whether it was heard; else it comes as text."""
        return self.latency is not None


class Partial(CheckedRecord, frozen=True, tag_field="type", tag="partial", omit_defaults=True):
    """A command that seems to have been said; an utterance that settles what it was follows.

    Attributes:
        t: when it was noticed, s.
        text: the command.
        confidence: how sure it is, if nothing else was said around it, 0 to 1; while the sound
            around it goes on, only how well it fits.
        command: the name of the command, where it is not the text itself.
    """

    t: Finite
    text: str
    confidence: Fraction
    command: str | None = None

    @property
    def name(self) -> str:
        """The name of the command."""
        return self.command or self.text


class Twist(CheckedRecord, frozen=True, tag_field="type", tag="cmd_vel"):
    """The velocity that the robot is asked to hold, sent 10 times a second.

    Attributes:
        t: when it is sent, s.
        linear: forward velocity, m/s.
        angular: turning velocity to the left, rad/s.
    """

    t: Finite
    linear: float
    angular: float


class SelectedObject(CheckedRecord, frozen=True, tag_field="type", tag="selected_object"):
    """The object the arm is asked to point at.

    Attributes:
        t: when it is sent, s.
        value: 1 beer, 2 cocacola, 100 fold the arm.
    """

    t: Finite
    value: Int16


class Reply(CheckedRecord, frozen=True, tag_field="type", tag="reply"):
    """A sentence that the robot says.

    Attributes:
        t: when it is asked for, s.
        text: the sentence.
    """

    t: Finite
    text: str


class Attention(CheckedRecord, frozen=True, tag_field="type", tag="attention", omit_defaults=True):
    """Whether the robot is awake: it has no name, or that was said; and what may be answered.

    Attributes:
        t: when that has changed, s.
        awake: whether spoken commands count, besides those that stop.
        answers: what may be said to a question; empty if nothing was asked.
    """

    t: Finite
    awake: bool
    answers: tuple[str, ...] = ()


class Publish(CheckedRecord, frozen=True, tag_field="type", tag="publish"):
    """A value for a topic of the user's own.

    Attributes:
        t: when it is sent, s.
        topic: where it goes; relative, as in ROS.
        value: true or false, a number or a text.
    """

    t: Finite
    topic: str
    value: bool | int | Finite | str


class Play(CheckedRecord, frozen=True, tag_field="type", tag="play"):
    """A sound that the robot plays.

    Attributes:
        t: when it is to begin, s.
        sound: a name of `voz sound --list`, or a file.
    """

    t: Finite
    sound: str


class StartProgram(CheckedRecord, frozen=True, tag_field="type", tag="run", omit_defaults=True):
    """A program that is started.

    Attributes:
        t: when it is started, s.
        program: it and its arguments.
        seconds: how long it may take, s; None is a minute.
    """

    t: Finite
    program: tuple[str, ...]
    seconds: Annotated[float, msgspec.Meta(gt=0, le=3600)] | None = None


class CallFunction(CheckedRecord, frozen=True, tag_field="type", tag="call", omit_defaults=True):
    """A function in Python that is called.

    Attributes:
        t: when it is called, s.
        function: `module:function`.
        arguments: what it gets.
        seconds: after this time, s, it is reported that it has not ended; None is a minute.
    """

    t: Finite
    function: str
    arguments: tuple[str | int | Finite, ...] = ()
    seconds: Annotated[float, msgspec.Meta(gt=0, le=3600)] | None = None


class ProgramEnded(CheckedRecord, frozen=True, tag_field="type", tag="ended", omit_defaults=True):
    """The end of a program or a function.

    Attributes:
        t: when it was noticed, s.
        name: the program or function.
        problem: why it did not end well; empty if it did.
    """

    t: Finite
    name: str
    problem: str = ""


class Notice(CheckedRecord, frozen=True, tag_field="type", tag="warning", omit_defaults=True):
    """Something the user should know that does not end the run.

    It is written as `"type":"warning"`, its name in version 0.1: files and pages have that.

    Attributes:
        t: when it was noticed, s.
        text: for people.
        good: whether it is good news: what was lost is back.
        stops: whether the robot stops for this, whatever drives it.
    """

    t: Finite
    text: str
    good: bool = False
    stops: bool = False


Event: TypeAlias = (
    Utterance
    | Partial
    | Twist
    | SelectedObject
    | Attention
    | Publish
    | Reply
    | Play
    | StartProgram
    | CallFunction
    | ProgramEnded
    | Notice
)

Receiver: TypeAlias = Callable[[Event], None]
"""What is called with every event of a run, in order."""


def to_json(event: msgspec.Struct) -> str:
    """Write an event, or another record, as one line of JSON, without the newline.

    A `command` that equals the text is left out.
    """
    written: object = event
    if getattr(event, "command", None) is not None:
        written = fields = msgspec.to_builtins(event)
        if fields["command"] == fields["text"]:
            del fields["command"]
    try:
        return msgspec.json.encode(written).decode()
    except UnicodeEncodeError:  # names of files and typed text may not be valid Unicode
        builtins = msgspec.to_builtins(written)
        plain = json.dumps(builtins, ensure_ascii=False, separators=(",", ":"))
        return plain.encode(errors="replace").decode()


IGNORED_IN_WORDS: Mapping[Ignored, str] = {
    "not_listening": "it does not listen",
    "asleep": "the robot's name was not said",
    "robot_speaking": "the robot was speaking",
    "too_late": "it came too late",
    "not_now": "it has no meaning now",
    "asked_first": "it is done after a yes",
    "nothing_asked": "nothing was asked",
    "rehearsal": "this is a rehearsal",
}


START_SPEECH = "start speech"
"""What begins the listening, if the list has no other command for it."""


def explain(reason: Reason, between: tuple[str, str] | None, language: str = ENGLISH) -> str:
    """Say in words of a language why an utterance is not accepted."""
    if between:
        one, other = between
        return text('unsure between "{one}" and "{other}"', language, one=one, other=other)
    return text(reason.replace("_", " "), language)


def explain_not_obeyed(utterance: Utterance, language: str = ENGLISH) -> str:
    """Say in words of a language why an utterance is not obeyed, and what may have been meant."""
    if utterance.meant:
        why = explain("not_a_command", None, language)
        return text('{why}; did you mean "{meant}"?', language, why=why, meant=utterance.meant)
    if utterance.ignored == "not_listening" and utterance.say_first != "":
        first = utterance.say_first or START_SPEECH
        return text('not obeyed: say "{command}" first', language, command=first)
    if utterance.ignored:
        why = text(IGNORED_IN_WORDS[utterance.ignored], language)
        return text("not obeyed: {why}", language, why=why)
    return explain(utterance.reason or "not_a_command", utterance.between, language)


def evidence_in_words(score: float | None, next_best: str | None) -> str:
    """Say in words how good the evidence for an utterance is; empty if unknown."""
    parts = [] if score is None else [f"score {score:.1f}"]
    if next_best:
        parts.append(f'next best "{next_best}"')
    return ", ".join(parts)


def shift_time(event: Utterance | Partial, seconds: float) -> Utterance | Partial:
    """Move the times of an event of a stream that began at `seconds`."""
    if isinstance(event, Partial):
        return replace(event, t=round(event.t + seconds, 3))
    moved = {name: round(getattr(event, name) + seconds, 3) for name in ("t", "start", "end")}
    words = tuple(
        SpokenWord(each.word, round(each.start + seconds, 3), round(each.end + seconds, 3))
        for each in event.words
    )
    return replace(event, **moved, words=words)
