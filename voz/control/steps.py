"""What a command does, step by step: the types of `[commands]` in voz.toml. Does no I/O.

A command is one step, several in order, or the name of another command:

    "go forward" = { drive = 0.1 }
    "come here" = [{ drive = 0.2, metres = 1 }, { rotate = 0.5, degrees = 180 }]
    "advance" = "go forward"
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, TypeAlias

import msgspec

from voz.errors import ConfigError
from voz.records import CheckedRecord, Finite, Int32

PER_UNIT = 1000
"""Velocities are whole thousandths of 1 m/s and 1 rad/s: they leave no float residue."""

SLOT = re.compile(r"\{([^\W\d]\w*)\}")
"""A slot in a text, as `{angle}`; an amount is a number or one slot."""

FUNCTION_NAME = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*")
TOPIC_PATTERN = r"^[/~]?[A-Za-z]\w*(/\w+)*\Z"

ACTIONS: tuple[str, ...] = ("drive", "turn", "rotate", "faster", "slower", "stop", "listen")
ACTIONS += ("state", "publish", "run", "call", "again", "answer")

FLAGS = ("stop", "again")
"""Actions that False leaves out."""

VELOCITY_ACTIONS = ("drive", "turn", "rotate")
"""Actions that set a velocity, which may end after a time, a distance or an angle."""

AMOUNTS = (*VELOCITY_ACTIONS, "faster", "slower", "metres", "degrees", "seconds")
"""Fields that are numbers; all but the first three are more than 0."""

Amount: TypeAlias = Annotated[float, msgspec.Meta(ge=-1000, le=1000)] | str
Text: TypeAlias = Annotated[str, msgspec.Meta(max_length=300)]
Seconds: TypeAlias = Annotated[float, msgspec.Meta(gt=0, le=3600)]
Value: TypeAlias = bool | Int32 | Finite | str


class Step(
    CheckedRecord, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True
):
    """What a command does: at most one of the first thirteen, or only words or a sound."""

    drive: Amount | None = None  # drives straight at this velocity, m/s; negative is back
    # Turns to the left while driving, rad/s; negative to the right, said again tighter.
    turn: Amount | None = None
    rotate: Amount | None = None  # rotates on the spot to the left, rad/s; negative to the right
    faster: Amount | None = None  # moves the velocity in use away from 0, m/s or rad/s
    slower: Amount | None = None  # moves it toward 0
    stop: bool = False  # both velocities 0
    listen: bool | None = None  # whether commands are obeyed from now on
    # The set of commands from now on, of `[states.NAME]`; "" is `[commands]` again.
    state: str | None = None
    publish: Value | None = None  # a value for a topic
    # A program and its arguments.
    run: Annotated[tuple[Text, ...], msgspec.Meta(min_length=1)] | None = None
    # A function in Python, `module:function`, and its arguments.
    call: Annotated[tuple[Text | int | Finite, ...], msgspec.Meta(min_length=1)] | None = None
    again: bool = False  # whether the last command that moved the robot is repeated
    answer: bool | None = None  # yes or no to what `confirm` asks
    say: Text | None = None  # what the robot says, if the step takes effect
    play: Text | None = None  # a sound that comes with voz, or a file
    topic: Annotated[str, msgspec.Meta(pattern=TOPIC_PATTERN)] | None = None  # of `publish`
    metres: Amount | None = None  # how far to `drive`
    degrees: Amount | None = None  # how far to `rotate` or `turn`
    # How long to move; how long a program or function may take.
    seconds: Seconds | str | None = None
    # Whether it is asked first; or the question. Alone, the command is only for the robot's own
    # code.
    confirm: bool | Text = False

    def __post_init__(self) -> None:
        """Check the fields, alone and together; raises ConfigError."""
        super().__post_init__()
        if len(self.actions) > 1:
            one, other, *_ = self.actions
            raise ConfigError(f"`{one}` and `{other}` are two steps; write [{{...}}, {{...}}]")
        if self.is_empty and not self.confirm:
            words = f"{', '.join(ACTIONS)}, say, play, confirm"
            raise ConfigError(f"does nothing; write one of {words}")
        self._check_bounds()
        self._check_amounts()
        if (self.publish is None) != (self.topic is None):
            raise ConfigError("`publish` and `topic` go together: a value, and where it goes")
        if self.call is not None and not FUNCTION_NAME.fullmatch(str(self.call[0])):
            raise ConfigError(f'`call` begins with "module:function", not with "{self.call[0]}"')

    @property
    def actions(self) -> tuple[str, ...]:
        """The actions that it has; a valid step has one at most."""
        given = {name for name in ACTIONS if getattr(self, name) is not None}
        return tuple(a for a in ACTIONS if a in given and (a not in FLAGS or getattr(self, a)))

    @property
    def is_empty(self) -> bool:
        """Whether it does nothing by itself; it may still ask first."""
        return not self.actions and self.say is None and self.play is None

    @property
    def moves(self) -> bool:
        """Whether it may change a velocity, other than to 0."""
        return self.starts_motion or self.faster is not None or self.slower is not None

    @property
    def sets_velocity(self) -> bool:
        """Whether it names a velocity."""
        return any(getattr(self, name) is not None for name in VELOCITY_ACTIONS)

    @property
    def starts_motion(self) -> bool:
        """Whether it sets a velocity, its own or that of the last command that moved."""
        return self.again or self.sets_velocity

    @property
    def bounded(self) -> bool:
        """Whether the motion ends by itself."""
        bounds = (self.metres, self.degrees, self.seconds)
        return self.sets_velocity and any(bound is not None for bound in bounds)

    @property
    def slots(self) -> frozenset[str]:
        """Names of the slots in its texts and amounts."""
        texts = [getattr(self, name) for name in self.__struct_fields__]
        texts += [*(self.run or ()), *(self.call or ())]
        return frozenset(s for text in texts if isinstance(text, str) for s in SLOT.findall(text))

    def _check_bounds(self) -> None:
        if self.metres is not None and self.drive is None:
            raise ConfigError("`metres` is how far to `drive`")
        if self.degrees is not None and self.rotate is None and self.turn is None:
            raise ConfigError("`degrees` is how far to `rotate` or `turn`")
        timed = (*VELOCITY_ACTIONS, "run", "call")
        if self.seconds is not None and not set(timed).intersection(self.actions):
            raise ConfigError(f"`seconds` is for one of {', '.join(timed)}")

    def _check_amounts(self) -> None:
        for name in AMOUNTS:
            amount = getattr(self, name)
            if isinstance(amount, str):
                if not SLOT.fullmatch(amount):
                    raise ConfigError(f'`{name}` is a number or a slot as "{{way}}", no "{amount}"')
            elif amount is not None and not (amount if name in VELOCITY_ACTIONS else amount > 0):
                raise ConfigError(f"`{name}` is {amount:g}; to end a motion write stop = true")


def fill_slots(step: Step, slots: Mapping[str, str | float]) -> Step:
    """Replace the slots of a step by what was said; raises ConfigError for a missing slot."""
    if not step.slots:
        return step
    missing = step.slots - slots.keys()
    if missing:
        raise ConfigError(f"nothing was said for {{{min(missing)}}}")
    values = {name: getattr(step, name) for name in step.__struct_fields__}
    for name, value in values.items():
        if isinstance(value, tuple):
            inserted = _in_place if name == "run" else _argument
            values[name] = tuple(inserted(each, slots) for each in value)
        elif isinstance(value, str):
            values[name] = _number(value, slots) if name in AMOUNTS else _in_place(value, slots)
    return Step(**values)


def _argument(text: str | float, slots: Mapping[str, str | float]) -> str | float:
    """Fill an argument; one that is only a slot keeps its type, text or number."""
    if not isinstance(text, str):
        return text
    return slots[text[1:-1]] if SLOT.fullmatch(text) else _in_place(text, slots)


def _in_place(text: str, slots: Mapping[str, str | float]) -> str:
    return SLOT.sub(lambda found: _shown(slots[found[1]]), text)


def _shown(value: str | float) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return value if isinstance(value, str) else f"{value:g}"


def _number(text: str, slots: Mapping[str, str | float]) -> float:
    value = slots[text[1:-1]]
    try:
        return float(_shown(value) if isinstance(value, bool) else value)
    except (ValueError, OverflowError):
        raise ConfigError(f'{text} is "{value}", not a number') from None


CommandDefinition: TypeAlias = str | Step | tuple[Step, ...]
