"""Recordings that are elsewhere: in fsspec's memory, and on a web server."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import fsspec
import pytest
from calls import in_process
from recordings import GO_BACK

from voz.apps.batch.batch_decoder import BatchDecoder
from voz.apps.batch.outcomes import ErrorRow, Outcome
from voz.apps.batch.remote import local_recording
from voz.apps.batch.tasks import WorkerSetup
from voz.errors import AudioError
from voz.language.language_files import PACKAGED_FOLDER
from voz.settings import Recognition


@pytest.fixture
def server(serve: Callable[[Path], str]) -> str:
    """A web server with the recorded commands."""
    return serve(GO_BACK.parent)


def decoded(*names: str) -> list[Outcome]:
    many = BatchDecoder(WorkerSetup(str(PACKAGED_FOLDER), Recognition()), jobs=1)
    return [outcome for _, outcome in many.decode(names, range(len(names)))]


def test_memory_gives_what_the_disk_gives() -> None:
    with fsspec.open("memory://recordings/back.flac", "wb") as file:
        file.write(GO_BACK.read_bytes())
    there, here = decoded("memory://recordings/back.flac", str(GO_BACK))
    assert there.rows[0].file == "memory://recordings/back.flac"
    assert [row.text for row in there.rows] == [row.text for row in here.rows] == ["go back"]  # type: ignore[union-attr]


def test_what_is_wrong_elsewhere_is_named_as_the_user_did() -> None:
    with fsspec.open("memory://recordings/bad.wav", "wb") as file:
        file.write(b"no recording")
    expected = {
        "memory://recordings/bad.wav": "is no recording that can be read",
        "memory://none.wav": "cannot be fetched",
        "nonesuch://a.wav": "cannot be fetched",
    }
    for outcome, (name, said) in zip(decoded(*expected), expected.items(), strict=True):
        (row,) = outcome.rows
        assert isinstance(row, ErrorRow)
        assert row.error.startswith(f"{name}: {said}")


def test_what_has_no_end_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("voz.apps.batch.remote.MOST_FETCHED_BYTES", 1000)
    with fsspec.open("memory://large.wav", "wb") as file:
        file.write(bytes(1001))
    with pytest.raises(AudioError, match="is larger than"), local_recording("memory://large.wav"):
        pass


@pytest.mark.slow
def test_a_web_server_is_read_by_the_workers(server: str, tmp_path: Path) -> None:
    names = sorted(path.name for path in GO_BACK.parent.glob("festival_slt*"))
    given = [f"{server}/{name}" for name in [*names, "none.flac"]]
    out = tmp_path / "heard.jsonl"
    result = in_process("decode", *given, "--jobs", "2", "--out", out)
    assert result.code == 3
    text = out.read_text()
    assert text.count('"accepted":true') == len(names)
    assert f"{server}/none.flac: cannot be fetched" in text
