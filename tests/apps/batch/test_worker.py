from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from recordings import FIXTURES, GO_BACK

from voz.apps.batch import worker
from voz.apps.batch.decoding import decode_recording
from voz.apps.batch.outcomes import Outcome
from voz.apps.batch.stamps import check_stamps
from voz.apps.batch.worker import WorkerSetup, work
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
