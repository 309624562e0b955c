"""Buttons stand where they do by what their commands do."""

from __future__ import annotations

from language.template_texts import commands_of

from voz.apps.command_buttons import MAX_BUTTONS, button_sentences, command_buttons
from voz.config import default_commands
from voz.control.steps import Step
from voz.control.table import command_table
from voz.language.sentences.command_set import plain_commands

OWN = {
    "halt": "stop",
    "advance": Step(drive=0.2),
    "advance quickly": Step(drive=0.4),
    "advance one metre": Step(drive=0.2, metres=1),
    "look left": Step(rotate=0.5),
    "light on": Step(publish=True, topic="living_room/lamp"),
    "take a picture": Step(run=("fswebcam", "picture.jpg")),
    "wave": (Step(say="hello"), Step(call=("my_arm:wave",))),
    "yes": Step(answer=True),
    "again": Step(again=True),
    "menu": Step(state="menu"),
    "wake up": Step(listen=True),
    "stop": Step(stop=True),
}


def places(buttons: list[object]) -> dict[str, str | None]:
    return {button.text: button.place for button in buttons}  # type: ignore[attr-defined]


def test_the_commands_that_come_with_voz_are_a_pad_and_two_groups() -> None:
    table = default_commands()
    buttons = command_buttons(plain_commands(list(table.sets[""])), table)
    assert places([*buttons]) == {
        "start speech": "wake", "stop speech": None, "go forward": "forward", "go back": "back",
        "turn left": "turn-left", "turn right": "turn-right", "rotate left": "rotate-left",
        "rotate right": "rotate-right", "speed up": "faster", "slow down": "slower",
        "point beer": None, "point cocacola": None, "fold arm": None,
    }  # fmt: skip
    groups = {button.group for button in buttons}
    assert groups == {"Drive", "Listening", "Objects"}


def test_groups_and_places_come_from_the_table_in_any_words_and_order() -> None:
    table = command_table(OWN, {"menu": {"back": Step(state="")}})
    buttons = command_buttons(plain_commands([*OWN, "back", "sing"]), table)
    assert {button.text: button.group for button in buttons} == {
        "advance": "Drive", "advance quickly": "Drive", "advance one metre": "Drive",
        "look left": "Drive", "light on": "Living room lamp", "take a picture": "Programs",
        "wave": "Actions", "yes": "Answers", "again": "Drive", "menu": "Menus",
        "wake up": "Listening", "back": "Menus", "sing": "Others",
    }  # fmt: skip
    on_pad = {text: place for text, place in places([*buttons]).items() if place}
    assert on_pad == {"advance": "forward", "look left": "rotate-left", "wake up": "wake"}


SLOTS = """
stop
sing
turn: [please] turn {side} {angle: 5..180 by 5} degrees
bring: bring the {thing}
count: count to {number: 1..1000}
side = left | right
thing = (red | green) cup | key
"""


def test_a_template_with_slots_has_one_button_with_what_may_be_said_in_each() -> None:
    own = {"stop": Step(stop=True), "turn": Step(rotate=0.1), "bring": Step(say="here")}
    buttons = command_buttons(commands_of(SLOTS), command_table(own, {}))
    turn, bring, sing, count = buttons
    assert (turn.text, turn.group, turn.place) == ("turn left five degrees", "Drive", None)
    side, angle = turn.slots
    assert (side.name, side.start, side.end, side.values) == ("side", 1, 2, ("left", "right"))
    assert (angle.name, angle.start, angle.end, angle.is_number) == ("angle", 2, 3, True)
    assert angle.values == tuple(str(number) for number in range(5, 181, 5))
    (thing,) = bring.slots
    assert (bring.group, bring.text, thing.values) == (
        "Replies", "bring the key", ("key", "red cup", "green cup")
    )  # fmt: skip
    assert (sing.slots, sing.group) == ((), "Others")
    (number,) = count.slots
    assert (count.text, number.values[:3], number.values[-1]) == (
        "count to one",
        ("1", "6", "11"),
        "1000",
    )


def test_each_sentence_that_a_button_gives_is_a_command_with_what_was_chosen() -> None:
    commands = commands_of(SLOTS)
    for button in command_buttons(commands, default_commands()):
        for slot in button.slots:
            for value in slot.values:
                words = button.text.split()
                words[slot.start : slot.end] = [value]
                parse = commands.parse(" ".join(words))
                assert parse
                assert str(parse.slots[slot.name]) == value


def test_a_short_list_has_a_button_for_each_sentence_but_of_slots_one() -> None:
    few = commands_of("stop\n(open | close) gripper\ngo {far: 1..3} metres")
    assert button_sentences(few) == ["stop", "open gripper", "close gripper", "go one metres"]


def test_of_very_many_sentences_each_command_has_one_button() -> None:
    sentences = [f"go {word}" for word in map(chr, range(ord("a"), ord("a") + 26))]
    assert button_sentences(plain_commands(sentences)) == sentences
    many = [f"{one} {two}" for one in "abcdefgh" for two in "abcdefghij"]
    assert len(button_sentences(plain_commands(many))) == MAX_BUTTONS
