"""A manifest is text that people edit: what was written is read again, whatever they leave."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from voz.apps.recordings.manifest_text import ManifestLine, join_lines, parse_lines, parse_records

FIELD = st.text(st.characters(exclude_characters="\t\n\r", exclude_categories=["Cs"]))
ROWS = st.lists(st.lists(FIELD, min_size=1).filter(lambda fields: "".join(fields).strip()))


@given(ROWS)
def test_what_is_written_is_read_again(rows: list[list[str]]) -> None:
    assert [row.fields for row in parse_lines(join_lines(rows))] == rows


@given(ROWS)
def test_ends_of_lines_may_be_others_and_the_last_be_missing(rows: list[list[str]]) -> None:
    text = join_lines(rows)
    assert parse_lines(text.replace("\n", "\r\n")) == parse_lines(text)
    assert parse_lines(text.removesuffix("\n")) == parse_lines(text)


def test_empty_lines_are_left_out_and_counted() -> None:
    assert parse_lines("a\tb\n\n  \n\t\nc\n") == [
        ManifestLine(1, ["a", "b"]),
        ManifestLine(5, ["c"]),
    ]
    assert parse_lines("") == []


def test_an_empty_field_stays_one() -> None:
    assert parse_lines("a\t\tb\t\n") == [ManifestLine(1, ["a", "", "b", ""])]


def test_a_quote_is_a_character_like_others() -> None:
    assert parse_lines('"a\tb"\n') == [ManifestLine(1, ['"a', 'b"'])]


def test_records_have_the_names_of_the_columns() -> None:
    records = parse_records("file\ttext\na.wav\tgo back\nb.wav\t\n")
    assert records == [{"file": "a.wav", "text": "go back"}, {"file": "b.wav", "text": ""}]
