"""What commands do, by a `[commands]` of the user's own, through the whole program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from calls import Result

TABLE = """
[commands]
"avanza" = { drive = 0.2, metres = 0.4 }
"para" = "stop"
"luz" = { publish = true, topic = "lamp", say = "it is light" }
"marca" = { run = ["touch", "marked"] }
"again" = { again = true }
"cuchillo" = { publish = "knife", topic = "bring", confirm = "the knife?" }
"si" = { answer = true }
"no" = { answer = false }
"""


@pytest.fixture
def here(here: Path, voz: Any) -> Path:
    """A folder with the user's own list and table."""
    (here / "voz.toml").write_text(TABLE)
    words = "avanza\npara\nluz\nmarca\nagain\ncuchillo\nsi\nno\n"
    (here / "list.txt").write_text(words)
    said = "\n".join(f"{word}\tS IY" for word in words.split() if word not in ("again", "no"))
    (here / "pronunciations.txt").write_text(said + "\n")
    assert voz("build-lm", "list.txt", "--out", "lm").code == 0
    return here


def last(result: Result) -> str:
    """The last line that says what is wrong."""
    return str(result.err.splitlines()[-1])


def events(voz: Any, here: Path, *lines: str) -> list[dict[str, Any]]:
    (here / "typed.txt").write_text("\n".join(lines) + "\n")
    result = voz("run", "--text", "typed.txt", "--events", "-", "--no-sound")
    assert result.code == 0, result.err
    assert "commands are obeyed from the start" in result.err
    found: list[dict[str, Any]] = result.json
    return found


def test_values_programs_and_questions(voz: Any, here: Path) -> None:
    found = events(voz, here, "luz", "marca", "cuchillo", "si", "cuchillo", "no")
    other = [e for e in found if e["type"] not in ("cmd_vel", "utterance", "attention")]
    assert [(e["type"], e.get("value") or e.get("text") or e.get("name")) for e in other] == [
        ("publish", True),
        ("reply", "it is light"),
        ("run", None),
        ("ended", "touch"),
        ("reply", "the knife?"),
        ("publish", "knife"),
        ("reply", "the knife?"),
    ]
    assert (here / "marked").exists()
    asked = [event.get("answers") for event in found if event["type"] == "attention"]
    assert asked == [["si", "no"], None, ["si", "no"], None]


def test_the_console_says_what_is_done(voz: Any, here: Path) -> None:
    (here / "typed.txt").write_text("luz\nmarca\nsi\n")
    out = voz("run", "--text", "typed.txt", "--no-sound").out
    for told in ("lamp: True", 'robot says "it is light"', "runs touch marked", "touch has ended"):
        assert told in out
    assert "not obeyed: nothing was asked" in out


def test_what_a_program_prints_is_seen_where_the_robots_print(voz: Any, here: Path) -> None:
    table = TABLE.replace('["touch", "marked"]', '["sh", "-c", "echo marked; echo odd >&2"]')
    (here / "voz.toml").write_text(table)
    (here / "typed.txt").write_text("marca\n")
    arguments = ["run", "--text", "typed.txt", "--no-sound"]
    lines = voz(*arguments).out.splitlines()
    place = lines.index("sh: marked")
    assert lines[place + 1] == "sh: odd"
    assert lines[place - 1].endswith("runs sh -c echo marked; echo odd >&2")
    assert lines[place + 2].endswith("sh has ended")
    assert "sh: marked\nsh: odd\n" in voz(*arguments, "--events", "-").err


def test_a_list_that_drives_and_cannot_stop_is_refused(voz: Any, here: Path) -> None:
    (here / "list.txt").write_text("avanza\nluz\n")
    for moment in ("build", "run"):
        if moment == "run":
            (here / "voz.toml").unlink()
            assert voz("build-lm", "list.txt", "--out", "lm").code == 0
            (here / "voz.toml").write_text(TABLE)
            result = voz("run", "--text", "-", "--no-sound")
        else:
            result = voz("build-lm", "list.txt", "--out", "lm")
        assert result.code == 2
        assert 'has "avanza", which moves the robot, and no command that stops it' in result.err


def test_a_command_that_begins_with_stop_and_moves_is_refused(voz: Any, here: Path) -> None:
    (here / "list.txt").write_text("avanza: [stop and] advance\nstop\n")
    result = voz("build-lm", "list.txt", "--out", "lm")
    assert result.code == 2
    assert '"avanza" moves the robot and begins with what stops it' in result.err


def test_slots_drive_as_far_as_was_said(voz: Any, here: Path) -> None:
    (here / "list.txt").write_text("go: go {way: 0.5..3 by 0.5} metres\nstop: [please] stop\n")
    (here / "voz.toml").write_text('[commands]\n"go" = { drive = 0.5, metres = "{way}" }\n')
    assert voz("build-lm", "list.txt", "--out", "lm").code == 0
    found = events(voz, here, "Go 1.5 metres.", *"-" * 39)
    driven = [event["linear"] for event in found if event["type"] == "cmd_vel"]
    assert driven[:31] == [0.5] * 30 + [0]
    found = events(voz, here, "go three metres", "-", "please stop", "-")
    driven = [event["linear"] for event in found if event["type"] == "cmd_vel"]
    assert driven[:2] == [0.5] * 2
    assert set(driven[2:]) == {0}
    (here / "voz.toml").write_text('[commands]\n"go" = { drive = 0.5, metres = "{far}" }\n')
    result = voz("run", "--text", "-", "--no-sound")
    assert result.code == 2
    assert last(result) == (
        'voz: voz.toml:2: [commands] "go" uses the slot far, which list.txt does not give it; '
        "it has way"
    )


def test_a_slot_that_a_plain_list_does_not_give_is_told_with_the_list(voz: Any, here: Path) -> None:
    (here / "voz.toml").write_text('[commands]\n"fold arm" = { say = "{thing}" }\n')
    (here / "lm" / "comandos_voz.txt").write_text("fold arm\nstop\n")
    told = 'voz: voz.toml:2: [commands] "fold arm" uses the slot thing, which {} does not give it'
    assert last(voz("build-lm")).startswith(told.format("lm/comandos_voz.txt"))
    (here / "voz.toml").rename(here / "later.toml")
    assert voz("build-lm").code == 0
    arguments = ("run", "--text", "-", "--no-sound", "--config", "later.toml")
    told = told.replace("voz.toml", "later.toml")
    assert last(voz(*arguments)).startswith(told.format("lm/comandos_voz.txt"))
    (here / "lm" / "comandos_voz.txt").unlink()
    assert last(voz(*arguments)).startswith(told.format("the list from which lm was made"))


@pytest.mark.parametrize(
    ("sound", "meant"),
    [
        ("horn.wav", "`voz sound --list` shows the others"),
        ("backing-upp", "did you mean backing-up?"),
    ],
)
def test_a_sound_that_is_not_there_is_told_before_anything_moves(
    voz: Any, here: Path, sound: str, meant: str
) -> None:
    table = f'[commands]\n"fold arm" = "stop"\n"go back" = {{ drive = -0.1, play = "{sound}" }}\n'
    (here / "voz.toml").write_text(table)
    (here / "typed").write_text("start speech\ngo back\n")
    result = voz("run", "--text", "typed", "--no-sound", "--events", "-")
    assert (result.code, last(result)) == (
        2,
        f'voz: voz.toml:3: [commands] "go back" plays {sound}, and there is no such file; {meant}',
    )
    assert "cmd_vel" not in result.out
    (here / sound).write_bytes(b"")  # that it is no sound is told when it is played
    assert voz("run", "--text", "typed", "--no-sound").code == 0
