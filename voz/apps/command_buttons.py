"""The buttons of a page: which commands have one, and where each stands by what it does. Pure."""

from __future__ import annotations

import msgspec

from voz.control.steps import Step
from voz.control.table import CommandTable, Steps, is_selection
from voz.language.sentences.command_set import Commands

MAX_BUTTONS = 60
"""Of more sentences, each command has one button, with the shortest of its own."""

DRIVE, LISTEN, OBJECTS, OTHERS = "Drive", "Listening", "Objects", "Others"

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


class CommandButton(msgspec.Struct, frozen=True, omit_defaults=True):
    """A button.

    Attributes:
        text: the sentence that it gives.
        group: what it does, in a word or two.
        place: where it stands on the direction pad; "wake" if it begins the listening; None
            elsewhere. One button at most has each place.
    """

    text: str
    group: str
    place: str | None = None


def command_buttons(commands: Commands, table: CommandTable) -> list[CommandButton]:
    """Return the buttons in the order of the list; `stop` has one of its own on every page."""
    buttons: list[CommandButton] = []
    taken: set[str] = set()
    for text in button_sentences(commands):
        parse = commands.parse(text)
        name = parse.command if parse else text
        if name in table.stops:
            continue
        steps = find_steps(table, name)
        place = "wake" if name in table.starts else command_place(steps)
        if place in taken:
            place = None
        if place:
            taken.add(place)
        buttons.append(CommandButton(text, command_group(steps), place))
    return buttons


def button_sentences(commands: Commands) -> list[str]:
    """The sentences that have a button, and those that stop."""
    if len(commands) <= MAX_BUTTONS:
        return commands.listed
    shortest = [commands.named([name], 1) for name in commands.names[:MAX_BUTTONS]]
    return [sentence for sentences in shortest for sentence in sentences[:1]]


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
    return OTHERS


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
