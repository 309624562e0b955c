"""The robot's sounds without words: told apart, never a click, and the bad ones more urgent."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from voz.audio.playback import AUDIBLE_AMPLITUDE, PLAYBACK_RATE, Wave
from voz.errors import SpeechError
from voz.speech.builtin_sounds import BuiltinSound, synthesize_sound

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
