"""Text to a WAV file, by festival or espeak-ng, kept in the user's cache folder.

Festival (https://www.cstr.ed.ac.uk/projects/festival/) crashes on many texts, and its language is a
programming language. So it reads plain words on its standard input, which it never evaluates, and
its output is checked. espeak-ng (https://github.com/espeak-ng/espeak-ng) speaks other languages.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import os
import re
import reprlib
import shutil
import signal
import stat
import subprocess
import tempfile
import threading
import time
import unicodedata
from collections.abc import Sequence
from pathlib import Path

from voz.errors import SpeechError
from voz.files import atomic_write, sha256
from voz.records import check_type

ESPEAK_PREFIX = "espeak-ng:"
"""Of the names of its voices, as in `espeak-ng:es`."""

_VOICE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,30}(\+[A-Za-z0-9_-]{1,20})?")


def is_espeak(voice: str) -> bool:
    """Whether a voice is one of espeak-ng's, by its name."""
    return voice.startswith(ESPEAK_PREFIX)


def check_espeak_voice(voice: str) -> None:
    """Raise SpeechError for an impossible name; only espeak-ng knows which voices it has."""
    if not _VOICE.fullmatch(voice.removeprefix(ESPEAK_PREFIX)):
        raise SpeechError(f"voice {voice!a} is unknown; see `espeak-ng --voices`")


def espeak_command(voice: str, wav: str) -> Sequence[str]:
    """Return a command that speaks standard input into a file; SpeechError without espeak-ng."""
    path = shutil.which("espeak-ng")
    if path is None:
        raise SpeechError(
            "espeak-ng is not installed; install it with: sudo apt-get install espeak-ng"
        )
    return [path, "-v", voice.removeprefix(ESPEAK_PREFIX), "-w", wav, "--stdin"]


def no_voice_error(voice: str) -> SpeechError:
    """The error where espeak-ng wrote no sound."""
    return SpeechError(f"voice {voice!a}: espeak-ng has no such voice; see `espeak-ng --voices`")


VOICES = {
    "kal_diphone": "festvox-kallpc16k",
    "ked_diphone": "festvox-kdlpc16k",
    "cmu_us_slt_arctic_hts": "festvox-us-slt-hts",
}
"""Festival's voices, each with its Debian package."""

MAX_TEXT_LENGTH = 1000
"""Characters; more than a minute of speech."""

MAX_WORD_LENGTH = 100
"""Characters; festival crashes on words of some thousands."""

FESTIVAL_TIMEOUT = 30.0
"""Ten times what the longest text takes the slowest voice on a desktop computer, s."""

CANCEL_CHECK_INTERVAL = 0.05
"""Between checks of whether the text is still wanted, s."""

PLAIN_PUNCTUATION = str.maketrans("‘’“”‐–—", "''\"\"---")  # noqa: RUF001
"""Characters that Unicode does not decompose, and their ASCII forms."""

SPEAKABLE = re.compile(r"[A-Za-z0-9#$%&*+=@]")
"""Festival crashes on a phrase without any of these."""

SPEAKABLE_BY_ESPEAK = re.compile(r"[^\W_]|[#$%&*+=@]")
"""The same for espeak-ng, which reads the letters of all languages."""

WAV_HEADER_BYTES = 44


def installed_voices() -> list[str]:
    """List the installed ones of `VOICES`; raises SpeechError without festival."""
    answer = _run([_program("festival"), "--batch", "(print (voice.list))"])
    found = re.findall(r"\w+", answer)
    return [voice for voice in VOICES if voice in found]


def speakable(text: str, voice: str = "") -> str:
    """Reduce a text to one line of words that a voice can speak, for festival in ASCII.

    Args:
        text: anything.
        voice: one of espeak-ng's keeps all letters, any other is festival's.

    Raises:
        SpeechError: nothing is left, or too much.
        ConfigError: it is no text.
    """
    check_type(str, text, "text")
    if is_espeak(voice):
        composed = unicodedata.normalize("NFC", text.translate(PLAIN_PUNCTUATION))
        words = "".join(char if char.isprintable() else " " for char in composed).split()
        words = [word for word in words if SPEAKABLE_BY_ESPEAK.search(word)]
    else:
        decomposed = unicodedata.normalize("NFKD", text.translate(PLAIN_PUNCTUATION))
        folded = "".join(char for char in decomposed if not unicodedata.combining(char))
        # Blank lines end a phrase, so they are removed like all that is not printable ASCII.
        words = re.sub(r"[^!-~]+", " ", folded).split()
        words = [word for word in words if SPEAKABLE.search(word)]
    plain = " ".join(words)
    if not plain:
        raise SpeechError(f"{reprlib.repr(text)} has nothing to speak; give letters or digits")
    if len(plain) > MAX_TEXT_LENGTH:
        raise SpeechError(
            f"the text is too long: {len(plain)} characters; give at most {MAX_TEXT_LENGTH}"
        )
    longest = max(words, key=len)
    if len(longest) > MAX_WORD_LENGTH:
        raise SpeechError(
            f"{reprlib.repr(longest)} is too long for a word: {len(longest)} characters; "
            f"give at most {MAX_WORD_LENGTH}"
        )
    return plain


