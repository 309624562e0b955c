"""What a worker does: each recording as if it were alone, and the bad ones are one line each."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
import soundfile
from recordings import FIXTURES, GO_BACK, Recording

from voz.api.recognizer import Recognizer
from voz.apps.batch import worker
from voz.apps.batch.outcomes import ErrorRow, Outcome, SilentRow, UtteranceRow
from voz.apps.batch.stamps import check_stamps
from voz.apps.batch.worker import WorkerSetup, decode_recording, work
from voz.language.language_files import PACKAGED_FOLDER
from voz.settings import Recognition

OTHER = FIXTURES / "commands" / "festival_slt__stop.flac"


@pytest.mark.parametrize("changes", [False, True])
def test_what_changes_while_it_is_decoded_has_the_stamp_of_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changes: bool
) -> None:
    path = tmp_path / "a.flac"
    shutil.copy(GO_BACK, path)

    def meanwhile(*given: object) -> Outcome:
        outcome: Outcome = decode_recording(*given)  # type: ignore[arg-type]
        if changes:
            shutil.copy(OTHER, path)
        return outcome

    monkeypatch.setattr(worker, "decode_recording", meanwhile)
    setup = WorkerSetup(str(PACKAGED_FOLDER), Recognition(use_network=False))
    (outcome,) = work(setup, [str(path)])
    looked = list(check_stamps([str(path)], [(0, outcome.stamp)]))
    assert [each.changed for each in looked] == ([True] if changes else [])


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
