"""The robot's sounds without words: told apart, never a click, and the bad ones more urgent."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, invariant, rule

from voz.audio.mixer import Mixer
from voz.audio.playback import AUDIBLE_AMPLITUDE, PLAYBACK_RATE, Wave
from voz.errors import SpeechError
from voz.speech.sounds import (
    BuiltinSound,
    RequestedSound,
    RequestedSounds,
    SoundKey,
    synthesize_sound,
)

URGENT = {
    BuiltinSound.NEEDS_UNPLUGGING: BuiltinSound.NEEDS_UNPLUGGING_BADLY,
    BuiltinSound.NEEDS_PLUGGING: BuiltinSound.NEEDS_PLUGGING_BADLY,
}


def notes_per_second(wave: Wave) -> float:
    """How often it goes from silence to a tone."""
    level = np.abs(wave[: len(wave) // 120 * 120].reshape(-1, 120)).max(axis=1)
    quiet = level < 0.35 * level.max()
    return float(np.count_nonzero(quiet[:-1] & ~quiet[1:]) + (not quiet[0])) / (
        len(wave) / PLAYBACK_RATE
    )


def brightness(wave: Wave) -> float:
    """The middle of its spectrum, Hz."""
    power = np.abs(np.fft.rfft(wave)) ** 2
    return float((power * np.fft.rfftfreq(len(wave), 1 / PLAYBACK_RATE)).sum() / power.sum())


def test_the_numbers_are_those_of_sound_play() -> None:
    assert [(sound.name, int(sound)) for sound in BuiltinSound] == [
        ("BACKINGUP", 1),
        ("NEEDS_UNPLUGGING", 2),
        ("NEEDS_PLUGGING", 3),
        ("NEEDS_UNPLUGGING_BADLY", 4),
        ("NEEDS_PLUGGING_BADLY", 5),
    ]
    assert BuiltinSound(3) is BuiltinSound.NEEDS_PLUGGING


@pytest.mark.parametrize("number", [0, 6, -3])
def test_another_number_is_no_sound(number: int) -> None:
    with pytest.raises(SpeechError, match=rf"^there is no built-in sound {number}; give 1 to 5$"):
        BuiltinSound(number)


def test_each_has_a_name_for_the_command_line() -> None:
    titles = [sound.title for sound in BuiltinSound]
    assert titles[:2] == ["backing-up", "needs-unplugging"]
    assert len(set(titles)) == len(titles)


@pytest.mark.parametrize("sound", BuiltinSound)
def test_a_sound_can_follow_itself_without_a_click(sound: BuiltinSound) -> None:
    wave = synthesize_sound(sound)
    assert 0.5 < len(wave) / PLAYBACK_RATE < 2
    assert 0.2 < np.abs(wave).max() <= 0.5
    # Its own steepest slope is less than that of a full wave at its highest frequency.
    steps = np.abs(np.diff(np.concatenate([[0], wave, wave])))
    assert steps.max() < 0.5 * 2 * np.pi * 4 * 1046.5 / PLAYBACK_RATE
    assert abs(wave[0]) < AUDIBLE_AMPLITUDE
    assert (
        np.abs(wave[-PLAYBACK_RATE // 10 :]).max() < AUDIBLE_AMPLITUDE
    )  # a pause before it comes again


def test_no_two_sound_alike() -> None:
    for one, other in combinations(map(synthesize_sound, BuiltinSound), 2):
        size = 1 << (len(one) + len(other)).bit_length()
        spectra = np.fft.rfft(one, size) * np.conj(np.fft.rfft(other, size))
        alike = np.abs(np.fft.irfft(spectra)).max()
        assert alike < 0.5 * np.linalg.norm(one) * np.linalg.norm(other)


@pytest.mark.parametrize("usual", URGENT)
def test_what_is_needed_badly_is_quicker_and_brighter(usual: BuiltinSound) -> None:
    calm, urgent = synthesize_sound(usual), synthesize_sound(URGENT[usual])
    assert notes_per_second(urgent) > 1.5 * notes_per_second(calm)
    assert brightness(urgent) > 1.2 * brightness(calm)


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
        self.mixer = Mixer(lambda _: None)
        self.mixer._loudspeaker.wake = lambda: None  # there is none
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


TestOrdersInAnyOrder = OrdersInAnyOrder.TestCase


@given(st.floats() | st.integers() | st.none() | st.text(max_size=3))
def test_a_volume_is_from_0_to_1_whatever_is_asked_for(volume: Any) -> None:
    try:
        assert 0 <= RequestedSound(volume, False).volume <= 1
    except SpeechError:
        assert not isinstance(volume, int | float)
