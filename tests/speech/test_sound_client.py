"""The sound client: what sound_play offered, heard from a real sound server."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from threading import Thread
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
import soundfile
from calls import HANGS
from hanging import wait_for_end
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import Bundle, RuleBasedStateMachine, invariant, rule
from loudspeaker import Recorder, at_16_khz, best, is_silent, likeness
from programs import PATIENCE, wait_until

from voz.audio.loudspeaker import Loudspeaker, Mixer
from voz.audio.playback import PLAYBACK_RATE
from voz.audio.sound_files import read_sound
from voz.errors import AudioError, SpeechError, VozError
from voz.speech import synthesis
from voz.speech.builtin_sounds import ALL, BuiltinSound, synthesize_sound
from voz.speech.sound_client import (
    MAX_RENDERERS,
    RequestedSound,
    RequestedSounds,
    SoundClient,
    SoundKey,
    mixer_of,
)
from voz.speech.synthesis import cached_speech, is_cached

KAL, KED = "kal_diphone", "ked_diphone"
TEXT = "go on"


@pytest.fixture
def warnings() -> list[str]:
    return []


@pytest.fixture
def client(loudspeaker: Recorder, warnings: list[str]) -> Iterator[SoundClient]:
    client = SoundClient(warn=warnings.append)
    yield client
    client.close()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Half a second that rises, and resembles itself at a single place only."""
    time = np.arange(PLAYBACK_RATE // 2) / PLAYBACK_RATE
    wave = 0.4 * np.sin(2 * np.pi * (300 + 1500 * time) * time)
    soundfile.write(tmp_path / "rise.wav", wave, PLAYBACK_RATE)
    return tmp_path / "rise.wav"


def goes_on(client: SoundClient) -> bool:
    return mixer_of(client).busy_until() == math.inf


# Built-in sounds


@pytest.mark.slow
@pytest.mark.parametrize("sound", BuiltinSound)
def test_each_built_in_sound_is_heard(
    sound: BuiltinSound, client: SoundClient, loudspeaker: Recorder
) -> None:
    def alike() -> float:
        client.play(sound, blocking=True)
        loudspeaker.pass_by(0.2)
        return likeness(at_16_khz(synthesize_sound(sound)), loudspeaker.heard())

    assert best(alike, 0.95) > 0.95


@pytest.mark.slow
def test_a_sound_that_was_started_goes_on_until_it_is_stopped(
    client: SoundClient, loudspeaker: Recorder
) -> None:
    client.start(BuiltinSound.BACKINGUP)
    wait_until(lambda: not is_silent(loudspeaker.pass_by(0.1)))
    assert not is_silent(loudspeaker.pass_by(1))
    assert not is_silent(loudspeaker.pass_by(1))
    client.stop(BuiltinSound.NEEDS_PLUGGING)
    assert goes_on(client)
    client.stop(BuiltinSound.BACKINGUP)
    loudspeaker.pass_by(0.3)
    assert is_silent(loudspeaker.pass_by(1))


def until_something_sounds(client: SoundClient) -> None:
    until = time.monotonic() + PATIENCE
    while np.abs(mixer_of(client).recent(1)[0]).max() < 0.02:
        assert time.monotonic() < until, "nothing sounds"
        time.sleep(0.01)


@pytest.mark.realtime
@pytest.mark.slow
def test_playing_a_sound_again_begins_it_anew_and_does_not_double_it(client: SoundClient) -> None:
    client.play(BuiltinSound.NEEDS_PLUGGING)
    until_something_sounds(client)  # a loudspeaker may take its time to be opened
    for _ in range(2):
        time.sleep(0.1)
        client.play(BuiltinSound.NEEDS_PLUGGING)
    client.wait()
    time.sleep(0.1)
    samples, _ = mixer_of(client).recent(3)
    once = np.abs(at_16_khz(synthesize_sound(BuiltinSound.NEEDS_PLUGGING)))
    assert np.abs(samples).max() < 1.2 * once.max()
    # Three attacks, one end: 0.2 s longer than one.
    sounding = np.flatnonzero(np.abs(samples) > 0.02)
    length = np.flatnonzero(once > 0.02)
    assert 0.15 < (np.ptp(sounding) - np.ptp(length)) / 16_000 < 1


@pytest.mark.parametrize("stop", [lambda c: c.stop_all(), lambda c: c.stop(ALL)])
def test_all_sounds_can_be_stopped_at_once(
    stop: Callable[[SoundClient], None], client: SoundClient, file: Path
) -> None:
    client.start(BuiltinSound.BACKINGUP)
    client.start_wave(file)
    client.repeat(TEXT)
    client.say("something that was never said before")
    stop(client)
    client.wait()
    assert mixer_of(client).busy_until() < time.monotonic() + 1


# Files


@pytest.mark.parametrize("ending", ["wav", "flac", "ogg"])
def test_files_are_heard(
    ending: str, file: Path, client: SoundClient, loudspeaker: Recorder
) -> None:
    path = file.with_suffix(f".{ending}")
    soundfile.write(path, soundfile.read(file)[0], PLAYBACK_RATE)

    def alike() -> float:
        client.play_wave(str(path), blocking=True)
        loudspeaker.pass_by(0.2)
        return likeness(at_16_khz(read_sound(file, PLAYBACK_RATE)), loudspeaker.heard())

    assert best(alike, 0.97) > 0.97


def test_a_file_goes_on_until_it_is_stopped_by_any_name_of_it(
    client: SoundClient, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    client.start_wave(file)
    assert goes_on(client)
    monkeypatch.chdir(file.parent)
    client.stop_wave("rise.wav")
    assert not goes_on(client)


def test_a_file_that_cannot_be_played_is_told_at_once_and_the_rest_goes_on(
    client: SoundClient, file: Path, tmp_path: Path, warnings: list[str]
) -> None:
    client.start_wave(file)
    cut = tmp_path / "cut.ogg"
    soundfile.write(cut, np.zeros(2 * PLAYBACK_RATE), PLAYBACK_RATE)
    cut.write_bytes(cut.read_bytes()[:-300])
    file.write_text("no sound any more")
    for path in (tmp_path / "none.wav", tmp_path, cut, file):
        sound = client.wave_sound(path)
        for play in (partial(client.play_wave, path), partial(client.start_wave, path), sound.play):
            with pytest.raises(AudioError) as caught:
                play()
            assert str(caught.value).startswith(f"{path}: ")
            assert "\n" not in str(caught.value)
    assert goes_on(client)
    assert warnings == []


# Speech


@pytest.mark.slow
def test_a_text_is_heard_without_the_silence_before_it(
    client: SoundClient, loudspeaker: Recorder, scratch: Path
) -> None:
    def alike() -> float:
        client.say(TEXT, blocking=True)
        loudspeaker.pass_by(0.3)
        return likeness(at_16_khz(wave[PLAYBACK_RATE // 4 :]), loudspeaker.heard())

    wave = read_sound(cached_speech(TEXT, KAL), PLAYBACK_RATE)
    assert best(alike, 0.9) > 0.9
    assert list(scratch.iterdir()) == []  # and no file is left


def test_a_text_is_said_again_and_again_until_it_is_stopped(client: SoundClient) -> None:
    client.repeat(TEXT)
    wait_until(lambda: goes_on(client))
    client.stop_saying("something else")
    assert goes_on(client)
    client.stop_saying(f" {TEXT} ")
    assert not goes_on(client)


def test_stopping_a_text_stops_it_in_every_voice(client: SoundClient) -> None:
    cached_speech(TEXT, KAL)
    cached_speech(TEXT, KED)
    client.repeat(TEXT)
    client.repeat(TEXT, voice=KED)
    client.stop_saying(TEXT)
    assert not goes_on(client)
    client.repeat(TEXT, voice=KED)
    client.stop_saying(TEXT)
    assert not goes_on(client)


@pytest.mark.slow
def test_another_voice_is_another_sound(client: SoundClient) -> None:
    client.say(TEXT, KED, blocking=True)
    assert is_cached(TEXT, KED)
    assert not is_cached(TEXT, KAL)


def test_what_cannot_be_said_is_told_at_once(client: SoundClient, warnings: list[str]) -> None:
    with pytest.raises(SpeechError, match="nothing to speak"):
        client.say("...")
    with pytest.raises(SpeechError, match=r"voice '\(system \"ls\"\)' is unknown"):
        client.say(TEXT, '(system "ls")')
    assert warnings == []


@pytest.mark.usefixtures("no_festival")
def test_a_missing_festival_is_one_warning_or_an_error_for_who_waits(
    client: SoundClient, warnings: list[str]
) -> None:
    for text in ("one", "two", "three"):
        client.say(text)
    client.wait()
    wait_until(lambda: bool(warnings))
    (warning,) = warnings
    assert warning.startswith("festival is not installed")
    with pytest.raises(SpeechError, match="festival is not installed"):
        client.say("four", blocking=True)


@pytest.mark.slow
def test_a_festival_that_hangs_keeps_nothing_else_back(
    begun: Callable[[], list[Thread]],
    client: SoundClient,
    loudspeaker: Recorder,
    slow_festival: Path,
    file: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(synthesis, "FESTIVAL_TIMEOUT", 60.0)
    with monkeypatch.context() as usual:
        usual.setenv("PATH", os.environ["PATH"].split(":", 1)[1])
        cached_speech("known", KAL)
    for number in range(MAX_RENDERERS):
        client.say(f"text {number}")
    with pytest.raises(SpeechError, match="festival is busy"):
        client.say("one more")
    client.say("known", blocking=True)
    client.play_wave(file, blocking=True)
    loudspeaker.pass_by(0.1)
    assert not is_silent(loudspeaker.heard())
    wait_until(slow_festival.exists)
    client.close()
    wait_for_end(slow_festival)
    assert "voz-loudspeaker" not in [thread.name for thread in begun()]


def test_a_text_that_is_stopped_while_it_is_rendered_is_never_heard(
    client: SoundClient, warnings: list[str]
) -> None:
    client.say("some text")
    client.stop_saying("some text")
    client.wait()
    wait_until(lambda: is_cached("some text", KAL))
    time.sleep(0.2)
    assert not mixer_of(client).recent(2)[0].any()
    assert warnings == []


# Objects, waiting, closing


@pytest.mark.realtime
@pytest.mark.slow
def test_sounds_as_objects(client: SoundClient, file: Path) -> None:
    cached_speech(TEXT, KAL)
    for sound in (
        client.builtin_sound(BuiltinSound.NEEDS_UNPLUGGING, 0.5),
        client.wave_sound(file, 0.5),
        client.voice_sound(TEXT, 0.5),
    ):
        sound.repeat()
        assert goes_on(client)
        sound.stop()
        assert not goes_on(client)
        before = time.monotonic()
        sound.play(blocking=True)
        time.sleep(0.1)
        seconds = min(5.9, time.monotonic() - before)
        assert 0.1 < np.abs(mixer_of(client).recent(seconds)[0]).max() < 0.5


@pytest.mark.slow
def test_a_block_waits_for_what_is_heard_once_and_ends_what_repeats(
    loudspeaker: Recorder, file: Path
) -> None:
    with SoundClient() as client:
        client.start(BuiltinSound.BACKINGUP, 0.1)
        client.say(TEXT)
    assert is_cached(TEXT, KAL)
    assert np.abs(mixer_of(client).recent(2)[0]).max() > 0.2
    assert mixer_of(client).busy_until() <= time.monotonic()
    client.play_wave(file, blocking=True)
    client.say("not known yet")
    client.wait()


@pytest.mark.realtime
@pytest.mark.slow
def test_a_client_that_blocks_says_one_thing_after_the_other(
    loudspeaker: Recorder, file: Path
) -> None:
    client = SoundClient(blocking=True)
    for _ in range(2):
        client.play_wave(file)
    time.sleep(0.1)
    samples, _ = mixer_of(client).recent(3)
    client.close()
    assert 0.9 < np.ptp(np.flatnonzero(np.abs(samples) > 0.01)) / 16_000 < 2
    assert np.abs(samples).max() < 0.45


NO_DEVICE = """
import logging, sys
from voz.speech.builtin_sounds import BuiltinSound
from voz.speech.sound_client import SoundClient
logging.basicConfig(stream=sys.stdout, format="%(message)s")
with SoundClient() as client:
    client.set_quiet(len(sys.argv) > 1)
    for sound in BuiltinSound:
        client.play(sound)
    client.start(1)
    client.play(2, blocking=True)
"""


@pytest.mark.parametrize(
    ("arguments", "printed"), [([], "there is no loudspeaker; connect one\n"), (["quiet"], "")]
)
def test_without_a_loudspeaker_there_is_one_warning(
    arguments: list[str], printed: str, tmp_path: Path
) -> None:
    (tmp_path / "alsa.conf").write_text("pcm.default { type hw card 99 }")
    done = subprocess.run(
        [sys.executable, "-c", NO_DEVICE, *arguments],
        env=os.environ | {"ALSA_CONFIG_PATH": str(tmp_path / "alsa.conf")},
        capture_output=True,
        text=True,
        check=True,
        timeout=HANGS,
    )
    assert (done.stdout, done.stderr) == (printed, "")


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        (lambda client: client.play("beep"), "there is no built-in sound 'beep'; give 1 to 5"),
        (lambda client: client.play(1, volume="loud"), "a volume is a number from 0 to 1"),
        (lambda client: client.play_wave(7), "7 is no path of a sound; give a file"),
        (lambda client: client.stop_wave(None), "None is no path of a sound; give a file"),
        (lambda client: client.say(7), "Expected `str`, got `int` - at `text`"),
        (lambda client: client.stop_saying(None), "Expected `str`, got `NoneType` - at `text`"),
        (lambda client: client.say("hello", voice=7), "Expected `str`, got `int` - at `voice`"),
    ],
)
def test_what_is_no_sound_is_an_error_of_voz(ask: Callable[[Any], None], told: str) -> None:
    with SoundClient() as client, pytest.raises(VozError) as caught:
        ask(client)
    assert str(caught.value).startswith(told)


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
