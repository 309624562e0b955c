"""Where something stands in a passage, for messages."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from voz.language.sentences.text_lines import Passage


@given(
    st.text("ab \n", max_size=30),
    st.integers(1, 9),
    st.integers(0, 9),
    st.sampled_from(["", "all"]),
)
def test_a_place_has_the_line_and_the_column_of_its_character(
    text: str, line: int, column: int, whole: str
) -> None:
    passage = Passage("list.txt", line, column, text, whole)
    for at in range(len(text) + 1):
        place = passage.place(at)
        lines = text[:at].split("\n")
        first = len(lines) == 1
        assert (place.file, place.line) == ("list.txt", line + len(lines) - 1)
        assert place.column == len(lines[-1]) + 1 + (column if first else 0)
        assert place.text == (whole if whole and first else text.split("\n")[len(lines) - 1])


class Counted(str):
    """A text that counts how many of its characters are read by what makes copies of it."""

    read = 0

    def split(self, *separator: object) -> list[str]:  # type: ignore[override]
        Counted.read += len(self)
        return super().split(*separator)  # type: ignore[arg-type]

    def __getitem__(self, part: object) -> str:
        found = super().__getitem__(part)  # type: ignore[index]
        Counted.read += len(found)
        return found


def test_the_places_of_thousands_of_rules_are_found_in_one_reading() -> None:
    text = Counted("<a> = b;\n" * 8000)
    passage = Passage("list.gram", 1, 0, text)
    assert [passage.place(9 * n).line for n in range(8000)] == list(range(1, 8001))
    assert Counted.read == len(text)
