"""The unit: as systemd itself reads it, and its command run literally."""

from __future__ import annotations

import configparser
import os
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from calls import HANGS, in_process
from hypothesis import given
from hypothesis import strategies as st
from recordings import ROOT

from voz.apps.systemd import unit_text

WORDS = st.text(st.characters(exclude_categories=["C"]), min_size=1, max_size=20)


def read(text: str) -> configparser.RawConfigParser:
    parser = configparser.RawConfigParser(strict=False)
    parser.optionxform = str  # type: ignore[assignment, method-assign]
    parser.read_string(text)
    return parser


def command_of(text: str) -> list[str]:
    """Read ExecStart as systemd does: quotes, backslashes, and doubled signs."""
    line = read(text)["Service"]["ExecStart"]
    return [word.replace("%%", "%").replace("$$", "$") for word in shlex.split(line)]


def printed(*options: str, **more: object) -> str:
    result = in_process("service", "install", "--print", "--", *options, **more)
    assert (result.code, result.err) == (0, "")
    return result.out


@given(st.lists(WORDS, min_size=1, max_size=5))
def test_whatever_the_options_are_the_command_has_them(words: list[str]) -> None:
    assert command_of(unit_text(["/bin/voz", *words], "/", {})) == ["/bin/voz", *words]


def test_what_ros_has_set_is_kept_and_nothing_else() -> None:
    environment = {"ROS_DOMAIN_ID": "7", "CYCLONEDDS_URI": "<a b='%'/>", "TOKEN": "secret"}
    text = unit_text(["/bin/voz"], "/home/ana", environment)
    assert "Environment=ROS_DOMAIN_ID=7\n" in text
    assert "Environment=\"CYCLONEDDS_URI=<a b='%%'/>\"\n" in text
    assert "secret" not in text
    assert "WorkingDirectory=/home/ana\n" in text


def test_it_comes_after_the_sound_server_and_comes_back_after_a_failure() -> None:
    parts = read(printed())
    assert "pipewire-pulse.service" in parts["Unit"]["After"]
    assert "pulseaudio.service" in parts["Unit"]["After"]
    assert parts["Service"]["Restart"] == "on-failure"
    # `mixed` and `process` differ when voz has crashed: its watchdog would be killed, or stay.
    assert parts["Service"]["KillMode"] == "control-group"
    assert parts["Install"]["WantedBy"] == "default.target"


def systemd_analyze(folder: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    program = shutil.which("systemd-analyze")
    assert program, "it comes with Debian"
    return subprocess.run(
        [program, "--user", *map(str, arguments)],
        env=os.environ | {"XDG_RUNTIME_DIR": str(folder)},
        capture_output=True,
        text=True,
    )


def test_systemd_itself_takes_it(tmp_path: Path) -> None:
    file = tmp_path / "voz.service"
    (tmp_path / "my %h $HOME.toml").touch()
    robots = ("--robot", "console,ros2")
    file.write_text(printed(*robots, "--config", "my %h $HOME.toml", cwd=tmp_path))
    done = systemd_analyze(tmp_path, "verify", file)
    assert (done.returncode, done.stderr) == (0, "")


def test_systemd_takes_a_program_and_words_of_any_name(tmp_path: Path) -> None:
    program = tmp_path / "a $b %h" / "voz"
    program.parent.mkdir()
    program.touch(0o755)
    file = tmp_path / "voz.service"
    words = ["run", "--config", "a\nExecStartPre=/bin/false\r\t\x1b.toml", "b\udcff"]
    file.write_text(unit_text([str(program), *words], str(program.parent), {"PYTHONPATH": "\n"}))
    assert len(file.read_text().splitlines()) == len(
        unit_text(["a"], "/", {"ROS_IP": "1"}).splitlines()
    )
    done = systemd_analyze(tmp_path, "verify", file)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("name", ["a\nExecStartPre=touch owned", "a\r", "a ", "a\\", "a\udcff"])
def test_a_folder_that_a_unit_cannot_hold_is_refused(name: str, voz: Any, tmp_path: Path) -> None:
    (tmp_path / name).mkdir()
    complaint = voz("service", "install", "--print", cwd=tmp_path / name).complaint
    assert "a unit cannot hold a folder" in complaint
    assert complaint.isprintable()


def test_what_a_voice_does_not_need_is_closed(tmp_path: Path) -> None:
    file = tmp_path / "voz.service"
    file.write_text(printed())
    done = systemd_analyze(tmp_path, "security", "--offline=true", "--threshold=65", file)
    assert done.returncode == 0, done.stdout  # 9.8 with nothing closed
    service = read(printed())["Service"]
    # With these it does not start where users may make no namespaces, or not for a user at all.
    assert not {"PrivateUsers", "CapabilityBoundingSet", "DynamicUser"} & set(service)
    # Sound cards, serial ports and pins are devices, what is recorded lies where the user says.
    assert not {"PrivateDevices", "DeviceAllow", "ProtectHome", "ProtectClock"} & set(service)
    assert set(service["RestrictAddressFamilies"].split()) >= {"AF_UNIX", "AF_INET", "AF_NETLINK"}


def test_its_command_runs_in_its_folder(tmp_path: Path) -> None:
    orders = tmp_path / "my orders.txt"
    orders.write_text("start speech\ngo forward\n")
    text = printed("--text", "my orders.txt", "--no-sound", cwd=tmp_path)
    service = read(text)["Service"]
    done = subprocess.run(
        command_of(text),
        cwd=service["WorkingDirectory"],
        env={"PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=HANGS,
    )
    assert done.returncode == 0
    assert "drives forward at 0.10 m/s" in done.stdout
    assert "\x1b" not in done.stdout + done.stderr  # the journal is no terminal


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--nonsense"], "--nonsense"),
        (["--robot"], "--robot"),
        (["--threshold", "x"], "threshold"),
        (["--robot", "nobody"], "there is no robot nobody"),
        (["--profile", "nobody"], 'there is no profile "nobody"'),
        (["--config", "none.toml"], "none.toml: "),
        (["--lm", "none"], "none/comandos_voz.dic: is missing"),
        (["--https"], "add --web"),
    ],
)
def test_options_that_voz_run_does_not_take_are_refused(
    options: list[str], said: str, voz: Any
) -> None:
    assert said in voz("service", "install", "--", *options).complaint


def without_systemd(folder: Path) -> dict[str, str]:
    return os.environ | {"PATH": str(folder), "HOME": str(folder), "XDG_CONFIG_HOME": ""}


@pytest.mark.parametrize("act", ["install", "status"])
def test_without_systemd_one_line_says_so_and_nothing_is_written(act: str, tmp_path: Path) -> None:
    complaint = in_process("service", act, env=without_systemd(tmp_path)).complaint
    assert "there is no systemctl here" in complaint
    assert "--print" in complaint
    assert list(tmp_path.iterdir()) == []


def test_what_is_not_installed_cannot_be_removed(tmp_path: Path) -> None:
    complaint = in_process("service", "uninstall", env=without_systemd(tmp_path)).complaint
    assert str(tmp_path / ".config/systemd/user/voz.service") in complaint
