"""The notation: the template, then what it says."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from language.template_texts import commands_of, compile_text

from voz.errors import CommandsError
from voz.language.command_source import read_list
from voz.language.formats.notation import has_templates
from voz.language.sentences.command_set import Commands


def said(text: str) -> list[str]:
    return list(commands_of(text))


@pytest.mark.parametrize(
    ("template", "sentences"),
    [
        ("[please] (go|drive) on", ["please go on", "please drive on", "go on", "drive on"]),
        ("a (b;c d)", ["a b c d", "a c d b"]),
        ("(a;b;c)", ["a b c", "a c b", "b a c", "b c a", "c a b", "c b a"]),
        ("turn light[s] on", ["turn light on", "turn lights on"]),
        ("move (up|down)wards", ["move upwards", "move downwards"]),
        ("turn [the ]lamp on", ["turn the lamp on", "turn lamp on"]),
        ("Go  (Left | RIGHT)", ["go left", "go right"]),
        ("advance | move on", ["advance", "move on"]),
        ("go [[very] fast]", ["go very fast", "go fast", "go"]),
        ("go back # (", ["go back"]),
    ],
)
def test_a_template_says_its_sentences(template: str, sentences: list[str]) -> None:
    assert sorted(said(template)) == sorted(sentences)


def test_lists_have_what_is_spoken_and_its_value() -> None:
    commands = commands_of("bring the {color} cup\ncolor = red | deep blue:blue | seven:7")
    parses = [commands.parse(text) for text in commands]
    assert [parse and parse.slots for parse in parses] == [
        {"color": "red"},
        {"color": "blue"},
        {"color": 7},
    ]


def test_a_slot_may_have_another_name_than_its_list() -> None:
    commands = commands_of("from {place:origin} to {place:goal}\nplace = here | there")
    parse = commands.parse("from here to there")
    assert parse
    assert parse.slots == {"origin": "here", "goal": "there"}


def test_a_slot_belongs_to_the_template_that_names_it() -> None:
    commands = commands_of("turn {angle: 5..10 by 5}\nlift {angle: 1..2}")
    assert commands.parse("turn ten")
    assert not commands.parse("lift ten")
    assert commands.parse("lift two")


def test_a_rule_brings_its_slots_with_it() -> None:
    commands = commands_of("<far> = {n: 1..3} metres\ngo: go <far>\nback: go back [<far>]")
    parse = commands.parse("go back two metres")
    assert parse
    assert (parse.command, parse.slots) == ("back", {"n": 2})


def test_a_command_is_named_before_a_colon_or_is_what_was_said_without_options() -> None:
    commands = commands_of(
        "go forward: advance\ngo forward: [please] move on\nstop\n[please] (go|come) back\n"
        "bring the {what}\nwhat = cup\n"
    )
    found = {text: parse.command for text in commands if (parse := commands.parse(text))}
    assert found == {
        "advance": "go forward",
        "please move on": "go forward",
        "move on": "go forward",
        "stop": "stop",
        "please go back": "go back",
        "please come back": "come back",
        "go back": "go back",
        "come back": "come back",
        "bring the cup": "bring the {what}",
    }


def test_numbers_are_said_in_all_usual_ways() -> None:
    commands = commands_of("turn {angle: 90..180 by 90}\ngo {far}\nfar = 0.5 .. 1.5 by 0.5")
    said = {
        "turn ninety": 90,
        "turn a hundred and eighty": 180,
        "turn one hundred eighty": 180,
        "turn one eighty": 180,
        "go a half": 0.5,
        "go half a": 0.5,
        "go one": 1,
        "go one point five": 1.5,
        "go one and a half": 1.5,
    }
    assert {text: next(iter(p.slots.values())) for text in said if (p := commands.parse(text))} == (
        said
    )


CHAIN = "".join(f"<r{n}> = a <r{n + 1}>\n" for n in reversed(range(90)))
LAUGHS = "<l0>\n<l40> = a | b\n" + "".join(f"<l{n}> = <l{n + 1}> <l{n + 1}>\n" for n in range(20))
LAUGHS += "<l20> = ha\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("go (left", 'l.txt:1:4: "(" is not closed; write ")"'),
        ("go left)", 'l.txt:1:8: unmatched ")"'),
        ("go {way", 'l.txt:1:4: "{" is not closed; add "}" after the name'),
        ("go (a|)", 'l.txt:1:7: empty alternative; write "[...]"'),
        ("go []", "l.txt:1:5: empty alternative"),
        ("stop\ngo (back|½)", 'l.txt:2:10: "½" is a digit; write the number as words'),
        ("go (back)*", 'l.txt:1:10: "*" cannot be spoken; remove it'),
        ("go 1234567", "l.txt:1:4: 1234567 is no number that voz can say; write it as words"),
        (" ".join(["(a|b|c)"] * 6), "makes more than 500 commands; give it a name"),
        ("go (a;b|c)", 'l.txt:1:8: ";" and "|" are mixed; use parentheses'),
        ("a; b", 'l.txt:1:2: ";" (in any order) is allowed only in groups'),
        ("go {way}", 'l.txt:1:5: there is no list "way"; add it, as in: way = red | green'),
        ("go <way>", 'l.txt:1:4: there is no rule "way"; add it, as in: <way> ='),
        ("go <way>\nway = left", '"way" is a list; write {way}'),
        ("go <a>\n<a> = x <b>\n<b> = <a>", "l.txt:3:7: <a> in <b> in <a> is recursive"),
        ("go {a: 5..1}", "l.txt:1:7: empty range"),
        ("go {a: 1..5 by 0}", "the step must be above 0"),
        ("go {a: 1..20000}", "20,000 numbers are too many"),
        ("go {a: 1..x}", "expected a name, as in {thing:object}, or numbers"),
        ("go {a b}", "the name of a slot is one word"),
        ("a = b\na = c\n{a}", 'l.txt:2:1: the list "a" is already defined (l.txt:1:1)'),
        ("<a> =\n<a>", "l.txt:1:5: nothing follows"),
        ("go:", "l.txt:1:3: nothing follows"),
        ("go red:*", 'l.txt:1:8: "*" cannot be spoken'),
        ("x: go red:1", 'l.txt:1:10: ":" gives values in lists only'),
        ("{a} and {a}\na = b", 'l.txt:1:10: the slot "a" occurs twice in one sentence'),
        ("[please] [go]", "l.txt:1:1: everything is optional"),
        ("on: go\noff: [please] go", '"go" is a sentence of "on" already (l.txt:1:1)'),
        ("a: " + " ".join(["(a|b)"] * 31), "has up to 31 words; at most 30"),
        ("a: " + " ".join(["(a|b|c|d|e|f|g|h|i|j)"] * 11), "sentences; make lists shorter"),
        ("a = b", "l.txt: contains no command"),
        ("light {a}s\na = b", "l.txt:1:10: only letters may touch a word, as in light[s]"),
        ("go <r0>\n" + CHAIN, "nested names; use fewer"),
        (CHAIN + "go <r0>\n" + "<r90> = x\n", "nested names; use fewer"),
        (LAUGHS, "at most 30 are allowed"),
        ("go (" + "x" * 41 + ")", "has 41 letters, more than 40"),
    ],
)
def test_what_cannot_be_used_is_refused_with_where_and_what_to_do(text: str, message: str) -> None:
    with pytest.raises(CommandsError, match=re.escape(message)) as caught:
        compile_text(text)
    assert "\n" not in str(caught.value)


def test_the_line_is_shown_with_a_caret() -> None:
    with pytest.raises(CommandsError) as caught:
        compile_text("stop\n  go (left|)  # or right\n")
    assert caught.value.excerpt == ("  go (left|)", "           ^")


def test_names_that_nobody_uses_are_named() -> None:
    assert compile_text("stop\ncolor = red\n<polite> = please").warnings == (
        "l.txt:2:1: list {color} is never used; remove it",
        "l.txt:3:1: rule <polite> is never used; remove it",
    )


def test_the_same_sentence_twice_of_one_command_is_kept_once() -> None:
    built = compile_text("on: go\non: [please] go")
    assert built.warnings == ('l.txt:2:1: "go" is there twice (first in l.txt:1:1)',)
    assert list(built.commands) == ["go", "please go"]


def test_many_sentences_that_are_there_twice_give_one_warning() -> None:
    lines = "".join(f"(go|come) {word}\n{word}: go {word}\n" for word in ("a", "b"))
    with pytest.raises(CommandsError, match="is a sentence of"):
        compile_text(lines)
    (line,) = compile_text("[please] go\n" + "go\n" * 20).warnings
    assert line == "l.txt: 20 sentences are there twice, or can be read in two ways"


def test_a_sentence_that_can_be_read_in_two_ways_is_named() -> None:
    (warning,) = compile_text("count {a: 1..30} [{b: 1..9}]").warnings
    assert '"count twenty one" can be read as a=20, b=1 or as a=21' in warning


def test_plain_lists_have_no_templates() -> None:
    assert not has_templates(b"stop\nimport data\ngo back # (or not)\n")
    assert has_templates(b"import other.txt")
    assert has_templates(b"go [back]")


PIECES = st.sampled_from([*"()[]{}<>|;:=# \n", "a", "b", "go", "1..3", "..", "by", "import x.txt"])


@given(st.lists(PIECES, max_size=25).map("".join))
@example("[[[[" * 30)
@example("(a|b)(c|d)e[f]")
def test_any_text_gives_sentences_or_one_line_of_error(text: str) -> None:
    try:
        commands = commands_of(text)
    except CommandsError as error:
        message = str(error)
        commands = None
    if commands is None:
        assert message.isprintable()
        return
    for sentence in commands.sample(5):
        assert re.fullmatch(r"[a-z']+( [a-z']+)*", sentence)
        parse = commands.parse(sentence)
        assert parse
        assert parse.text == sentence


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
