"""Where commands stand in a voz.toml, in all ways to write one."""

from __future__ import annotations

import sys

from hypothesis import given
from hypothesis import strategies as st

from voz.toml_lines import lines_of_commands

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
