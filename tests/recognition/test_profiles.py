"""What is kept of speakers and microphones, and what becomes of files that cannot be used."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from full_disk import full_disk

from voz.errors import ConfigError
from voz.recognition.profiles import (
    Profile,
    load_profile,
    profile_folder,
    save_profile,
)


@pytest.mark.parametrize("name", ["", ".", "..", "a/b", "../x", ".hidden", "a b", "x" * 61, "a\n"])
def test_a_name_that_is_no_folder_is_refused_with_one_line(name: str) -> None:
    with pytest.raises(ConfigError, match="cannot be the name of a profile") as error:
        profile_folder(name)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("home", ["", "not/absolute"])
def test_without_a_data_folder_it_is_the_usual_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, home: str
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", home)
    monkeypatch.setenv("HOME", str(tmp_path))
    assert profile_folder("ana").is_relative_to(tmp_path / ".local" / "share" / "voz")


def test_a_profile_that_cannot_be_written_leaves_the_one_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    save_profile("ana", Profile(0.5))
    before = load_profile("ana")
    with full_disk(10), pytest.raises(ConfigError, match="cannot be written"):
        save_profile("ana", Profile(1.0))
    assert load_profile("ana") == before
    assert [path.name for path in profile_folder("ana").iterdir()] == ["profile.json"]


def test_what_an_older_voz_learned_is_told_of_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    path = save_profile("ana", Profile(0.5))
    old = {"start": {"shift": [1.5] * 13, "frames": 60.0}, "mllr": "mllr.txt", "log_odds": 0.5}
    told: list[str] = []
    load_profile("ana", told.append)
    assert told == []
    path.write_text(json.dumps(old))
    assert load_profile("ana", told.append) == load_profile("ana") == Profile(0.5)
    (line,) = told
    assert line.startswith(f"{path}: what an older voz learned of the voice is no longer used")
