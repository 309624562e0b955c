"""The card of a list says how each command is said, and what it does."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

import pytest

from voz.apps.command_card import (
    Pattern,
    card_lines,
    card_page,
    command_card,
    describe_steps,
    read_patterns,
)
from voz.config import Config, default_commands, load_config
from voz.control.steps import Step
from voz.control.table import command_table

LIST = """\
start speech
stop: stop | hold [your] position
fly: fly {direction:speed} {way: 1..10} (metre|metres)
turn: [please] turn [to the {side}] by {angle: 5..180 by 5} degrees
land: (land | come down) [[very] gently]
menu
back
dance

direction = forward:0.5 | straight back:-0.5
side = left:0.5 | right:-0.5
"""

TABLE = """\
[commands]
"fly" = { drive = "{speed}", metres = "{way}" }
"turn" = { rotate = "{side}", degrees = "{angle}" }
"land" = { call = ["drone:land"], say = "<mind> your head", confirm = "land here?" }
"yes" = { answer = true }
"no" = { answer = false }
"menu" = { state = "menu" }
[states.menu]
"back" = { state = "" }
"""


class Read(HTMLParser):
    """The texts of a page by their class or element."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.texts: dict[str, list[str]] = {}
        self._open: list[str] = []
        self.feed(page)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "rect", "circle", "path"):
            self._open.append(str(dict(attrs).get("class") or tag))
            if tag != "i":
                self.texts.setdefault(self._open[-1], []).append("")

    def handle_endtag(self, tag: str) -> None:
        if tag not in ("rect", "circle", "path"):
            self._open.pop()

    def handle_data(self, data: str) -> None:
        at = next((name for name in reversed(self._open) if name != "i"), "")
        if at:
            self.texts[at][-1] += data


@pytest.fixture
def patterns(tmp_path: Path) -> list[Pattern]:
    (tmp_path / "commands.txt").write_text(LIST)
    return read_patterns(tmp_path / "commands.txt")


def test_a_pattern_leaves_out_what_may_be_left_out_and_names_its_slots(
    patterns: list[Pattern],
) -> None:
    assert [(pattern.command, pattern.text) for pattern in patterns] == [
        ("start speech", "start speech"), ("stop", "stop"), ("stop", "hold position"),
        ("fly", "fly {direction} {way} metre"), ("turn", "turn [to the {side}] by {angle} degrees"),
        ("land", "land"), ("land", "come down"), ("menu", "menu"), ("back", "back"),
        ("dance", "dance"),
    ]  # fmt: skip
    fly, turn = patterns[3:5]
    assert fly.slots == {"speed": "direction", "way": "way"}
    assert fly.values == {"direction": ("forward", "straight back"), "way": ("1 to 10",)}
    assert turn.values["angle"] == ("5 to 180, by 5",)


def test_a_folder_is_read_and_a_number_is_no_range(tmp_path: Path) -> None:
    (tmp_path / "a.ini").write_text("[Go]\ngo 2 steps\n")
    (tmp_path / "b.yaml").write_text("sentences: [stop]\n")
    assert [one.text for one in read_patterns(tmp_path)] == ["go 2 steps", "stop"]


def test_of_very_many_values_some_are_named(tmp_path: Path) -> None:
    letters = " | ".join(f"{one} {two}" for one in "abcde" for two in "abcdef")
    (tmp_path / "list.txt").write_text(f"go to {{place}}\n\nplace = {letters}\n")
    (pattern,) = read_patterns(tmp_path / "list.txt")
    assert len(pattern.values["place"]) == 25
    assert pattern.values["place"][-1] == "6 more"


def test_the_page_has_each_command_with_what_it_does_and_stop_large(
    patterns: list[Pattern], tmp_path: Path
) -> None:
    (tmp_path / "voz.toml").write_text(TABLE)
    table = load_config(tmp_path / "voz.toml").table
    page = card_page(command_card(patterns, table), "a<b>.txt", "<svg><path/></svg>")
    assert "http" not in page
    assert "script" not in page
    texts = Read(page).texts
    assert texts["strong"] == ["stop"]
    assert texts["others"] == ["or hold position"]
    assert texts["h2"] == ["Listening", "Drive", "Actions", "Menus", "Others"]
    assert texts["said"] == [
        "start speech", "fly direction way metre", "turn [to the side] by angle degrees", "land",
        "come down", "menu", "back", "dance",
    ]  # fmt: skip
    assert texts["does"] == [
        "wakes up, and says “bep bep. I am listening you”",
        "drives way m",
        "turns on the spot by angle°",
        "asks “land here?”, then calls land, and says “<mind> your head”",
        "goes on to “menu”",
        "in “menu”: goes back to the first commands",
        "is up to the robot's program",
    ]
    assert texts["dt"] == ["direction", "way", "side", "angle"]
    assert texts["dd"] == ["forward", "straight back", "1 to 10", "left", "right", "5 to 180, by 5"]
    assert "The commands of a<b>.txt" in texts["p"]


def test_the_commands_that_come_with_voz_have_arrows_on_the_page_and_lines_in_a_terminal() -> None:
    table = default_commands()
    card = command_card([Pattern(name, name) for name in table.sets[""]], table)
    arrows = Read(card_page(card, "list", "")).texts["arrow"]
    assert [arrow for arrow in arrows if arrow] == [*"↑↓↰↱↺↻»«"]
    lines = list(card_lines(card))
    assert lines[0] == "stop: stands still, at any time"
    assert "  go back         drives back at 0.1 m/s" in lines
    assert "  turn right      turns right while it drives" in lines


def test_a_list_without_a_stop_says_so() -> None:
    card = command_card([Pattern("dance", "dance")], Config().table)
    assert "No command of this list stops the robot." in card_page(card, "list", "")
    assert next(card_lines(card)) == "nothing stops"


@pytest.mark.parametrize(
    ("step", "words"),
    [
        (Step(drive=-0.2, metres=1.5), "drives back 1.5 m at 0.2 m/s"),
        (Step(turn=0.1, seconds=3), "turns left while it drives for 3 s"),
        (Step(rotate=-0.5, degrees=180), "turns right on the spot by 180°"),
        (Step(faster=0.05), "goes faster"),
        (Step(slower=0.05), "goes slower"),
        (Step(listen=False), "stands still and sleeps"),
        (Step(publish=7, topic="selected_object"), "selects object 7"),
        (Step(publish=True, topic="lamp"), "sends true to lamp"),
        (Step(publish="open", topic="gripper"), "sends open to gripper"),
        (Step(run=("fswebcam", "a.jpg")), "starts fswebcam"),
        (Step(again=True), "does the last motion again"),
        (Step(answer=True), "answers yes"),
        (Step(answer=False), "answers no"),
        (Step(play="backing-up", confirm=True), "asks first, then plays backing-up"),
        (Step(stop=True, say="so be it"), "stands still, and says “so be it”"),
    ],
)
def test_a_step_in_words(step: Step, words: str) -> None:
    assert describe_steps([step]) == words


def test_several_steps_are_told_in_order() -> None:
    table = command_table(
        {"fetch": (Step(drive=0.1, metres=1), Step(stop=True)), "stop": Step(stop=True)}, {}
    )
    assert (
        describe_steps(table.sets[""]["fetch"])
        == "drives forward 1 m at 0.1 m/s, then stands still"
    )
