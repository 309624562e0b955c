"""A user's copy of a language: taken, found by its name, and kept apart from others."""

from __future__ import annotations

from pathlib import Path

import pytest
from spanish import spanish, spanish_model

from voz.errors import ConfigError, LanguageError
from voz.language.build import build, stale_files
from voz.language.command_source import read_list
from voz.language.language_files import (
    LanguageFiles,
    check_files,
    read_ipa,
    read_language_info,
    read_pronunciations,
)
from voz.language.spoken_language import (
    LanguageInfo,
    OtherLanguage,
    add_language,
    added_languages,
    check_acoustic_model,
    check_same_language,
    configured_language,
    find_sources,
    read_language,
)
from voz.settings import SpokenLanguage


@pytest.fixture
def given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A language as people get it, in a home of its own."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return spanish(tmp_path / "cmusphinx-es")


def taken(name: str = "es") -> OtherLanguage:
    sources = find_sources(SpokenLanguage(name=name))
    assert sources
    return read_language(sources)


def listed(folder: Path, text: str = "gira la derecha\npara\n") -> Path:
    path = folder / "comandos.txt"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_copy_is_found_by_its_name(given: Path) -> None:
    (given / "rules.txt").write_text("a a\n")
    add_language(given, "es")
    assert added_languages() == ["es"]
    language = taken()
    assert language.spoken.name == "es"
    assert language.dictionary["derecha"] == ("d e r e ch a", "d e r e ch")
    assert language.rules
    add_language(given, "es")  # again, in its place
    assert added_languages() == ["es"]


def test_without_settings_it_is_english() -> None:
    assert find_sources(SpokenLanguage()) is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda folder: (folder / "es.dic").unlink(), "has no dictionary"),
        (lambda folder: (folder / "more.dict").write_text("a a\n"), "several .* dictionary"),
        (lambda folder: spanish_model(folder / "other"), "several .* mdef"),
        (lambda folder: (folder / "es.dic").write_text("para P A\n"), 'no phone "P"'),
        (lambda folder: (folder / "model_parameters/es/means").unlink(), "means"),
    ],
)
def test_what_cannot_be_used_is_not_copied(change, message: str, given: Path) -> None:
    change(given)
    with pytest.raises(LanguageError, match=message):
        add_language(given, "es")
    assert added_languages() == []


def test_a_dictionary_can_be_named_where_there_are_several(given: Path) -> None:
    (given / "more.dict").write_text("a a\n")
    add_language(given, "es", given / "more.dict")
    assert taken().dictionary == {"a": ("a",)}


@pytest.mark.parametrize("name", ["../es", "", "e s", ".es"])
def test_a_name_that_is_no_folder_is_refused(name: str, given: Path) -> None:
    with pytest.raises(ConfigError, match="is not a valid name of a language"):
        add_language(given, name)


def test_a_language_of_which_only_a_part_is_named_says_how_to_add_it(given: Path) -> None:
    with pytest.raises(ConfigError, match="voz language add"):
        find_sources(SpokenLanguage(name="es", dictionary="es.dic"))


def test_a_language_that_nobody_added_is_pronounced_by_espeak_ng(
    given: Path, tmp_path: Path
) -> None:
    settings = SpokenLanguage(name="es")
    assert find_sources(settings) is None
    language = configured_language(settings)
    build(listed(tmp_path), tmp_path / "lm", read_list(listed(tmp_path), language))
    files = LanguageFiles(tmp_path / "lm")
    check_files(files)
    assert read_pronunciations(files)["gira"] == ("HH", "IY", "R", "AA")
    assert read_ipa(files)["gira"] == ("x", "i", "ɾ", "a")
    info = read_language_info(files)
    assert (info.name, info.code, info.is_english) == ("es", "es", False)
    assert info.uses_default_model
    check_same_language(info, settings, files.folder)
    with pytest.raises(LanguageError, match=r"made for es, and \[language\] says fr"):
        check_same_language(info, SpokenLanguage(name="fr"), files.folder)
    assert stale_files(listed(tmp_path), files.folder, read_list(listed(tmp_path), language)) == []
    build(listed(tmp_path, "go back\nstop\n"), files.folder)
    assert read_ipa(files) == {}


def test_files_by_espeak_ng_are_none_for_a_model_that_was_added_since(
    given: Path, tmp_path: Path
) -> None:
    spoken = LanguageInfo("es")
    add_language(given, "es")
    with pytest.raises(LanguageError, match="by another acoustic model"):
        check_same_language(spoken, SpokenLanguage(name="es"), tmp_path)


@pytest.mark.parametrize("name", ["English", "en", "EN"])
def test_english_needs_no_espeak_ng(name: str, given: Path) -> None:
    assert configured_language(SpokenLanguage(name=name)) is None


def test_language_files_keep_the_model_and_phones_of_their_language(
    given: Path, tmp_path: Path
) -> None:
    add_language(given, "es")
    out = tmp_path / "lm"
    build(listed(tmp_path), out, read_list(listed(tmp_path), taken()))
    files = LanguageFiles(out)
    check_files(files)
    assert read_pronunciations(files)["gira"] == ("j", "i", "r", "a")
    assert read_language_info(files).phones == taken().spoken.phones
    check_acoustic_model(read_language_info(files), out)
    assert stale_files(listed(tmp_path), out, read_list(listed(tmp_path), taken())) == []


def test_a_list_that_is_english_again_leaves_nothing_of_the_language(
    given: Path, tmp_path: Path
) -> None:
    add_language(given, "es")
    out = tmp_path / "lm"
    build(listed(tmp_path), out, read_list(listed(tmp_path), taken()))
    english = listed(tmp_path, "go forward\nstop\n")
    assert "comandos_voz.language" in stale_files(english, out)
    build(english, out)
    assert read_language_info(LanguageFiles(out)).uses_default_model
    check_files(LanguageFiles(out))


def test_a_model_that_is_another_than_before_is_refused(given: Path, tmp_path: Path) -> None:
    add_language(given, "es")
    out = tmp_path / "lm"
    build(listed(tmp_path), out, read_list(listed(tmp_path), taken()))
    means = taken().spoken.folder(out) / "means"
    means.write_bytes(means.read_bytes() + b"\0")
    with pytest.raises(LanguageError, match="another acoustic model"):
        check_acoustic_model(read_language_info(LanguageFiles(out)), out)


def test_language_files_of_another_language_than_the_settings_say_are_refused(
    given: Path, tmp_path: Path
) -> None:
    add_language(given, "es")
    english = read_language_info(LanguageFiles(tmp_path))
    with pytest.raises(LanguageError, match=r"made for English, and \[language\] says es"):
        check_same_language(english, SpokenLanguage(name="es"), tmp_path)
    check_same_language(english, SpokenLanguage(), tmp_path)
    check_same_language(taken().spoken, SpokenLanguage(name="es"), tmp_path)


def test_a_model_beside_the_settings_may_move_with_them(
    given: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = tmp_path / "robot"
    robot.mkdir()
    spanish(robot / "es")
    monkeypatch.chdir(robot)
    settings = SpokenLanguage(
        name="es", acoustic_model="es/model_parameters/es", dictionary="es/es.dic"
    )
    sources = find_sources(settings)
    assert sources
    build(listed(robot), Path("lm"), read_list(listed(robot), read_language(sources)))
    moved = robot.rename(tmp_path / "another")
    files = LanguageFiles(moved / "lm")
    assert str(read_language_info(files).acoustic_model) == "../es/model_parameters/es"
    check_acoustic_model(read_language_info(files), files.folder)
