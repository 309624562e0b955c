"""Voices of espeak-ng, the real program."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
import soundfile
from hanging import wait_for_end
from hypothesis import given, settings
from hypothesis import strategies as st

from voz.errors import SpeechError
from voz.speech import synthesis
from voz.speech.synthesis import (
    VOICES,
    cached_speech,
    check_known,
    installed_voices,
    is_cached,
    render,
    speakable,
)

REPLY = "bep bep. I am listening you"
KAL = "kal_diphone"


def refusal(text: str, voice: str, out: Path) -> str:
    with pytest.raises(SpeechError) as caught:
        render(text, voice, out)
    assert "\n" not in str(caught.value)
    return str(caught.value)


# What is spoken


@pytest.mark.parametrize(("voice", "rate"), [(KAL, 16000), ("cmu_us_slt_arctic_hts", 32000)])
def test_a_reply_becomes_a_wav_of_plausible_length(voice: str, rate: int, tmp_path: Path) -> None:
    render(REPLY, voice, tmp_path / "reply.wav")
    samples, found_rate = soundfile.read(tmp_path / "reply.wav")
    assert found_rate == rate
    assert 1.5 < len(samples) / rate < 5
    assert abs(samples).max() > 0.05


@pytest.mark.parametrize(
    ("text", "spoken"),
    [
        ("Él girará a la izquierda, señor", "El girara a la izquierda, senor"),
        ("Hello ... – world 🤖 !\n\n?\n\n5 + 3", "Hello world 5 + 3"),  # noqa: RUF001
        ("I don’t “know”", 'I don\'t "know"'),  # noqa: RUF001
    ],
)
def test_a_text_becomes_what_festival_can_say(text: str, spoken: str) -> None:
    assert speakable(text) == spoken


@given(st.text())
def test_festival_is_given_plain_words_or_nothing(text: str) -> None:
    try:
        plain = speakable(text)
    except SpeechError:
        return
    assert plain.isascii()
    assert plain.isprintable()
    assert all(synthesis.SPEAKABLE.search(word) for word in plain.split(" "))
    assert speakable(plain) == plain


CRASHING = [
    "hello\n\n...\n\nworld",
    ";;; -*- mode: sable -*-\nhello",
    "- -- - a",
    "é",
    "a\x00b\x07",
    "\ud800 lone surrogate",
    "x" * synthesis.MAX_WORD_LENGTH,
]


@pytest.mark.slow
@pytest.mark.parametrize("text", CRASHING, ids=ascii)
def test_texts_that_crash_festival_are_spoken(text: str, tmp_path: Path) -> None:
    render(text, KAL, tmp_path / "out.wav")
    assert soundfile.info(tmp_path / "out.wav").frames > 0


@pytest.mark.slow
@pytest.mark.parametrize("voice", [KAL, "espeak-ng:en"])
def test_no_text_is_lost_on_a_machine_that_starts_programs_late(
    voice: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    communicate = subprocess.Popen.communicate
    over = iter([0.0])  # the first wait is over before anything is written

    def late(process: subprocess.Popen[bytes], *given: Any, timeout: float) -> Any:
        return communicate(process, *given, timeout=next(over, timeout))

    monkeypatch.setattr(subprocess.Popen, "communicate", late)
    render("hello", voice, tmp_path / "out.wav")
    assert soundfile.info(tmp_path / "out.wav").duration > 0.2


@pytest.mark.slow
@settings(max_examples=8)
@given(text=st.text("aB5 .,;:-'\"()<>?!#$\n\\é", max_size=40))
def test_festival_speaks_whatever_is_speakable(
    text: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    out = tmp_path_factory.mktemp("any") / "out.wav"
    try:
        speakable(text)
    except SpeechError:
        refusal(text, KAL, out)
        assert list(out.parent.iterdir()) == []
    else:
        render(text, KAL, out)
        assert list(out.parent.iterdir()) == [out]


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        '(system "touch {0}")',
        '") (system "touch {0}") ("',
        '-eval (system "touch {0}")',
        "-o {0}",
        "<?xml version='1.0'?><SABLE><AUDIO SRC='{0}'/>hello</SABLE>",
        "<speak><audio src='{0}'/>hello</speak>",
        "`touch {0}` $(touch {0}); touch {0}",
    ],
)
def test_a_program_in_the_text_is_read_and_not_run(text: str, tmp_path: Path) -> None:
    trap = tmp_path / "trap"
    render(text.format(trap), KAL, tmp_path / "out.wav")
    assert not trap.exists()
    # A name, a slash and dots are many words to read: markup that was obeyed would be short.
    assert soundfile.info(tmp_path / "out.wav").duration > 2


# What is refused


@pytest.mark.parametrize("text", ["", "  \n", "...", "?", "🤖", "«»", "你好", '"(-)"', "...\n\n?"])
def test_a_text_without_sound_is_refused(text: str, tmp_path: Path) -> None:
    assert "has nothing to speak" in refusal(text, KAL, tmp_path / "out.wav")


def test_a_text_that_is_too_long_is_refused(tmp_path: Path) -> None:
    assert "1001 characters; give at most 1000" in refusal("a " * 501, KAL, tmp_path / "out.wav")


def test_a_word_that_is_too_long_is_refused(tmp_path: Path) -> None:
    assert "too long for a word" in refusal("hello " + "b" * 500, KAL, tmp_path / "out.wav")


def test_an_unknown_voice_is_refused_with_those_installed(tmp_path: Path) -> None:
    message = refusal(REPLY, '") (system "touch trap', tmp_path / "out.wav")
    assert "is unknown; installed: " in message
    assert all(voice in message for voice in installed_voices())


def test_a_voice_that_is_not_installed_names_its_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(VOICES, "absent_diphone", "festvox-absent")
    message = refusal(REPLY, "absent_diphone", tmp_path / "out.wav")
    assert message.endswith(
        "is not installed; install it with: sudo apt-get install festvox-absent"
    )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("no_festival")
def test_without_festival_the_message_says_how_to_install_it(tmp_path: Path) -> None:
    line = "festival is not installed; install it with: sudo apt-get install festival "
    assert refusal(REPLY, KAL, tmp_path / "out.wav").startswith(line)
    with pytest.raises(SpeechError, match="festival is not installed"):
        installed_voices()


def test_a_festival_that_hangs_is_ended_with_its_children(
    slow_festival: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out" / "hello.wav"
    out.parent.mkdir()
    assert "took longer than 0.5 s" in refusal(REPLY, KAL, out)
    assert list(out.parent.iterdir()) == []
    wait_for_end(slow_festival)


def test_a_text_that_is_not_wanted_any_more_ends_festival(
    slow_festival: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(synthesis, "FESTIVAL_TIMEOUT", 60.0)
    cancelled = threading.Event()
    timer = threading.Timer(0.5, cancelled.set)
    timer.start()
    with pytest.raises(SpeechError, match="is not to be said any more"):
        render(REPLY, KAL, tmp_path / "hello.wav", cancelled)
    timer.join()
    wait_for_end(slow_festival)


@pytest.mark.parametrize("out", ["missing/out.wav", "file/out.wav", "folder"])
def test_a_file_that_cannot_be_written_is_refused(out: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("kept")
    before = sorted(tmp_path.rglob("*"))
    assert refusal(REPLY, KAL, tmp_path / out).startswith(f"{tmp_path / out}: ")
    assert sorted(tmp_path.rglob("*")) == before
    assert (tmp_path / "file").read_text() == "kept"


def test_a_device_is_not_replaced_by_a_file() -> None:
    assert "is no regular file" in refusal(REPLY, KAL, Path("/dev/null"))


def test_nothing_is_left_in_the_temporary_folder(scratch: Path, tmp_path: Path) -> None:
    render(REPLY, KAL, tmp_path / "out.wav")
    cached_speech(REPLY, KAL)
    assert list(scratch.iterdir()) == []


def test_a_text_keeps_the_letters_of_its_language(tmp_path: Path) -> None:
    assert speakable("¡Señal,\n más!", "espeak-ng:es") == "¡Señal, más!"
    assert speakable("стоп", "espeak-ng:ru") == "стоп"
    render("señal", "espeak-ng:es", tmp_path / "n.wav")
    render("senal", "espeak-ng:es", tmp_path / "plain.wav")
    one, other = (soundfile.read(tmp_path / name)[0] for name in ("n.wav", "plain.wav"))
    assert len(one) != len(other)


@pytest.mark.parametrize(
    "voice", ["espeak-ng:", "espeak-ng:../es", "espeak-ng:-w", "espeak-ng:a b"]
)
def test_a_name_that_is_no_voice_is_refused(voice: str) -> None:
    with pytest.raises(SpeechError, match="is unknown"):
        check_known(voice)


def test_a_voice_that_espeak_does_not_have_is_one_clear_line(tmp_path: Path) -> None:
    with pytest.raises(SpeechError, match="has no such voice"):
        render("hola", "espeak-ng:nobody", tmp_path / "x.wav")
    assert not list(tmp_path.iterdir())


def test_without_espeak_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SpeechError, match="apt-get install espeak-ng"):
        render("hola", "espeak-ng:es", tmp_path / "x.wav")


def test_a_cached_reply_needs_no_festival(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = cached_speech(REPLY, KAL)
    monkeypatch.setenv("PATH", "")
    assert cached_speech(f"  {REPLY}\n", KAL) == first
    assert list(cache.iterdir()) == [first]


def test_whether_a_reply_is_cached_is_known() -> None:
    assert not is_cached(REPLY, KAL)
    cached_speech(REPLY, KAL)
    assert is_cached(f"  {REPLY}\n", KAL)
    assert not is_cached(REPLY, "ked_diphone")


@pytest.mark.slow
def test_another_text_or_voice_has_its_own_file() -> None:
    files = {cached_speech("stop", KAL), cached_speech("stop now", KAL)}
    files |= {cached_speech("stop", voice) for voice in installed_voices()}
    assert len(files) == len(installed_voices()) + 1


def test_a_damaged_cache_file_is_rendered_anew() -> None:
    wav = cached_speech(REPLY, KAL)
    whole = wav.read_bytes()
    changed = bytearray(whole)
    changed[-1] ^= 1
    for damaged in (b"", whole[:-1000], b"x" * 5000, changed):
        wav.write_bytes(damaged)
        assert cached_speech(REPLY, KAL) == wav
        assert wav.read_bytes() == whole


@pytest.mark.parametrize("whole", [True, False])
def test_a_link_in_the_cache_is_replaced_and_not_what_it_points_to(
    whole: bool, tmp_path: Path
) -> None:
    wav = cached_speech(REPLY, KAL)
    precious = tmp_path / "precious"
    precious.write_bytes(wav.read_bytes() if whole else b"precious")
    before = precious.read_bytes()
    wav.unlink()
    wav.symlink_to(precious)
    assert cached_speech(REPLY, KAL) == wav
    assert not wav.is_symlink()
    assert precious.read_bytes() == before


def test_a_pipe_in_the_cache_is_not_waited_for() -> None:
    wav = cached_speech(REPLY, KAL)
    wav.unlink()
    os.mkfifo(wav)
    assert is_cached(REPLY, KAL)
    assert soundfile.info(cached_speech(REPLY, KAL)).frames > 0


def test_the_cache_of_another_user_is_not_used(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cached_speech(REPLY, KAL)
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    assert cached_speech(REPLY, KAL).parent != cache


def test_a_cache_that_cannot_be_written_is_done_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    wav = cached_speech(REPLY, KAL)
    assert soundfile.info(wav).frames > 0
    assert cached_speech(REPLY, KAL) == wav


def test_a_relative_cache_folder_is_ignored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cached_speech(REPLY, KAL).parent == tmp_path / ".cache" / "voz" / "speech"


@pytest.mark.slow
def test_many_at_once_do_not_harm_each_other(cache: Path) -> None:
    call = f"cached_speech({REPLY!r}, {KAL!r})"
    script = f"from voz.speech.synthesis import cached_speech; print({call})"

    def run(_: int) -> str:
        command = [sys.executable, "-c", script]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    with ThreadPoolExecutor(4) as pool:
        paths = set(pool.map(run, range(4)))
    assert len(paths) == 1
    assert [str(path) for path in cache.iterdir()] == [paths.pop().strip()]
    assert soundfile.info(next(cache.iterdir())).frames > 0
