"""The options that several subcommands take: which settings are read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from recordings import FIXTURES, GO_BACK

from voz.cli.options import CommonOptions


@pytest.fixture
def here(here: Path) -> Path:
    (here / "typed.txt").write_text("start speech\ngo forward\n")
    return here


SLOW = "[safety]\nmax_linear = 0.05\n"
TYPED = ("run", "--no-sound", "--text", "typed.txt")


def test_a_voz_toml_here_is_read_and_told_once(here: Path, voz: Any) -> None:
    (here / "voz.toml").write_text(SLOW)
    result = voz(*TYPED)
    assert (result.code, result.err) == (0, "settings: voz.toml\n")
    assert "drives forward at 0.05 m/s" in result.out


def test_another_that_is_named_takes_its_place(here: Path, voz: Any) -> None:
    (here / "voz.toml").write_text(SLOW)
    (here / "mine.toml").write_text("")
    for name in ("mine.toml", "/dev/null"):
        result = voz(*TYPED, "--config", name)
        assert (result.code, result.err) == (0, "")
        assert "drives forward at 0.10 m/s" in result.out


@pytest.mark.parametrize(
    "arguments",
    [
        TYPED,
        ("decode", GO_BACK),
        ("eval", FIXTURES / "manifest.tsv"),
        ("calibrate", "--wav", "none"),
    ],
)
def test_a_mistake_in_it_is_told_as_in_one_that_is_named(
    arguments: tuple[object, ...], here: Path, voz: Any
) -> None:
    (here / "voz.toml").write_text("[safety]\nmax_speed = 1\n")
    result = voz(*arguments)
    assert result.code == 2
    told, complaint = result.err.splitlines()
    assert told == "settings: voz.toml"
    assert complaint.startswith("voz: voz.toml: Object contains unknown field `max_speed`")


def test_it_is_not_written_over(here: Path, voz: Any) -> None:
    (here / "voz.toml").write_text(SLOW)
    result = voz(*TYPED, "--events", "voz.toml")
    assert result.code == 2
    assert "voz: voz.toml: is read or written already" in result.err
    assert (here / "voz.toml").read_text() == SLOW


def test_what_is_no_file_is_none(here: Path, voz: Any) -> None:
    (here / "voz.toml").mkdir()
    result = voz(*TYPED)
    assert (result.code, result.err) == (0, "")


def test_what_reads_no_settings_tells_of_none(here: Path, voz: Any) -> None:
    (here / "voz.toml").write_text("nonsense")
    for arguments in (["calibrate", "--list"], ["say", "--list-voices"], ["--help"]):
        result = voz(*arguments)
        assert (result.code, result.err) == (0, "")


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "-0.1", "1e400", "10001"])
@pytest.mark.parametrize(
    ("option", "setting"),
    [("--threshold", "threshold"), ("--false-alarms-per-hour", "false_alarms_per_hour")],
)
def test_no_number_from_outside_its_range_is_an_option(
    here: Path, voz: Any, option: str, setting: str, value: str
) -> None:
    complaint = voz(*TYPED, option, value).complaint
    assert complaint.startswith("voz: an option cannot be used: Expected `float` ")
    assert complaint.endswith(f" - at `$.recognition.{setting}`; see --help")


def test_an_old_name_is_told_once_however_often_the_settings_are_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "robot.toml"
    file.write_text("[recognition]\nsecond_ear = false\n")
    options = CommonOptions(config=file)
    assert not any(options.settings().recognition.use_network for _ in range(2))
    assert capsys.readouterr().err.count("second_ear is called use_network") == 1
