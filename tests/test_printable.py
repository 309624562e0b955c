from __future__ import annotations

import pytest

from voz.printable import printable


@pytest.mark.parametrize("text", ["go forward", "¿ñandú? 東京", "a\\b", ""])
def test_what_is_text_stays(text: str) -> None:
    assert printable(text) == text


@pytest.mark.parametrize(
    ("text", "seen"),
    [
        ("\x1b[2Jgone", r"\x1b[2Jgone"),
        ("\x9b31m", r"\x9b31m"),
        ("done\rfail", r"done\rfail"),
        ("two\nlines\tand a bell\a", r"two\nlines\tand a bell\x07"),
        ("a\u202egpj.exe", r"a\u202egpj.exe"),
        ("\udcff.wav", r"\udcff.wav"),
        ("\U000e0041", r"\U000e0041"),
    ],
)
def test_what_a_terminal_would_obey_is_seen(text: str, seen: str) -> None:
    assert printable(text) == seen
