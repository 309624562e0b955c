# ruff: noqa: RUF001 (letters of the International Phonetic Alphabet)
"""Phones of other languages: how espeak-ng writes them, and the nearest English ones."""

from __future__ import annotations

import pytest

from voz.language.ipa import in_english, known_phones, nearest_english, parse_phones
from voz.language.pronunciation import PHONES


@pytest.mark.parametrize(
    ("written", "phones"),
    [
        ("a_β_ˈa_n_θ_a", "a β a n θ a"),
        ("k_ˈoː_k_a_k_ˌoː_l_ɑː", "k o k a k o l ɑ"),  # long
        ("l_ɑ̃_v_ˈɛ_ʁ", "l ɑ̃ v ɛ ʁ"),
        ("_a_v_ˈa_n_ts_ɑː", "a v a n ts ɑ"),  # a pause first
        ("k_w_ˈa_t__r_e", "k w a t r e"),
        ("v_ˈʏ_ɾ_d_ə", "v ʏ ɾ d ə"),  # from espeak-ng 1.52 on
        ("d_ˈʊɐ_ç", "d ʊɐ ç"),
        ("t̪_w_ˈiː_t̪", "t w i t"),
        ("(en)_w_ˈɪ_n_d_əʊ_z_(de)", "w ɪ n d əʊ z"),  # a foreign word
        ("k_t_??_m_ɜ", "k t m ɜ"),  # a glottal stop
        ("p_a_ss_o", "p a s o"),
        ("k_ˈa p_ˌe", "k a p e"),  # two words
        ("d_ə-_ɡ", "d ə ɡ"),
        ("so\N{COMBINING TILDE}", "sõ"),
        ("", ""),
        ("_", ""),
    ],
)
def test_only_phones_are_kept(written: str, phones: str) -> None:
    assert " ".join(parse_phones(written)) == phones


def test_each_phone_has_nearest_english_ones() -> None:
    assert all(near and PHONES.issuperset(near) for near in nearest_english().values())
    assert nearest_english().keys().isdisjoint(PHONES)
    assert known_phones() == PHONES | nearest_english().keys()
    assert {"ʏ", "ʊɐ"} <= known_phones()  # only newer espeak-ng has them


def test_phones_become_english_ones_but_those_that_are_kept() -> None:
    assert in_english(["s", "e", "ɲ", "a", "K"]) == ("S", "EH", "N", "Y", "AA", "K")
    assert in_english(["ɲ", "x"], kept={"ɲ"}) == ("ɲ", "HH")