def render(text: str, voice: str, out: Path, cancelled: threading.Event | None = None) -> None:
    """Speak a text into a WAV file.

    Args:
        text: what to say; see `speakable`.
        voice: one of `VOICES`, or of espeak-ng.
        out: the file to write; it is replaced only when complete.
        cancelled: festival is killed when another thread sets it.

    Raises:
        SpeechError: festival or the voice is missing, the text cannot be spoken, or the file
            cannot be written.
    """
    plain = speakable(text, voice)
    check_known(voice)
    try:
        if out.exists() and not out.is_file():
            raise SpeechError(f"{out}: is no regular file; name a file to write")
        with atomic_write(out, "wb") as file, tempfile.TemporaryDirectory(prefix="voz-") as folder:
            file.write(synthesize_speech(plain, voice, Path(folder), cancelled).read_bytes())
    except OSError as error:
        raise SpeechError(
            f"{out}: cannot be written ({error.strerror}); name a file in a folder that exists "
            "and is yours"
        ) from error


def check_known(voice: str) -> None:
    """Raise SpeechError if a voice is none of `VOICES` and cannot be one of espeak-ng's."""
    check_type(str, voice, "voice")
    if is_espeak(voice):
        check_espeak_voice(voice)
    elif voice not in VOICES:
        installed = ", ".join(installed_voices()) or "none"
        raise SpeechError(
            f"voice {reprlib.repr(voice)} is unknown",
            f"installed: {installed}; those of espeak-ng are called as in {ESPEAK_PREFIX}es",
        )


def synthesize_speech(
    plain: str, voice: str, folder: Path, cancelled: threading.Event | None
) -> Path:
    """Speak in an empty folder, since a crash may leave a core dump there."""
    wav = folder / "speech.wav"
    if is_espeak(voice):
        _run(espeak_command(voice, wav.name), plain, folder, cancelled)
        if not _is_whole_wav(wav):
            raise no_voice_error(voice)
        return wav
    text2wave = _program("text2wave")
    festival = [text2wave, "-o", wav.name, "-otype", "riff", "-eval", f"(voice_{voice})"]
    _run(festival, plain, folder, cancelled)
    if not _is_whole_wav(wav):
        raise _failure_reason(plain, voice)
    return wav


def _program(name: str) -> str:
    path = shutil.which(name)
    if path is None:
        raise SpeechError(
            "festival is not installed; install it with: "
            f"sudo apt-get install festival {VOICES['kal_diphone']}"
        )
    return path


def _run(
    program: Sequence[str],
    text: str = "",
    folder: Path | None = None,
    cancelled: threading.Event | None = None,
) -> str:
    """Run a program with a text on its standard input; return its output."""
    try:
        # A file, no pipe: `communicate` loses what it has not yet written when its time is up.
        with tempfile.TemporaryFile() as stdin:
            stdin.write(text.encode())
            stdin.seek(0)
            process = subprocess.Popen(
                program,
                cwd=folder,
                stdin=stdin,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # a group of its own, to be ended with all its children
            )
    except OSError as error:
        raise SpeechError(
            f"{program[0]}: cannot be started ({error.strerror}); install it again"
        ) from error
    with process:
        try:
            output = _output(process, cancelled)
        except BaseException:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            raise
    return output.decode("ascii", "replace")


def _output(process: subprocess.Popen[bytes], cancelled: threading.Event | None) -> bytes:
    """Wait for the output; raises SpeechError if it is cancelled or takes too long."""
    deadline = time.monotonic() + FESTIVAL_TIMEOUT
    while not (cancelled and cancelled.is_set()):
        with contextlib.suppress(subprocess.TimeoutExpired):
            return process.communicate(timeout=CANCEL_CHECK_INTERVAL)[0]
        if time.monotonic() > deadline:
            raise SpeechError(
                f"festival took longer than {FESTIVAL_TIMEOUT:g} s and was ended; "
                "give a shorter text or another voice"
            )
    raise SpeechError("festival was ended, as its text is not to be said any more")


def _failure_reason(plain: str, voice: str) -> SpeechError:
    """Find out why there is no sound: festival ends with 0 without the voice."""
    if voice not in installed_voices():
        return SpeechError(
            f"voice {voice!r} is not installed; install it with: "
            f"sudo apt-get install {VOICES[voice]}"
        )
    return SpeechError(f"festival cannot speak {reprlib.repr(plain)}", "use other words")


def _is_whole_wav(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            header = file.read(WAV_HEADER_BYTES)
            size = os.fstat(file.fileno()).st_size
    except OSError:
        return False
    promised = int.from_bytes(header[4:8], "little") + 8
    return header.startswith(b"RIFF") and size == promised and size > WAV_HEADER_BYTES


CACHE_FORMAT = 1
"""To be raised when the same text and voice are to give another file."""

KNOWN_TEXTS: set[tuple[str, str]] = set()
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
    KNOWN_TEXTS.add((plain, voice))
    return wav


def is_cached(text: str, voice: str) -> bool:
    """Whether `cached_speech` has returned a file before; the disk is not asked."""
    return (speakable(text, voice), voice) in KNOWN_TEXTS


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
