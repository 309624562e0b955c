"""The commands of a list in groups, each with what it does. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from voz.apps.card.steps_in_words import describe_steps
from voz.apps.web.command_buttons import LISTEN, command_group, command_place, find_steps
from voz.control.table import DEFAULT_STATE, CommandTable, Steps
from voz.language.patterns import Pattern


@dataclass(frozen=True)
class CardEntry:
    """A command.

    Attributes:
        texts: how it may be said, with slots in braces.
        does: what it does, in words.
        values: what may be said for each slot.
        place: where its button stands on the direction pad; None elsewhere.
    """

    texts: tuple[str, ...]
    does: str
    values: dict[str, tuple[str, ...]]
    place: str | None = None


@dataclass(frozen=True)
class CommandCard:
    """The commands of a list.

    Attributes:
        stops: how the robot is stopped.
        groups: the other commands by what they do, what begins and ends the listening first.
    """

    stops: tuple[str, ...]
    groups: dict[str, list[CardEntry]]


def command_card(patterns: Sequence[Pattern], table: CommandTable) -> CommandCard:
    """Put the patterns of a list, in its order, with what they do into groups."""
    by_name: dict[str, list[Pattern]] = {}
    for pattern in patterns:
        by_name.setdefault(pattern.command, []).append(pattern)
    stops = tuple(p.text for p in patterns if p.command in table.stops)
    groups: dict[str, list[CardEntry]] = {LISTEN: []}
    for name, ways in by_name.items():
        if name not in table.stops:
            steps = find_steps(table, name)
            groups.setdefault(command_group(steps), []).append(_entry(table, name, ways, steps))
    return CommandCard(stops, {name: entries for name, entries in groups.items() if entries})


def card_lines(card: CommandCard) -> Iterator[str]:
    """Yield the lines of a card for a terminal."""
    entries = [entry for group in card.groups.values() for entry in group]
    width = max(map(len, (_said(entry.texts) for entry in entries)), default=0)
    yield f"{' or '.join(card.stops)}: stands still, at any time" if card.stops else "nothing stops"
    for name, group in card.groups.items():
        yield f"{name}:"
        for entry in group:
            yield f"  {_said(entry.texts):{width}}  {entry.does}"
            for slot, values in entry.values.items():
                yield f"  {'':{width}}  {{{slot}}}: {', '.join(values)}"


def _said(texts: Sequence[str]) -> str:
    return " or ".join(texts)


def _entry(table: CommandTable, name: str, patterns: Sequence[Pattern], steps: Steps) -> CardEntry:
    does = describe_steps(steps)
    values: dict[str, tuple[str, ...]] = {}
    for pattern in patterns:
        values |= pattern.values
        for slot, shown in pattern.slots.items():
            does = does.replace(f"{{{slot}}}", f"{{{shown}}}")
    states = [state for state, own in table.sets.items() if name in own]
    if states and DEFAULT_STATE not in states:
        does = f"in “{states[0]}”: {does}"
    texts = tuple(dict.fromkeys(pattern.text for pattern in patterns))
    return CardEntry(texts, does, values, command_place(steps))
