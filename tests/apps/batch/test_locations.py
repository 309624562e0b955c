"""Recordings and outputs that are elsewhere: in fsspec's memory, and on a web server."""

from __future__ import annotations

import http.server
import sys
from collections.abc import Callable, Generator, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import fsspec
import pytest
from calls import in_process
from recordings import FIXTURES, GO_BACK

from voz.apps.batch.batch_decoder import BatchDecoder, Finished
from voz.apps.batch.fingerprint import Header
from voz.apps.batch.locations import exists, journal_path, local_recording
from voz.apps.batch.outcomes import ErrorRow, Outcome
from voz.apps.batch.output import ResumeOptions, decode_to_output, merge
from voz.apps.batch.worker import WorkerSetup
from voz.errors import AudioError, ConfigError
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
    monkeypatch.setattr("voz.apps.batch.locations.MOST_FETCHED_BYTES", 1000)
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


HEADER = Header("0.1.0", "print", "commands", "models", Recognition())
NAMES = [str(GO_BACK), str(FIXTURES / "none.wav")]


class Store(http.server.BaseHTTPRequestHandler):
    """Keeps what is put there, as stores of objects do."""

    objects: dict[str, bytes]
    closed = False

    def do_PUT(self) -> None:
        data = b""
        while size := int(self.rfile.readline(), 16):
            data += self.rfile.read(size)
            self.rfile.readline()
        self.rfile.readline()
        if not self.closed:
            self.objects[self.path] = data
        self.send_response(403 if self.closed else 201)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def do_GET(self) -> None:
        data = self.objects.get(self.path)
        self.send_response(404 if data is None else 200)
        self.send_header("Content-Length", str(len(data or b"")))
        self.end_headers()
        if self.command == "GET":
            self.wfile.write(data or b"")

    do_HEAD = do_GET  # noqa: N815

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def store(serve: Callable[[type[Store]], str]) -> tuple[str, type[Store]]:
    handler = type("_", (Store,), {"objects": {}})
    return serve(handler), handler


@pytest.fixture(autouse=True)
def working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def voz(voz: Any, inline: None, tmp_path: Path) -> Any:
    return partial(voz, cwd=tmp_path)


def decode(output: str, resume: bool = False) -> list[int]:
    """Decode two recordings, of which one is not there; tells which it did not know yet."""
    many = BatchDecoder(WorkerSetup(str(PACKAGED_FOLDER), Recognition(use_network=False)), jobs=1)
    asked: list[int] = []

    def some(numbers: list[int]) -> Generator[Finished, None, None]:
        asked.extend(numbers)
        return many.decode(NAMES, numbers)

    options = ResumeOptions(resume, False, False, notice=lambda _: None)
    decode_to_output(output, HEADER, NAMES, some, options, manifest={}, on_outcome=lambda _: None)
    return asked


@pytest.fixture
def on_the_disk(tmp_path: Path) -> bytes:
    decode(str(tmp_path / "disk.jsonl"))
    return (tmp_path / "disk.jsonl").read_bytes()


def test_memory_gets_what_the_disk_gets(on_the_disk: bytes) -> None:
    output = "memory://heard/all.jsonl"
    assert not exists(output)
    assert decode(output) == [0, 1]
    assert exists(output)
    with fsspec.open(output, "rb") as file:
        assert file.read() == on_the_disk
    assert decode(output, resume=True) == []
    assert not journal_path(output).exists()


def test_an_address_that_is_no_text_is_known_again(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(sys.modules[__name__], "NAMES", ["memory://\udcff.wav"])
    output = str(tmp_path / "heard.jsonl")
    assert decode(output) == [0]
    assert decode(output, resume=True) == []
    assert (tmp_path / "heard.jsonl").read_text().startswith('{"file":"memory://\\\\udcff.wav"')


def test_what_cannot_be_written_loses_nothing(
    store: tuple[str, type[Store]], on_the_disk: bytes, tmp_path: Path
) -> None:
    address, handler = store
    output = f"{address}/heard.jsonl"
    handler.closed = True
    with pytest.raises(ConfigError, match=r"heard.jsonl: cannot be written \(403.*with --resume"):
        decode(output)
    assert journal_path(output).resolve().parent == tmp_path
    handler.closed = False
    assert decode(output, resume=True) == []
    assert handler.objects == {"/heard.jsonl": on_the_disk}
    assert not journal_path(output).exists()


@pytest.mark.parametrize("there", [False, True])
def test_what_another_run_wrote_meanwhile_is_not_written_over(
    there: bool, on_the_disk: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    output = (tmp_path / "bucket" / "heard.jsonl").as_uri()
    path = tmp_path / "bucket" / "heard.jsonl"
    path.parent.mkdir()
    if there:
        decode(output)
    known = BatchDecoder.decode

    def while_another_runs(self: BatchDecoder, *arguments: Any) -> Iterator[object]:
        yield from known(self, *arguments)
        path.write_text("of another run")

    monkeypatch.setattr(BatchDecoder, "decode", while_another_runs)
    with pytest.raises(
        ConfigError, match=r"was written by another run meanwhile; .* with --resume"
    ):
        decode(output)
    assert path.read_text() == "of another run"
    path.unlink()
    assert decode(output, resume=True) == []
    assert path.read_bytes() == on_the_disk


def test_an_unknown_address_is_refused_before_the_work(voz: Any) -> None:
    result = voz("decode", GO_BACK, "--out", "nonesuch://bucket/heard.jsonl")
    assert "nonesuch://bucket/heard.jsonl: cannot be opened" in result.complaint
    result = voz("decode", GO_BACK, "--out", "memory://bucket/heard.txt")
    assert "memory://bucket/heard.txt: end it with .jsonl, .csv, .parquet" in result.complaint


def test_an_object_is_replaced_only_if_asked(voz: Any, store: tuple[str, type[Store]]) -> None:
    address, handler = store
    output = f"{address}/heard.jsonl"
    handler.objects["/heard.jsonl"] = b"mine"
    given = ("decode", GO_BACK, "--no-network", "--jobs", "1", "--out", output)
    assert f"{output}: is there already; continue it" in voz(*given).complaint
    assert handler.objects == {"/heard.jsonl": b"mine"}
    assert voz(*given, "--overwrite").code == 0
    assert handler.objects["/heard.jsonl"] != b"mine"


@pytest.mark.slow
def test_shards_elsewhere_are_merged_to_elsewhere(
    voz: Any, store: tuple[str, type[Store]], tmp_path: Path
) -> None:
    address, handler = store
    given = ("decode", GO_BACK.parent, "--glob", "festival_ked*", "--no-network", "--jobs", "1")
    places = [f"{address}/shards/1.parquet", f"{address}/shards/2.csv"]
    for number, place in enumerate(places, start=1):
        assert voz(*given, "--shard", f"{number}/2", "--out", place).code == 0
    assert voz(*given, "--out", tmp_path / "whole.jsonl").code == 0
    missing = voz("merge", places[0], f"{address}/none.csv", "--out", tmp_path / "merged.jsonl")
    assert missing.complaint.startswith(f"voz: {address}/none.csv: cannot be fetched")
    result = voz("merge", *places, "--out", f"{address}/heard.jsonl")
    assert (result.code, result.err) == (0, f"written: {address}/heard.jsonl, 14 recordings\n")
    whole = (tmp_path / "whole.jsonl").read_bytes()
    assert handler.objects["/heard.jsonl"] == whole
    assert merge(places, "memory://merged/heard.jsonl") == 14
    with fsspec.open("memory://merged/heard.jsonl", "rb") as file:
        assert file.read() == whole
