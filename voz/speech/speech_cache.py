"""A cache of rendered speech in the user's cache folder, one file for each text and voice."""

from __future__ import annotations

import atexit
import functools
import os
import shutil
import stat
import tempfile
import threading
from pathlib import Path

from voz.checksum import sha256
from voz.errors import SpeechError
from voz.speech.festival import check_known, speakable, synthesize_speech

CACHE_FORMAT = 1
"""To be raised when the same text and voice are to give another file."""

_KNOWN_TEXTS: set[tuple[str, str]] = set()
"""Text and voice of what `cached_speech` has returned in this process."""


def cached_speech(text: str, voice: str, cancelled: threading.Event | None = None) -> Path:
    """Return a WAV file of a text, which is rendered the first time; raises SpeechError.

    It is in `$XDG_CACHE_HOME/voz/speech` or `~/.cache/voz/speech`; if that cannot be written or is
    another user's, in a temporary folder of this process. The arguments are those of `render`.
    """
    plain = speakable(text, voice)
    check_known(voice)
    folder = _cache_folder()
    key = sha256(f"{CACHE_FORMAT}\n{voice}\n{plain}".encode()).hexdigest()[:32]
    try:
        wav = _find_in(folder, key) or _render_into(folder, key, plain, voice, cancelled)
    except OSError as error:
        raise SpeechError(f"{folder}: cannot be used ({error.strerror}); remove it") from error
    _KNOWN_TEXTS.add((plain, voice))
    return wav


def is_cached(text: str, voice: str) -> bool:
    """Whether `cached_speech` has returned a file before; the disk is not asked."""
    return (speakable(text, voice), voice) in _KNOWN_TEXTS


def _render_into(
    folder: Path, key: str, plain: str, voice: str, cancelled: threading.Event | None
) -> Path:
    # In the cache folder, so that the finished file can be renamed.
    with tempfile.TemporaryDirectory(prefix=".voz-", dir=folder) as work:
        wav = synthesize_speech(plain, voice, Path(work), cancelled)
        target = folder / f"{key}-{_digest_of_own(wav)}.wav"
        wav.replace(target)  # a link too, and not what it points to
    return target


def _find_in(folder: Path, key: str) -> Path | None:
    """Find a file in the cache; damaged ones are removed."""
    for path in folder.glob(f"{key}-*.wav"):
        if path.name == f"{key}-{_digest_of_own(path)}.wav":
            return path
        path.unlink(missing_ok=True)
    return None


def _digest_of_own(path: Path) -> str | None:
    """Digest a file; None if it is not a regular one of this user."""
    try:
        # Links are not followed, and a pipe is not waited for.
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return None
    with os.fdopen(descriptor, "rb") as file:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode) or status.st_uid != os.geteuid():
            return None
        digest = sha256()
        while block := file.read(2**16):
            digest.update(block)
    return digest.hexdigest()[:32]


def _cache_folder() -> Path:
    try:
        base = Path(os.environ.get("XDG_CACHE_HOME", ""))
        if not base.is_absolute():  # the XDG standard: a relative one is to be ignored
            base = Path.home() / ".cache"
        folder = base / "voz" / "speech"
        folder.mkdir(parents=True, exist_ok=True)
        if folder.stat().st_uid != os.geteuid():  # its owner could replace files at any time
            return _private_folder()
        # Only writing shows whether it is allowed: for root, permissions mean nothing.
        tempfile.TemporaryFile(dir=folder).close()
    except (OSError, RuntimeError):  # RuntimeError: there is no home folder
        return _private_folder()
    return folder


@functools.cache
def _private_folder() -> Path:
    folder = tempfile.mkdtemp(prefix="voz-speech-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)
