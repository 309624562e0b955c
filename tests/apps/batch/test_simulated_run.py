"""`voz decode --drive`: what the robot would have done is what it does in `voz run`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import GO_BACK, Recording

from voz.apps.batch.locations import file_name_for

pytestmark = pytest.mark.slow


def events_of(folder: Path, name: object) -> list[dict[str, Any]]:
    lines = (folder / f"{file_name_for(str(name))}.jsonl").read_text().splitlines()
    return [json.loads(line) for line in lines]


def test_the_events_are_those_of_a_run(voz: Any, session: Recording, tmp_path: Path) -> None:
    options = ("--json", "--pictures", "--drive", tmp_path / "driven")
    result = voz("decode", *options, session.path, GO_BACK)
    assert result.code == 0
    run = voz(
        *("run", "--wav", session.path, "--robot", "simulator", "--no-sound", "--events", "-")
    )
    assert events_of(tmp_path / "driven", session.path) == run.json
    picture = tmp_path / "driven" / f"{file_name_for(str(session.path))}.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    plain = voz("decode", "--json", session.path, GO_BACK)
    assert result.json == plain.json


def test_nothing_moves_unless_the_robot_listens(voz: Any, tmp_path: Path) -> None:
    def moves(*more: object) -> bool:
        voz("decode", "--drive", tmp_path, GO_BACK, *more)
        sent = [e for e in events_of(tmp_path, GO_BACK) if e["type"] == "cmd_vel"]
        assert sent[-1]["linear"] == 0
        return any(e["linear"] for e in sent)

    assert not moves()
    assert moves("--listening", "--overwrite")


def test_what_a_recording_did_before_is_replaced_only_if_asked(voz: Any, tmp_path: Path) -> None:
    call = ("decode", "--drive", tmp_path, GO_BACK)
    assert voz(*call).code == 0
    events = tmp_path / f"{file_name_for(str(GO_BACK))}.jsonl"
    assert list(tmp_path.iterdir()) == [events]  # a picture is drawn only if asked
    events.write_text("mine")
    assert f"{events}: is there already; replace it by --overwrite" in voz(*call).complaint
    assert events.read_text() == "mine"
    assert voz(*call, "--overwrite").code == 0
    assert events.read_text() != "mine"


def test_programs_of_commands_are_not_started(voz: Any, tmp_path: Path) -> None:
    (tmp_path / "voz.toml").write_text(
        f'[commands]\n"go back" = {{ run = ["touch", "{tmp_path}/started"] }}\n'
    )
    options = ("--config", tmp_path / "voz.toml", "--listening", "--words", GO_BACK)
    assert voz("decode", "--drive", tmp_path / "driven", *options).code == 0
    events = events_of(tmp_path / "driven", GO_BACK)
    assert {e["type"] for e in events} >= {"utterance", "cmd_vel"}
    assert [word["word"] for e in events for word in e.get("words", [])] == ["go", "back"]
    assert not (tmp_path / "started").exists()


def test_a_recording_that_cannot_be_read_is_a_row(voz: Any, tmp_path: Path) -> None:
    result = voz("decode", "--json", "--drive", tmp_path / "driven", "none.wav")
    assert result.code == 3
    assert result.json == [{"file": "none.wav", "error": "none.wav: there is no such file"}]


def test_a_run_without_it_is_not_gone_on_with(voz: Any, tmp_path: Path) -> None:
    out = tmp_path / "heard.jsonl"
    assert voz("decode", GO_BACK, "--out", out).code == 0
    options = ("--out", out, "--resume", "--drive", tmp_path / "driven")
    assert "was started with no --drive" in voz("decode", GO_BACK, *options).complaint


def test_pictures_without_a_robot_are_refused(voz: Any) -> None:
    assert "--pictures: draws the way of a robot" in voz("decode", GO_BACK, "--pictures").complaint


def test_names_of_files_are_readable() -> None:
    assert file_name_for("rooms/Küche 2/go (3).wav") == "rooms+Küche 2+go (3).wav"
    assert file_name_for("/data/1.wav") == "+data+1.wav"
    assert file_name_for("../a+b.wav") == "%2E.+a%2Bb.wav"
    assert file_name_for("s3://bucket/x.wav") == "s3%3A++bucket+x.wav"


LETTERS = st.text(st.sampled_from("ab./+%_ ü\n") | st.characters(exclude_categories=["Cs"]))


@given(st.lists(st.one_of(LETTERS, LETTERS.map(lambda text: text * 50)), unique=True))
def test_names_of_files_are_unique_and_do_not_lead_out_of_the_folder(names: list[str]) -> None:
    made = [file_name_for(f"{name}.wav") for name in ["../x", "..", "y" * 900, *names]]
    assert len(set(made)) == len({"../x", "..", "y" * 900, *names})
    assert max(len(name.encode()) for name in made) < 250
    assert all("/" not in name and not name.startswith(".") for name in made)
    assert all(name.isprintable() for name in made)
