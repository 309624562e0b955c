"""`voz run`: what its options may not be together."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from calls import VOZ
from recordings import GO_BACK, ROOT


@pytest.mark.parametrize(
    ("read", "written"),
    [
        (["--wav", "in.png"], ["--events", "in.png"]),
        (["in.png"], ["--events", "in.png"]),
        (["--text", "in.png"], ["--events", "in.png"]),
        (["--replay", "in.png"], ["--events", "in.png"]),
        (["--replay", "."], ["--events", "in.png"]),
        (["--text", "-", "--config", "in.png"], ["--events", "in.png"]),
        (["--text", "-", "--lm", "lm"], ["--events", "lm/comandos_voz.gram"]),
        (["--text", "-", "--profile", "ana"], ["--events", "voz/profiles/ana/profile.json"]),
        (["--wav", "in.png"], ["--robot", "simulator", "--picture", "in.png"]),
        (["--wav", "in.gif"], ["--robot", "simulator", "--animation", "in.gif"]),
        (["--replay", "in.bag"], ["--bag", "in.bag"]),
        (["--text", "-"], ["--events", "new", "--robot", "simulator", "--picture", "lm/../new"]),
    ],
)
def test_no_result_takes_the_place_of_what_is_read_or_of_another(
    read: list[str], written: list[str], voz: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("in.png", "in.gif", "in.bag"):
        shutil.copy(GO_BACK, tmp_path / name)
    (tmp_path / "in.png").write_text("[safety]\n")
    shutil.copytree(ROOT / "lm", tmp_path / "lm")
    (tmp_path / "voz" / "profiles" / "ana").mkdir(parents=True)
    (tmp_path / "voz" / "profiles" / "ana" / "profile.json").write_text("{}")
    before = contents(tmp_path)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    result = voz("run", "--no-sound", *read, *written)
    assert result.complaint.startswith(f"voz: {written[-1]}: is read or written already")
    assert result.code == 2
    assert contents(tmp_path) == before


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_typed_text_from_a_file_on_standard_input_is_not_written_over(tmp_path: Path) -> None:
    typed = tmp_path / "typed.txt"
    typed.write_text("stop\n")
    call = [*VOZ, "run", "--no-sound", "--text", "-", "--events", str(typed)]
    with typed.open() as stream:
        done = subprocess.run(call, stdin=stream, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"{typed}: is read or written already, as /dev/stdin; name another" in done.stderr
    assert typed.read_text() == "stop\n"


def test_events_may_go_where_nothing_is_kept(voz: Any, tmp_path: Path) -> None:
    (tmp_path / "typed.txt").write_text("stop\n")
    arguments = ["--text", tmp_path / "typed.txt", "--events", "/dev/null"]
    assert voz("run", "--no-sound", *arguments).code == 0


@pytest.mark.parametrize("played", [["--wav", GO_BACK], ["--text", "-"], ["--replay", "in.bag"]])
def test_another_recognizer_is_not_left_out_without_a_word(played: list[Any], voz: Any) -> None:
    complaint = voz("run", "--no-sound", "--listen-ros", *played).complaint
    assert complaint.startswith("voz: --listen-ros is for live runs: leave out ")
