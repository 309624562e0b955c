"""What is asked for, begun, stopped and given up in any order."""

from __future__ import annotations

from typing import Any
from unittest.mock import patch

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, invariant, rule

from voz.audio.loudspeaker import Loudspeaker
from voz.audio.mixer import Mixer
from voz.errors import SpeechError
from voz.speech.sound_client import RequestedSound, RequestedSounds, SoundKey

WAVE = np.full(48_000, 0.1, np.float32)
kinds = st.sampled_from(["builtin", "wave", "voice"])
names = st.sampled_from(["a", "b"])
voices = st.sampled_from(["kal", "ked"])
keys = st.tuples(kinds, names) | st.tuples(st.just("voice"), names, voices)


class OrdersInAnyOrder(RuleBasedStateMachine):
    """Against a model: for each key the sound that was requested last, and what became of it."""

    requested_sounds = Bundle("requested_sounds")

    def __init__(self) -> None:
        super().__init__()
        self.silent = patch.object(Loudspeaker, "wake")  # there is none
        self.silent.start()
        self.mixer = Mixer(lambda _: None)
        self.sounds = RequestedSounds(self.mixer)
        self.state: dict[RequestedSound, str] = {}
        self.current: dict[SoundKey, RequestedSound] = {}

    @rule(target=requested_sounds, key=keys, repeats=st.booleans())
    def place(self, key: SoundKey, repeats: bool) -> RequestedSound:
        self.model_stop(key)
        sound = self.sounds.add(key, 1.0, repeats)
        self.current[key] = sound
        self.state[sound] = "waiting"
        return sound

    @rule(sound=requested_sounds)
    def begin(self, sound: RequestedSound) -> None:
        self.sounds.begin(sound, WAVE)
        if self.state[sound] == "waiting":
            self.state[sound] = "heard"

    @rule(sound=requested_sounds)
    def fail(self, sound: RequestedSound) -> None:
        error = SpeechError("no")
        assert self.sounds.fail(sound, error) is (self.state[sound] == "waiting")
        if self.state[sound] == "waiting":
            self.state[sound] = "over"
            assert sound.error is error

    @rule(beginning=keys | st.tuples(kinds) | st.just(()))
    def stop(self, beginning: SoundKey) -> None:
        self.sounds.stop(beginning)
        self.model_stop(beginning)

    def model_stop(self, beginning: SoundKey) -> None:
        for key, sound in self.current.items():
            if key[: len(beginning)] == beginning:
                self.state[sound] = "over"

    @invariant()
    def what_is_over_is_known(self) -> None:
        for sound, state in self.state.items():
            assert sound.over is (state == "over")
            assert (sound.source is not None and not sound.source.over) is (state == "heard")

    @invariant()
    def who_waits_for_all_waits_for_what_ends(self) -> None:
        waited = self.sounds.without_repeating()
        for sound, state in self.state.items():
            if state != "over":
                assert (sound in waited) is (not sound.repeats)

    def teardown(self) -> None:
        self.sounds.close()
        assert all(sound.over for sound in self.state)
        late = self.sounds.add(("wave", "a"), 1.0, True)
        self.sounds.begin(late, WAVE)
        assert late.over
        self.silent.stop()


TestOrdersInAnyOrder = OrdersInAnyOrder.TestCase


@given(st.floats() | st.integers() | st.none() | st.text(max_size=3))
def test_a_volume_is_from_0_to_1_whatever_is_asked_for(volume: Any) -> None:
    try:
        assert 0 <= RequestedSound(volume, False).volume <= 1
    except SpeechError:
        assert not isinstance(volume, int | float)
