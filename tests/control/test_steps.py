"""What a step may say, and what is refused."""

from __future__ import annotations

import re

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz.control.steps import Step, fill_slots
from voz.errors import ConfigError


@pytest.mark.parametrize(
    ("written", "why"),
    [
        ({}, "does nothing; write one of drive, "),
        ({"drive": 0.1, "rotate": 0.1}, "`drive` and `rotate` are two steps"),
        ({"drive": 0}, "`drive` is 0; to end a motion write stop = true"),
        ({"faster": -0.1}, "`faster` is -0.1"),
        ({"drive": "fast"}, '`drive` is a number or a slot as "{way}", no "fast"'),
        ({"drive": 0.1, "degrees": 90}, "`degrees` is how far to `rotate` or `turn`"),
        ({"rotate": 0.1, "metres": 1}, "`metres` is how far to `drive`"),
        ({"stop": True, "seconds": 1}, "`seconds` is for one of drive, "),
        ({"publish": 1}, "`publish` and `topic` go together"),
        ({"topic": "lamp", "say": "x"}, "`publish` and `topic` go together"),
        ({"publish": 1, "topic": "a b"}, "matching regex"),
        ({"call": ["os.system"]}, '`call` begins with "module:function", not with "os.system"'),
        ({"run": []}, "length >= 1"),
        ({"publish": 2**31, "topic": "lamp"}, "Expected `int` <= 2147483647"),
        ({"drives": 0.1}, "unknown field `drives`"),
    ],
)
def test_what_contradicts_itself_is_refused(written: dict[str, object], why: str) -> None:
    with pytest.raises(msgspec.ValidationError) as caught:
        msgspec.convert(written, Step)
    assert why in str(caught.value)


@pytest.mark.parametrize(
    ("written", "beyond"),
    [
        ({"drive": 1000}, {"drive": 1000.5}),
        ({"drive": -1000}, {"drive": -1000.5}),
        ({"turn": 0.1, "degrees": 1000}, {"turn": 0.1, "degrees": 1000.5}),
        ({"drive": 0.1, "seconds": 0.001}, {"drive": 0.1, "seconds": 0}),
        ({"run": ["true"], "seconds": 3600}, {"run": ["true"], "seconds": 3600.5}),
        ({"call": ["a:b"], "seconds": 3600}, {"call": ["a:b"], "seconds": 3600.5}),
        ({"drive": 0.1, "metres": 0.001}, {"drive": 0.1, "metres": -0.001}),
        ({"say": "x" * 300}, {"say": "x" * 301}),
        ({"play": "bell"}, {"call": []}),
        ({"confirm": True}, {"confirm": False}),
    ],
)
def test_each_bound_is_allowed_and_what_is_beyond_is_refused(
    written: dict[str, object], beyond: dict[str, object]
) -> None:
    step = Step(**written)  # type: ignore[arg-type]
    assert msgspec.convert(written, Step) == step
    with pytest.raises(ConfigError):
        Step(**beyond)  # type: ignore[arg-type]
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert(beyond, Step)


@given(st.floats() | st.integers() | st.text(max_size=4) | st.sampled_from(["nan", 10**400]))
def test_no_slot_moves_faster_or_farther_than_a_table_may_say(said: str | float) -> None:
    try:
        step = fill_slots(Step(drive="{x}", metres="{x}"), {"x": said})
    except ConfigError:
        return
    assert isinstance(step.drive, float)
    assert 0 < step.drive == step.metres <= 1000


def test_false_is_something_to_do_but_for_stop_and_again() -> None:
    assert Step(listen=False).actions == ("listen",)
    assert Step(answer=False).actions == ("answer",)
    assert Step(publish=False, topic="lamp").actions == ("publish",)
    assert Step(stop=False, again=False, say="well").actions == ()


def test_slots_are_filled_as_numbers_and_in_texts() -> None:
    step = Step(drive="{speed}", metres="{way}", say="{way} metres, {who}", confirm="{who}?")
    assert step.slots == {"speed", "way", "who"}
    found = fill_slots(step, {"speed": 0.2, "way": 1.0, "who": "ana"})
    assert found == Step(drive=0.2, metres=1.0, say="1 metres, ana", confirm="ana?")
    program = fill_slots(Step(run=("echo", "{who}; rm", "{way}")), {"way": 1.5, "who": "ana"})
    assert program.run == ("echo", "ana; rm", "1.5")
    call = fill_slots(Step(call=("arm:bring", "{who}", "{way}")), {"way": 1.5, "who": "ana"})
    assert call.call == ("arm:bring", "ana", 1.5)
    lamp = fill_slots(Step(say="lamp {on}, door {open}"), {"on": True, "open": False})
    assert lamp == Step(say="lamp true, door false")


@pytest.mark.parametrize(
    ("slots", "why"),
    [
        ({}, "nothing was said for {pace}"),
        ({"pace": 0.1}, "nothing was said for {way}"),
        ({"pace": 0.1, "way": "far"}, '{way} is "far", not a number'),
        ({"pace": 0.1, "way": True}, '{way} is "True", not a number'),
        ({"pace": 0.1, "way": 0}, "`metres` is 0"),
        ({"pace": 0.1, "way": 5000}, "Expected `float` <= 1000.0 - at `Step.metres`"),
        ({"pace": 0.1, "way": "nan"}, "Expected `float` >= -1000.0 - at `Step.metres`"),
    ],
)
def test_a_slot_that_does_not_fit_is_refused(slots: dict[str, str | float], why: str) -> None:
    with pytest.raises(ValueError, match=re.escape(why)):
        fill_slots(Step(drive="{pace}", metres="{way}"), slots)


def test_what_is_no_text_stays_as_it_is_among_the_arguments_of_a_call() -> None:
    step = fill_slots(Step(call=("arm:turn", 3, "{angle}", "by {angle}")), {"angle": 90.0})
    assert step.call == ("arm:turn", 3, 90.0, "by 90")
