"""The buttons of a page: which commands have one, and where each stands by what it does. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import msgspec

from voz.control.steps import Step
from voz.control.table import CommandTable, Steps, is_selection
from voz.language.sentences.automaton import Automaton
from voz.language.sentences.command_set import Commands, SlotMarks, SlotReader
from voz.language.sentences.expression import Value

MAX_VALUES = 1200
"""Values of a slot that are found, each in a tenth of a millisecond."""

MAX_VALUE_WORDS = 8
"""Words of a value, such as `one hundred and twenty two point five`."""


@dataclass(frozen=True)
class SlotChoice:
    """A slot of a sentence, and what may be said there if the rest stays."""

    name: str  # of the slot
    start: int  # its first word in the sentence, from 0
    end: int  # the word after it
    values: dict[str, Value]  # each value by its words, in the order of the list


def slot_choices(commands: Commands, text: str) -> list[SlotChoice]:
    """Return the slots of a sentence, in its order; none if it has none, or is no command."""
    words = text.split()
    label = commands.label(words)
    reader = None if label is None else commands.meanings[label].reader
    if label is None or reader is None:
        return []
    return [
        SlotChoice(
            name, start, end, _values(commands.automaton, reader, label, words, (start, end))
        )
        for name, start, end in _spans(next(reader.marks(words), []))
    ]


def _spans(marks: Sequence[SlotMarks]) -> Iterator[tuple[str, int, int]]:
    """Yield name, begin and end of each slot, by the marks before each word and at the end."""
    name, start = "", 0
    for at, here in enumerate(marks):
        for mark, value in here:
            if mark == "{":
                name, start = str(value), at
            elif mark == "}" and at > start:
                yield name, start, at


def _values(
    automaton: Automaton,
    reader: SlotReader,
    label: int,
    words: Sequence[str],
    slot: tuple[int, int],
) -> dict[str, Value]:
    start, end = slot
    before, after = list(words[:start]), list(words[end:])
    spans = [(name, at) for name, at, _ in _spans(next(reader.marks(words), []))]
    found: dict[str, Value] = {}
    for said in _continuations(automaton, automaton.walk(before), MAX_VALUE_WORDS):
        sentence = [*before, *said, *after]
        reached = automaton.walk(sentence)
        if reached is None or automaton.labels[reached] != label:
            continue
        longer = len(said) - (end - start)
        for marks in reader.marks(sentence):
            here = list(_spans(marks))
            moved = [(name, at + longer * (at > start)) for name, at in spans]
            if [(name, at) for name, at, _ in here] == moved and (
                any(at == start and to == start + len(said) for _, at, to in here)
            ):
                name = next(name for name, at, _ in here if at == start)
                found[" ".join(said)] = (reader.slots(sentence) or {}).get(name, " ".join(said))
                break
        if len(found) == MAX_VALUES:
            break
    return found


def _continuations(automaton: Automaton, state: int | None, most: int) -> Iterator[tuple[str, ...]]:
    """Yield the words to which a state leads, the fewest first."""
    level: list[tuple[int, tuple[str, ...]]] = [] if state is None else [(state, ())]
    for _ in range(most):
        level = [
            (to, (*words, word)) for at, words in level for word, to in automaton.arcs[at].items()
        ][: 10 * MAX_VALUES]
        yield from (words for _, words in level)


MAX_STEPS = 200
"""Numbers on a slider: of more, each second or third and the last."""

MAX_CHIPS = 40
"""Words to choose from that a slot shows."""

MAX_BUTTONS = 60
"""Of more sentences, each command has one button, with the shortest of its own."""

DRIVE, LISTEN, OBJECTS, OTHERS = "Drive", "Listening", "Objects", "Others"
SAYS = "Replies"

GROUPS = {
    "drive": DRIVE, "turn": DRIVE, "rotate": DRIVE, "faster": DRIVE, "slower": DRIVE,
    "stop": DRIVE, "again": DRIVE,
    "listen": LISTEN, "state": "Menus", "run": "Programs", "call": "Actions", "answer": "Answers",
}  # fmt: skip
"""The group of a command, by the first of its actions; that of `publish` is the topic's name."""

SIGNED_PLACES = {
    "drive": ("forward", "back"),
    "turn": ("turn-left", "turn-right"),
    "rotate": ("rotate-left", "rotate-right"),
}
"""Places on the direction pad, for amounts above and below 0."""

