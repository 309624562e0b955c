"""The table of `voz.control.attention`, by itself and as a controller applies it."""

from __future__ import annotations

from typing import Any

import pytest
from controlled import Controlled
from hypothesis import example, given
from hypothesis import strategies as st
from msgspec.structs import replace

from voz.config import default_commands
from voz.control.attention import (
    ANSWER_SECONDS,
    AWAKE_SECONDS,
    NOTHING,
    AttentionState,
    Question,
    answer,
    differing_words,
    forget_old_question,
    is_asleep,
    put_question,
    question_about,
    shared_ends,
    wake,
)
from voz.control.messages import Renewal
from voz.events import Attention, Event, PossibleCommand, Reply, Twist, Utterance
from voz.settings import Ask

NAME = "hey robot"
TABLE = default_commands()


def a_controller(name: str = NAME, ask: Ask = "never") -> tuple[Controlled, list[Event]]:
    controller = Controlled(name=name, ask=ask)
    return controller, controller.events


def spoken(text: str, t: float, **more: Any) -> Utterance:
    fields = {"confidence": 0.9, "accepted": True, "source": "microphone", "latency": 0.2}
    return Utterance(t=t, text=text, start=t - 0.5, end=t - 0.1, **{**fields, **more})


def unsure(t: float, *texts: str) -> Utterance:
    perhaps = tuple(PossibleCommand(text, text) for text in texts)
    return spoken(texts[0], t, accepted=False, confidence=0.3, perhaps=perhaps)


def obeyed(events: list[Event]) -> list[str]:
    return [e.text for e in events if isinstance(e, Utterance) and e.obeyed]


def test_only_what_follows_the_name_counts() -> None:
    controller, events = a_controller()
    controller.hear(spoken("go forward", 1.0))
    assert not controller.moving
    assert obeyed(events) == []
    assert [e.ignored for e in events if isinstance(e, Utterance)] == ["asleep"]
    controller.hear(spoken(NAME, 3.0, named=True))
    assert controller.awake
    controller.hear(spoken("go forward", 5.0))
    assert controller.velocities == (0.1, 0.0)
    controller.send(3.0 + AWAKE_SECONDS)
    assert not controller.awake
    controller.hear(spoken("speed up", 4.0 + AWAKE_SECONDS))
    assert controller.velocities == (0.1, 0.0)
    assert [e.awake for e in events if isinstance(e, Attention)] == [False, True, False]


def test_a_command_in_one_breath_with_the_name_counts() -> None:
    controller, _events = a_controller()
    controller.hear(spoken("go forward", 1.0, named=True))
    assert controller.velocities == (0.1, 0.0)
    assert controller.awake


def test_the_name_counts_though_the_command_after_it_is_not_sure() -> None:
    controller, _ = a_controller()
    controller.hear(spoken("go forward", 1.0, named=True, accepted=False))
    assert controller.awake
    assert not controller.moving


def test_what_stops_counts_always() -> None:
    controller, events = a_controller()
    controller.hear(spoken("go forward", 1.0, named=True))
    controller.send(20.0)
    assert not controller.awake
    assert controller.moving
    controller.hear(spoken("stop", 21.0))
    assert not controller.moving
    assert obeyed(events)[-1] == "stop"


def test_asleep_stop_speech_stops_the_robot_and_it_listens_on() -> None:
    controller, events = a_controller()
    controller.hear(spoken("go forward", 1.0, named=True))
    controller.send(20.0)
    controller.hear(spoken("stop speech", 21.0))
    assert not controller.moving
    assert controller.listening
    assert not [e for e in events if isinstance(e, Reply)]


def test_what_is_typed_or_tapped_needs_no_name() -> None:
    controller, _ = a_controller()
    controller.hear(Utterance(1.0, "go forward", 1.0, True, 1.0, 1.0, "text"))
    assert controller.velocities == (0.1, 0.0)


@pytest.mark.parametrize("ignored", ["robot_speaking", "too_late"])
def test_a_name_that_does_not_count_does_not_wake(ignored: Any) -> None:
    controller, _ = a_controller()
    controller.hear(spoken(NAME, 1.0, named=True, ignored=ignored))
    assert not controller.awake


def test_after_a_loss_what_follows_the_name_in_time_still_counts() -> None:
    controller, _ = a_controller()
    controller.hear(spoken(NAME, 1.0, named=True))
    controller.stop(2.0, "the control loop stalled for 0.5 s")
    controller.hear(spoken("go forward", 2.05))  # it ended before the loss
    assert not controller.moving
    controller.hear(spoken("go forward", 3.0))
    assert controller.moving


