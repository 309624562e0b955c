"""Many recordings: each as if it were alone, and the bad ones are one line each."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
import soundfile
from recordings import Recording

from voz.api.recognizer import Recognizer
from voz.apps.batch.decoding import decode_recording, piped_blocks
from voz.apps.batch.outcomes import ErrorRow, SilentRow, UtteranceRow
from voz.errors import AudioError


def test_an_unreadable_recording_does_not_end_the_rest(
    recognizer: Recognizer, recordings: list[Recording], tmp_path: Path
) -> None:
    good = [r.path for r in recordings if r.kind == "command"][:2]
    bad = tmp_path / "bad.wav"
    bad.write_text("no recording")
    outcomes = [decode_recording(recognizer, path) for path in (good[0], bad, good[1])]
    assert [type(o.rows[0]) for o in outcomes] == [UtteranceRow, ErrorRow, UtteranceRow]
    assert [o.failed for o in outcomes] == [False, True, False]
    assert outcomes[1].rows[0].file == str(bad)


def test_a_recording_with_nothing_in_it_has_a_row(recognizer: Recognizer, tmp_path: Path) -> None:
    soundfile.write(tmp_path / "silence.wav", [0.0] * 24000, 16000)
    outcome = decode_recording(recognizer, tmp_path / "silence.wav")
    assert outcome.rows == (SilentRow(str(tmp_path / "silence.wav"), 1.5),)


def test_results_do_not_hang_on_the_order(
    recognizer: Recognizer, recordings: list[Recording]
) -> None:
    paths = [r.path for r in recordings if r.kind != "long"][::7]
    there = [decode_recording(recognizer, path).rows for path in paths]
    back = [decode_recording(recognizer, path).rows for path in paths[::-1]]
    assert there == back[::-1]


def test_more_channels_than_sound_has_are_refused_before_a_block_is_made(
    tmp_path: Path,
) -> None:
    channels, rate, width = 1000, 768_000, 2
    layout = struct.pack("<HHIIHH", 1, channels, rate, 0, channels * width, 8 * width)
    chunks = b"WAVEfmt " + struct.pack("<I", len(layout)) + layout + b"data\xff\xff\xff\x7f"
    (tmp_path / "pipe").write_bytes(b"RIFF\xff\xff\xff\x7f" + chunks + bytes(1000))
    with (tmp_path / "pipe").open("rb") as stream, pytest.raises(AudioError) as raised:
        list(piped_blocks(stream, None))
    assert str(raised.value) == "-: has 1000 channels; pipe one"
