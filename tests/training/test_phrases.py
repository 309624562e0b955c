"""Which words are one phone apart, and which phrases are made of them."""

from __future__ import annotations

import random

from training_programs import load_training

phrases = load_training("phrases")

PHONES = {"fold": "f ow l d", "cold": "k ow l d", "old": "ow l d", "told": "t ow l d", "arm": "a m"}


def near() -> dict[str, list[str]]:
    found: dict[str, list[str]] = phrases.one_phone_apart(
        {word: said.split() for word, said in PHONES.items()}
    )
    return found


def test_neighbors_have_another_phone_or_one_more() -> None:
    assert near() == {
        "fold": ["cold", "old", "told"],
        "cold": ["fold", "old", "told"],
        "old": ["cold", "fold", "told"],
        "told": ["cold", "fold", "old"],
        "arm": [],
    }


def test_a_word_said_alike_is_no_neighbor() -> None:
    assert phrases.one_phone_apart({"son": "s u n", "sun": "s u n", "run": "r u n"}) == {
        "son": ["run"],
        "sun": ["run"],
        "run": ["son", "sun"],
    }


def test_a_pair_differs_in_one_word_by_one_phone() -> None:
    groups = phrases.choose_phrases(near(), 300, random.Random(1))
    assert {len(group) for group in groups} == {1, 2}
    for group in groups:
        if len(group) == 2:
            (changed,) = ({*words} for words in zip(*group, strict=True) if words[0] != words[1])
            assert changed < {"fold", "cold", "old", "told"}
