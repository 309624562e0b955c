"""`voz decode`: what it prints, and its exit codes."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import pytest
import soundfile
from calls import in_process
from recordings import GO_BACK, Recording

from voz.language.files import PACKAGED


def test_decode_writes_a_line_of_json_for_each_utterance(voz: Any, session: Recording) -> None:
    result = voz("decode", "--json", session.path, GO_BACK)
    assert result.code == 0
    assert [line["text"] for line in result.json] == [*session.commands, "go back"]
    assert {tuple(line) for line in result.json} == {
        ("file", "start", "end", "text", "confidence", "accepted", "ears")
    }
    assert result.json[-1]["file"] == str(GO_BACK)


def test_decode_shows_a_table(voz: Any) -> None:
    header, row = voz("decode", GO_BACK).out.splitlines()
    assert header.split() == ["start", "end", "sure", "accepted", "text", "file"]
    assert row.split()[3:] == ["yes", "go", "back", str(GO_BACK)]


def test_what_libraries_say_of_a_damaged_recording_is_not_seen(tmp_path: Path) -> None:
    samples, rate = soundfile.read(GO_BACK)
    path = tmp_path / "bad.mp3"
    soundfile.write(path, samples, rate, format="MP3")
    data = bytearray(path.read_bytes())
    for at in range(1000, len(data), 211):
        data[at] ^= 0x55
    path.write_bytes(data)
    result = in_process("decode", "--json", path)
    assert result.err == ""
    assert {line["file"] for line in result.json} == {str(path)}


def test_names_that_are_not_utf_8(tmp_path: Path) -> None:
    odd = tmp_path / os.fsdecode(b"\xff.flac")
    shutil.copy(GO_BACK, odd)
    assert in_process("decode", "--json", odd).json[0]["file"] == rf"{tmp_path}/\xff.flac"
    folder = tmp_path / os.fsdecode(b"\xfe")
    shutil.copytree(PACKAGED, folder)
    assert (
        rf"{tmp_path}/\xfe: is no name in UTF-8"
        in in_process("decode", "--lm", folder, odd).complaint
    )


@pytest.mark.parametrize("path", ["/dev/zero", "/proc/self/mem", "/", "x" * 5000])
def test_what_is_no_file_of_sound_is_one_line(path: str) -> None:
    (line,) = in_process("decode", "--json", path).json
    assert line["error"].startswith(f"{path}: ")


def test_an_unreadable_recording_is_a_line_and_the_exit_code_3(voz: Any, tmp_path: Path) -> None:
    (tmp_path / "bad.wav").write_text("no recording")
    result = voz("decode", "--json", tmp_path / "bad.wav", GO_BACK, tmp_path / "none.wav")
    assert result.code == 3
    assert [tuple(line)[:2] for line in result.json] == [
        ("file", "error"),
        ("file", "start"),
        ("file", "error"),
    ]


def test_silence_is_no_utterance_and_no_error(voz: Any, tmp_path: Path) -> None:
    soundfile.write(tmp_path / "silence.wav", [0.0] * 16000, 16000)
    result = voz("decode", "--json", tmp_path / "silence.wav")
    assert (result.code, result.out, result.err) == (0, "", "")


def test_a_threshold_and_the_trigram_model_can_be_chosen(voz: Any) -> None:
    (strict,) = voz("decode", "--json", "--threshold", "1", GO_BACK).json
    assert not strict["accepted"]
    (trigram,) = voz("decode", "--json", "--search", "lm", GO_BACK).json
    assert trigram["text"] == "go back"


def test_a_file_name_that_is_no_utf_8(tmp_path: Path) -> None:
    odd = os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9.flac")
    shutil.copy(GO_BACK, odd)
    result = in_process("decode", "--json", odd)
    assert result.code == 0
    assert result.json[0]["file"].endswith("caf\\xe9.flac")
