"""SoundClient of ROS sound_play without ROS: names in snake case, the same numbers of sounds."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from voz.audio.loudspeaker import Mixer
from voz.audio.playback import PLAYBACK_RATE, PlayingSound, Wave, trim_leading_silence
from voz.audio.sound_files import read_sound
from voz.errors import AudioError, SpeechError, VozError
from voz.printable import shown_value
from voz.records import PublicNames, check_callable, check_path, check_type, is_finite, is_number
from voz.speech.builtin_sounds import ALL, BuiltinSound, synthesize_sound
from voz.speech.synthesis import ESPEAK_PREFIX, cached_speech, check_known, is_cached, speakable

SoundKey: TypeAlias = tuple[str, ...]
"""The kind of a sound, then its name, its path, or its text and voice."""

SPOKEN = "voice"
"""The kind of speech."""


class RequestedSound:
    """A requested sound, and the playing one once it has begun.

    Args:
        volume: limited to 0 to 1.
        repeats: whether it repeats until it is stopped.
        text: what it says, if it is speech.

    Raises:
        SpeechError: the volume is no number.
    """

    def __init__(self, volume: float, repeats: bool, text: str | None = None) -> None:
        if not is_number(volume):
            raise SpeechError(f"a volume is a number from 0 to 1, and no {type(volume).__name__}")
        self.volume = min(max(0.0, volume), 1.0)  # in this order NaN is silence
        self.repeats = repeats
        self.text = text
        self.error: VozError | None = None
        self.decided = threading.Event()  # it has begun, or never will
        self.source: PlayingSound | None = None

    @property
    def over(self) -> bool:
        """Whether it will not be heard any more."""
        return self.decided.is_set() and (self.source is None or self.source.over)


class RequestedSounds:
    """All requested sounds, one of each key; thread-safe."""

    def __init__(self, mixer: Mixer) -> None:
        self._mixer = mixer
        self._lock = threading.Lock()
        self._sounds: dict[SoundKey, RequestedSound] = {}
        self._closed = False

    def add(self, key: SoundKey, volume: float, repeats: bool) -> RequestedSound:
        """Add a sound that is to begin; it replaces the one with the same key."""
        sound = RequestedSound(volume, repeats, key[1] if key[0] == SPOKEN else None)
        self.stop(key)
        with self._lock:
            if self._closed:
                sound.decided.set()
            self._sounds = {k: one for k, one in self._sounds.items() if not one.over}
            self._sounds[key] = sound
        return sound

    def begin(self, sound: RequestedSound, wave: Wave) -> None:
        """Play a sound, unless it was stopped meanwhile."""
        with self._lock:
            if not sound.decided.is_set():
                sound.source = self._mixer.play(wave, sound.volume, sound.repeats, sound.text)
                sound.decided.set()

    def fail(self, sound: RequestedSound, error: VozError) -> bool:
        """Note that a sound cannot be played; returns False if it was stopped meanwhile."""
        with self._lock:
            if sound.decided.is_set():
                return False
            sound.error = error
            sound.decided.set()
            return True

    def stop(self, beginning: SoundKey = ()) -> None:
        """Stop all sounds whose keys begin like this."""
        with self._lock:
            for key, sound in self._sounds.items():
                if key[: len(beginning)] == beginning:
                    sound.decided.set()
                    if sound.source:
                        self._mixer.stop(sound.source)

    def wait(self, sound: RequestedSound) -> None:
        """Wait until a sound has ended; raises the error that prevented it."""
        sound.decided.wait()
        if sound.source:
            self._mixer.wait(sound.source)
        if sound.error:
            raise sound.error

    def without_repeating(self) -> list[RequestedSound]:
        """The sounds that do not repeat."""
        with self._lock:
            return [sound for sound in self._sounds.values() if not sound.repeats]

    def close(self) -> None:
        """Stop all sounds, and start no more."""
        with self._lock:
            self._closed = True
        self.stop()


_log = logging.getLogger("voz")

MAX_RENDERERS = 4
"""Texts that festival renders at once; more are an error."""

RENDERER_TIMEOUT = 1.0
"""For festival to be killed, s."""


@dataclass(frozen=True)
class Sound:
    """A sound of a client, to be played later."""

    play: Callable[..., None]  # plays it once
    repeat: Callable[[], None]  # plays it again and again
    stop: Callable[[], None]  # stops it


class SoundClient(PublicNames):
    """Plays built-in sounds, files and speech, several at once, without waiting by default.

    A sound that is played again starts anew. One that cannot be played raises an error; a missing
    loudspeaker or a failing festival is one warning. A `with` block waits at its end for sounds
    that do not repeat.

        with SoundClient() as client:
            client.play(BuiltinSound.BACKINGUP)
            client.say("I am going back")

    Args:
        voice: the default voice, one of `voz.speech.synthesis.VOICES`, or of espeak-ng.
        blocking: whether `play`, `play_wave` and `say` wait until the sound has ended.
        warn: called with the message of a warning, on any thread.

    Raises:
        ConfigError: an argument has another type.
    """

    def __init__(
        self,
        voice: str = "kal_diphone",
        blocking: bool = False,
        warn: Callable[[str], None] = _log.warning,
    ) -> None:
        check_type(str, voice, "voice")
        check_type(bool, blocking, "blocking")
        check_callable(warn, "warn")
        self._voice = voice
        self._blocking = blocking
        self._warn = warn
        self._quiet = False
        self._told: set[str] = set()
        self._closed = threading.Event()
        self._renderers: list[threading.Thread] = []
        self._mixer = Mixer(self._tell)
        self._sounds = RequestedSounds(self._mixer)

    def play(self, sound: int, volume: float = 1.0, blocking: bool | None = None) -> None:
        """Play a built-in sound once.

        Args:
            sound: its number, as in `BuiltinSound`.
            volume: limited to 0 to 1.
            blocking: whether to wait until it has ended; None is the client's setting.

        Raises:
            SpeechError: there is no such sound, or the volume is no number.
        """
        self._wait_for(self._play_builtin(sound, volume, repeats=False), blocking)

    def start(self, sound: int, volume: float = 1.0) -> None:
        """Play a built-in sound again and again; otherwise as `play`."""
        self._play_builtin(sound, volume, repeats=True)

    def stop(self, sound: int) -> None:
        """Stop a built-in sound, or with `ALL` every sound."""
        is_all = is_number(sound) and sound == ALL
        self._sounds.stop(() if is_all else ("builtin", _builtin(sound).name))

    def play_wave(
        self, sound: str | os.PathLike[str], volume: float = 1.0, blocking: bool | None = None
    ) -> None:
        """Play a sound file once.

        Args:
            sound: its path; in any format of libsndfile, as WAV, FLAC or OGG, up to 10 minutes.
            volume: as for `play`.
            blocking: as for `play`.

        Raises:
            AudioError: it cannot be read.
        """
        self._wait_for(self._play_wave(sound, volume, repeats=False), blocking)

    def play_named(self, name: str, volume: float = 1.0, blocking: bool | None = None) -> None:
        """Play a built-in sound by its title, or a file; otherwise as `play` and `play_wave`."""
        check_path(name, "name")
        for builtin_sound in BuiltinSound:
            if builtin_sound.title == name:
                return self.play(builtin_sound, volume, blocking)
        return self.play_wave(name, volume, blocking)

    def start_wave(self, sound: str | os.PathLike[str], volume: float = 1.0) -> None:
        """Play a sound file again and again, without a gap; otherwise as `play_wave`."""
        self._play_wave(sound, volume, repeats=True)

    def stop_wave(self, sound: str | os.PathLike[str]) -> None:
        """Stop a sound file."""
        self._sounds.stop(_key_of(sound))

    def say(
        self, text: str, voice: str = "", volume: float = 1.0, blocking: bool | None = None
    ) -> None:
        """Say a text once.

        Args:
            text: what to say; it starts at once if any program has said it before.
            voice: another than the client's, if not empty.
            volume: as for `play`.
            blocking: as for `play`; then festival's failure raises an error, too.

        Raises:
            SpeechError: the text cannot be spoken, or the voice is unknown.
        """
        told = not self._blocks(blocking)
        self._wait_for(self._say(text, voice, volume, repeats=False, tell=told), blocking)

    def repeat(self, text: str, volume: float = 1.0, voice: str = "") -> None:
        """Say a text again and again; otherwise as `say`."""
        self._say(text, voice, volume, repeats=True, tell=True)

    def stop_saying(self, text: str) -> None:
        """Stop a text, in any voice."""
        for voice in ("", ESPEAK_PREFIX):
            with suppress(SpeechError):  # such a voice cannot say it
                self._sounds.stop((SPOKEN, speakable(text, voice)))

    def stop_all(self) -> None:
        """Stop every sound."""
        self._sounds.stop()

    def builtin_sound(self, sound: int, volume: float = 1.0) -> Sound:
        """A built-in sound, to be played later."""
        return Sound(
            partial(self.play, sound, volume),
            partial(self.start, sound, volume),
            partial(self.stop, sound),
        )

    def wave_sound(self, sound: str | os.PathLike[str], volume: float = 1.0) -> Sound:
        """A sound file, to be played later."""
        return Sound(
            partial(self.play_wave, sound, volume),
            partial(self.start_wave, sound, volume),
            partial(self.stop_wave, sound),
        )

    def voice_sound(self, text: str, volume: float = 1.0) -> Sound:
        """A text, to be said later."""
        return Sound(
            partial(self.say, text, "", volume),
            partial(self.repeat, text, volume),
            partial(self.stop_saying, text),
        )

    def set_quiet(self, quiet: bool) -> None:
        """Suppress warnings, or no longer."""
        check_type(bool, quiet, "quiet")
        self._quiet = quiet

    def wait(self) -> None:
        """Wait until all sounds that do not repeat have ended."""
        for requested in self._sounds.without_repeating():
            with suppress(VozError):  # reported before
                self._sounds.wait(requested)

    def close(self) -> None:
        """Stop every sound, and play nothing more."""
        self._sounds.close()
        self._closed.set()
        for thread in self._renderers:
            thread.join(RENDERER_TIMEOUT)
        self._mixer.close()

    def __enter__(self) -> SoundClient:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            if kind is None:
                self.wait()
        finally:
            self.close()

    def _play_builtin(self, sound: int, volume: float, repeats: bool) -> RequestedSound:
        known = _builtin(sound)
        requested = self._sounds.add(("builtin", known.name), volume, repeats)
        self._sounds.begin(requested, synthesize_sound(known))
        return requested

    def _play_wave(
        self, sound: str | os.PathLike[str], volume: float, repeats: bool
    ) -> RequestedSound:
        key = _key_of(sound)
        wave = read_sound(Path(sound), PLAYBACK_RATE)
        requested = self._sounds.add(key, volume, repeats)
        self._sounds.begin(requested, wave)
        return requested

    def _say(
        self, text: str, voice: str, volume: float, repeats: bool, tell: bool
    ) -> RequestedSound:
        check_type(str, voice, "voice")
        voice = voice or self._voice
        check_known(voice)
        plain = speakable(text, voice)
        at_once = is_cached(plain, voice)
        self._renderers = [thread for thread in self._renderers if thread.is_alive()]
        if not at_once and len(self._renderers) >= MAX_RENDERERS:
            raise SpeechError("festival is busy with other texts; say it again later")
        requested = self._sounds.add((SPOKEN, plain, voice), volume, repeats)
        render = partial(self._render, requested, plain, voice, tell)
        if at_once:
            render()
        else:
            thread = threading.Thread(target=render, name="voz-renderer", daemon=True)
            self._renderers.append(thread)
            thread.start()
        return requested

    def _render(self, requested: RequestedSound, plain: str, voice: str, tell: bool) -> None:
        try:
            wave = read_sound(cached_speech(plain, voice, self._closed), PLAYBACK_RATE)
        except VozError as error:
            if self._sounds.fail(requested, error) and tell and str(error) not in self._told:
                self._told.add(str(error))
                self._tell(str(error))
        else:
            self._sounds.begin(requested, trim_leading_silence(wave))

    def _wait_for(self, requested: RequestedSound, blocking: bool | None) -> None:
        if self._blocks(blocking):
            self._sounds.wait(requested)

    def _blocks(self, blocking: bool | None) -> bool:
        check_type((bool, type(None)), blocking, "blocking")
        return self._blocking if blocking is None else blocking

    def _tell(self, problem: str) -> None:
        if not self._quiet:
            self._warn(problem)


def mixer_of(client: SoundClient) -> Mixer:
    """Return what a client plays on."""
    return client._mixer


def _builtin(sound: object) -> BuiltinSound:
    # An array, for one, cannot even be compared with the known numbers.
    number: Any = sound if isinstance(sound, str) or is_finite(sound) else shown_value(sound)
    return BuiltinSound(number)


def _key_of(sound: str | os.PathLike[str]) -> SoundKey:
    try:
        return "wave", str(Path(sound).resolve())
    except (TypeError, ValueError):  # no name of a file has a zero in it
        raise AudioError(f"{shown_value(sound)} is no path of a sound; give a file") from None
