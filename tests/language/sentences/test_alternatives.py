"""Without a name a template means what was said."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
from language.template_texts import commands_of, compile_text

from voz.errors import CommandsError
from voz.language.command_source import read_list
from voz.language.sentences.command_set import Commands


def meant(commands: Commands, text: str) -> str | None:
    parse = commands.parse(text)
    return parse and parse.command


@pytest.mark.parametrize(
    ("template", "said", "command"),
    [
        ("turn the {led} led (on|off)\nled = red | blue", "turn the red led off",
         "turn the {led} led off"),
        ("move the arm (up|down|home)", "move the arm down", "move the arm down"),
        ("(raise|lower) the arm", "lower the arm", "lower the arm"),
        ("[please] (open gripper | close gripper | halt)", "please close gripper",
         "close gripper"),
        ("[please|kindly] go", "kindly go", "go"),
        ("<polite> go (on|back)\n<polite> = please | would you", "would you go back",
         "would you go back"),
        ("light[s] (up|down)wards", "lights downwards", "light downwards"),
        ("[re]start", "restart", "start"),
        ("go (left;(now|later))", "go later left", "go left later"),
        ("go (2|3) meters", "go three meters", "go three meters"),
        ("turn 180 degrees", "turn one eighty degrees",
         "turn one hundred and eighty degrees"),
        ("arm: (raise|lower) the arm", "lower the arm", "arm"),
    ],
)  # fmt: skip
def test_alternatives_are_commands_of_their_own_and_options_are_not(
    template: str, said: str, command: str
) -> None:
    assert meant(commands_of(template), said) == command


def test_what_may_be_nothing_is_an_option_in_any_notation(tmp_path: Path) -> None:
    path = tmp_path / "robot.jsgf"
    path.write_text(
        "#JSGF V1.0;\ngrammar robot;\npublic <command> = <polite> <action>;\n"
        "<polite> = please | kindly | <NULL>;\n<action> = stop | select object;\n"
    )
    commands = read_list(path).commands
    assert meant(commands, "please stop") == "stop"
    assert meant(commands, "kindly select object") == "select object"
    assert commands.alternatives == [("stop", "select object")]


def test_a_sentence_of_two_alternatives_of_a_line_means_the_first() -> None:
    built = compile_text("[please] (go|please go)")
    assert meant(built.commands, "please go") == "go"
    assert built.warnings == ('l.txt:1:1: "please go" is a sentence of "go" already (l.txt:1:1), and means that',)  # fmt: skip  # noqa: E501


def test_rules_within_rules_are_not_followed_to_their_end() -> None:
    names = ["r" + "x" * depth for depth in range(26)]
    rules = "".join(f"<{a}> = go <{b}> | back <{b}>\n" for a, b in pairwise(names))
    with pytest.raises(CommandsError, match="makes more than 500 commands"):
        compile_text(f"<r>\n{rules}<{names[-1]}> = on\n")
