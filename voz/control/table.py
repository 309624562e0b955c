"""What each command does: the table that the settings make. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from itertools import combinations
from types import MappingProxyType
from typing import TypeAlias

from voz.control.steps import CommandDefinition, Step
from voz.errors import ConfigError
from voz.events import START_SPEECH

Steps: TypeAlias = tuple[Step, ...]
CommandDefinitions: TypeAlias = Mapping[str, CommandDefinition]
Places: TypeAlias = Mapping[tuple[str, str], str]
"""Where commands are defined, as `FILE:LINE`, by state and name."""

DEFAULT_STATE = ""
"""The set of commands that a run begins with."""

SELECTED_OBJECT = "selected_object"

OBJECT_NUMBERS = range(-(2**15), 2**15)
"""Valid `selected_object` values: those of a `std_msgs/Int16`."""

STOP = "stop"
"""The command that always stops; settings cannot redefine it."""


HELP = "help"
"""The command that says what may be said now, unless settings give it something else to do."""

TYPED_HELP = "?"
"""Its name where it was typed and is not in the list."""


@dataclass(frozen=True)
class CommandTable:
    """What each command does."""

    # The steps of each command, by the state in which it works.
    sets: Mapping[str, Mapping[str, Steps]]
    stops: frozenset[str]  # the commands that do nothing but stop; they work always, in every state
    # The commands that leave the robot at rest: those, and what ends the listening.
    halts: frozenset[str]
    starts: frozenset[str]  # the commands that begin the listening
    places: Places = field(default_factory=dict)  # where the user defined them
    # A sentence of each command of the list, by its name; None without a list.
    examples: Mapping[str, str] | None = None

    @cached_property
    def wake(self) -> str:
        """What is said to begin the listening; empty if the list has nothing for it."""
        if self.examples is None:
            return START_SPEECH
        return next((text for name, text in self.examples.items() if name in self.starts), "")

    def usable(self, listening: bool, state: str = DEFAULT_STATE) -> dict[str, str]:
        """Return the commands that work in a state, but answers, with a sentence of each."""
        known = {name for own in self.sets.values() for name in own}
        listed = {name: name for name in sorted(known)} if self.examples is None else self.examples
        return {
            name: text
            for name, text in listed.items()
            if name in self.halts
            or (name in self.starts and not listening)
            or (listening and self._does_something(name, state, known))
        }

    def _does_something(self, name: str, state: str, known: Collection[str]) -> bool:
        """Whether a command works in a state: one that no state has is the robot's own."""
        if name not in known:
            return state == DEFAULT_STATE and name != HELP
        steps = self.sets[state].get(name, ())
        return name not in self.starts and any(step.answer is None for step in steps)

    def steps(self, name: str, state: str = DEFAULT_STATE) -> Steps | None:
        """Return the steps of a command in a state, or None.

        Commands in `halts` and `starts` are the same in every state.
        """
        always = name in self.halts or name in self.starts
        return self.sets[DEFAULT_STATE if always else state].get(name)

    def all_steps(self) -> Iterator[tuple[str, str, Step]]:
        """Iterate over all steps, as (state, command, step)."""
        for state, commands in self.sets.items():
            for name, steps in commands.items():
                yield from ((state, name, step) for step in steps)

    @property
    def topics(self) -> dict[str, type]:
        """The users' own topics, and the type of the values on each; ConfigError for two types."""
        topics: dict[str, type] = {}
        for state, name, step in self.all_steps():
            if step.topic is not None and not is_selection(step):
                kind = topics.setdefault(step.topic, type(step.publish))
                if kind is not type(step.publish):
                    raise self.error_at(
                        state, name, f"publishes values of two types on {step.topic}"
                    )
        return topics

    @property
    def replies(self) -> tuple[str, ...]:
        """The replies without slots, which can be rendered beforehand."""
        said = (step.say for _, _, step in self.all_steps() if step.say and "{" not in step.say)
        return tuple(dict.fromkeys(said))

    def answers(self, state: str = DEFAULT_STATE) -> tuple[str, ...]:
        """Return the commands that answer a question in a state, those that mean yes first."""
        given = [(steps[0].answer, name) for name, steps in self.sets[state].items() if steps]
        return tuple(name for wanted in (True, False) for answer, name in given if answer is wanted)

    def error_at(self, state: str, name: str, why: str) -> ConfigError:
        """Return the error of an invalid command, with its place in the user's file."""
        return _error_at(self.places, state, name, why)


