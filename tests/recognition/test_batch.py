"""Many recordings: each as if it were alone, and the bad ones are one line each."""

from __future__ import annotations

from pathlib import Path

from recordings import Recording

from voz.recognition.batch import Decoded, Unreadable, decode_recordings
from voz.recognition.recognizer import Recognizer


def test_an_unreadable_recording_does_not_end_the_rest(
    recognizer: Recognizer, recordings: list[Recording], tmp_path: Path
) -> None:
    good = [r.path for r in recordings if r.kind == "command"][:2]
    bad = tmp_path / "bad.wav"
    bad.write_text("no recording")
    results = list(decode_recordings(recognizer, [good[0], bad, good[1]]))
    assert [type(r) for r in results] == [Decoded, Unreadable, Decoded]
    assert results[1].file == str(bad)


def test_results_do_not_hang_on_the_order(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    paths = [r.path for r in recordings if r.kind != "long"][::7]
    there = list(decode_recordings(recognizer, paths))
    back = list(decode_recordings(recognizer, paths[::-1]))
    assert sorted(map(repr, there)) == sorted(map(repr, back))
