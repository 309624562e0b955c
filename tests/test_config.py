"""Where commands stand in a voz.toml, in all ways to write one."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from recordings import ROOT

from voz.config import Config, default_commands, lines_of_commands, load_config, overridden
from voz.control.steps import Step, fill_slots
from voz.errors import ConfigError


def write(folder: Path, content: str | bytes) -> Path:
    path = folder / "voz.toml"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def test_what_the_file_leaves_out_keeps_its_default(tmp_path: Path) -> None:
    config = load_config(write(tmp_path, "[safety]\nmax_linear = 0.3\n"))
    assert config.safety.max_linear == 0.3
    assert config.safety.max_angular == Config().safety.max_angular
    assert config.recognition == Config().recognition
    assert load_config(write(tmp_path, "")) == Config()


def test_an_old_name_still_works_and_says_what_it_is_called(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = write(tmp_path, "[recognition]\nsecond_ear = false\n")
    config = load_config(path)
    assert not config.recognition.use_network
    assert caplog.messages == [f"{path}: [recognition] second_ear is called use_network"]
    assert overridden(config, {}).old_names == config.old_names == tuple(caplog.messages)
    both = load_config(write(tmp_path, "[recognition]\nuse_network = true\nsecond_ear = false\n"))
    assert both.recognition.use_network


def test_the_home_folder_is_known_in_all_paths(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", "/home/ada")
    content = """lm = "~/lm"
    language = { acoustic_model = "~/model", dictionary = "~/es.dic", pronunciations = "~/es.tsv" }
    recognition = { network = "~/weights.npz", confidence = "~/~own.json" }
    [commands]
    ring = { play = "~/bell.wav" }
    lamp = [{ run = ["~/bin/lamp", "~", "a~/b", "~other/c"] }]
    [states.menu]
    ring = { play = "bell" }
    """
    config = load_config(write(tmp_path, content))
    language, recognition = config.language, config.recognition
    assert (config.lm, recognition.network) == ("/home/ada/lm", "/home/ada/weights.npz")
    assert recognition.confidence == "/home/ada/~own.json"
    assert language.acoustic_model == "/home/ada/model"
    assert (language.dictionary, language.pronunciations) == (
        "/home/ada/es.dic", "/home/ada/es.tsv"
    )  # fmt: skip
    assert config.commands["ring"] == Step(play="/home/ada/bell.wav")
    run = ("/home/ada/bin/lamp", "/home/ada", "a~/b", "~other/c")
    assert config.commands["lamp"] == (Step(run=run),)
    assert config.states["menu"]["ring"] == Step(play="bell")


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("[commands]\na.say = 'a'\n[safety]\n[commands]\nb.say = 'b'\n",
         "[commands] is in line 1 already: write what is new below that line"),
        ("[commands]\n'a' = {say='a'}\n\na = {say='b'}\n", '"a" is in line 2 already: remove one'),
        ("[commands]\n'a' = {say = 'a'}\na = {say = 'b'}", '"a" is in line 2 already: remove one'),
        ("lm = 'a'\n[safety\n", None),
    ],
)  # fmt: skip
def test_what_is_twice_in_the_file_is_told_with_the_line_where_it_is(
    tmp_path: Path, content: str, told: str | None
) -> None:
    with pytest.raises(ConfigError) as refused:
        load_config(write(tmp_path, content))
    assert str(refused.value).partition("; ")[2] == (told or "")


def test_voz_own_commands_are_known_by_any_capitals(tmp_path: Path) -> None:
    path = write(tmp_path, '[commands]\n"Go  Back" = { drive = -0.2 }\nAdvance = "Go Forward"\n')
    config = load_config(path)
    assert config.table.steps("go back") == (Step(drive=-0.2),)
    assert config.table.steps("Advance") == config.table.steps("go forward") != None  # noqa: E711
    assert config.places["", "go back"] == f"{path}:2"
    with pytest.raises(ConfigError, match=r':2: \[commands\] "stop" is redefined'):
        load_config(write(tmp_path, '[commands]\n"STOP" = { drive = 0.2 }\n'))


def test_who_gives_a_robot_a_table_is_told_its_place(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"`my_robot`; .*; \[own\.MODULE\] is for robots of your"):
        load_config(write(tmp_path, "[my_robot]\nport = 3\n"))


def test_what_a_function_gets_is_what_the_file_says(tmp_path: Path) -> None:
    path = write(tmp_path, '[commands]\nwave = { call = ["arm:wave", 3, 3.0, "{far}", "a"] }\n')
    step = load_config(path).commands["wave"]
    assert isinstance(step, Step)
    assert repr(fill_slots(step, {"far": 2}).call) == "('arm:wave', 3, 3.0, 2, 'a')"


@pytest.mark.parametrize(
    ("content", "what"),
    [
        ("[safety]\nmax_liner = 0.3", "max_liner"),
        ("safety = 3", "safety"),
        ("[ros2]\ncmd_vel = '2nd/cmd_vel'", "cmd_vel"),
        ('[ros1]\ncmd_vel = "cmd_vel\\n"', "cmd_vel"),
        ("[ros1]\nnode = 'españa'", "node"),
        ("[ros2]\ncmd_vel = 'cmd vel'", "cmd_vel"),
        ("[ros2]\nnamespace = 'robot1/'", "namespace"),
        ("[ros2]\ndomain = 233", "domain"),
        ("[safety", "not valid TOML"),
        (b"\xff\xfe", "not UTF-8"),
        ("[safety]\nmax_linear = " + "9" * 5000, "a number that is too long"),
        ("[safety]\nmax_linear = " + "9" * 400, "max_linear"),
        ("a = " + "[" * 3000 + "]" * 3000, "too many tables in each other"),
        ("a = " + "{b = " * 3000 + "1" + "}" * 3000, "too many tables in each other"),
        ('"a\\n\\u001b[31m" = 1', r"unknown field `a\n\x1b[31m`"),
        ("#" * 1_000_001, "larger than 1,000,000 bytes"),
    ],
)
def test_what_cannot_be_is_one_line_that_names_it(
    content: str | bytes, what: str, tmp_path: Path
) -> None:
    path = write(tmp_path, content)
    with pytest.raises(ConfigError) as caught:
        load_config(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert what in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_and_a_folder(tmp_path: Path) -> None:
    for path in (tmp_path / "none.toml", tmp_path):
        with pytest.raises(ConfigError, match="cannot be read"):
            load_config(path)


def test_the_command_line_overrides_and_none_changes_nothing() -> None:
    options = {"lm": "here", "recognition": {"search": "lm", "threshold": None}}
    config = overridden(Config(), options)
    assert (config.lm, config.recognition.search, config.recognition.threshold) == (
        "here",
        "lm",
        Config().recognition.threshold,
    )


@pytest.mark.parametrize(
    ("setting", "what"),
    [
        ("beer = [0.1, 0.1]", "the beer is not on the table"),
        ("cocacola = [2.9, 1.7]", "the cocacola is not on the table"),
        ("room = [2.0, 2.0]", "the table is not within the room"),
        ("start = [0.1, 0.7, 0.0]", "the robot is in a wall"),
        ("start = [2.2, 1.4, 0.0]", "the robot is in the table"),
        ("room = [3.0]", "room"),
        ("radius = 0", "radius"),
        ("arm_speed = nan", "arm_speed"),
    ],
)
def test_a_room_that_cannot_be_is_one_line_that_says_why(
    setting: str, what: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError) as caught:
        load_config(write(tmp_path, f"[simulator]\n{setting}"))
    assert what in str(caught.value)
    assert "simulator" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_room_may_be_another() -> None:
    config = overridden(Config(), {"simulator": {"start": [2, 0.5, 1], "cmd_vel_timeout": 1}})
    assert config.simulator.start == (2.0, 0.5, 1.0)
    assert config.simulator.room == Config().simulator.room


def test_the_settings_in_the_documents_are_the_defaults(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "settings.md").read_text()
    (shown,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    assert load_config(write(tmp_path, shown)) == Config(lm="my_robot")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[commands]\nadvance = { drives = 1 }\n", ':2: [commands] "advance": '),
        ('\n[commands."go far"]\ndrive = 0\n', ':2: [commands] "go far": `drive` is 0'),
        ('[states.menu]\n\n"back" = [{ }]\n', ':3: [states.menu] "back": does nothing'),
        ('[commands]\n"a.b" = 3\n', ':2: [commands] "a.b": Expected'),
        (
            "[commands]\ncome = { drive = 1, meters = 2 }\n",
            ':2: [commands] "come": Object contains unknown field `meters`; did you mean `metres`? '
            "docs/actions.md lists what a command does",
        ),
        (
            '[commands]\nback = "stop"\n\n[states.menu]\nback = { drive = 0.1, blink = 1 }\n',
            ':5: [states.menu] "back": Object contains unknown field `blink`; docs/actions.md',
        ),
        (
            '[safety]\nenabled = true\n[commands]\nadvance = "go forwards"\n',
            ':4: [commands] "advance" is an alias of "go forwards", which is not a command '
            'here; did you mean "go forward"?',
        ),
        (
            '[states.menu]\nback = { drive = 1 }\n[states.other]\nback = { state = "menus" }\n',
            ':4: [states.other] "back" switches to "menus"; there is no [states.menus]',
        ),
    ],
)
def test_a_wrong_command_is_told_with_its_line(tmp_path: Path, text: str, told: str) -> None:
    path = tmp_path / "voz.toml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_config(path)
    assert str(caught.value).startswith(f"{path}{told}")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "[safety]\nmax_liner = 1\n",
            "unknown field `max_liner` - at `$.safety`; did you mean `max_l",
        ),
        (
            "[saftey]\nmax_linear = 1\n",
            "unknown field `saftey`; did you mean `safety`? docs/settings",
        ),
        (
            "[ros2]\nzzz = 1\n",
            "unknown field `zzz` - at `$.ros2`; docs/settings.md lists the settings",
        ),
    ],
)
def test_the_name_that_is_nearest_to_an_unknown_one_is_asked_for(
    tmp_path: Path, text: str, told: str
) -> None:
    with pytest.raises(ConfigError) as caught:
        load_config(write(tmp_path, text))
    assert told in str(caught.value)


def test_an_option_keeps_the_lines_of_the_file(tmp_path: Path) -> None:
    path = write(tmp_path, '[commands]\n\n"wave" = { say = "hello" }\n')
    config = overridden(load_config(path), {"safety": {"enabled": False}})
    assert str(config.table.error_at("", "wave", "is shy")) == f'{path}:3: [commands] "wave" is shy'
    assert str(config.table.error_at("", "stop", "is shy")) == '[commands] "stop" is shy'


def test_own_commands_stand_beside_those_of_voz_and_stop_is_never_missed(tmp_path: Path) -> None:
    path = tmp_path / "voz.toml"
    path.write_text('[commands]\n"para" = "stop"\n"go back" = { drive = -0.3 }\n')
    config = overridden(load_config(path), {})
    assert config.table.steps("go back") == (Step(drive=-0.3),)
    assert config.table.steps("go forward") == (Step(drive=0.1),)
    assert config.recognition.never_missed == ("stop", "para")


if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

DOTTED = """\
commands."by a path".drive = 0.1
commands."by a path".metres = 1
states . menu.back = "stop"
"""

WRITTEN = """\
[language]
name = "x"

