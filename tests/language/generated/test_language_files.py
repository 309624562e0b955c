from __future__ import annotations

import re
from pathlib import Path

import pytest

from voz import LanguageError
from voz.language.build import build
from voz.language.generated.language_files import (
    PACKAGED_FOLDER,
    LanguageFiles,
    find_language,
    read_sentences,
    stale_warning,
)


@pytest.fixture
def built(tmp_path: Path) -> LanguageFiles:
    files = LanguageFiles(tmp_path / "lm")
    files.folder.mkdir()
    files.commands.write_text("go back\nstop\n")
    build(files.commands, files.folder)
    return files


def test_the_folder_given_comes_first(built: LanguageFiles):
    assert find_language(str(built.folder)) == built


def test_a_folder_lm_here_comes_before_the_package(
    built: LanguageFiles, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(built.folder.parent)
    assert find_language(None).folder == Path("lm")


def test_a_folder_lm_without_grammar_is_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    (tmp_path / "lm").mkdir()
    monkeypatch.chdir(tmp_path)
    assert find_language(None).folder == PACKAGED_FOLDER


def test_the_package_brings_the_fourteen_commands():
    files = LanguageFiles(PACKAGED_FOLDER)
    sentences = read_sentences(files)
    assert len(sentences) == 14
    assert sentences[0] == "start speech"
    assert stale_warning(files) is None


def test_a_folder_without_the_files_says_what_to_run(tmp_path: Path):
    with pytest.raises(LanguageError, match=r"dic: is missing; .*`voz build-lm LIST --out"):
        find_language(tmp_path)


def test_the_sentences_are_read_back_in_order(built: LanguageFiles):
    assert read_sentences(built) == ["go back", "stop"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b"<s> stop </s>\nstop\n", ":2: expected `"),
        (b"<s> </s>\n", ":1: expected `"),
        (b"\n", ":1: expected `"),
        (b"\xff\n", "is not text"),
    ],
)
def test_broken_sentences_are_refused(built: LanguageFiles, content: bytes, message: str):
    built.sentences.write_bytes(content)
    with pytest.raises(LanguageError, match=re.escape(message)):
        read_sentences(built)


def test_missing_sentences_are_refused(tmp_path: Path):
    with pytest.raises(LanguageError, match="cannot be read"):
        read_sentences(LanguageFiles(tmp_path))


def test_a_list_that_changed_in_form_alone_is_not_stale(built: LanguageFiles):
    built.commands.write_text("STOP # all\n\nGo back\n")
    assert stale_warning(built) is None


@pytest.mark.parametrize("changed", ["go back\nstop\nopen gripper\n", "go back\n", "7\n"])
def test_a_list_that_changed_is_stale(built: LanguageFiles, changed: str):
    built.commands.write_text(changed)
    assert stale_warning(built) == (
        f"{built.commands} has changed since the last `voz build-lm`: run it again"
    )


def test_without_a_list_nothing_is_stale(built: LanguageFiles):
    built.commands.unlink()
    assert stale_warning(built) is None