def test_yes_does_what_was_asked_and_no_forgets_it() -> None:
    for said, moves in ((["yes"], True), (["no"], False), (["no", "yes"], False)):
        controller, events = a_controller(name="", ask="always")
        controller.hear(unsure(1.0, "go back"))
        assert [e.text for e in events if isinstance(e, Reply)] == ["did you say go back?"]
        assert [e.answers for e in events if isinstance(e, Attention)] == [("yes", "no")]
        assert not controller.moving
        for number, text in enumerate(said):
            controller.hear(spoken(text, 3.0 + number))
        assert controller.moving == moves
        assert [e.answers for e in events if isinstance(e, Attention)][-1] == ()


@pytest.mark.parametrize(("word", "velocity"), [("forward", 0.1), ("back", -0.1), ("no", 0.0)])
def test_one_word_decides_between_two(word: str, velocity: float) -> None:
    controller, events = a_controller(name="", ask="always")
    controller.hear(unsure(1.0, "go forward", "go back"))
    assert [e.text for e in events if isinstance(e, Reply)] == ["forward or back?"]
    controller.hear(spoken(word, 3.0))
    assert controller.velocities == (velocity, 0.0)
    assert obeyed(events) == [f"go {word}" if velocity else "no"]


def test_it_is_awake_for_eight_seconds_to_the_last_moment() -> None:
    awake = wake(AttentionState(), spoken(NAME, 1.1))  # which ended a tenth before
    assert awake.awake_until == 9.0
    assert not is_asleep(awake, 9.0)
    assert is_asleep(awake, 9.01)


def test_a_question_can_be_answered_for_four_seconds_after_it_was_said() -> None:
    question = question_about(unsure(1.0, "go back"), "always", TABLE)
    assert question
    assert question.until == pytest.approx(1.0 + len("did you say go back?") * 0.07 + 4.0)
    asked = put_question(AttentionState(), question)
    assert asked.awake_until == question.until
    in_time = replace(spoken("no", 3.0), start=question.until)
    assert answer(asked, in_time) is NOTHING
    assert answer(asked, replace(in_time, start=question.until + 0.01)) is None
    assert forget_old_question(asked, question.until) == asked
    assert forget_old_question(asked, question.until + 0.01).question is None


@pytest.mark.parametrize(
    ("language", "perhaps", "asks", "answers"),
    [
        ("es", ["avanza"], "¿has dicho avanza?", ("sí", "no")),
        ("es", ["gira aquí", "gira allí"], "¿aquí o allí?", ("aquí", "allí", "no")),
        ("fr", ["avance"], "tu as dit avance ?", ("oui", "non")),
        ("fr", ["va ici", "va là"], "ici ou là ?", ("ici", "là", "non")),
    ],
)
def test_it_asks_in_the_language_of_the_robot_and_takes_its_answers(
    language: str, perhaps: list[str], asks: str, answers: tuple[str, ...]
) -> None:
    controller = Controlled(ask="always", language=language)
    controller.hear(unsure(1.0, *perhaps))
    asked, attention = (e for e in controller.events if isinstance(e, Reply | Attention))
    assert (asked, attention) == (Reply(1.0, asks), Attention(1.0, True, answers))
    controller.hear(spoken(answers[0], 2.0))
    assert obeyed(controller.events) == [perhaps[0]]


def test_a_question_lets_nobody_fall_asleep_earlier() -> None:
    asked = put_question(AttentionState(awake_until=20.0), Question("so?", {}, until=5.0))
    assert asked.awake_until == 20.0


def test_it_asks_once_and_waits_for_four_seconds() -> None:
    controller, events = a_controller(name="", ask="always")
    controller.hear(unsure(1.0, "go back"))
    controller.hear(unsure(2.0, "go back"))
    assert len([e for e in events if isinstance(e, Reply)]) == 1
    controller.send(3.0 + ANSWER_SECONDS + 1.0)
    assert [e.answers for e in events if isinstance(e, Attention)] == [("yes", "no"), ()]
    controller.hear(spoken("yes", 3.0 + ANSWER_SECONDS + 1.5))
    assert not controller.moving


@pytest.mark.parametrize(
    ("ask", "texts", "asks"),
    [
        ("never", ["fold arm"], False),
        ("standing", ["fold arm"], True),
        ("standing", ["go back"], False),
        ("standing", ["fold arm", "go back"], False),
        ("always", ["go back"], True),
        ("always", ["stop"], False),
        ("always", ["slow down", "stop"], False),
        ("always", ["stop speech"], False),
    ],
)
def test_what_stops_is_never_asked_and_what_moves_only_if_wanted(
    ask: Ask, texts: list[str], asks: bool
) -> None:
    assert (question_about(unsure(1.0, *texts), ask, TABLE) is not None) == asks


