"""Which pairs that sound alike are reported: each way to be misunderstood once."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from language.template_texts import commands_of
from recordings import ROOT

from voz.language.command_source import read_list, similar_pairs
from voz.language.sentences.command_set import Commands
from voz.language.similarity.confusion import SimilarPair
from voz.language.similarity.distinct_pairs import distinct_pairs
from voz.language.similarity.similarity_report import WARNING_SIMILARITY


def every_pair(commands: Commands) -> list[SimilarPair]:
    """All pairs, those that come first the most alike."""
    listed = commands.listed
    pairs = [(one, other) for n, one in enumerate(listed) for other in listed[n + 1 :]]
    return [SimilarPair(*pair, 1 - n / len(pairs), ("", "")) for n, pair in enumerate(pairs)]


def risky(path: Path, text: str) -> list[set[str]]:
    path.write_text(text)
    return [
        {pair.first, pair.second}
        for pair in similar_pairs(read_list(path))
        if pair.similarity >= WARNING_SIMILARITY
    ]


@given(first=st.integers(0, 900), count=st.integers(2, 12), step=st.sampled_from([0.5, 1, 15]))
@settings(max_examples=25)
def test_numbers_of_one_range_are_not_compared_with_each_other(
    first: int, count: int, step: float
) -> None:
    commands = commands_of(f"turn: turn {{angle: {first}..{first + count * step} by {step}}}\n")
    assert distinct_pairs(every_pair(commands), commands) == []


def test_words_that_stand_for_numbers_are_compared() -> None:
    commands = commands_of("fly: fly {way} {far: 1..3}\nway = forward:0.5 | backward:-0.5\n")
    (pair,) = distinct_pairs(every_pair(commands), commands)
    assert {pair.first, pair.second} == {"fly forward one", "fly backward one"}


def test_a_number_is_compared_with_other_words(tmp_path: Path) -> None:
    text = "turn: turn {angle: 1..30}\nturn to\nstop\n"
    assert risky(tmp_path / "list.txt", text)[0] == {"turn to", "turn two"}


def test_what_a_simpler_pair_mixes_up_already_is_left_out(tmp_path: Path) -> None:
    template = "bring: [please] (bring|give) me the [{color}] {thing}"
    text = f"{template}\ncolor = red\nthing = cup | cap\n"
    pairs = risky(tmp_path / "list.txt", text)
    assert len(pairs) == 2
    assert {tuple(sorted(one ^ other)) for one, other in (map(words, pair) for pair in pairs)} == {
        ("cap", "cup"),
        ("red",),
    }


def words(sentence: str) -> set[str]:
    return set(sentence.split())


def test_pairs_of_two_commands_are_reported_once_by_the_most_alike() -> None:
    commands = commands_of("go: go (now|on)\nhalt: halt (now|on)\nstop\n")
    pairs = distinct_pairs(every_pair(commands), commands)
    assert [{pair.first, pair.second} for pair in pairs] == [
        {"go now", "halt now"}, {"go now", "stop"}, {"halt now", "stop"},
    ]  # fmt: skip


def test_the_pairs_of_a_plain_list_are_all_reported() -> None:
    pairs = similar_pairs(read_list(ROOT / "lm" / "comandos_voz.txt"))
    assert len([pair for pair in pairs if pair.similarity >= WARNING_SIMILARITY]) == 4


@pytest.mark.parametrize("numbers", ["1..1000", "1..40"])
def test_many_numbers_do_not_hide_the_pairs_of_other_commands(tmp_path: Path, numbers: str) -> None:
    text = f"fly: fly {{way: {numbers}}} metres\nstart speech\nstop speech\nstop\n"
    pairs = risky(tmp_path / "list.txt", text)
    assert pairs[0] == {"start speech", "stop speech"}
    assert len(pairs) <= 3
