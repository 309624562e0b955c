"""`voz build-lm`: own commands, and files that are not up to date."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from documents import written
from recordings import GO_BACK, ROOT


def test_own_commands_are_built_and_understood(voz: Any, own_commands: Path, here: Path) -> None:
    result = voz("build-lm")
    assert result.code == 0
    assert "3 sentences, 5 words" in result.out
    wav = here / "gripper.wav"
    assert voz("say", "open gripper", "--out", wav).code == 0
    (heard,) = voz("decode", "--json", wav).json
    assert (heard["text"], heard["accepted"]) == ("open gripper", True)


def test_without_a_list_that_of_voz_is_built(voz: Any, here: Path) -> None:
    for options, command in (([], "go forward"), (["--language", "es"], "avanza")):
        assert voz("build-lm", *options).code == 0
        assert f"<s> {command} </s>" in (here / "lm/comandos_voz.sent").read_text().splitlines()
        assert voz("build-lm", *options, "--check").out == "lm: up to date\n"


def test_without_a_list_files_that_another_one_made_are_kept(voz: Any, here: Path) -> None:
    (here / "mine.txt").write_text("open gripper\nclose gripper\n")
    assert voz("build-lm", "mine.txt", "--out", "lm").code == 0
    assert "lm/comandos_voz.txt: cannot be read" in voz("build-lm").complaint
    assert "open gripper" in (here / "lm/comandos_voz.sent").read_text()


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
    assert len(names) == 9
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_a_list_that_changed_since_it_was_built_is_said(
    voz: Any, own_commands: Path, tmp_path: Path
) -> None:
    voz("build-lm", own_commands)
    own_commands.write_text("go home\nstop\n")
    result = voz("decode", "--lm", own_commands.parent, GO_BACK)
    assert result.code == 0
    assert "run it again" in result.err


TEMPLATES = "turn: turn {way} {angle: 5..180 by 5} degrees\n[please] stop\nway = left | right:r\n"


@pytest.fixture
def templates(tmp_path: Path) -> Path:
    path = tmp_path / "list.txt"
    path.write_text(TEMPLATES)
    return path


def test_templates_are_built_and_parsed(voz: Any, templates: Path) -> None:
    out = templates.parent / "lm"
    built = voz("build-lm", templates, "--out", out, "--count", "--sample", 2)
    assert built.code == 0
    assert "turn " in built.out
    assert "{way}" in built.out
    parsed = voz("parse", "--lm", out, "--json", "Turn right 90 degrees.", "sotp", "hello there")
    assert parsed.code == 0
    assert parsed.json == [
        {
            "text": "turn right ninety degrees",
            "command": "turn",
            "slots": {"way": "r", "angle": 90},
        },
        {"text": "sotp", "command": None, "slots": {}, "meant": "stop"},
        {"text": "hello there", "command": None, "slots": {}},
    ]
    shown = voz("parse", "--lm", out, "please stop", "sotp").out
    assert shown.splitlines() == [
        '"please stop": stop',
        '"sotp": no command; did you mean "stop"?',
    ]


def test_a_mistake_in_a_template_is_shown_with_a_caret(voz: Any, templates: Path) -> None:
    templates.write_text("stop\ngo (left|)\n")
    result = voz("build-lm", templates)
    assert result.code == 2
    assert result.err.splitlines() == [
        f'voz: {templates}:2:10: empty alternative; write "[...]" around optional words',
        "  go (left|)",
        "           ^",
    ]


def test_at_most_ten_lines_warn_of_what_sounds_alike_and_all_if_asked(
    voz: Any, templates: Path
) -> None:
    templates.write_text("bring: bring the {thing}\nstop\nthing = cap|cop|cup|cub|cab|cob|cut\n")
    few = voz("build-lm", templates).err.splitlines()
    every = voz("build-lm", templates, "--all").err.splitlines()
    assert len(few) == 10
    assert few[:9] == every[:9]
    more = len(every) - 9
    assert few[9] == f"warning: {more} more pairs sound alike; `voz build-lm --all` shows them"
    assert all("sound alike" in line for line in every)


def test_sentences_that_must_be_commands_are_tried(voz: Any, templates: Path) -> None:
    tests = templates.parent / "tests.txt"
    tests.write_text("turn left 5 degrees\n! turn left 6 degrees\nstop\n!\nstop it\n")
    assert voz("build-lm", templates).code == 0
    tests.write_text("stop it # no\n!\nplease stop\ngo\n")
    result = voz("build-lm", templates)
    assert result.code == 2
    assert result.err.splitlines() == [
        f'{tests}:1: "stop it" should be a command, but is not; the nearest is "stop"',
        f'{tests}:3: "please stop" should not be a command, but is "stop"',
    ]


MANY = """
stop
turn: turn {way} {angle: 5..180 by 5} degrees [and go (forward|back) {far: 0.5..3 by 0.5} metres]
bring: [please] bring [me] (the|a) [{color}] {thing} [from the {place}]
way = left | right
color = red | green | deep blue:blue | yellow
thing = cup | bottle | apple | key | box | hammer
place = kitchen | garage | office
"""


@pytest.mark.slow
def test_spoken_templates_are_understood_with_their_slots(voz: Any, templates: Path) -> None:
    templates.write_text(MANY)
    out, wav = templates.parent / "lm", templates.parent / "said.wav"
    assert voz("build-lm", templates, "--out", out).code == 0
    for text, command, slots in (
        ("turn left ninety degrees", "turn", {"way": "left", "angle": 90}),
        (
            "bring me the deep blue bottle from the kitchen",
            "bring",
            {"color": "blue", "thing": "bottle", "place": "kitchen"},
        ),
    ):
        assert voz("say", text, "--out", wav).code == 0
        (heard,) = voz("decode", "--lm", out, "--json", wav).json
        assert (heard["text"], heard["accepted"]) == (text, True)
        assert (heard["command"], heard["slots"]) == (command, slots)
    assert voz("say", "the weather is nice today", "--out", wav).code == 0
    assert not any(heard["accepted"] for heard in voz("decode", "--lm", out, "--json", wav).json)


def test_the_warning_that_the_documents_show_is_what_is_said(voz: Any, tmp_path: Path) -> None:
    (page,) = (page for page in written() if page.path == Path("docs/commands.md"))
    (shown,) = (block for block in page.terminals if block.startswith("$ voz build-lm commands"))
    lists = {
        "commands.txt": "stop\nopen gripper\nopen the gripper\nup\n",
        "better.txt": "stop\nlight on\ndarkness\nraise the arm\n",
        "worse.txt": "stop\nlight on\nlight off\n",
    }
    said = {}
    for name, lines in lists.items():
        (tmp_path / name).write_text(lines)
        said[name] = voz("build-lm", tmp_path / name, "--out", tmp_path / name[0], "--alike")
    assert said["commands.txt"].err == shown.partition("\n")[2]
    assert re.search(r"^up .*\bcup, app", said["commands.txt"].out, re.M)
    assert re.search(r"^0\.\d+ .* light on +darkness", said["better.txt"].out, re.M)
    alike = [
        float(re.search(rf"^(0\.\d+) .* light on +{other}\b", said[name].out, re.M)[1])  # type: ignore[index]
        for name, other in (("better.txt", "darkness"), ("worse.txt", "light off"))
    ]
    assert alike[0] < alike[1]
    assert said["better.txt"].err == ""
