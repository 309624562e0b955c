"""What a new list or table changes, and what can be taken at a start only."""

from __future__ import annotations

import pytest
from controlled import Controlled
from msgspec import convert

from voz.config import Config
from voz.control.messages import Renewal
from voz.control.steps import Step
from voz.errors import ConfigError
from voz.events import Event, Notice, Twist, Utterance
from voz.language.sentences.command_set import plain_commands
from voz.run.command_check import check_renewal, describe_renewal, matched_settings

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


def test_words_that_differ_in_their_accents_alone_stay_two_commands() -> None:
    both = plain_commands(["papa", "papá"])
    given = settings(commands={"PAPÁ": {"say": "father"}, "Papa": {"say": "potato"}})
    assert set(matched_settings(given, both).commands) == {"papá", "papa"}
    assert set(matched_settings(settings(commands={"papà": {"say": "?"}}), both).commands) == {
        "papà"
    }


def said(text: str, now: float) -> Utterance:
    return Utterance(now, text, 0.9, True, now, now, "microphone")


@pytest.fixture
def driven() -> tuple[Controlled, list[Event]]:
    controller = Controlled()
    controller.hear(said("go forward", 1.0))
    return controller, controller.events


def test_nothing_moves_while_the_commands_are_renewed(
    driven: tuple[Controlled, list[Event]],
) -> None:
    controller, events = driven
    controller.take(Renewal("list.txt was saved", 2.0, under_way=True), 2.0)
    assert events[-1] == Notice(2.0, "list.txt was saved: the robot stops", True, stops=True)
    controller.hear(said("go back", 2.1))
    assert isinstance(events[-1], Utterance)
    assert (events[-1].obeyed, events[-1].ignored) == (False, "too_late")
    controller.hear(said("stop", 2.2))
    assert events[-1].obeyed  # type: ignore[union-attr]
    table = settings(commands={"go back": {"drive": -0.3}}).table
    controller.take(Renewal("renewed", 2.5, under_way=False, table=table), 2.5)
    controller.hear(said("go back", 2.4))  # begun before
    controller.send(2.6)
    assert events[-1] == Twist(2.6, 0, 0)
    controller.hear(said("go back", 2.7))
    assert controller.velocities == (-0.3, 0)


def test_a_renewal_that_failed_leaves_the_robot_at_rest_and_the_commands_as_they_were(
    driven: tuple[Controlled, list[Event]],
) -> None:
    controller, events = driven
    table = controller.state.rules.table
    controller.take(Renewal("list.txt was saved", 2.0, under_way=True), 2.0)
    controller.take(Renewal("the disk is full", 2.5, under_way=False), 2.5)
    assert events[-1] == Notice(2.5, "the disk is full")
    assert controller.state.rules.table is table
    controller.hear(said("go back", 2.6))
    assert controller.velocities == (-0.1, 0)
