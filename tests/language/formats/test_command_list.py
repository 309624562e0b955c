"""Plain lists, and templates: their imports, and the formats of other programs."""

from __future__ import annotations

import re
import unicodedata
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from voz import CommandsError
from voz.language.formats.command_list import PARSERS, is_templates, parse_commands, read_templates
from voz.language.sentences.command_set import Commands
from voz.language.sentences.spelling import normalize
from voz.language.sentences.text_lines import MAX_TEXT_BYTES
from voz.language.template_compiler import compile_templates


def test_normalize_lowers_case_and_leaves_single_spaces():
    assert normalize("  Go \t BACK ") == "go back"


def test_comments_blank_lines_bom_crlf_and_case_do_not_matter():
    data = b"\xef\xbb\xbf# commands\r\n\r\nGo   Back # trailing\r\n\tSTOP\r\n"
    parsed = parse_commands(data, "list.txt")
    assert parsed.sentences == ("go back", "stop")
    assert parsed.lines == (3, 4)
    assert parsed.warnings == ()


def test_the_order_of_the_list_is_kept():
    assert parse_commands(b"stop\ngo back\narm", "l").sentences == ("stop", "go back", "arm")


def test_a_duplicate_is_kept_once_with_a_warning_that_names_both_lines():
    parsed = parse_commands(b"stop\n\ngo back\nGO  back\n", "list.txt")
    assert parsed.sentences == ("stop", "go back")
    assert parsed.warnings == ('list.txt:4: "go back" is repeated (first in line 3); kept once',)


def test_many_duplicates_give_one_warning():
    parsed = parse_commands(b"stop\n" * 1000, "list.txt")
    assert parsed.warnings == (
        "list.txt: 999 lines repeat an earlier one; each sentence is kept once",
    )


def test_each_word_has_the_place_where_it_first_stands():
    places = parse_commands(b"go back\n\nback up", "l.txt").places()
    assert places == {"go": "l.txt:1", "back": "l.txt:1", "up": "l.txt:3"}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ("stop\nmove ½".encode(), 'l:2: "½" is a digit; write the number as words'),
        (b"stop @ home", 'l:1: "@" cannot be spoken; remove it'),
        (b"stop\n...", "l:2: has no word; remove this line, or write what is said"),
        (b"go\0back", "l:1: the character U+0000 cannot be spoken; remove it"),
        (b"go\x0bback", "U+000B"),
        (b"stop\ncaf\xe9", "l:2: is not UTF-8 text; save the file as UTF-8"),
        (b"a " * 13, "l:1: has 13 words; at most 12 are allowed"),
        (b"a" * 41, "has 41 letters, more than 40; write it as several words"),
        (b"", "l: contains no command; write one sentence per line"),
        (b"# nothing\n \n", "l: contains no command"),
        (b"\n" * (MAX_TEXT_BYTES + 1), "l: larger than 1,000,000 bytes; make it smaller"),
    ],
)
def test_what_cannot_be_used_is_refused_with_what_to_do(data: bytes, message: str):
    with pytest.raises(CommandsError, match=re.escape(message)) as caught:
        parse_commands(data, "l")
    assert "\n" not in str(caught.value)


def test_twelve_words_and_one_million_bytes_are_accepted():
    line = b"a a a a a a a a a a a a"
    assert parse_commands(line.ljust(MAX_TEXT_BYTES), "l").sentences == (line.decode(),)


@given(st.one_of(st.binary(), st.text().map(str.encode)))
@example("\u2028\x85\x1c\u00a0".encode())
@example(b"\xef\xbb\xbf\xef\xbb\xbf")
@example("stop\u00a0now".encode())
def test_any_bytes_give_a_usable_list_or_one_line_of_error(data: bytes):
    sentences, error = outcome(data)
    if error:
        assert error.isprintable()
    else:
        assert sentences
        assert len(set(sentences)) == len(sentences)
        words = [sentence.split(" ") for sentence in sentences]
        assert all(0 < len(each) <= 12 and all(each) for each in words)
        letters = {char for each in words for word in each for char in word} - {"'"}
        assert all(unicodedata.category(char)[0] in "LM" for char in letters)


def outcome(data: bytes) -> tuple[tuple[str, ...], str]:
    try:
        return parse_commands(data, "l").sentences, ""
    except CommandsError as error:
        return (), str(error)


@given(st.text())
def test_normalizing_twice_changes_nothing_for_what_can_be_a_command(text: str):
    plain = "".join(char for char in text if char.isascii())
    assert normalize(normalize(plain)) == normalize(plain)


def load(path: Path, text: str) -> Commands:
    path.write_text(text)
    return compile_templates(read_templates(path)[0]).commands


def parses(commands: Commands, *texts: str) -> list[tuple[str, dict[str, object]] | None]:
    found = [commands.parse(text) for text in texts]
    return [(parse.command, dict(parse.slots)) if parse else None for parse in found]


