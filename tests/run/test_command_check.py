"""What a new list or table changes, and what can be taken at a start only."""

from __future__ import annotations

import pytest
from msgspec import convert

from voz.config import Config, overridden
from voz.control.steps import Step
from voz.errors import ConfigError
from voz.language.formats.notation import parse_templates
from voz.language.sentences.command_set import plain_commands
from voz.language.template_compiler import compile_templates
from voz.run.command_check import (
    check_renewal,
    describe_renewal,
    forgotten_alternatives,
    matched_settings,
    mismatches,
)

LIST = plain_commands(["start speech", "stop", "go back", "wave"])


def settings(**others: object) -> Config:
    return convert(others, Config)


@pytest.mark.parametrize(
    ("new", "sentences", "told"),
    [
        ({}, ["start speech", "stop", "wave", "dance"], 'new "dance"; gone "go back"'),
        ({"commands": {"wave": {"say": "hi"}}}, list(LIST), 'changed "wave"'),
        ({"commands": {"jump": {"say": "hi"}}}, list(LIST), 'no line of the list is "jump"'),
        ({"states": {"menu": {"wave": "stop"}}}, list(LIST), 'changed "wave"'),
        ({"speech": {"enabled": False}}, list(LIST), "4 sentences; from the next start: speech"),
        ({}, [*LIST, *"abcdefg"], 'new "a", "b", "c", "d" and 3 more'),
    ],
)
def test_it_says_what_has_changed(new: dict[str, object], sentences: list[str], told: str) -> None:
    found = describe_renewal(settings(), settings(**new), LIST, plain_commands(sentences))
    assert found == f"the commands were renewed: {told}"


@pytest.mark.parametrize(
    ("robot", "new", "sentences", "why"),
    [
        ("console", {"halt": "stop"}, list(LIST), '"halt" stops the robot, or did'),
        ("console", {"wake": {"listen": True}}, list(LIST), '"wake" begins the listening, or did'),
        ("ros2", {"wave": {"publish": 1, "topic": "arm"}}, list(LIST), "arm is a new topic"),
        ("console", {}, ["stop", "wave"], 'no command begins the listening; add "start speech"'),
    ],
)
def test_what_only_a_start_can_take_is_refused(
    robot: str, new: dict[str, object], sentences: list[str], why: str
) -> None:
    with pytest.raises(ConfigError, match=why):
        check_renewal(
            settings(robot=[robot]), settings(commands=new), LIST, plain_commands(sentences)
        )


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("más despacio", "mas despacio"),
        ("mas despacio", "Más  despacio"),
        ("open gripper", "Open Gripper"),
        ("SetTimer", "settimer"),
    ],
)
def test_settings_get_the_names_of_the_list(line: str, name: str) -> None:
    own = {name: {"say": "hi"}, "alias": name}
    given = settings(
        commands=own, states={"menu": {name: "alias", "alias": {"play": "bell"}}},
        recognition={"never_missed": [name]},
    )  # fmt: skip
    found = matched_settings(given, plain_commands(["stop", line]))
    assert set(found.commands) == {line, "alias"}
    assert found.table.steps("alias") == found.table.steps(line) == (Step(say="hi"),)
    assert found.table.steps(line, "menu") == (Step(play="bell"),)
    assert found.recognition.never_missed == (line,)


@pytest.mark.parametrize(
    ("lines", "commands", "wake"),
    [
        (["stop", "start speech"], {}, "start speech"),
        (["stop", "oye robot"], {"oye robot": {"listen": True}}, "oye robot"),
        (["stop", "oye", "start speech"], {"Oye": {"listen": True}}, "oye"),
        (["stop"], {}, ""),
    ],
)  # fmt: skip
def test_what_begins_the_listening_is_a_sentence_of_the_list(
    lines: list[str], commands: dict[str, object], wake: str
) -> None:
    found = matched_settings(settings(commands=commands), plain_commands(lines))
    assert found.table.wake == overridden(found, {}).table.wake == wake


def test_words_that_differ_in_their_accents_alone_stay_two_commands() -> None:
    both = plain_commands(["papa", "papá"])
    given = settings(commands={"PAPÁ": {"say": "father"}, "Papa": {"say": "potato"}})
    assert set(matched_settings(given, both).commands) == {"papá", "papa"}
    assert set(matched_settings(settings(commands={"papà": {"say": "?"}}), both).commands) == {
        "papà"
    }


def test_alternatives_of_a_line_that_lack_an_entry_are_told() -> None:
    source = parse_templates(b"(raise|lower|stop) the arm | stop\n", "list.txt")
    commands = compile_templates(source).commands
    assert list(forgotten_alternatives(commands, settings())) == []
    (line,) = forgotten_alternatives(commands, settings(commands={"raise the arm": {"say": "up"}}))
    assert '"raise the arm", and not at "lower the arm" or "stop the arm" of the same line' in line


def test_what_else_does_nothing_is_told_beside_forgotten_alternatives() -> None:
    source = parse_templates(b"(raise|lower) the arm | stop\nwave\n", "list.txt")
    commands = compile_templates(source).commands
    found = settings(commands={"raise the arm": {"say": "up"}})
    forgotten, other = mismatches(commands, found, False)
    assert '"lower the arm"' in forgotten
    assert other == 'no line of [commands] in voz.toml says what to do at "wave"'
