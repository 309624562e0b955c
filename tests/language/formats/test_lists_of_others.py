"""Lists as people have them: small files that went wrong, each of a kind of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from voz.errors import CommandsError
from voz.language.command_source import CommandSource, read_list


def read(tmp_path: Path, name: str, text: str) -> CommandSource:
    path = tmp_path / name
    path.write_text(text)
    return read_list(path)


def meant(source: CommandSource, text: str) -> tuple[str, dict[str, object]] | None:
    parse = source.commands.parse(text)
    return parse and (parse.command, dict(parse.slots))


HASSIL = """language: en
intents:
  Do:
    data:
      - sentences: [%s]
"""


@pytest.mark.parametrize(
    ("name", "text", "said", "found"),
    [
        ("a.ini", "[Timer]\nset timer to (half:30!int | quarter:15!int){min} minutes\n",
         "set timer to half minutes", ("Timer", {"min": 30})),
        ("a.ini", "[A]\nlamp (on:true!bool | off:false!bool){state}\n",
         "lamp off", ("A", {"state": False})),
        ("a.ini", "[A]\nlamp (on:yes | off:no){state!bool}\n", "lamp on", ("A", {"state": True})),
        ("a.ini", "[A]\npaint it (red | blue)!upper{color}\n",
         "paint it blue", ("A", {"color": "BLUE"})),
        ("a.ini", "[A]\ngo (one:1 | two:2){far!float}\n", "go two", ("A", {"far": 2.0})),
        ("a.ini", "[T]\nh = (1..9){h} [and (a half){m:30!int}]\nm = (1..59){m}\nwait <h> [<m>]\n",
         "wait two and a half five", ("T", {"h": 2, "m": 5})),
        ("a.yaml", HASSIL % '"set a timer for {m}( |-)minute[s]"'
         + "lists:\n  m: {range: {from: 1, to: 5}}\n",
         "set a timer for two minutes", ("Do", {"m": 2})),
        ("a.yaml", HASSIL % '"dim to {p}[ ][%| percent]"'
         + "lists:\n  p: {range: {from: 1, to: 50}}\n",
         "dim to 50%", ("Do", {"p": 50})),
        ("a.yaml", HASSIL % '"dim to {0..100:x}%"', "dim to 50 %", ("Do", {"x": 50})),
        ("a.yaml", HASSIL % '"heat to {t} degrees"'
         + "lists:\n  t: {range: {type: temperature, from: 19, to: 21, fractions: halves}}\n",
         "heat to nineteen and a half degrees", ("Do", {"t": 19.5})),
        ("a.yaml", HASSIL % '"volume {v}"'
         + "lists:\n  v: {range: {from: 0, to: 10, multiplier: 10}}\n",
         "volume three", ("Do", {"v": 30})),
        ("a.yaml", HASSIL % '"lamp on"' + 'skip_words: ["please", "can you"]\n',
         "please lamp on", ("Do", {})),
        ("a.yaml", HASSIL % '"lamp on"' + 'skip_words: ["please", "can you"]\n',
         "lamp on please", ("Do", {})),
        ("a.yaml", "sentences:\n  - go home\n  - {in: [lights out, dark], out: lights off}\n",
         "dark", ("lights off", {})),
        ("a.jsgf", "#JSGF V1.0;\ngrammar g;\npublic <c> = /10/ open gate | /2/ close gate;\n",
         "close gate", ("close gate", {})),
        ("a.jsgf", "grammar g;\npublic <go-on> = go {http://a.b/c};\n",
         "go", ("http://a.b/c", {})),
        ("a.jsgf", "grammar g;\npublic <a> = go | stop;\npublic <b> = stop | hold;\n",
         "stop", ("a", {})),
        ("a.kwlist", "go forward /1e-20/\nstop/1.0/\nhold still\n", "stop", ("stop", {})),
        ("a.txt", "stop\nhow are you?\ngo 2 meters\n", "go two meters", ("go two meters", {})),
        ("a.txt", "self-test\nrock & roll\nopen_gripper\n", "open gripper", ("open gripper", {})),
        ("a.txt", "Don’t go\n'halt'\n", "don't go", ("don't go", {})),  # noqa: RUF001
    ],
)  # fmt: skip
def test_what_others_write_is_understood(
    tmp_path: Path, name: str, text: str, said: str, found: tuple[str, dict[str, object]]
) -> None:
    assert meant(read(tmp_path, name, text), said) == found


@pytest.mark.parametrize(
    ("name", "text", "warning"),
    [
        ("a.ini", "[P]\ni = (one:1 | two:2)\ni = (one:1 | two:2)\ntake <i>\n",
         'the rule "P.i" is there twice'),
        ("a.jsgf", "grammar g;\npublic <a> = go | stop;\npublic <b> = stop;\n",
         '"stop" is a sentence of "a" already'),
        ("a.yaml", HASSIL % '"go", "say {x}"' + "lists:\n  x: {wildcard: true}\n",
         "this sentence is left out, as wildcards are not supported"),
        ("a.yaml", HASSIL % '"go"'
         + "      - {sentences: [come], requires_context: {domain: light}}\n",
         "1 sentences are left out, as requires_context is not supported"),
    ],
)  # fmt: skip
def test_what_is_not_taken_as_it_stands_is_told(
    tmp_path: Path, name: str, text: str, warning: str
) -> None:
    assert warning in "\n".join(read(tmp_path, name, text).warnings)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.ini", "[A]\n(one | two)!int{n}\n", '"one" cannot be converted by !int'),
        ("a.ini", "[A]\none:inf!int\n", '"inf" cannot be converted by !int'),
        ("a.ini", "[A]\n(up:inf){n!float}\n", '"inf" cannot be converted by !float'),
        ("a.ini", "[A]\non:maybe!bool\n", '"maybe" cannot be converted by !bool'),
        ("a.ini", "[A]\none!round\n", "there is no converter round; the converters are int"),
        ("a.yaml", HASSIL % '"heat <name>"' + 'expansion_rules:\n  name: "[the] {name}"\n',
         'there is no list "name" (Home Assistant fills it itself); add it, as in: lists:'),
        ("a.yaml", HASSIL % '"raise <blind>"', 'add it, as in: expansion_rules: {blind: "'),
        ("a.jsgf", "grammar g;\npublic <a> = <b>;\n", "add it, as in: <b> = red | green;"),
    ],
)  # fmt: skip
def test_advice_is_in_the_notation_of_the_file(
    tmp_path: Path, name: str, text: str, message: str
) -> None:
    with pytest.raises(CommandsError) as caught:
        read(tmp_path, name, text)
    assert message in str(caught.value)


def test_what_only_left_out_sentences_use_is_no_fault(tmp_path: Path) -> None:
    text = HASSIL % '"go", "tell <whom> that <what>"' + (
        "lists:\n  x: {wildcard: true}\nexpansion_rules:\n  whom: ann\n  what: it is {x}\n"
    )
    (warning,) = read(tmp_path, "a.yaml", text).warnings
    assert "this sentence is left out, as wildcards are not supported" in warning


def test_many_sentences_that_are_left_out_are_one_line(tmp_path: Path) -> None:
    block = "      - {sentences: [come], requires_context: {area: hall}}\n"
    (warning,) = read(tmp_path, "a.yaml", HASSIL % '"go"' + 11 * block).warnings
    assert "sentences are left out in 11 places" in warning


def test_all_faults_of_a_file_are_told_at_once(tmp_path: Path) -> None:
    for text in ("go @ home\nstop\nturn *\n", "go @ (home)\nstop\nturn *\n"):
        with pytest.raises(CommandsError) as caught:
            read(tmp_path, "a.txt", text)
        told = [str(caught.value), *caught.value.excerpt]
        assert [line for line in told if "cannot be spoken" in line and ":1" in line]
        assert [line for line in told if "cannot be spoken" in line and ":3" in line]


def test_a_folder_is_one_list_and_changes_with_its_files(tmp_path: Path) -> None:
    (tmp_path / "_common.yaml").write_text("lists:\n  room: {values: [kitchen, hall]}\n")
    (tmp_path / "clean.yaml").write_text(HASSIL % '"clean the {room}"')
    (tmp_path / "notes.txt").write_text("no list")
    source = read_list(tmp_path)
    assert meant(source, "clean the hall") == ("Do", {"room": "hall"})
    assert list(source.files_read) == [tmp_path, tmp_path / "_common.yaml", tmp_path / "clean.yaml"]
    listed = source.files_read[tmp_path]
    (tmp_path / "more.ini").write_text("[A]\nstop\n")
    assert read_list(tmp_path).files_read[tmp_path] != listed


def test_a_folder_with_one_list_is_that_list(tmp_path: Path) -> None:
    (tmp_path / "comandos_voz.txt").write_text("stop\n")
    (tmp_path / "tests.txt").write_text("stop\n")
    source = read_list(tmp_path)
    assert (source.compiled, source.name) == (None, str(tmp_path / "comandos_voz.txt"))


def test_acronyms_are_spelled_and_shown_as_a_guess(tmp_path: Path) -> None:
    entries = read(tmp_path, "a.txt", "stop\nMQTT on\nPTZ camera\nlift 2 kg\n").entries
    assert entries["mqtt"].phones == ("EH M K Y UW T IY T IY",)
    assert entries["ptz"].phones == ("P IY T IY Z IY",)
    assert entries["kg"].phones[0] == "K EY JH IY"
    assert entries["mqtt"].origin == "letter by letter (a guess)"