def test_files_are_imported_once_from_beside_the_one_that_names_them(tmp_path: Path) -> None:
    (tmp_path / "lists").mkdir()
    (tmp_path / "lists" / "things.txt").write_text("import ../main.txt\nthing = cup | box\n")
    (tmp_path / "polite.jsgf").write_text(
        "#JSGF V1.0;\ngrammar p;\n<polite> = please;\npublic <go> = move;\n"
    )
    commands = load(
        tmp_path / "main.txt",
        "import lists/things.txt\nimport polite.jsgf\nimport ./polite.jsgf\n<polite> get {thing}\n",
    )
    assert sorted(commands) == ["move", "please get box", "please get cup"]


def test_a_missing_import_is_named_where_it_stands(tmp_path: Path) -> None:
    path = tmp_path / "main.txt"
    with pytest.raises(
        CommandsError, match=r"main\.txt:2:8: .*other\.txt: cannot be read"
    ) as caught:
        load(path, "stop\nimport other.txt\n")
    assert caught.value.excerpt == ("import other.txt", "       ^")


def test_an_error_in_an_imported_file_names_that_file(tmp_path: Path) -> None:
    (tmp_path / "other.txt").write_text("go (")
    with pytest.raises(CommandsError, match=r"other\.txt:1:5: empty alternative"):
        load(tmp_path / "main.txt", "import other.txt")


def test_the_ending_tells_the_format() -> None:
    assert is_templates(Path("a.ini"), b"stop")
    assert is_templates(Path("a.YAML"), b"stop")
    assert is_templates(Path("a.txt"), b"[please] stop")
    assert not is_templates(Path("a.txt"), b"stop")


RHASSPY = """
# lights
[ChangeLight]
colors = (red | green | deep blue:blue){color}
set [the] light to <colors>
\\[please] turn (on:ON){state} the $room light
dim to (0..100!int){level} percent
make it (warm){how:cosy}

[Stop]
stop
all <ChangeLight.colors> off
"""


def test_rhasspy(tmp_path: Path) -> None:
    (tmp_path / "slots").mkdir()
    (tmp_path / "slots" / "room").write_text("(living room):lounge\n[the] kitchen\n")
    commands = load(tmp_path / "sentences.ini", RHASSPY)
    assert parses(
        commands,
        "set the light to deep blue",
        "turn on the living room light",
        "please turn on the the kitchen light",
        "dim to 35 percent",
        "make it warm",
        "stop",
        "all green off",
        "turn off",
    ) == [
        ("ChangeLight", {"color": "deep blue"}),
        ("ChangeLight", {"state": "ON"}),
        ("ChangeLight", {"state": "ON"}),
        ("ChangeLight", {"level": 35}),
        ("ChangeLight", {"how": "cosy"}),
        ("Stop", {}),
        ("Stop", {"color": "green"}),
        None,
    ]


HASSIL = """
language: en
intents:
  TurnOn:
    data:
      - sentences:
          - "[<polite>] turn on[ the] {place:area} light[s]"
        slots:
          domain: light
      - sentences: ["set {brightness} percent", "set {local}"]
        lists:
          local:
            values: [high]
  Stop:
    data:
      - sentences:
          - stop
lists:
  place:
    values:
      - kitchen
      - in: "(living|sitting) room"
        out: lounge
  brightness:
    range:
      from: 0
      to: 100
      step: 10
expansion_rules:
  polite: "please|would you"
"""


def test_hassil(tmp_path: Path) -> None:
    commands = load(tmp_path / "en.yaml", HASSIL)
    assert parses(
        commands,
        "would you turn on sitting room lights",
        "turn on the kitchen light",
        "set 40 percent",
        "set high",
        "stop",
    ) == [
        ("TurnOn", {"domain": "light", "area": "lounge"}),
        ("TurnOn", {"domain": "light", "area": "kitchen"}),
        ("TurnOn", {"brightness": 40}),
        ("TurnOn", {"local": "high"}),
        ("Stop", {}),
    ]


def test_speech_to_phrase(tmp_path: Path) -> None:
    text = """---
language: "en"
lists:
  color:
    - "white"
    - "red"
expansion_rules:
  set: "start|set"
data:
  - "nevermind"
  - "<set> a timer for 1 minute"
  - sentences:
      - "set [the] lights to {color}"
    domains:
      - "light"
"""
    commands = load(tmp_path / "en.yml", text)
    assert parses(commands, "never mind", "start a timer for one minute", "set lights to red") == [
        None,
        ("start a timer for one minute", {}),
        ("set lights to {color}", {"color": "red"}),
    ]


RHINO = """
context:
  expressions:
    setTimer:
      - "(please) set (a, the) [alarm, timer] for $pv.TwoDigitInteger:minutes [minute, minutes]"
      - "@polite volume $pv.Percent:level"
    changeColor:
      - make it $color:paint
  slots:
    color: [red, sky blue]
  macros:
    polite: [could you, please]
"""


def test_rhino(tmp_path: Path) -> None:
    commands = load(tmp_path / "clock.yml", RHINO)
    assert parses(
        commands,
        "set the timer for 25 minutes",
        "please set alarm for one minute",
        "could you volume fifty percent",
        "make it sky blue",
        "make it",
    ) == [
        ("setTimer", {"minutes": 25}),
        ("setTimer", {"minutes": 1}),
        ("setTimer", {"level": 50}),
        ("changeColor", {"paint": "sky blue"}),
        None,
    ]