@pytest.mark.parametrize(
    "prevent",
    [
        lambda c: c.rehearse(),
        lambda c: c.take(Renewal("a list was saved", 0.0, under_way=True), 0.0),
        lambda c: c.hear(spoken("stop speech", 0.5)),
    ],
)
def test_what_would_not_be_obeyed_is_not_asked(prevent: Any) -> None:
    controller, events = a_controller(name="", ask="always")
    prevent(controller)
    controller.hear(unsure(1.0, "go back"))
    assert not any(isinstance(e, Reply) and e.text.startswith("did you") for e in events)


def test_a_command_a_key_and_a_loss_take_a_question_back() -> None:
    for act in (
        lambda c: c.hear(spoken("fold arm", 2.0)),
        lambda c: c.press(2.0),
        lambda c: c.stop(2.0, "the microphone is lost"),
        lambda c: c.take(Renewal("a list was saved", 2.0, under_way=False), 2.0),
    ):
        controller, _ = a_controller(name="", ask="always")
        controller.hear(unsure(1.0, "go back"))
        act(controller)
        controller.hear(spoken("yes", 3.0))
        assert not controller.moving


@given(
    one=st.lists(st.sampled_from("abc"), min_size=1, max_size=5),
    other=st.lists(st.sampled_from("abc"), min_size=1, max_size=5),
)
@example(["a"], ["a", "b"])
def test_the_words_that_differ_tell_two_sentences_apart(one: list[str], other: list[str]) -> None:
    if one != other:
        first, second = differing_words(" ".join(one), " ".join(other))
        assert first
        assert second
        assert first != second
        assert first in " ".join(one)
        assert second in " ".join(other)


@pytest.mark.parametrize(
    ("one", "other", "differing"),
    [
        ("turn left now", "turn right now", ("left", "right")),
        ("go", "go on", ("go", "go on")),
        ("please go on", "go on", ("please go", "go")),
    ],
)
def test_two_sentences_are_told_apart_by_as_few_words_as_do(
    one: str, other: str, differing: tuple[str, str]
) -> None:
    assert differing_words(one, other) == differing


MOMENTS = st.lists(
    st.tuples(
        st.floats(0.0, 12.0),
        st.sampled_from(["name", "named", "command", "unsure", "between", "yes", "no", "back"])
        | st.sampled_from(["stop", "stop speech", "lost", "key", "renewed", "rehearsal", "typed"]),
    ),
    max_size=20,
)


@given(moments=MOMENTS, ask=st.sampled_from(["never", "standing", "always"]))
def test_asleep_nothing_but_stop_has_an_effect_and_it_falls_asleep_whatever_happens(
    moments: list[tuple[float, str]], ask: Ask
) -> None:
    controller, events = a_controller(ask=ask)
    t = 0.0
    for pause, what in moments:
        t += pause
        controller.send(t)
        slept, moved = not controller.awake, controller.velocities
        listened = controller.listening
        _let_happen(controller, what, t)
        if slept and what not in ("name", "named", "typed"):
            assert controller.velocities in (moved, (0.0, 0.0))
            assert controller.listening == listened
            assert what in ("name", "stop") or not controller.awake
    controller.send(t + AWAKE_SECONDS + ANSWER_SECONDS + 5.0)
    assert not controller.awake
    assert [e for e in events if isinstance(e, Attention)][-1:] in (
        [],
        [a for a in events if isinstance(a, Attention) and not a.awake and not a.answers][-1:],
    )


def _let_happen(controller: Controlled, what: str, t: float) -> None:
    heard = {
        "name": spoken(NAME, t, named=True),
        "named": spoken("go forward", t, named=True),
        "command": spoken("speed up", t),
        "unsure": unsure(t, "go back"),
        "between": unsure(t, "go back", "go forward"),
        "typed": Utterance(t, "go back", 1.0, True, t, t, "text"),
    }
    said = replace(heard.get(what) or spoken(what, t), start=t, end=t)
    if what == "lost":
        controller.stop(t, "the microphone is lost")
    elif what == "key":
        controller.press(t, pressed=t)
    elif what == "renewed":
        controller.take(Renewal("a list was saved", t, under_way=False), t)
    elif what == "rehearsal":
        controller.rehearse(not controller.state.rehearsing)
    else:
        controller.hear(said)


def test_twists_go_on_while_it_sleeps() -> None:
    controller, events = a_controller()
    controller.send(0.0)
    assert [type(event) for event in events] == [Attention, Twist]


LETTERS = st.lists(st.sampled_from("ab"), max_size=6)


@given(LETTERS, LETTERS)
def test_what_is_shared_is_the_same_and_what_is_next_to_it_is_not(
    one: list[str], other: list[str]
) -> None:
    begin, end = shared_ends(one, other)
    assert one[:begin] == other[:begin]
    assert one[len(one) - end :] == other[len(other) - end :]
    first, second = one[begin : len(one) - end], other[begin : len(other) - end]
    if first and second:
        assert first[0] != second[0]
        assert first[-1] != second[-1]
