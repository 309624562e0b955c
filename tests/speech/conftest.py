"""Every test of speech has a cache of its own, and shows what it leaves in the temporary folder."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from voz.speech import synthesis


@pytest.fixture(autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    home = tmp_path_factory.mktemp("cache")
    monkeypatch.setenv("XDG_CACHE_HOME", str(home))
    monkeypatch.setattr(synthesis, "KNOWN_TEXTS", set())
    return home / "voz" / "speech"


@pytest.fixture(autouse=True)
def scratch(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path_factory.mktemp("scratch")
    monkeypatch.setenv("TMPDIR", str(folder))
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def no_festival(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")


@pytest.fixture
def slow_festival(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A text2wave that writes half a file and hangs in a child; gives where its child's id is."""
    folder = tmp_path / "bin"
    folder.mkdir()
    program = folder / "text2wave"
    program.write_text(
        f"#!/bin/sh\nprintf RIFF > \"$2\"\nsleep 60 &\necho $! > '{folder}/child'\nwait\n"
    )
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=":")
    monkeypatch.setattr(synthesis, "FESTIVAL_TIMEOUT", 0.5)
    return folder / "child"
