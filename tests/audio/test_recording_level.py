"""What a recording is like, and what is wrong with it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from recordings import FIXTURES, Recording

from voz.apps.evaluation.noise import mix, random_stretch
from voz.audio import SAMPLE_RATE, Samples
from voz.audio.recording_level import (
    MIN_DBFS,
    Fault,
    dbfs,
    find_faults,
    measure_level,
    obeyed_of_100,
)
from voz.audio.sound_files import read_samples

LENGTH = 3 * SAMPLE_RATE
GO_FORWARD = FIXTURES / "commands" / "flite_rms__go_forward.flac"


def spoken(samples: Samples, background: float = 5.0) -> Samples:
    """Three seconds with a command in the middle, in the hiss of a quiet room."""
    sound = np.random.default_rng(1).standard_normal(LENGTH) * background
    begin = SAMPLE_RATE // 2
    part = samples[: LENGTH - begin]
    sound[begin : begin + len(part)] += part
    return as_recorded(sound)


def as_recorded(sound: np.ndarray) -> Samples:
    return np.clip(np.round(sound), -32768, 32767).astype(np.int16)


def louder(samples: Samples, decibels: float) -> Samples:
    return as_recorded(samples.astype(float) * 10 ** (decibels / 20))


@pytest.fixture(scope="module")
def command() -> Samples:
    return spoken(read_samples(GO_FORWARD))


@pytest.fixture(scope="module")
def noise() -> Samples:
    """A mains hum, hiss and a rattle: no speech."""
    chance = np.random.default_rng(2)
    time = np.arange(LENGTH) / SAMPLE_RATE
    hum = np.sin(2 * np.pi * 100 * time) + 0.5 * chance.standard_normal(LENGTH)
    rattle = chance.standard_normal(LENGTH) * (np.sin(2 * np.pi * 3 * time) > 0.9)
    return as_recorded(2000 * (hum + rattle))


@pytest.mark.slow
def test_every_voice_of_the_fixtures_is_fine(recordings: list[Recording]) -> None:
    some = [r for r in recordings if r.kind == "command" and r.text in ("stop", "turn left")]
    assert len({r.voice for r in some}) == 8
    for recording in some:
        assert find_faults(measure_level(spoken(recording.samples()))) == [], recording.path


@pytest.mark.slow
def test_the_session_is_fine_and_the_kitchen_is_noisy(recordings: list[Recording]) -> None:
    by_name = {r.path.name: r.samples() for r in recordings if r.kind == "long"}
    for start in range(0, 18 * SAMPLE_RATE, LENGTH):
        quiet_room = measure_level(by_name["session.wav"][start : start + LENGTH])
        assert find_faults(quiet_room) == []
        kitchen = measure_level(by_name["kitchen.wav"][start : start + LENGTH])
        assert kitchen.above_background == pytest.approx(15, abs=4)
        assert set(find_faults(kitchen)) <= {Fault.NOISY}


@pytest.mark.parametrize("value", [0, 1, -1, 300, -32768, 32767])
def test_a_microphone_that_gives_the_same_all_the_time_is_silent(value: int) -> None:
    assert find_faults(measure_level(np.full(LENGTH, value, np.int16))) == [Fault.SILENT]


def test_noise_of_one_unit_from_a_muted_converter_is_silent() -> None:
    samples = np.random.default_rng(1).integers(-1, 2, LENGTH).astype(np.int16)
    assert find_faults(measure_level(samples)) == [Fault.SILENT]


@pytest.mark.parametrize("level", [2, 30, 3000])
def test_hiss_and_hum_are_no_speech(level: int, noise: Samples) -> None:
    hiss = np.random.default_rng(1).standard_normal(LENGTH) * level
    for sound in (as_recorded(hiss), as_recorded(noise * (level / 3000))):
        found = measure_level(sound)
        assert find_faults(found) == [Fault.NO_SPEECH]
        assert found.background == pytest.approx(dbfs(sound), abs=3)


@pytest.mark.parametrize(("decibels", "fault"), [(-10, []), (-30, [Fault.TOO_QUIET])])
def test_quiet_speech_is_found_and_said_to_be_quiet(
    decibels: float, fault: list[Fault], command: Samples
) -> None:
    found = measure_level(louder(command, decibels))
    assert find_faults(found) == fault
    assert found.speech == pytest.approx(measure_level(command).speech + decibels, abs=1)


@pytest.mark.parametrize("decibels", [18, 24, 30])
def test_what_is_cut_off_is_clipped(decibels: float, command: Samples) -> None:
    assert Fault.CLIPPED in find_faults(measure_level(louder(command, decibels)))


def test_what_was_cut_off_before_it_was_turned_down_is_clipped(command: Samples) -> None:
    found = measure_level(louder(louder(command, 20), -12))
    assert found.peak == pytest.approx(-12, abs=0.1)
    assert find_faults(found) == [Fault.CLIPPED]


@pytest.mark.parametrize(("ratio", "fault"), [(25, []), (10, [Fault.NOISY]), (5, [Fault.NOISY])])
def test_noise_behind_the_speech_is_noisy(
    ratio: float, fault: list[Fault], command: Samples, noise: Samples
) -> None:
    behind = random_stretch(noise, LENGTH, np.random.default_rng(1))
    found = measure_level(mix(command, behind, ratio))
    assert find_faults(found) == fault
    assert found.above_background == pytest.approx(ratio, abs=3.5)


def test_far_and_in_noise_is_both_quiet_and_noisy(command: Samples, noise: Samples) -> None:
    found = measure_level(louder(mix(command, noise, 8), -40))
    assert find_faults(found) == [Fault.TOO_QUIET, Fault.NOISY]


def test_who_speaks_all_the_time_is_not_taken_for_the_background(command: Samples) -> None:
    word = command[SAMPLE_RATE // 2 :][: SAMPLE_RATE * 6 // 10]
    assert find_faults(measure_level(np.tile(word, 5))) == []


def test_a_converter_that_is_off_zero_changes_nothing(command: Samples) -> None:
    off = measure_level(as_recorded(command.astype(float) * 0.5 + 3000))
    on = measure_level(as_recorded(command.astype(float) * 0.5))
    assert off.speech == pytest.approx(on.speech, abs=0.2)
    assert off.background == pytest.approx(on.background, abs=1)
    assert find_faults(off) == []


def test_every_fault_says_what_to_do() -> None:
    for fault in Fault:
        assert fault.words
        assert fault.advice
        assert "\n" not in fault.words + fault.advice


@pytest.mark.slow
@given(
    st.integers(1, 20_000).flatmap(
        lambda length: arrays(np.int16, length, elements=st.integers(-32768, 32767))
    )
)
@settings(max_examples=50)
def test_any_samples_have_a_level_within_what_16_bits_hold(samples: Samples) -> None:
    level = measure_level(samples)
    assert MIN_DBFS <= level.background <= 0.1
    assert MIN_DBFS <= level.peak <= 0
    assert 0 <= level.at_top <= 1
    assert level.still == (int(samples.max()) - int(samples.min()) <= 2)
    found = find_faults(level)
    assert (Fault.SILENT in found) == level.still
    assert (found in ([Fault.SILENT], [Fault.NO_SPEECH])) == (level.speech is None)


@pytest.mark.slow
@given(st.floats(-20, 8))
@settings(max_examples=25)
def test_a_louder_recording_is_louder_and_as_far_above_its_background(decibels: float) -> None:
    plain = spoken(read_samples(GO_FORWARD) // 3, background=50)
    before, after = measure_level(plain), measure_level(louder(plain, decibels))
    assert before.speech is not None
    assert after.speech == pytest.approx(before.speech + decibels, abs=0.5)
    assert after.above_background == pytest.approx(before.above_background, abs=0.5)


def test_the_further_above_the_room_the_more_commands_are_obeyed() -> None:
    shares = [obeyed_of_100(above) for above in (60.0, 20.0, 15.0, 10.0)]
    assert shares == sorted((s for s in shares if s is not None), reverse=True)
    assert obeyed_of_100(5.0) is None
