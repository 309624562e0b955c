"""Which English phrases voices read to teach the network."""

from __future__ import annotations

import random
from pathlib import Path
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
    groups = english_words.otherwise([["turn", "left"]], words, 200, random.Random(1))
    read = {" ".join(phrase) for (phrase,) in groups}
    assert read == {"table left", "mother left", "turn table", "turn mother"}


def test_texts_to_score_are_read_as_the_dictionary_has_them(
    english_words: ModuleType, tmp_path: Path
) -> None:
    table = tmp_path / "texts.tsv"
    table.write_text(
        "text\tkind\nturn left\tcommand\nburn left\tnear-miss\nrotate zzyzx\tcommand\n"
    )
    kinds = english_words.kinds_of(table)
    assert kinds == {"turn left": "command", "burn left": "near-miss", "rotate zzyzx": "command"}
    listed = {word for text in kinds for word in text.split()}
    words = english_words.readable(english_words.usual_phones(listed))
    assert words.keys() == {"turn", "burn", "left", "rotate"}  # as no dictionary has the other
    assert english_words.read_as(["burn", "left"], words) == (
        "burn left",
        "bˈɜɹn lˈɛft",  # noqa: RUF001
        "B ER N L EH F T",
    )
