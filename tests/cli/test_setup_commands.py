"""`voz doctor` on computers that have a microphone, festival and language files, and lack them."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from calls import Result, in_process
from recordings import ROOT

pytestmark = pytest.mark.slow


def findings(result: Result) -> dict[str, dict[str, Any]]:
    return {one["what"]: one for one in result.json}


def test_on_a_computer_that_has_all_is_well(pulse: dict[str, str]) -> None:
    result = in_process("doctor", "--json", env=pulse)
    found = findings(result)
    assert all(one["well"] for one in found.values() if one["needed"]), found
    assert result.code == 0
    assert "gives sound" in found["microphone"]["told"]
    assert found["festival"]["told"] == "speaks with the voice kal_diphone"
    assert found["phoneme network"]["well"]
    assert not found["ROS 1 master"]["needed"]  # nobody said that a robot is driven by it


def test_for_people_each_line_says_what_and_how_it_is(pulse: dict[str, str]) -> None:
    result = in_process("doctor", "--device", "mic.monitor", env=pulse)
    assert result.code == 0
    first = result.out.splitlines()[0]
    assert first.startswith('ok  microphone:            "mic.monitor" gives sound, at most -')


def test_a_microphone_that_is_muted_gives_zeros(pulse: dict[str, str]) -> None:
    result = in_process("doctor", "--json", "--device", "speaker.monitor", env=pulse)
    found = findings(result)["microphone"]
    assert (result.code, found["well"]) == (1, False)
    assert found["told"] == '"speaker.monitor" is silent: the microphone gives nothing but zeros'
    assert found["to_do"].startswith("unmute it")


def test_what_is_missing_is_told_with_what_helps(no_sound: dict[str, str], tmp_path: Path) -> None:
    result = in_process("doctor", "--json", env=no_sound | {"PATH": str(tmp_path)})
    found = findings(result)
    assert result.code == 1
    assert {what for what, one in found.items() if one["needed"] and not one["well"]} == {
        "microphone", "loudspeaker", "festival",
    }  # fmt: skip
    assert found["microphone"]["told"] == "there is no microphone"
    assert "--text" in found["microphone"]["to_do"]
    assert "apt-get install festival" in found["festival"]["to_do"]


def test_a_robot_that_is_silent_needs_neither_loudspeaker_nor_festival(
    no_sound: dict[str, str], tmp_path: Path
) -> None:
    (tmp_path / "voz.toml").write_text("[speech]\nenabled = false\n")
    settings = str(tmp_path / "voz.toml")
    environment = no_sound | {"PATH": str(tmp_path)}
    found = findings(in_process("doctor", "--json", "--config", settings, env=environment))
    assert not found["loudspeaker"]["needed"]
    assert not found["festival"]["needed"]


@pytest.mark.parametrize(
    ("file", "change", "said"),
    [
        ("comandos_voz.dic", b"x", "comandos_voz.dic: was changed after `voz build-lm`"),
        ("comandos_voz.txt", b"go home\n", "has changed since the last `voz build-lm`"),
    ],
)
def test_language_files_that_are_damaged_or_stale_are_told_of(
    file: str, change: bytes, said: str, tmp_path: Path, no_sound: dict[str, str]
) -> None:
    folder = tmp_path / "lm"
    shutil.copytree(ROOT / "lm", folder)
    with (folder / file).open("ab") as changed:
        changed.write(change)
    found = findings(in_process("doctor", "--json", "--lm", folder, env=no_sound))
    assert not found["language files"]["well"]
    assert said in found["language files"]["told"]
    assert "build-lm" in found["language files"]["told"] + found["language files"]["to_do"]
    assert "recognizer" not in found or file.endswith(".txt")  # the old list is heard all the same


def test_an_extra_that_is_missing_is_told_with_how_to_install_it() -> None:
    code = (
        "import sys, json; sys.modules['rosbags'] = None\n"
        "from voz.apps.doctor.all_checks import check_extras\n"
        "from voz.events import to_json\n"
        "print(to_json(next(check_extras())))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
    )
    found = json.loads(done.stdout)
    assert (found["what"], found["well"], found["needed"]) == ("extra bags", False, False)
    assert "[bags]" in found["to_do"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--base"], "add --robot ros1 or --robot ros2"),
        (["--base", "--robot", "ros1,ros2"], "add --robot ros1 or --robot ros2"),
        (["--base", "--robot", "ros2"], "add --yes"),
        (["--robot", "nobody"], "there is no robot nobody"),
    ],
)
def test_a_wrong_call_moves_nothing_and_is_one_line(
    arguments: list[str], said: str, voz: Any
) -> None:
    assert said in voz("doctor", *arguments, typed="").complaint
