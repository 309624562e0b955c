"""What is kept of speakers and microphones, and what becomes of files that cannot be used."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from full_disk import full_disk

from voz.errors import ConfigError
from voz.recognition.speaker.adaptation import Observation, StartVector
from voz.recognition.speaker.profiles import (
    Profile,
    learned_file,
    load_learned,
    load_profile,
    profile_folder,
    save_learned,
    save_profile,
)

VECTOR = StartVector().updated(Observation((1.23456,) * 13, 60))


def test_what_was_learnt_outlives_the_program(tmp_path: Path) -> None:
    path = tmp_path / "not" / "yet" / "there.json"
    assert save_learned(path, VECTOR.with_contradiction()) is None
    vector, warning = load_learned(path)
    assert warning is None
    assert vector.doubts == 1
    assert np.allclose(vector.shift, VECTOR.shift, atol=0.001)
    assert [p.name for p in path.parent.iterdir()] == ["there.json"]


def test_no_file_is_nothing_learnt(tmp_path: Path) -> None:
    assert load_learned(tmp_path / "none.json") == (StartVector(), None)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe",
        b"{}}",
        b'{"shift":[1,2,3],"frames":10,"doubts":0}',
        b'{"shift":[1,2,3,4,5,6,7,8,9,10,11,12,1e9],"frames":10,"doubts":0}',
        b'{"frames":-1}',
        b'{"frames":1e99}',
        b'{"doubts":1000}',
        b'{"speaker":"somebody"}',
    ],
)
def test_a_spoilt_file_is_ignored_with_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "spoilt.json"
    path.write_bytes(content)
    vector, warning = load_learned(path)
    assert vector == StartVector()
    assert warning is not None
    assert str(path) in warning
    assert "\n" not in warning


def test_a_folder_that_cannot_be_used_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    path = tmp_path / "file" / "state.json"
    for warning in (save_learned(path, VECTOR), load_learned(path)[1]):
        assert warning is not None
        assert str(path) in warning


def test_each_microphone_and_each_speaker_has_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    pairs = [("ana", "hw:1,0"), ("ana", "hw:1.0"), ("juan", "hw:1,0"), ("josé", "é" * 500)]
    paths = [learned_file(name, device) for name, device in pairs]
    assert len(set(paths)) == len(pairs)
    for path in paths:
        assert path.is_relative_to(tmp_path / "voz" / "profiles")
        assert save_learned(path, VECTOR) is None
    assert paths[0].name.startswith("hw-1-0-")


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
    save_profile("ana", Profile(VECTOR))
    before = load_profile("ana")
    with full_disk(50), pytest.raises(ConfigError, match="cannot be written"):
        save_profile("ana", Profile(VECTOR, log_odds=1.0))
    assert load_profile("ana") == before
    assert [path.name for path in profile_folder("ana").iterdir()] == ["profile.json"]
