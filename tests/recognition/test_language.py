"""Pronunciations of other accents."""

from __future__ import annotations

from voz.language.phones import PHONES
from voz.recognition.language import BRITISH_FILE, added, with_british, with_rounded


def test_the_open_o_is_also_said_rounded() -> None:
    words = {"stop": ("S", "T", "AA", "P"), "go": ("G", "OW")}
    assert added(words, with_rounded(words)) == {"stop(2)": ("S", "T", "AO", "P")}


def test_it_is_an_o_that_is_written_and_no_r_that_follows() -> None:
    words = {"father": ("F", "AA", "DH", "ER"), "sorry": ("S", "AA", "R", "IY")}
    assert with_rounded(words) == words


def test_what_is_known_is_not_added_again_and_numbers_go_on() -> None:
    words = {
        "on": ("AA", "N"),
        "on(2)": ("AO", "N"),
        "rocks": ("R", "AA", "K", "S"),
        "rocks(2)": ("R", "AA", "K"),
    }
    assert added(words, with_rounded(words)) == {
        "rocks(3)": ("R", "AO", "K", "S"),
        "rocks(4)": ("R", "AO", "K"),
    }


def test_british_pronunciations_are_added() -> None:
    words = {"half": ("HH", "AE", "F"), "hover": ("HH", "AH", "V", "ER")}
    assert added(words, with_british(words)) == {
        "half(2)": ("HH", "AA", "F"),
        "hover(2)": ("HH", "AO", "V", "ER"),
    }


def test_the_file_of_british_pronunciations_has_phones_of_the_dictionary() -> None:
    lines = BRITISH_FILE.read_text(encoding="utf-8").splitlines()
    assert lines == sorted(set(lines), key=lines.index)
    for line in lines:
        word, _, phones = line.partition("\t")
        assert word.isascii()
        assert PHONES.issuperset(phones.split()), line
