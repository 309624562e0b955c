"""How an utterance looks in a notebook."""

from __future__ import annotations

from html.parser import HTMLParser

import pytest
from msgspec.structs import replace

import voz

HEARD = voz.Utterance(
    5.6, "go forward", 0.98, True, 4.7, 5.6, "microphone", above=31.4, latency=0.2, score=24.9,
    next_best="go back",
)  # fmt: skip


class Page(HTMLParser):
    """What a browser shows: texts."""

    def __init__(self, heard: voz.Utterance) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.texts: list[str] = []
        self.feed(heard._repr_html_())
        self.close()
        self.text = " ".join(self.texts)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_it_says_what_was_heard_and_both_opinions() -> None:
    page = Page(HEARD)
    for part in ("“go forward”", "accepted", "98% sure", "also have been “go back”", "24.9"):
        assert part in page.text
    refused = replace(HEARD, accepted=False, command=None, reason="part_of_a_command", score=-4.2)
    assert "not accepted: part of a command" in Page(refused).text
    assert "rather hears something else" in Page(refused).text
    unsure = replace(refused, reason="unsure_between", between=("go back", "go forward"))
    assert 'unsure between "go back" and "go forward"' in Page(unsure).text
    assert "It was not asked" in Page(replace(HEARD, score=None)).text
    assert "It was typed" in Page(replace(HEARD, above=None, latency=None, source="text")).text


def test_no_text_is_taken_for_markup() -> None:
    odd = '<script>alert("&amp;")</script>'
    page = Page(replace(HEARD, text=odd, next_best=odd, accepted=False, between=(odd, odd)))
    assert page.tags == Page(HEARD).tags
    assert page.text.count(odd) == 4


@pytest.mark.parametrize("heard", [HEARD, replace(HEARD, text="two\nlines")])
def test_its_repr_is_one_line(heard: voz.Utterance) -> None:
    assert "\n" not in repr(heard)
    assert str(heard) == heard.text
