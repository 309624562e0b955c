"""`voz decode --drive`: what the robot would have done is what it does in `voz run`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from calls import in_process
from recordings import GO_BACK, Recording

from voz.apps.batch.remote import file_name_for

pytestmark = pytest.mark.slow


def events_of(folder: Path, name: object) -> list[dict[str, Any]]:
    lines = (folder / f"{file_name_for(str(name))}.jsonl").read_text().splitlines()
    return [json.loads(line) for line in lines]


def test_the_events_are_those_of_a_run(session: Recording, tmp_path: Path) -> None:
    result = in_process("decode", "--json", "--drive", tmp_path / "driven", session.path, GO_BACK)
    assert result.code == 0
    run = in_process(
        *("run", "--wav", session.path, "--robot", "simulator", "--no-sound", "--events", "-")
    )
    assert events_of(tmp_path / "driven", session.path) == run.json
    picture = tmp_path / "driven" / f"{file_name_for(str(session.path))}.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    plain = in_process("decode", "--json", session.path, GO_BACK)
    assert result.json == plain.json


def test_nothing_moves_unless_the_robot_listens(tmp_path: Path) -> None:
    def moves(*more: object) -> bool:
        in_process("decode", "--drive", tmp_path, GO_BACK, *more)
        sent = [e for e in events_of(tmp_path, GO_BACK) if e["type"] == "cmd_vel"]
        assert sent[-1]["linear"] == 0
        return any(e["linear"] for e in sent)

    assert not moves()
    assert moves("--listening", "--overwrite")


def test_what_a_recording_did_before_is_replaced_only_if_asked(tmp_path: Path) -> None:
    given = ("decode", "--drive", tmp_path, GO_BACK)
    assert in_process(*given).code == 0
    events = tmp_path / f"{file_name_for(str(GO_BACK))}.jsonl"
    events.write_text("mine")
    assert f"{events}: is there already; replace it by --overwrite" in in_process(*given).complaint
    assert events.read_text() == "mine"
    assert in_process(*given, "--overwrite").code == 0
    assert events.read_text() != "mine"


def test_programs_of_commands_are_not_started(tmp_path: Path) -> None:
    (tmp_path / "voz.toml").write_text(
        f'[commands]\n"go back" = {{ run = ["touch", "{tmp_path}/started"] }}\n'
    )
    given = ("--config", tmp_path / "voz.toml", "--listening", GO_BACK)
    assert in_process("decode", "--drive", tmp_path / "driven", *given).code == 0
    assert {e["type"] for e in events_of(tmp_path / "driven", GO_BACK)} >= {"utterance", "cmd_vel"}
    assert not (tmp_path / "started").exists()


def test_a_recording_that_cannot_be_read_is_a_row(tmp_path: Path) -> None:
    result = in_process("decode", "--json", "--drive", tmp_path / "driven", "none.wav")
    assert result.code == 3
    assert result.json == [{"file": "none.wav", "error": "none.wav: there is no such file"}]


def test_a_run_without_it_is_not_gone_on_with(tmp_path: Path) -> None:
    out = tmp_path / "heard.jsonl"
    assert in_process("decode", GO_BACK, "--out", out).code == 0
    given = ("--out", out, "--resume", "--drive", tmp_path / "driven")
    assert "was started with no --drive" in in_process("decode", GO_BACK, *given).complaint


def test_names_of_files_do_not_lead_out_of_the_folder() -> None:
    names = [
        "../a.wav",
        "/b/../c.wav",
        "a%2Fb.wav",
        "a/b.wav",
        "s3://bucket/x.wav",
        "..",
        "y" * 900,
    ]
    made = [file_name_for(name) for name in names]
    assert len(set(made)) == len(names)
    assert max(map(len, made)) < 250
    assert all("/" not in name and not name.startswith(".") for name in made)
