from __future__ import annotations

import re
from pathlib import Path

import pytest

from voz.language.pronunciation import letter_to_sound
from voz.language.pronunciation.letter_to_sound import FestivalError, guess
from voz.language.pronunciation.lexicon import PHONES


def test_festival_guesses_in_the_phones_of_the_model():
    guesses = guess(["zorblax", "fribblethorn", "o'zorb", "''"])
    assert guesses["zorblax"] == "Z AO R B L AE K S"
    assert set(guesses) == {"zorblax", "fribblethorn", "o'zorb"}
    assert all(PHONES.issuperset(phones.split()) for phones in guesses.values())


def test_every_phone_of_festival_becomes_phones_of_the_model():
    program = "(setup_cmu_lex)\n(mapcar (lambda (p) (print (car p))) (cadr (assoc 'phones ("
    program += "PhoneSet.description))))\n"
    phones = re.findall("^[a-z]+$", letter_to_sound._run_festival(program), re.MULTILINE)
    assert len(phones) > 40
    for phone in phones:
        known = letter_to_sound._PHONES.get(phone, phone.upper())
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
    monkeypatch.setattr(letter_to_sound, "FESTIVAL_TIME_LIMIT", 0.2)
    with pytest.raises(FestivalError, match="did not answer"):
        guess(["zorblax"])


def test_a_festival_that_fails_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    _fake_festival(tmp_path, "exit 3", monkeypatch)
    with pytest.raises(FestivalError, match="festival failed"):
        guess(["zorblax"])