PLACES = {"faster": "faster", "slower": "slower"}


class ButtonSlot(msgspec.Struct, frozen=True, omit_defaults=True):
    """A slot of a button's sentence: words to choose from, or numbers."""

    name: str  # of the slot
    start: int  # its first word in the sentence, from 0
    end: int  # the word after it
    values: tuple[str, ...]  # what may be said, as words or digits
    is_number: bool = False  # whether these are numbers, the lowest first


class CommandButton(msgspec.Struct, frozen=True, omit_defaults=True):
    """A button."""

    text: str  # the sentence that it gives
    group: str  # what it does, in a word or two
    # Where it stands on the direction pad; "wake" if it begins the listening; None elsewhere. One
    # button at most has each place.
    place: str | None = None
    slots: tuple[ButtonSlot, ...] = ()  # what else may be said in the sentence


def command_buttons(commands: Commands, table: CommandTable) -> list[CommandButton]:
    """Return the buttons in the order of the list, those that do nothing last.

    `stop` has one of its own on every page. A template with slots has one button.
    """
    buttons: list[CommandButton] = []
    taken: set[str] = set()
    for text in button_sentences(commands):
        parse = commands.parse(text)
        name = parse.command if parse else text
        if name in table.stops:
            continue
        steps = find_steps(table, name)
        slots = button_slots(commands, text)
        place = "wake" if name in table.starts else None if slots else command_place(steps)
        if place in taken:
            place = None
        if place:
            taken.add(place)
        buttons.append(CommandButton(text, command_group(steps), place, slots))
    return sorted(buttons, key=lambda button: button.group == OTHERS)


def button_sentences(commands: Commands) -> list[str]:
    """The sentences that have a button, and those that stop."""
    if len(commands) <= MAX_BUTTONS:
        return list(_one_of_each_template(commands))
    return list(commands.examples_by_name.values())[:MAX_BUTTONS]


def _one_of_each_template(commands: Commands) -> Iterator[str]:
    """Yield all sentences, but of templates with slots the shortest alone."""
    seen: set[int] = set()
    for text in commands.listed:
        label = commands.label(text.split())
        if label is None or commands.meanings[label].reader is None:
            yield text
        elif label not in seen:
            seen.add(label)
            yield commands.example(label) or text


def button_slots(commands: Commands, text: str) -> tuple[ButtonSlot, ...]:
    """Return what may be chosen in a sentence."""
    choices = (choice for choice in slot_choices(commands, text) if len(choice.values) > 1)
    return tuple(_button_slot(choice) for choice in choices)


def _button_slot(choice: SlotChoice) -> ButtonSlot:
    numbers = [value for value in choice.values.values() if not isinstance(value, str)]
    if len(numbers) == len(choice.values):  # typed text may have digits
        ordered = sorted(set(numbers))
        shown = ordered[:: 1 + (len(ordered) - 1) // MAX_STEPS]
        values = tuple(f"{number:.10g}" for number in dict.fromkeys([*shown, ordered[-1]]))
        return ButtonSlot(choice.name, choice.start, choice.end, values, is_number=True)
    return ButtonSlot(choice.name, choice.start, choice.end, tuple(choice.values)[:MAX_CHIPS])


def find_steps(table: CommandTable, name: str) -> Steps:
    """The steps of a command, in whichever state it works."""
    found = (table.steps(name, state) for state in table.sets)
    return next((steps for steps in found if steps), ())


def command_group(steps: Steps) -> str:
    """What a command does, in a word or two."""
    for step in steps:
        if step.publish is not None and step.topic is not None:
            topic = step.topic.strip("/~").replace("/", " ").replace("_", " ")
            return OBJECTS if is_selection(step) else topic.capitalize()
        for action in step.actions:
            return GROUPS[action]
    return SAYS if any(step.say or step.play for step in steps) else OTHERS


def command_place(steps: Steps) -> str | None:
    """A place on the direction pad for what moves without an end; everything else is beside it."""
    if len(steps) != 1 or steps[0].bounded or steps[0].confirm:
        return None
    return _direction(steps[0])


def _direction(step: Step) -> str | None:
    for action in step.actions:
        amount = getattr(step, action)
        if action in SIGNED_PLACES and isinstance(amount, float) and amount:
            return SIGNED_PLACES[action][amount < 0]
        if action in PLACES:
            return PLACES[action]
    return None
