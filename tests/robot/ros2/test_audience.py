from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from voz.robot.ros2.audience import PATIENCE, Audience

Cycle = tuple[frozenset[int], bool]
cycles = st.lists(st.tuples(st.frozensets(st.integers(1, 4)), st.booleans()), max_size=40)


def after(*heard: Cycle) -> Audience:
    audience = Audience()
    for listeners, answered in heard:
        audience.note(listeners, answered)
    return audience


def silence(*listeners: int, cycles: int = PATIENCE) -> list[Cycle]:
    return [(frozenset(listeners), False)] * cycles


def test_who_does_not_answer_for_half_a_second_is_not_there() -> None:
    assert after(*silence(1, cycles=PATIENCE - 1)).present({1}) == {1}
    assert after(*silence(1)).present({1}) == set()


def test_who_comes_after_the_silence_is_there() -> None:
    assert after(*silence(1), *silence(1, 2, cycles=3)).present({1, 2}) == {2}


@given(cycles, st.frozensets(st.integers(1, 4)))
def test_an_answer_makes_everybody_present(before: list[Cycle], now: frozenset[int]) -> None:
    assert after(*before, (now, True)).present(now) == now


@given(cycles, st.frozensets(st.integers(1, 4)))
def test_nobody_is_present_who_is_not_connected(before: list[Cycle], now: frozenset[int]) -> None:
    assert after(*before).present(now) <= now


@given(cycles)
def test_without_a_long_silence_all_are_present(before: list[Cycle]) -> None:
    answers = [answered for _, answered in before]
    runs = "".join("a" if answered else "-" for answered in answers).split("a")
    if max(map(len, runs)) < PATIENCE:
        assert after(*before).present({1, 2, 3, 4}) == {1, 2, 3, 4}