def command_table(
    commands: CommandDefinitions,
    states: Mapping[str, CommandDefinitions],
    places: Places = MappingProxyType({}),
    examples: Mapping[str, str] | None = None,
) -> CommandTable:
    """Make the table, and refuse one with which the robot might not stop.

    Args:
        commands: `[commands]` of the settings and voz's own.
        states: `[states.NAME]` of the settings.
        places: where the user defined them.
        examples: a sentence of each command of the list; None without a list.

    Raises:
        ConfigError: a command is invalid; the message says which, where, and why.
    """
    named = {DEFAULT_STATE: commands, **states}
    sets = {
        state: {name: _resolved(name, own, state, places) for name in own}
        for state, own in named.items()
    }
    usual = sets[DEFAULT_STATE]
    stops = frozenset(name for name, steps in usual.items() if _only_stops(steps))
    ends = frozenset(name for name, steps in usual.items() if _only_listens(steps, False))
    starts = frozenset(name for name, steps in usual.items() if _only_listens(steps, True))
    table = CommandTable(sets, stops, stops | ends, starts, places, examples)
    if STOP not in stops:
        raise table.error_at(
            DEFAULT_STATE, STOP, "is redefined; it must stop the robot and do nothing else"
        )
    for state, own in sets.items():
        for name, steps in own.items():
            _check(table, state, name, steps)
    table.topics  # noqa: B018 (raises if one has two kinds)
    return table


def is_selection(step: Step) -> bool:
    """Whether a step selects an object; that has its own event and topic."""
    return step.topic == SELECTED_OBJECT and type(step.publish) is int


def can_move(table: CommandTable, name: str) -> bool:
    """Whether a command may move the robot, in any state."""
    return any(step.moves for commands in table.sets.values() for step in commands.get(name, ()))


def check_commands(
    table: CommandTable, names: Collection[str], after_stop: Collection[str], where: str
) -> None:
    """Raise ConfigError for a list of commands that can move a robot and not stop it.

    `after_stop` are those with a sentence that begins with one that stops the robot; `where` is the
    list's name in messages.
    """
    moving = next((name for name in names if can_move(table, name)), None)
    if moving is not None and table.stops.isdisjoint(names):
        raise ConfigError(
            f'{where}: has "{moving}", which moves the robot, and no command that stops it; add '
            f'the line "{STOP}", or another and [commands] "that one" = {{ stop = true }}'
        )
    hidden = next((name for name in after_stop if can_move(table, name)), None)
    if hidden is not None:
        raise ConfigError(
            f'{where}: "{hidden}" moves the robot and begins with what stops it; '
            "begin it with another word"
        )


def _resolved(name: str, commands: CommandDefinitions, state: str, places: Places) -> Steps:
    seen = [name]
    while isinstance(command := commands[seen[-1]], str):
        if command not in commands:
            near = get_close_matches(command, commands)
            meant = f'; did you mean "{near[0]}"?' if near else ""
            why = f'is an alias of "{command}", which is not a command here{meant}'
            raise _error_at(places, state, name, why)
        if command in seen:
            why = f'is an alias of "{command}", which is an alias of it'
            raise _error_at(places, state, name, why)
        seen.append(command)
    return command if isinstance(command, tuple) else (command,)


def _only_stops(steps: Steps) -> bool:
    if not steps or not steps[0].stop or any(step.confirm for step in steps):
        return False
    return all(step.stop or not step.actions for step in steps)


def _only_listens(steps: Steps, listen: bool) -> bool:
    return len(steps) == 1 and steps[0].listen is listen and not steps[0].confirm


def _check(table: CommandTable, state: str, name: str, steps: Steps) -> None:
    if state != DEFAULT_STATE and (name in table.halts or name in table.starts):
        raise table.error_at(state, name, "stops or listens in all states, by [commands]")
    slots = frozenset[str]().union(*(step.slots for step in steps))
    if name in table.halts and slots:
        raise table.error_at(state, name, f"stops, and must not depend on the slot {min(slots)}")
    if any(step.listen is not None for step in steps) and name not in table.halts | table.starts:
        raise table.error_at(
            state, name, "begins or ends the listening; nothing else may be in the command"
        )
    for step in steps:
        if is_selection(step) and step.publish not in OBJECT_NUMBERS:
            raise table.error_at(
                state,
                name,
                f"selects an object; the largest number is {max(OBJECT_NUMBERS)} (Int16)",
            )
        if step.state is not None and step.state not in table.sets:
            raise table.error_at(
                state, name, f'switches to "{step.state}"; there is no [states.{step.state}]'
            )
    if any(step.confirm for step in steps) and not {True, False} <= _answers(table, state):
        raise table.error_at(
            state, name, "asks first, and no command answers; add { answer = true } and = false }"
        )
    if any(step.confirm or step.again for step in steps[1:]):
        raise table.error_at(
            state, name, "has `confirm` or `again` after the first step; move it there"
        )
    if len(steps) > 1 and any(step.answer is not None for step in steps):
        raise table.error_at(state, name, "answers, and can do nothing else but say so")
    for one, other in combinations(steps, 2):
        if one.sets_velocity and not one.bounded and (other.sets_velocity or other.stop):
            raise table.error_at(
                state, name, "goes on after a motion that does not end; add metres or seconds"
            )


def _answers(table: CommandTable, state: str) -> set[bool | None]:
    return {step.answer for where, _, step in table.all_steps() if where == state}


def _error_at(places: Places, state: str, name: str, why: str) -> ConfigError:
    place = f"{places[state, name]}: " if (state, name) in places else ""
    table = f"[states.{state}]" if state else "[commands]"
    return ConfigError(f'{place}{table} "{name}" {why}')
