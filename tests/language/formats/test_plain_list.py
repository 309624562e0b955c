from __future__ import annotations

import re
import unicodedata

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from voz import CommandsError
from voz.language.formats.plain_list import parse_commands
from voz.language.formats.text_lines import MAX_TEXT_BYTES
from voz.language.sentences.spelling import normalize


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
        (b"stop\nmove 5", 'l:2: "5" is a digit; write the number as words'),
        (b"stop!", 'l:1: "!" cannot be spoken; remove it'),
        (b"x-ray", 'l:1: "-" cannot be spoken; write a space instead'),
        ("don’t".encode(), "write a plain apostrophe (')"),  # noqa: RUF001
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
