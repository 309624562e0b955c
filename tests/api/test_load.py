"""A recognizer in one call."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest
from recordings import Recording

import voz

SAID = ("go forward", "stop", "turn left")
LIGHTS = ["turn [the] {color} light on", "color = red | green"]


def test_a_list_of_commands_is_understood(recordings: list[Recording]) -> None:
    recognizer = voz.load(list(SAID))
    for text in SAID:
        clip = next(r for r in recordings if r.text == text and r.voice.startswith("festival"))
        (heard,) = recognizer.decode(clip.samples(), 16000)
        assert (heard.text, heard.accepted) == (text, True)


@pytest.mark.parametrize("kind", [list, tuple, iter])
def test_lines_of_templates_mean_what_they_mean_in_a_file(
    kind: Callable[[list[str]], Iterable[str]],
) -> None:
    recognizer = voz.load(kind(["go forward", "stop", "# lights", "", *LIGHTS]))
    assert recognizer.commands.examples()[:2] == ["go forward", "stop"]
    parse = recognizer.commands.parse("turn green light on")
    assert parse
    assert (parse.command, dict(parse.slots)) == ("turn {color} light on", {"color": "green"})


@pytest.mark.parametrize(
    ("commands", "told"),
    [
        (["stop", LIGHTS[0]], r'^the list of commands:2:13: there is no list "color"; add it'),
        (["go forward\udcff"], "^the list of commands:1: is not UTF-8 text"),
        (["stop", "import others.txt"], "^the list of commands:2:8: import works only in files"),
        ([], "^the list of commands: contains no command"),
        (["stop", 1], "^1 is no command; give a list of texts, or a folder"),
        (1, "^1 is no command; give a list of texts, or a folder"),
        (b"stop", "is no command; give a list of texts, or a folder"),
    ],
)
def test_what_is_no_list_of_commands_is_one_clear_error(commands: Any, told: str) -> None:
    with pytest.raises(voz.CommandsError, match=told):
        voz.load(commands)


def test_a_file_is_a_list_with_its_pronunciations(tmp_path: Path) -> None:
    path = tmp_path / "commands.txt"
    path.write_text("stop\nzorblax\n")
    (tmp_path / "pronunciations.txt").write_text("zorblax Z AO R B L AE K S\n")
    for commands in (path, str(path)):
        assert [*voz.load(commands).commands] == ["stop", "zorblax"]
    path.write_text("stop\n@\n")
    with pytest.raises(voz.CommandsError, match=r"commands\.txt:2"):
        voz.load(path)


def test_a_list_leaves_no_files_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    voz.load(["stop"])
    assert not list(tmp_path.iterdir())


def test_a_folder_is_a_path_or_its_name(language: Any) -> None:
    for folder in (language.folder, str(language.folder)):
        assert voz.load(folder).commands.examples() == voz.load().commands.examples()
