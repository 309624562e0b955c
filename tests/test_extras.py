"""What is not installed is told by a command that installs it, and no stranger's package."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from recordings import ROOT

from voz.errors import ConfigError
from voz.extras import how_to_install, require


def test_in_a_clone_the_command_can_be_pasted_anywhere() -> None:
    before, command, after = how_to_install("report").split("`")
    assert (before, after) == ("run ", "")
    program, *arguments = shlex.split(command)
    assert program == sys.executable
    assert arguments == ["-m", "pip", "install", "--editable", f"{ROOT}[report]"]


def test_a_missing_library_gives_the_line_that_installs_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    require("report", "jiwer", "matplotlib")
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    require("report", "jiwer")
    with pytest.raises(ConfigError, match=r"matplotlib is .* -m pip install .*\[report\]"):
        require("report", "jiwer", "matplotlib")


@pytest.mark.parametrize(
    ("missing", "command"),
    [
        ("jiwer", "eval {manifest}"),
        ("matplotlib", "eval {manifest} --html page.html"),
        ("pyarrow", "decode {manifest} --out heard.parquet"),
        ("fsspec", "decode s3://bucket/heard.wav"),
        ("rosbags", "run --text - --bag new.mcap"),
        ("starlette", "view session.jsonl"),
        ("wyoming", "serve"),
    ],
)
def test_a_command_without_its_library_is_one_line(
    missing: str, command: str, tmp_path: Path
) -> None:
    arguments = command.format(manifest=ROOT / "audio_fixtures" / "manifest.tsv").split()
    program = (
        f"import sys; sys.modules[{missing!r}] = None; from voz.cli import main; sys.exit(main())"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 2
    assert done.stderr.startswith(f"voz: {missing} is not installed; run `")
    assert done.stderr.count("\n") == 1


def test_what_is_no_clone_says_that_one_is_needed(tmp_path: Path) -> None:
    (tmp_path / "extras.py").write_bytes((ROOT / "voz" / "extras.py").read_bytes())
    program = "from extras import how_to_install; print(how_to_install('bags'))"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.endswith("pip install '.[bags]'` in a clone of voz\n")


@pytest.mark.parametrize("place", ["README.md", "voz", "docs", "ros", "tools"])
def test_nobody_is_told_to_install_what_others_call_voz(place: str) -> None:
    files = [path for path in (ROOT / place, *(ROOT / place).rglob("*")) if path.is_file()]
    assert files
    assert [path for path in files if b"install 'voz" in path.read_bytes()] == []
