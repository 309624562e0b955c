"""Which English phrases voices read to teach the network."""

from __future__ import annotations

import random
from types import ModuleType

import pytest
from recordings import ROOT
from training_programs import load_training

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


def test_a_word_is_read_with_its_stress(english_words: ModuleType) -> None:
    words = english_words.readable({"mother": PHONES["mother"], "remote": "R IH M OW T"})
    assert [word.letters for word in words.values()] == ["mˈʌðəɹ", "ɹɪmˈOt"]  # noqa: RUF001


def test_commands_are_read_with_another_word_and_never_a_neighbor(
    english_words: ModuleType,
) -> None:
    words = english_words.readable(PHONES | {"tern": PHONES["turn"]})
    sounds = {text: word.phones.split() for text, word in words.items()}
    near = english_words.one_phone_apart(sounds)
    groups = english_words.otherwise([["turn", "left"]], words, near, 200, random.Random(1))
    read = {" ".join(phrase) for (phrase,) in groups}
    assert read == {"table left", "mother left", "turn table", "turn mother"}
