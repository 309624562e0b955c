"""Words of the dictionary that are one phone away from those of a list."""

from __future__ import annotations

import pytest

from voz.language.phones import known_phones
from voz.language.pronunciation import look_up, read_cmudict
from voz.language.word_neighbors import (
    COMMON_WORDS,
    MIN_PHONES,
    decode_rivals,
    encode_rivals,
    everyday_words,
    find_rivals,
    find_rivals_by_sound,
    neighbors,
    read_common_words,
)


def rivals_of(*words: str) -> dict[str, set[str]]:
    """The rival words of each word."""
    cmudict = read_cmudict()
    found = find_rivals({word: look_up(cmudict, word) for word in words}, cmudict)
    return {
        word: {other for names in ways.values() for other in names} for word, ways in found.items()
    }


def test_one_phone_is_another_or_left_out_or_too_many() -> None:
    found = rivals_of("fold", "arm")
    assert {"cold", "old", "folds"} <= found["fold"]
    assert {"charm", "are", "art"} <= found["arm"]
    assert "phone" not in found["fold"]


def test_what_sounds_the_same_is_no_rival_nor_what_is_two_phones_away() -> None:
    found = rivals_of("right", "stop")
    assert not {"write", "rite", "right", "light's"} & found["right"]
    assert {"light", "ride", "rat"} <= found["right"]
    assert not {"flop", "stomped", "chop"} & found["stop"]


def test_of_several_pronunciations_none_is_a_rival_of_another() -> None:
    found = find_rivals({"a": ["AH", "EY"]}, b"\na AH\na(2) EY\noh OW\nuh AH\nay EY\nug AH G\n")
    assert found == {"a": {"AH G": ("ug",), "OW": ("oh",)}}


def test_in_another_language_long_words_have_those_that_are_common() -> None:
    said = {"caja": ["k a x a", "k a h a"], "la": ["l a"], "va": ["b a", "b a j a"]}
    common = {"k a s a", "k a h a", "b a x a", "k a x a s", "k o s a", "l o"}
    found = find_rivals_by_sound(said, common)
    assert found == {
        "caja": {"b a x a": (), "k a s a": (), "k a x a s": ()},
        "la": {},
        "va": {"b a x a": ()},
    }


@pytest.mark.parametrize("language", ["de", "es", "fr", "it", "pt"])
def test_a_language_brings_its_common_words(language: str) -> None:
    words = [way.split() for way in read_common_words(language)]
    assert len(words) > 10_000
    assert min(map(len, words)) == MIN_PHONES - 1
    assert known_phones().issuperset(phone for way in words for phone in way)


def test_of_other_languages_no_words_are_known() -> None:
    assert not read_common_words("nl")
    assert read_common_words("es-419") == read_common_words("es")
    assert {"k a s a", "k a x a"} <= read_common_words("es")
    assert len([*COMMON_WORDS.glob("*.gz")]) == 5


def test_they_are_kept_as_text() -> None:
    found = {
        "fold": {"K OW L D": ("cold",), "T OW L D": ("told", "tolled")},
        "caja": {"k a s a": ()},
    }
    text = encode_rivals(found)
    assert text == "fold\tK OW L D\tcold\nfold\tT OW L D\ttold tolled\ncaja\tk a s a\t\n"
    assert decode_rivals(text) == found


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("fold\n", "not enough values"),
        ("fold\tK OO\tcold\n", "'K OO' are not all phones"),
        ("fold\t\tcold\n", "'' are not all phones"),
        ("fold\tK\tcold\tmore\n", "too many values"),
    ],
)
def test_other_text_is_refused(text: str, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        decode_rivals(text)


def test_everyday_words_are_those_of_the_language_model() -> None:
    words = ["cold", "hold", "folds", "tern", "zorblax", "r.", "a"]
    assert everyday_words(words) == {"cold", "hold"}


def test_the_nearest_phrases_come_first_and_few() -> None:
    ways = {word: look_up(read_cmudict(), word) for word in ("fold", "arm")}
    rivals = find_rivals(ways, read_cmudict())
    near = neighbors("fold arm", ways, rivals, {"cold", "hold", "mold", "folds", "charm", "art"})
    assert len(near) == 5
    assert near[:3] == ["folds arm", "hold arm", "cold arm"]
    assert neighbors("fold arm", ways, rivals, {"cold"}) == ["cold arm"]
    assert neighbors("fold arm", ways, rivals, ()) == []
