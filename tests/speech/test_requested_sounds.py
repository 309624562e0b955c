"""What is asked for, begun, stopped and given up in any order."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, invariant, rule

from voz.audio.playback.mixer import Mixer
from voz.errors import SpeechError
from voz.speech.requested_sounds import RequestedSound, RequestedSounds, SoundKey

WAVE = np.full(48_000, 0.1, np.float32)
kinds = st.sampled_from(["builtin", "wave", "voice"])
names = st.sampled_from(["a", "b"])
voices = st.sampled_from(["kal", "ked"])
keys = st.tuples(kinds, names) | st.tuples(st.just("voice"), names, voices)


class OrdersInAnyOrder(RuleBasedStateMachine):
    """Against a model: for each key the order that was placed last, and what became of it."""

    orders_placed = Bundle("orders_placed")

    def __init__(self) -> None:
        super().__init__()
        self.mixer = Mixer(lambda _: None)
        self.mixer._loudspeaker.wake = lambda: None  # there is none
        self.orders = RequestedSounds(self.mixer)
        self.state: dict[RequestedSound, str] = {}
        self.current: dict[SoundKey, RequestedSound] = {}

    @rule(target=orders_placed, key=keys, repeats=st.booleans())
    def place(self, key: SoundKey, repeats: bool) -> RequestedSound:
        self.model_stop(key)
        order = self.orders.place(key, 1.0, repeats)
        self.current[key] = order
        self.state[order] = "waiting"
        return order

    @rule(order=orders_placed)
    def begin(self, order: RequestedSound) -> None:
        self.orders.begin(order, WAVE)
        if self.state[order] == "waiting":
            self.state[order] = "heard"

    @rule(order=orders_placed)
    def fail(self, order: RequestedSound) -> None:
        error = SpeechError("no")
        assert self.orders.fail(order, error) is (self.state[order] == "waiting")
        if self.state[order] == "waiting":
            self.state[order] = "over"
            assert order.error is error

    @rule(beginning=keys | st.tuples(kinds) | st.just(()))
    def stop(self, beginning: SoundKey) -> None:
        self.orders.stop(beginning)
        self.model_stop(beginning)

    def model_stop(self, beginning: SoundKey) -> None:
        for key, order in self.current.items():
            if key[: len(beginning)] == beginning:
                self.state[order] = "over"

    @invariant()
    def what_is_over_is_known(self) -> None:
        for order, state in self.state.items():
            assert order.over is (state == "over")
            assert (order.source is not None and not order.source.over) is (state == "heard")

    @invariant()
    def who_waits_for_all_waits_for_what_ends(self) -> None:
        waited = self.orders.heard_once()
        for order, state in self.state.items():
            if state != "over":
                assert (order in waited) is (not order.repeats)

    def teardown(self) -> None:
        self.orders.close()
        assert all(order.over for order in self.state)
        late = self.orders.place(("wave", "a"), 1.0, True)
        self.orders.begin(late, WAVE)
        assert late.over


TestOrdersInAnyOrder = OrdersInAnyOrder.TestCase


@given(st.floats() | st.integers() | st.none() | st.text(max_size=3))
def test_a_volume_is_from_0_to_1_whatever_is_asked_for(volume: Any) -> None:
    try:
        assert 0 <= RequestedSound(volume, False).volume <= 1
    except SpeechError:
        assert not isinstance(volume, int | float)
