"""Opens the streams of PortAudio, through sounddevice.

PortAudio does not support opening streams from several threads, and finds devices only when it is
initialized, which closes all streams. So every stream of voz is opened here.
"""

from __future__ import annotations

import atexit
import ctypes
import functools
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import ModuleType
from typing import Any, Literal

from voz.errors import AudioError

# A message of libasound's: file, line, function, number, then the text and what belongs into it.
_MESSAGE = ctypes.CFUNCTYPE(None, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_int)
_ignore_message = _MESSAGE(lambda *_: None)

_lock = threading.Lock()
_open_streams = 0


def load_sounddevice() -> ModuleType:
    """Import sounddevice; raises AudioError if PortAudio is not installed."""
    _silence_alsa()
    try:
        import sounddevice  # importing it takes long: it looks for devices
    except OSError as error:
        raise AudioError(
            "PortAudio is not installed; install it with: sudo apt-get install libportaudio2"
        ) from error
    module: ModuleType = sounddevice
    _accept_any_name(module)
    return module


def audio_errors(sounddevice: ModuleType) -> tuple[type[Exception], ...]:
    """Return what sounddevice raises: for devices that are not of the right kind, ValueError."""
    return sounddevice.PortAudioError, ValueError


@contextmanager
def open_stream(
    kind: Literal["RawInputStream", "RawOutputStream"], **settings: Any
) -> Iterator[Any]:
    """Open and start a stream of sounddevice for a `with` block; buffered sound is dropped.

    Classes with numpy set an array's shape, which numpy deprecates.

    Raises:
        PortAudioError, ValueError: it cannot be opened; `audio_errors` has both.
    """
    global _open_streams
    sounddevice = load_sounddevice()
    with _lock:
        stream = getattr(sounddevice, kind)(**settings)
        try:
            stream.start()
        except BaseException:
            stream.close()
            raise
        _open_streams += 1
    try:
        yield stream
    finally:
        with suppress(sounddevice.PortAudioError):  # its device is gone
            stream.abort()  # outside the lock: this waits for a sound server that hangs
        with _lock:
            with suppress(sounddevice.PortAudioError):
                stream.close()
            _open_streams -= 1


def refresh_devices() -> None:
    """Find devices that were connected or removed, if no stream is open."""
    sounddevice = load_sounddevice()
    with _lock:
        if not _open_streams:
            # It has no public way: https://github.com/spatialaudio/python-sounddevice/issues/16
            sounddevice._terminate()
            sounddevice._initialize()


def abandon_streams() -> None:
    """Let the program end although a hanging sound server keeps a stream from closing."""
    atexit.unregister(load_sounddevice()._exit_handler)  # it would wait for that stream


class _DeviceText(bytes):
    """A text of PortAudio's, which comes from settings of users and from drivers."""

    def decode(self, encoding: str = "utf-8", errors: str = "strict") -> str:
        """Decode it; what is not in this encoding is taken for Latin-1, which has each byte."""
        try:
            return super().decode(encoding, errors)
        except UnicodeDecodeError:
            return super().decode("latin-1")


@functools.cache
def _accept_any_name(sounddevice: ModuleType) -> None:
    """Let sounddevice take names that are not UTF-8: one would hide all devices.

    It has no public way: https://github.com/spatialaudio/python-sounddevice/issues/490
    """
    read = getattr(sounddevice, "_ffi_string", None)  # not in versions before 0.5
    if read:
        setattr(sounddevice, "_ffi_string", lambda text: _DeviceText(read(text)))  # noqa: B010


@functools.cache
def _silence_alsa() -> None:
    """Keep libasound from writing each lost block to the terminal."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL("libasound.so.2").snd_lib_error_set_handler(_ignore_message)
