# ruff: noqa: RUF001 (letters of the International Phonetic Alphabet)
"""Pronunciations by the real espeak-ng."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from voz.errors import CommandsError, LanguageError
from voz.language.espeak import pronounce_by_espeak, run_espeak, with_ipa
from voz.language.phones import known_phones
from voz.language.pronunciation import LexiconEntry


def fake_espeak(folder: Path, monkeypatch: pytest.MonkeyPatch, program: str) -> None:
    """Put another program in the place of espeak-ng."""
    path = folder / "espeak-ng"
    path.write_text(f"#!{sys.executable}\n{program}")
    path.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder))


def test_each_word_is_pronounced_alone_and_as_each_accent_says_it() -> None:
    entries = pronounce_by_espeak({"cerveza": "l:1", "a": "l:1", "señala": "l:2"}, {}, "es")
    assert list(entries) == ["a", "cerveza", "señala"]
    assert entries["cerveza"].ipa == ("θ e ɾ β e θ a", "s e ɾ β e s a")
    assert entries["cerveza"].phones == ("TH EH R V EH TH AA", "S EH R V EH S AA")
    assert entries["señala"].ipa == ("s e ɲ a l a",)
    assert entries["señala"].origin == "espeak-ng"


def test_an_elision_belongs_to_its_word() -> None:
    assert run_espeak(["l'arrêt", "d'urgence", "à"], "fr") == {
        "l'arrêt": "l a ʁ ɛ",
        "d'urgence": "d y ʁ ʒ ɑ̃ s",
        "à": "a",
    }


@pytest.mark.parametrize(
    ("language", "words"),
    [
        ("es", "avanza retrocede gira izquierda derecha más despacio rota señala recoge brazo"),
        ("fr", "avance recule tourne gauche droite arrête plus lentement montre bière bras un"),
        ("it", "avanti indietro gira sinistra destra fermo veloce piano birra braccio piazza"),
        ("de", "vorwärts rückwärts links rechts halt schneller langsamer zeige Bier Arm zehn ich"),
        ("pt", "avança recua vira esquerda direita pára mais depressa devagar não braço mão um"),
        ("pt-br", "avança recua vira esquerda direita pára mais depressa devagar não braço mão"),
    ],
)
def test_the_phones_of_five_languages_are_known(language: str, words: str) -> None:
    for word, phones in run_espeak(words.split(), language).items():
        assert phones, word
        assert known_phones().issuperset(phones.split()), word


def test_the_users_pronunciations_come_first_and_need_no_program(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    (entry,) = pronounce_by_espeak({"rota": "l:1"}, {"rota": ("r o T a",)}, "es").values()
    assert entry.ipa == ("r o T a",)
    assert entry.phones == ("R OW T AA",)
    assert entry.origin == "pronunciations.txt"


def test_without_the_program_a_line_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(LanguageError, match="sudo apt-get install espeak-ng"):
        pronounce_by_espeak({"para": "l:1"}, {}, "es")


def test_a_language_that_it_does_not_speak_is_named() -> None:
    with pytest.raises(LanguageError, match='espeak-ng does not speak "xx-none"'):
        pronounce_by_espeak({"para": "l:1"}, {}, "xx-none")


def test_a_phone_that_no_table_knows_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    fake_espeak(tmp_path, monkeypatch, "import sys\nfor line in sys.stdin: print('a_ʘ')")
    with pytest.raises(CommandsError, match=r'l:3: .* "para" with the phone ʘ, which'):
        pronounce_by_espeak({"para": "l:3"}, {}, "de")


@pytest.mark.parametrize(
    ("program", "error", "message"),
    [
        ("import sys\nfor line in sys.stdin: print()", CommandsError, 'not pronounce "para"'),
        ("print('a')\nprint('b')", LanguageError, "read 1 words and wrote 2"),
        ("print('\\udcff')", LanguageError, r"espeak-ng failed \('utf-8'"),
    ],
)
def test_a_program_that_answers_something_else_is_an_error(
    program: str,
    error: type[Exception],
    message: str,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    fake_espeak(tmp_path, monkeypatch, program)
    with pytest.raises(error, match=message):
        pronounce_by_espeak({"para": "l:1"}, {}, "de")


def test_a_model_of_the_users_gets_phones_for_the_network_but_not_in_english() -> None:
    entries = {"stop": LexiconEntry(("S T AA P",), "dictionary.txt")}
    assert with_ipa(entries, "es")["stop"].ipa
    assert with_ipa(entries, "es")["stop"].phones == ("S T AA P",)
    for language in ("en", "castellano"):
        assert with_ipa(entries, language) == entries
