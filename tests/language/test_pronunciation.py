from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from voz import CommandsError
from voz.language.phones import PHONES
from voz.language.pronunciation import (
    FESTIVAL_PHONES,
    FestivalError,
    find_anywhere,
    guess,
    look_up,
    parse_pronunciations,
    pronounce,
    read_cmudict,
    run_festival,
    split_compound,
    words_in_capitals,
)


@pytest.fixture(scope="module")
def cmudict() -> bytes:
    return read_cmudict()


def no_guess(words: Sequence[str]) -> dict[str, str]:
    return {}


def test_every_phone_of_the_cmu_dictionary_is_known_and_no_other(cmudict: bytes):
    used = {phone for line in cmudict.decode().splitlines() for phone in line.split()[1:]}
    assert used == PHONES


@pytest.mark.parametrize(
    ("word", "phones"),
    [
        ("stop", ("S T AA P",)),
        ("the", ("DH AH", "DH IY")),
        ("'bout", ("B AW T",)),  # the first line
        ("zywicki", ("Z IH W IH K IY",)),  # the last line
        ("don't", ("D OW N T", "D OW N")),
        ("zorblax", ()),
        ("", ()),
        ("zzzzzz", ()),
    ],
)
def test_looking_up_gives_all_variants_in_order(cmudict: bytes, word: str, phones: tuple[str]):
    assert look_up(cmudict, word) == phones


def test_looking_up_agrees_with_a_plain_reading_of_the_dictionary(cmudict: bytes):
    plain: dict[str, list[str]] = {}
    for line in cmudict.decode().splitlines():
        word, _, phones = line.partition(" ")
        plain.setdefault(word.partition("(")[0], []).append(phones)
    some = list(plain)[::97]
    found = [look_up(cmudict, word) or find_anywhere(cmudict, word) for word in some]
    assert found == [tuple(plain[word]) for word in some]


def test_a_word_that_is_out_of_order_is_found_all_the_same():
    cmudict = b"a AH\nstop S T AA P\nbeer B IH R\nbeer(2) B IY R\ngo G OW\nup AH P\n"
    assert look_up(cmudict, "beer") == ()
    assert find_anywhere(cmudict, "beer") == ("B IH R", "B IY R")
    assert find_anywhere(cmudict, "bee") == ()
    assert pronounce({"beer": "p:1"}, {}, cmudict, no_guess)["beer"].origin == "cmudict"


def test_own_pronunciations_allow_variants_stress_case_and_comments():
    data = b"# mine\nZorblax z ao1 r b l ae0 k s\nzorblax(2) Z AO R\nzorblax Z AO R # again\n"
    assert parse_pronunciations(data, "p") == {"zorblax": ("Z AO R B L AE K S", "Z AO R")}


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"\nstop S T QQ P", "p:2: 'QQ' is not a phone; the phones are AA AE"),
        (b"stop", "p:1: no phones after the word"),
        (b"st0p S T AA P", "p:1: 'st0p' is not a word"),
        (b"stop \xff", "p:1: is not UTF-8 text"),
    ],
)
def test_a_wrong_pronunciation_is_refused_with_its_line(data: bytes, message: str):
    with pytest.raises(CommandsError, match=re.escape(message)):
        parse_pronunciations(data, "p")


@given(st.one_of(st.binary(), st.text().map(str.encode)))
def test_any_bytes_give_pronunciations_or_one_line_of_error(data: bytes):
    found, error = outcome(data)
    assert error.isprintable()
    assert all(PHONES.issuperset(p.split()) for variants in found.values() for p in variants)


def outcome(data: bytes) -> tuple[dict[str, tuple[str, ...]], str]:
    try:
        return parse_pronunciations(data, "p"), ""
    except CommandsError as error:
        return {}, str(error)


def test_the_users_words_are_parts_of_compounds_too(cmudict: bytes):
    entry = pronounce({"zorbcola": "l:1"}, {"zorb": ("Z AO R B",)}, cmudict, no_guess)["zorbcola"]
    assert entry.phones == ("Z AO R B K OW L AH",)


