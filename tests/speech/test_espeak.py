"""Voices of espeak-ng, the real program."""

from __future__ import annotations

from pathlib import Path

import pytest
import soundfile

from voz.errors import SpeechError
from voz.speech.festival import check_known, render, speakable
from voz.speech.speech_cache import cached_speech, is_cached


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


def test_what_was_said_once_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = cached_speech("ya no escucho", "espeak-ng:es")
    assert cached_speech("ya no  escucho", "espeak-ng:es") == first
    assert is_cached("ya no escucho", "espeak-ng:es")
    assert not is_cached("ya no escucho", "espeak-ng:es-419")


def test_without_espeak_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SpeechError, match="apt-get install espeak-ng"):
        render("hola", "espeak-ng:es", tmp_path / "x.wav")
