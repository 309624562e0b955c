"""Which English phrases voices read to teach the network."""

from __future__ import annotations

import random
from types import ModuleType

import pytest
from recordings import ROOT
from training_programs import load_training

from voz.language.pronunciation import read_cmudict
from voz.language.word_neighbors import Rivals, find_rivals

PHONES = {
    "turn": "T ER N",
    "burn": "B ER N",
    "left": "L EH F T",
    "lift": "L IH F T",
    "table": "T EY B AH L",
    "mother": "M AH DH ER",
}


@pytest.fixture
def english_words(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(ROOT / "training")
    return load_training("english_words")


def rivals() -> Rivals:
    return find_rivals({word: {phones} for word, phones in PHONES.items()}, read_cmudict())


def test_a_word_is_read_with_its_stress(english_words: ModuleType) -> None:
    words = english_words.readable({"mother": PHONES["mother"], "remote": "R IH M OW T"})
    assert [word.letters for word in words] == ["mˈʌðəɹ", "ɹɪmˈOt"]  # noqa: RUF001


def test_a_pair_differs_in_one_word_by_one_phone(english_words: ModuleType) -> None:
    words = english_words.readable(PHONES)
    groups = english_words.phrases(words, rivals(), 200, random.Random(1))
    changed = {
        frozenset(word.text for word in words)
        for group in groups
        if len(group) == 2
        for words in zip(*group, strict=True)
        if words[0] != words[1]
    }
    assert changed == {frozenset(("turn", "burn")), frozenset(("left", "lift"))}


def test_commands_are_read_with_another_word_and_never_a_neighbor(
    english_words: ModuleType,
) -> None:
    words = english_words.readable(PHONES | {"tern": PHONES["turn"]})
    groups = english_words.otherwise([["turn", "left"]], words, rivals(), 200, random.Random(1))
    read = {" ".join(word.text for word in phrase) for (phrase,) in groups}
    assert read == {"table left", "mother left", "turn table", "turn mother"}