[safety]
stop = 1
[ commands ]  # what they do
'in quotes' = { drive = 0.1 }
"several steps" = [
  { drive = 0.1, metres = 1 },
  { stop = true },
]
bare-key={stop=true}
"with \\u0061n escape" = "stop"
[commands."of its own"]
drive = 0.1
say = "in quotes"

[states.menu]
"in quotes" = "stop"
[states."the menu"."in quotes"]
stop = true
[[commands.two]]
drive = 0.1
metres = 1
[[commands.two]]
stop = true
"""


def test_each_way_to_write_a_command_is_found() -> None:
    tomllib.loads(WRITTEN)  # so it is TOML
    assert lines_of_commands(WRITTEN) == {
        ("", "in quotes"): 7,
        ("", "several steps"): 8,
        ("", "bare-key"): 12,
        ("", "with \\u0061n escape"): 13,
        ("", "of its own"): 14,
        ("menu", "in quotes"): 19,
        ("the menu", "in quotes"): 20,
        ("", "two"): 22,
    }
    tomllib.loads(DOTTED)
    assert lines_of_commands(DOTTED) == {("", "by a path"): 1, ("menu", "back"): 3}


NAMES = st.text("abc -.", min_size=1, max_size=6)


@given(st.lists(NAMES, unique=True, max_size=5), st.lists(NAMES, unique=True, max_size=5))
def test_the_lines_of_all_commands_are_right(commands: list[str], states: list[str]) -> None:
    tables = {"commands": "", **{f"states.'{state}'": state for state in states}}
    text: list[str] = []
    expected: dict[tuple[str, str], int] = {}
    for table, state in tables.items():
        text.append(f"[{table}]")
        for name in commands:
            text.append(f"'{name}' = {{ stop = true }}")
            expected[state, name] = len(text)
    written = "\n".join(text)
    tomllib.loads(written)
    assert lines_of_commands(written) == expected


@given(st.text())
def test_no_text_is_too_odd(text: str) -> None:
    assert all(1 <= line <= text.count("\n") + 1 for line in lines_of_commands(text).values())


def test_the_replies_of_its_own_commands_are_in_the_language(tmp_path: Path) -> None:
    path = tmp_path / "voz.toml"
    path.write_text('[language]\nname = "es"\n[commands]\nhola = "start speech"\n')
    assert load_config(path).table.replies == ("bip bip. Te escucho", "bip bip. Dejo de escuchar")
    path.write_text('[language]\nname = "fr"\n[commands]\n"stop speech" = { listen = false }\n')
    assert load_config(path).table.replies == ("bip bip. Je t'écoute",)
    path.write_text('[language]\nname = "sv"\n')
    assert load_config(path).table.replies == default_commands().replies
