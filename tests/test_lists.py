"""The other command lists of audio_fixtures/lists/ can be built, spoken and understood."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import soundfile
from make_fixtures import LISTS, lines, list_clips, list_names
from recordings import ROOT
from synthesis import Fixture, speak, write

from voz.api.recognizer import Recognizer
from voz.apps.batch.decoding import decode_recording
from voz.apps.batch.outcomes import UtteranceRow
from voz.apps.recordings.manifest import read_manifest
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.language.pronunciation import GUESS_ORIGIN
from voz.settings import Recognition

CLEAR_VOICES = ("flite_slt", "flite_rms")

every_list = pytest.mark.parametrize("name", ["arm", "drone", "home"])


def near_misses(name: str) -> list[str]:
    return lines(LISTS / f"{name}.near_misses.txt")


def some_clips(name: str) -> list[Fixture]:
    """Every eighth command, by two voices that are quick and clear."""
    commands = lines(LISTS / f"{name}.txt")[::8]
    clips = list_clips(name)
    return [c for c in clips if c.text in commands and c.voice in CLEAR_VOICES]


def test_these_are_all_lists() -> None:
    assert list_names() == ["arm", "drone", "home"]


@every_list
def test_a_list_has_ten_to_forty_commands_of_one_to_five_words(name: str) -> None:
    commands = lines(LISTS / f"{name}.txt")
    assert 10 <= len(set(commands)) == len(commands) <= 40
    assert "stop" in commands
    assert {len(command.split()) for command in commands} == {1, 2, 3, 4, 5}


@every_list
def test_its_near_misses_are_none_of_its_commands(name: str) -> None:
    texts = near_misses(name)
    assert len(set(texts)) == len(texts) == 25
    assert set(texts).isdisjoint(lines(LISTS / f"{name}.txt"))


@every_list
def test_every_word_of_a_list_is_in_the_dictionary(name: str, tmp_path: Path) -> None:
    built = build(LISTS / f"{name}.txt", tmp_path)
    assert built.sentences == len(lines(LISTS / f"{name}.txt"))
    assert not [warning for warning in built.warnings if "no dictionary" in warning]
    assert GUESS_ORIGIN not in LanguageFiles(tmp_path).pronounce_log.read_text()


@every_list
def test_all_voices_say_each_command_and_two_each_near_miss(name: str) -> None:
    clips = list(list_clips(name))
    said = [clip.text for clip in clips]
    assert {said.count(command) for command in lines(LISTS / f"{name}.txt")} == {8}
    assert {said.count(text) for text in near_misses(name)} == {2}
    assert len({clip.file for clip in clips}) == len(clips)


@pytest.mark.slow
@every_list
def test_spoken_commands_of_a_list_are_understood(name: str, tmp_path: Path) -> None:
    clips = some_clips(name)
    write(tmp_path, [(clip, clip.samples()) for clip in clips])
    build(LISTS / f"{name}.txt", tmp_path)
    recognizer = Recognizer(LanguageFiles(tmp_path), Recognition())
    recordings = read_manifest(tmp_path / "manifest.tsv")
    heard = [decode_recording(recognizer, recording.path) for recording in recordings]
    rows = [row for outcome in heard for row in outcome.rows]
    assert [row.text for row in rows if isinstance(row, UtteranceRow)] == [
        r.text for r in recordings
    ]
    assert len(recordings) == len(clips) >= 6


def test_a_clip_is_the_same_every_time(tmp_path: Path) -> None:
    clip = next(clip for clip in list_clips("arm") if clip.voice == "flite_rms")
    for folder in (tmp_path / "one", tmp_path / "two"):
        speak.cache_clear()
        write(folder, [(clip, clip.samples())])
    one, two = (soundfile.read(tmp_path / folder / clip.file)[0] for folder in ("one", "two"))
    assert (one == two).all()


def test_a_list_goes_without_another_folder(tmp_path: Path) -> None:
    script = str(ROOT / "tools" / "make_fixtures.py")
    run = subprocess.run(
        [sys.executable, script, "--lists", str(tmp_path), "--output", str(tmp_path)],
        capture_output=True,
        text=True,
    )
    assert run.returncode == 2
    assert run.stderr.splitlines() == [
        "--lists goes without --output and --commands; name the folder by it"
    ]