JSGF = """#JSGF V1.0 UTF-8 en;
grammar robot;
/* what it
   does */
public <command> = <move> | <robot.paint> | halt {STOP} | (wait | hold) still; // the end
<move> = [ please ] ( /0.7/ go | /0.3/ drive ) <way>;
<way> = forward {1} | "all" back {-1};
<paint> = paint it <color> <NULL>;
<color> = red | deep blue {blue};
"""


def test_jsgf(tmp_path: Path) -> None:
    commands = load(tmp_path / "robot.gram", JSGF)
    assert parses(
        commands, "please go all back", "paint it deep blue", "paint it red", "halt", "hold still"
    ) == [
        ("move", {"way": -1}),
        ("paint", {"color": "blue"}),
        ("paint", {"color": "red"}),
        ("STOP", {}),
        ("hold still", {}),
    ]


def test_of_several_public_rules_each_is_a_command(tmp_path: Path) -> None:
    text = "#JSGF V1.0;\ngrammar g;\npublic <go> = go | move;\npublic <halt> = stop;\n"
    assert parses(load(tmp_path / "g.jsgf", text), "move", "stop") == [("go", {}), ("halt", {})]


CHAIN = "public <go> = <r0>;\n" + "".join(f"<r{n}> = <r{n + 1}>;\n" for n in range(8000))


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.ini", "stop\n", ":1:1: no [Intent] before this line"),
        ("a.ini", "[A]\ngo to $place\n", ':2:7: there is no list "$place"'),
        ("a.ini", "[A]\n{x} go\n", ":2:1: no words before this tag"),
        ("a.ini", "[A]\ngo <B.x>\n", ':2:4: there is no rule "B.x"'),
        ("a.yaml", "a: [b", ":1:6: invalid YAML: "),
        ("a.yaml", "", ":1: is empty"),
        ("a.yaml", "words: 1\n", ':1:1: expected "intents" (hassil) or "context"'),
        ("a.yaml", "intents:\n  A: stop\n", ":2:6: expected the data of the intent"),
        (
            "a.yaml",
            "data:\n  - 'go {x}'\nlists:\n  x: {wildcard: true}",
            ":2:6: this sentence is left out, as wildcards are not supported",
        ),
        ("a.yaml", "data: ['go @ on']\n", ':1:12: "@" cannot be spoken'),
        (
            "a.yaml",
            "context: {expressions: {a: ['go $pv.Foo:b']}}",
            "supported slots of Rhino are $pv.Single",
        ),
        ("a.yaml", "context: {expressions: {a: ['go $b:c']}}", 'there is no list "b"'),
        ("a.gram", "#JSGF V1.0;\ngrammar a;\npublic <a> = go+;\n", ':3:16: "+" repeats without'),
        ("a.gram", "grammar a;\npublic <a> = go (b)*;\n", ':2:20: "*" repeats without'),
        ("a.gram", "grammar a;\npublic <a> = /x/ go | /1/ b;\n", ":2:14: /x/ is not a weight"),
        ("a.gram", "grammar a;\npublic <a> = go <b>;\n<b> = c <a>;", "is recursive"),
        ("a.gram", "grammar a;\n<a> = go;\n", ":1: no rule is public"),
        ("a.gram", "grammar a;\nimport <b.c>;\n", ":2:1: imports are not supported"),
        ("a.gram", "grammar a;\npublic <a> = go\n", ":2:1: the rule <a> does not end"),
        (
            "a.gram",
            "grammar a;\npublic <a> = go\n<b> = c;\n",
            ':2:1: the rule <a> does not end; write ";"',
        ),
        ("a.gram", CHAIN, ":32:9: more than 30 nested names"),
    ],
)
def test_what_cannot_be_done_is_refused_with_its_place(
    tmp_path: Path, name: str, text: str, message: str
) -> None:
    with pytest.raises(CommandsError, match=re.escape(message)) as caught:
        load(tmp_path / name, text)
    assert str(caught.value).startswith(f"{tmp_path / name}:")


@given(
    st.sampled_from(sorted(PARSERS)),
    st.sampled_from([RHASSPY.replace("$room", "hall"), HASSIL, RHINO, JSGF]),
    st.lists(
        st.tuples(st.integers(0, 500), st.sampled_from("[](){}<>|;:=\"'$@,.-\n ax1")), max_size=4
    ),
)
def test_a_damaged_file_gives_sentences_or_one_line_of_error(
    tmp_path_factory: pytest.TempPathFactory,
    ending: str,
    text: str,
    damage: list[tuple[int, str]],
) -> None:
    broken = list(text)
    for at, char in damage:
        broken[at % len(broken)] = char
    path = tmp_path_factory.mktemp("damaged") / f"a{ending}"
    message = ""
    try:
        assert load(path, "".join(broken)).sample(3)
    except CommandsError as error:
        message = str(error)
    assert message.isprintable()
