"""`voz decode`: what it prints, and its exit codes."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import soundfile
from calls import HANGS, VOZ, in_process
from recordings import FIXTURES, GO_BACK, Recording

from voz.apps.batch.formats import read_results
from voz.apps.batch.outcomes import column_name
from voz.language.language_files import PACKAGED_FOLDER


def test_decode_writes_a_line_of_json_for_each_utterance(voz: Any, session: Recording) -> None:
    result = voz("decode", "--json", session.path, GO_BACK)
    assert result.code == 0
    assert [line["text"] for line in result.json] == [*session.commands, "go back"]
    assert {tuple(line) for line in result.json} == {
        ("file", "start", "end", "text", "confidence", "accepted", "score", "next_best")
    }
    assert result.json[-1]["file"] == str(GO_BACK)


def test_decode_shows_a_table(voz: Any) -> None:
    header, row = voz("decode", GO_BACK).out.splitlines()
    assert header.split() == ["start", "end", "sure", "accepted", "text", "file"]
    assert row.split()[3:] == ["yes", "go", "back", str(GO_BACK)]


def test_words_and_what_fits_best_are_shown_if_asked_for(voz: Any) -> None:
    (row,) = voz("decode", "--json", "--words", "--best", "3", GO_BACK).json
    assert [each["word"] for each in row["words"]] == ["go", "back"]
    assert row["start"] < row["words"][1]["start"] < row["words"][1]["end"] < row["end"] + 0.2
    assert [each["text"] for each in row["best"]][:2] == ["go back", row["next_best"]]
    _, _, *best, words = voz("decode", "--words", "--best", "3", GO_BACK).out.splitlines()
    assert [line.split() for line in best] == [
        [f"{each['confidence']:.2f}", *each["text"].split()] for each in row["best"]
    ]
    assert words.split() == [
        *("go", "{start:.2f}-{end:.2f},".format(**row["words"][0])),
        *("back", "{start:.2f}-{end:.2f}".format(**row["words"][1])),
    ]


def test_words_are_kept_for_praat_and_sclite(voz: Any, tmp_path: Path) -> None:
    out, grids = tmp_path / "heard.ctm", tmp_path / "grids"
    call = ("decode", GO_BACK, "--out", out, "--textgrids", grids)
    assert voz(*call).code == 0
    _, *lines = out.read_text().splitlines()
    assert [line.split()[4] for line in lines] == ["go", "back"]
    (grid,) = grids.iterdir()
    assert f"xmin = {lines[1].split()[2][:-1]}" in grid.read_text()
    assert f"{grid}: is there already" in voz(*call).complaint
    assert "has words alone, and is not read back" in voz(*call, "--resume").complaint
    wrong = voz("decode", GO_BACK, "--out", tmp_path / "heard.TextGrid").complaint
    assert "each recording has a TextGrid of its own; write them with --textgrids DIR" in wrong


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


def test_names_that_are_not_utf_8(voz: Any, tmp_path: Path) -> None:
    odd = tmp_path / os.fsdecode(b"\xff.flac")
    shutil.copy(GO_BACK, odd)
    assert voz("decode", "--json", odd).json[0]["file"] == rf"{tmp_path}/\xff.flac"
    folder = tmp_path / os.fsdecode(b"\xfe")
    shutil.copytree(PACKAGED_FOLDER, folder)
    assert rf"{tmp_path}/\xfe: not a UTF-8 name" in voz("decode", "--lm", folder, odd).complaint


@pytest.mark.parametrize("path", ["/dev/zero", "/proc/self/mem", "x" * 5000])
def test_what_is_no_file_of_sound_is_one_line(voz: Any, path: str) -> None:
    (line,) = voz("decode", "--json", path).json
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


def test_silence_is_a_row_and_no_error(voz: Any, tmp_path: Path) -> None:
    path = tmp_path / "silence.wav"
    soundfile.write(path, [0.0] * 16000, 16000)
    result = voz("decode", "--json", path)
    assert (result.code, result.json, result.err) == (0, [{"file": str(path), "seconds": 1.0}], "")
    shown = voz("decode", path).out.splitlines()[1]
    assert shown.split() == ["1.00", "(nothing", "is", "said)", str(path)]


def test_a_threshold_and_the_trigram_model_can_be_chosen(voz: Any) -> None:
    (strict,) = voz("decode", "--json", "--threshold", "1", GO_BACK).json
    assert not strict["accepted"]
    (trigram,) = voz("decode", "--json", "--search", "lm", GO_BACK).json
    assert trigram["text"] == "go back"


def folder_of(tmp_path: Path, recordings: list[Recording]) -> Path:
    """Recordings in folders in a folder, one of them bad, beside what is none."""
    folder = tmp_path / "recordings"
    for number, recording in enumerate(recordings):
        inside = folder / f"day{number % 3}"
        inside.mkdir(parents=True, exist_ok=True)
        shutil.copy(recording.path, inside / f"{number:03}.flac")
    (folder / "day1" / "notes.txt").write_text("no recording")
    (folder / "day2" / "bad.wav").write_text("no recording either")
    return folder


@pytest.mark.slow
def test_a_folder_is_decoded_by_many_in_order_as_by_one(
    tmp_path: Path, recordings: list[Recording]
) -> None:
    folder = folder_of(tmp_path, [r for r in recordings if r.kind == "command"][::9])
    many = in_process("decode", "--json", "--jobs", "3", folder)
    one = in_process("decode", "--json", "--jobs", "1", folder)
    assert (many.code, many.out) == (one.code, one.out)
    assert many.code == 3
    files = list(dict.fromkeys(line["file"] for line in many.json))
    assert files == sorted(str(path) for path in folder.rglob("*.[fw][la]*"))


def test_which_files_of_a_folder_can_be_told(
    voz: Any, tmp_path: Path, recordings: list[Recording]
) -> None:
    folder = folder_of(tmp_path, recordings[:3])
    lines = voz("decode", "--json", "--jobs", "1", folder, "--glob", "day0/*").json
    assert [line["file"] for line in lines] == [str(folder / "day0" / "000.flac")]
    assert voz("decode", folder, "--glob", "*.mp3").err.endswith("no file that matches *.mp3\n")


def test_a_list_of_names_comes_on_standard_input(recordings: list[Recording]) -> None:
    names = "".join(f"{r.path}\n" for r in recordings[:2])
    lines = in_process("decode", "--json", "-", input=names).json
    assert [line["file"] for line in lines] == [str(r.path) for r in recordings[:2]]


@pytest.fixture
def piped(voz: Any, monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[dict[str, Any]]]:
    """Decode what comes through a pipe."""

    def decode(sound: bytes, *arguments: object) -> list[dict[str, Any]]:
        with tempfile.TemporaryFile() as file:
            file.write(sound)
            file.seek(0)
            with (
                subprocess.Popen(["cat"], stdin=file, stdout=subprocess.PIPE, text=True) as cat,
                monkeypatch.context() as patched,
            ):
                patched.setattr(sys, "stdin", cat.stdout)
                done = voz("decode", "--json", "-", *arguments)
        assert done.code == 0, done.err
        lines: list[dict[str, Any]] = done.json
        return lines

    return decode


@pytest.mark.slow
def test_a_wav_or_samples_come_on_standard_input(voz: Any, piped: Any, session: Recording) -> None:
    known = [line | {"file": "-"} for line in voz("decode", "--json", session.path).json]
    assert piped(session.path.read_bytes()) == known
    assert piped(session.samples().tobytes(), "--rate", 16000) == known
    done = subprocess.run(
        [*VOZ, "decode", "--json", "-"], input=session.path.read_bytes(), capture_output=True
    )
    assert [json.loads(line) for line in done.stdout.splitlines()] == known


def test_a_wav_on_standard_input_is_shown_while_it_goes_on(session: Recording) -> None:
    command = [*VOZ, "decode", "--json", "-"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as program:
        assert program.stdin is not None
        assert program.stdout is not None
        program.stdin.write(session.path.read_bytes()[: 16000 * 2 * 5])
        program.stdin.flush()
        assert json.loads(program.stdout.readline())["text"] == session.commands[0]
        program.kill()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("format_", "subtype"),
    [
        ("WAV", "PCM_U8"),
        ("WAV", "PCM_24"),
        ("WAVEX", "PCM_24"),
        ("WAVEX", "PCM_32"),
        ("WAVEX", "DOUBLE"),
        ("WAV", "FLOAT"),
        ("RF64", "PCM_16"),
        ("FLAC", "PCM_16"),
        ("OGG", "VORBIS"),
        ("MP3", "MPEG_LAYER_III"),
    ],
)
def test_what_a_file_may_be_a_pipe_may(
    piped: Any, format_: str, subtype: str, tmp_path: Path
) -> None:
    sound, rate = soundfile.read(GO_BACK)
    soundfile.write(tmp_path / "a", sound, rate, subtype, format=format_)
    assert [line["text"] for line in piped((tmp_path / "a").read_bytes())] == ["go back"]


@pytest.mark.slow
@pytest.mark.parametrize("output", [False, True])
def test_recordings_of_other_formats_in_a_folder_are_named(
    voz: Any, output: bool, tmp_path: Path
) -> None:
    (folder := tmp_path / "takes").mkdir()
    shutil.copy(GO_BACK, folder / "a.flac")
    (folder / "a.m4a").touch()  # a.flac was made of it
    (folder / "notes.txt").touch()
    out = ["--out", tmp_path / "h.jsonl"] if output else []
    assert voz("decode", folder, *out).code == 0
    (folder / "b.M4A").touch()
    result = voz("decode", folder, *out, *(["--overwrite"] if output else []))
    assert result.code == 3
    assert f"warning: left out, as voz does not read the format: {folder}/b.M4A" in result.err
    assert f"ffmpeg -i {folder}/b.M4A {folder}/b.wav" in result.err


def test_sound_on_standard_input_that_cannot_be_used_is_a_line(tmp_path: Path) -> None:
    command = [*VOZ, "decode", "--json", "-"]
    done = subprocess.run(command, input=b"RIFF1234WAVEnone", capture_output=True, timeout=HANGS)
    assert done.returncode == 3
    assert json.loads(done.stdout)["error"].startswith("-: is no recording that can be read")


def test_samples_without_their_rate_are_no_list_of_thousands_of_names(session: Recording) -> None:
    command = [*VOZ, "decode", "-"]
    sound = session.samples().tobytes()
    done = subprocess.run(command, input=sound, capture_output=True, timeout=HANGS)
    assert done.returncode == 2
    assert done.stdout == b""
    assert done.stderr.startswith(b"voz: -: is no list, a name a line; pipe a recording")


def test_a_name_that_never_ends_on_standard_input_is_a_line() -> None:
    command = ["sh", "-c", 'yes | tr -d "\\n" | "$@"', "sh", *VOZ, "decode", "-"]
    done = subprocess.run(command, capture_output=True, timeout=HANGS)
    assert (done.returncode, done.stdout) == (2, b"")
    assert done.stderr.startswith(b"voz: -: is no list, a name a line; pipe a recording")


@pytest.mark.slow
def test_a_manifest_is_scored(voz: Any, tmp_path: Path) -> None:
    head, *rows = (FIXTURES / "manifest.tsv").read_text().splitlines()
    some = [f"{FIXTURES}/{row}" for row in rows[::9]]
    (tmp_path / "manifest.tsv").write_text("\n".join([head, *some]))
    result = voz("decode", tmp_path / "manifest.tsv", "--out", tmp_path / "h.csv")
    assert result.code == 0
    heard = read_results(tmp_path / "h.csv").drop_duplicates("file")
    columns = [column_name(name) for name in head.split("\t")]
    assert list(heard.columns[-len(columns) :]) == columns
    assert heard[columns].fillna("").to_numpy().tolist() == [row.split("\t") for row in some]
    assert "written: " in result.err
    assert "right and accepted" in result.err
    assert f"{len(some)} recordings, 0.01 h of sound" in result.err


def test_an_output_is_named_by_its_ending(voz: Any, tmp_path: Path) -> None:
    complaint = voz("decode", GO_BACK, "--out", tmp_path / "heard.txt").complaint
    assert "end it with .jsonl, .csv, .parquet" in complaint


def test_to_go_on_needs_an_output(voz: Any) -> None:
    assert "name it with --out" in voz("decode", GO_BACK, "--resume").complaint


def test_the_network_can_be_left_out_by_its_old_name_too(voz: Any, tmp_path: Path) -> None:
    (settings := tmp_path / "voz.toml").write_text("[recognition]\nsecond_ear = false\n")
    for options, notice in (
        (["--no-network"], ""),
        (["--ears", "1"], "warning: --ears 1 is called --no-network\n"),
        (["--config", settings], f"warning: {settings}: [recognition] second_ear is called use_"),
    ):
        decoded = voz("decode", "--json", *options, GO_BACK)
        (line,) = decoded.json
        assert line["text"] == "go back"
        assert "score" not in line
        assert decoded.err.startswith(notice)
        assert len(decoded.err.splitlines()) == bool(notice)


def test_language_files_may_be_far_from_the_list_they_were_made_from(
    voz: Any, own_commands: Path, tmp_path: Path
) -> None:
    assert voz("build-lm", own_commands, "--out", tmp_path / "made").code == 0
    (heard,) = voz("decode", "--json", "--lm", tmp_path / "made", GO_BACK).json
    assert (heard["text"], heard["accepted"]) == ("go back", True)