@pytest.mark.parametrize(
    ("word", "known", "parts"),
    [
        ("cocacola", {"coca", "cola"}, ("coca", "cola")),
        ("onetwosix", {"one", "two", "six"}, ("one", "two", "six")),
        ("onetwosix", {"one", "two", "six", "twosix"}, ("one", "twosix")),  # fewest parts
        ("abcdefgh", {"abc", "defgh", "abcd", "efgh"}, ("abcd", "efgh")),  # most even
        ("abcdefg", {"abc", "defg", "abcd", "efg"}, ("abcd", "efg")),  # longer beginning
        ("abcd", {"ab", "cd"}, ()),  # parts too short
        ("", {"abc"}, ()),
    ],
)
def test_a_compound_is_split_in_the_most_sensible_way(
    word: str, known: set[str], parts: tuple[str, ...]
):
    assert split_compound(word, known.__contains__) == parts


@pytest.mark.parametrize(
    ("word", "phones"),
    [
        ("gpio", ("JH IY P IY AY OW",)),  # no English word begins so
        ("rfid", ("AA R EH F AY D IY",)),
        ("imu", ("AY EH M Y UW", "Z")),  # rather spelled
        ("lidar", ("Z", "EH L AY D IY EY AA R")),  # rather a word
        ("nasa", ("N AE S AH",)),
    ],
)
def test_short_words_in_capitals_may_be_spelled(
    cmudict: bytes, word: str, phones: tuple[str, ...]
) -> None:
    found = pronounce({word: "l:1"}, {}, cmudict, lambda _: {word: "Z"}, {word})
    assert found[word].phones == phones


def test_capitals_are_of_use_where_not_all_is_in_capitals() -> None:
    assert words_in_capitals(["lidar on\nGPIO off\n", "LIDAR off\nSHUTDOWN"]) == {"gpio"}
    assert words_in_capitals(["GO FORWARD\nLIDAR ON\n"]) == set()


def test_without_festival_the_message_names_the_word_and_its_line(cmudict: bytes):
    def fails(words: Sequence[str]) -> dict[str, str]:
        raise FestivalError("festival is not installed; install it")

    expected = (
        'l:2: "zorblax" is in no dictionary, and festival is not installed; install it, '
        "or add the word to pronunciations.txt"
    )
    with pytest.raises(CommandsError, match=re.escape(expected)):
        pronounce({"stop": "l:1", "zorblax": "l:2"}, {}, cmudict, fails)


def test_a_word_that_nothing_can_pronounce_is_refused(cmudict: bytes):
    expected = "l:7: nothing knows how to pronounce \"''\"; use another word"
    with pytest.raises(CommandsError, match=re.escape(expected)):
        pronounce({"''": "l:7"}, {}, cmudict, no_guess)


def test_festival_guesses_in_the_phones_of_the_model():
    guesses = guess(["zorblax", "fribblethorn", "o'zorb", "''"])
    assert guesses["zorblax"] == "Z AO R B L AE K S"
    assert set(guesses) == {"zorblax", "fribblethorn", "o'zorb"}
    assert all(PHONES.issuperset(phones.split()) for phones in guesses.values())


def test_every_phone_of_festival_becomes_phones_of_the_model():
    program = "(setup_cmu_lex)\n(mapcar (lambda (p) (print (car p))) (cadr (assoc 'phones ("
    program += "PhoneSet.description))))\n"
    phones = re.findall("^[a-z]+$", run_festival(program), re.MULTILINE)
    assert len(phones) > 40
    for phone in phones:
        known = FESTIVAL_PHONES.get(phone, phone.upper())
        assert known is None or PHONES.issuperset(known.split()), phone


def test_what_could_be_scheme_never_reaches_festival():
    with pytest.raises(ValueError, match="not a plain word"):
        guess(['x" nil))(system "reboot'])


def test_a_missing_festival_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(FestivalError, match="not installed; install it \\(apt-get install"):
        guess(["zorblax"])


def _fake_festival(folder: Path, script: str, monkeypatch: pytest.MonkeyPatch) -> None:
    program = folder / "festival"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder), prepend=":")


def test_a_festival_that_hangs_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    _fake_festival(tmp_path, "exec sleep 60", monkeypatch)
    monkeypatch.setattr("voz.language.pronunciation.FESTIVAL_TIME_LIMIT", 0.2)
    with pytest.raises(FestivalError, match="did not answer"):
        guess(["zorblax"])


def test_a_festival_that_fails_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    _fake_festival(tmp_path, "exit 3", monkeypatch)
    with pytest.raises(FestivalError, match="festival failed"):
        guess(["zorblax"])
