"""How voices of other languages are told to read English."""

from __future__ import annotations

import csv

from training_programs import load_training

from voz.language.phones import PHONES

synthesize = load_training("synthesize")


def test_each_language_of_a_voice_has_letters_for_each_phone() -> None:
    with synthesize.RESPELLING.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    assert {row["phone"] for row in rows} == PHONES
    for language in {language for language, _ in synthesize.FOREIGN.values()}:
        assert sum(bool(row[language]) for row in rows) >= len(PHONES) - 1  # Italian has no h


def test_hindi_joins_a_vowel_or_none_to_a_consonant() -> None:
    hindi = synthesize.spellings_of_phones()["hi"]

    def written(phones: str) -> str:
        return str(synthesize.joined([hindi[phone] for phone in phones.split()]))

    assert written("F AO R W ER D") == "फॉर्वर्ड"
    assert written("S T AA P") == "स्टाप"
    assert written("AH P") == "अप"
    assert synthesize.joined(["s", "t", "a", "p"]) == "stap"
