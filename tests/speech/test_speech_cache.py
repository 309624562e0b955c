"""What was rendered once is kept, and what is wrong with it is noticed."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import soundfile

from voz.speech import speech_cache
from voz.speech.festival import installed_voices
from voz.speech.speech_cache import cached_speech, is_cached

REPLY = "bep bep. I am listening you"
KAL = "kal_diphone"


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


@pytest.mark.parametrize("harm", ["emptied", "cut", "overwritten", "changed in one bit"])
def test_a_damaged_cache_file_is_rendered_anew(harm: str) -> None:
    wav = cached_speech(REPLY, KAL)
    whole = wav.read_bytes()
    changed = bytearray(whole)
    changed[-1] ^= 1
    damaged = {"emptied": b"", "cut": whole[:-1000], "overwritten": b"x" * 5000}
    wav.write_bytes(damaged.get(harm, changed))
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
    speech_cache._private_folder.cache_clear()
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    assert cached_speech(REPLY, KAL).parent != cache


def test_a_cache_that_cannot_be_written_is_done_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    speech_cache._private_folder.cache_clear()
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
    script = f"from voz.speech.speech_cache import cached_speech; print({call})"

    def run(_: int) -> str:
        command = [sys.executable, "-c", script]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    with ThreadPoolExecutor(4) as pool:
        paths = set(pool.map(run, range(4)))
    assert len(paths) == 1
    assert [str(path) for path in cache.iterdir()] == [paths.pop().strip()]
    assert soundfile.info(next(cache.iterdir())).frames > 0
