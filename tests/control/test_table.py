"""Which tables there may be: with none of them can the robot not be stopped."""

from __future__ import annotations

import pytest

from voz.config import Config, default_commands
from voz.control.steps import CommandDefinition, Step
from voz.control.table import check_commands
from voz.errors import ConfigError

YES, NO = Step(answer=True), Step(answer=False)


def table(commands: dict[str, CommandDefinition], **states: dict[str, CommandDefinition]):  # type: ignore[no-untyped-def]
    return Config(commands=commands, states=states).table


def test_what_voz_brings_has_its_fourteen_commands() -> None:
    usual = default_commands()
    assert len(usual.sets[""]) == 14
    assert usual.stops == {"stop"}
    assert usual.halts == {"stop", "stop speech"}
    assert usual.starts == {"start speech"}
    assert usual.topics == {}


def test_another_word_does_the_same() -> None:
    found = table({"advance": "go forward", "halt": "whoa", "whoa": "stop"})
    assert found.steps("advance") == found.steps("go forward") == (Step(drive=0.1),)
    assert found.stops == {"stop", "halt", "whoa"}


@pytest.mark.parametrize(
    ("commands", "why"),
    [
        ({"stop": Step(drive=0.1)}, '"stop" is redefined'),
        ({"stop": "go back"}, '"stop" is redefined'),
        ({"stop": (Step(say="now"), Step(stop=True))}, '"stop" is redefined'),
        ({"stop": Step(stop=True, confirm=True)}, '"stop" is redefined'),
        (
            {"stop": (Step(stop=True, confirm=True), Step(say="now")), "yes": YES, "no": NO},
            '"stop" is redefined',
        ),
        ({"stop": (Step(stop=True), Step(drive=0.1))}, '"stop" is redefined'),
        ({"stop": (Step(stop=True), Step(run=("sleep", "1")))}, '"stop" is redefined'),
        (
            {"halt": Step(stop=True, say="{why} {how}")},
            '"halt" stops, and must not depend on the slot how',
        ),
        (
            {"off": Step(listen=False, say="{why}")},
            '"off" stops, and must not depend on the slot why',
        ),
        ({"a": "b"}, '"a" is an alias of "b", which is not a command here'),
        ({"a": "stopp"}, 'which is not a command here; did you mean "stop"?'),
        ({"a": "b", "b": "a"}, '"a" is an alias of "a", which is an alias of it'),
        ({"off": (Step(listen=False), Step(drive=0.1))}, '"off" begins or ends the listening'),
        ({"menu": Step(state="arm")}, '"menu" switches to "arm"; there is no [states.arm]'),
        ({"a": Step(drive=0.1, confirm=True)}, '"a" asks first, and no command answers'),
        ({"a": (Step(drive=0.1, confirm=True), Step(say="on"))}, '"a" asks first, and no command'),
        ({"a": Step(drive=0.1, confirm=True), "yes": YES}, '"a" asks first, and no command'),
        ({"a": Step(drive=0.1, confirm=True), "no": NO}, '"a" asks first, and no command'),
        (
            {"a": (Step(stop=True), Step(drive=0.1, confirm=True)), "yes": YES, "no": NO},
            '"a" has `confirm` or `again` after the first step',
        ),
        (
            {"a": (Step(stop=True), Step(again=True))},
            '"a" has `confirm` or `again` after the first step',
        ),
        ({"yes": (YES, Step(drive=0.1))}, '"yes" answers, and can do nothing else'),
        ({"on": (Step(listen=True), Step(drive=0.1))}, '"on" begins or ends the listening'),
        ({"a": (Step(drive=0.1), Step(rotate=0.1, degrees=90))}, "goes on after a motion"),
        (
            {"a": Step(publish=32_768, topic="selected_object")},
            '"a" selects an object; the largest number is 32767',
        ),
        ({"a": Step(publish=-32_769, topic="selected_object")}, '"a" selects an object'),
        (
            {"a": Step(publish=1, topic="lamp"), "b": Step(publish="on", topic="lamp")},
            '"b" publishes values of two types on lamp',
        ),
    ],
)
def test_what_cannot_be_is_refused_by_name(
    commands: dict[str, CommandDefinition], why: str
) -> None:
    with pytest.raises(ConfigError) as caught:
        table(commands)
    assert str(caught.value).startswith("[commands] ")
    assert why in str(caught.value)


@pytest.mark.parametrize("number", [-32_768, 32_767])
def test_an_object_has_any_number_of_sixteen_bits(number: int) -> None:
    assert table({"a": Step(publish=number, topic="selected_object")}).topics == {}


@pytest.mark.parametrize("name", ["stop", "stop speech", "start speech"])
def test_no_state_changes_what_stops_or_listens(name: str) -> None:
    with pytest.raises(ConfigError, match=rf'\[states.menu\] "{name}" stops or listens'):
        table({}, menu={name: Step(drive=0.1)})


def test_a_list_that_drives_has_a_command_that_stops() -> None:
    usual = default_commands()
    check_commands(usual, ["open gripper"], [], "list")
    check_commands(usual, ["go forward", "stop"], [], "list")
    with pytest.raises(ConfigError, match='list: has "go back", which moves the robot, and no'):
        check_commands(usual, ["open gripper", "go back"], [], "list")
    own = table({"para": "stop", "adelante": "go forward"})
    check_commands(own, ["adelante", "para"], [], "list")


def test_no_command_that_drives_begins_with_the_one_that_stops() -> None:
    found = table({"stop and turn": Step(turn=0.1), "stop the music": Step(say="well")})
    check_commands(found, ["stop", "stop the music"], ["stop the music"], "list")
    with pytest.raises(ConfigError, match='"stop and turn" moves the robot and begins with what'):
        check_commands(found, ["stop", "stop and turn"], ["stop and turn"], "list")


def test_the_answers_to_a_question_are_those_of_the_state_and_a_yes_comes_first() -> None:
    answers = {"no": Step(answer=False), "yes": Step(answer=True), "wave": Step(say="hello")}
    table = Config(commands=answers, states={"menu": {"fine": Step(answer=True)}}).table
    assert table.answers() == ("yes", "no")
    assert table.answers("menu") == ("fine",)
