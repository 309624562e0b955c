"""The other command lists of audio_fixtures/lists/ can be built, spoken and understood."""

from __future__ import annotations

from pathlib import Path

import pytest
from make_fixtures import LISTS, lines, list_clips
from synthesis import Fixture, write

from voz.api.recognizer import Recognizer
from voz.apps.batch.outcomes import UtteranceRow
from voz.apps.batch.worker import decode_recording
from voz.apps.recordings.manifest import read_manifest
from voz.language.build import build
from voz.language.language_files import LanguageFiles
from voz.language.pronunciation import GUESS_ORIGIN
from voz.settings import Recognition

CLEAR_VOICES = ("flite_slt", "flite_rms")

every_list = pytest.mark.parametrize("name", ["arm", "drone", "home"])


def some_clips(name: str) -> list[Fixture]:
    """Every eighth command, by two voices that are quick and clear."""
    commands = lines(LISTS / f"{name}.txt")[::8]
    clips = list_clips(name)
    return [c for c in clips if c.text in commands and c.voice in CLEAR_VOICES]


@every_list
def test_every_word_of_a_list_is_in_the_dictionary(name: str, tmp_path: Path) -> None:
    built = build(LISTS / f"{name}.txt", tmp_path)
    assert built.sentences == len(lines(LISTS / f"{name}.txt"))
    assert not [warning for warning in built.warnings if "no dictionary" in warning]
    assert GUESS_ORIGIN not in LanguageFiles(tmp_path).pronounce_log.read_text()


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
