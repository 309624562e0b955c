"""`voz build-lm`: own commands, and files that are not up to date."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from recordings import GO_BACK, ROOT


def test_own_commands_are_built_and_understood(
    voz: Any, own_commands: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = voz("build-lm")
    assert result.code == 0
    assert "2 sentences, 4 words" in result.out
    wav = tmp_path / "gripper.wav"
    assert voz("say", "open gripper", "--out", wav).code == 0
    (heard,) = voz("decode", "--json", wav).json
    assert (heard["text"], heard["accepted"]) == ("open gripper", True)


def test_check_names_the_stale_files(voz: Any, own_commands: Path) -> None:
    folder = own_commands.parent
    assert voz("build-lm", own_commands).code == 0
    assert voz("build-lm", own_commands, "--check").code == 0
    (folder / "comandos_voz.dic").write_text("go G OW\n")
    result = voz("build-lm", own_commands, "--check")
    assert result.code == 1
    assert "comandos_voz.dic" in result.err
    assert "comandos_voz.lm" not in result.err


def test_the_tool_does_the_same(voz: Any, own_commands: Path, tmp_path: Path) -> None:
    assert voz("build-lm", own_commands, "--out", tmp_path / "a").code == 0
    tool = [sys.executable, ROOT / "tools" / "build_lm.py", own_commands, "--out", tmp_path / "b"]
    subprocess.run(tool, check=True, capture_output=True)
    names = sorted(path.name for path in (tmp_path / "a").iterdir())
    assert len(names) == 7
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_the_language_files_of_the_checkout_are_what_its_list_gives(voz: Any) -> None:
    assert voz("build-lm", "--check").code == 0


def test_a_list_that_changed_since_it_was_built_is_said(
    voz: Any, own_commands: Path, tmp_path: Path
) -> None:
    voz("build-lm", own_commands)
    own_commands.write_text("go back\nstop\n")
    result = voz("decode", "--lm", own_commands.parent, GO_BACK)
    assert result.code == 0
    assert "run it again" in result.err
