"""Language files: found, read, and refused before a C library gets damaged or mixed ones."""

from __future__ import annotations

import random
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from language.damage import damaged
from recordings import GO_BACK

from voz import LanguageError
from voz.language.build import build
from voz.language.language_files import (
    PACKAGED_FOLDER,
    LanguageFiles,
    check_files,
    find_language,
    read_sentences,
    stale_warning,
)
from voz.settings import SpokenLanguage


@pytest.fixture
def built(tmp_path: Path) -> LanguageFiles:
    """A set of files that `voz build-lm` has made."""
    return language_of("go back\nstop\n", tmp_path / "lm")


@pytest.fixture
def plain(built: LanguageFiles) -> LanguageFiles:
    """The same as lmtool makes them, or another voz: without a fingerprint."""
    built.fingerprint.unlink()
    return built


def language_of(commands: str, folder: Path) -> LanguageFiles:
    folder.mkdir()
    files = LanguageFiles(folder)
    files.commands.write_text(commands)
    build(files.commands, folder)
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


def test_a_folder_lm_in_another_language_than_a_list_of_voz_is_passed_over(
    built: LanguageFiles, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    spanish = SpokenLanguage(name="es")
    shutil.copytree(built.folder, tmp_path / "here" / "lm")
    monkeypatch.chdir(tmp_path / "here")
    assert find_language(None).folder == Path("lm")
    assert find_language(None, spanish).folder == PACKAGED_FOLDER / "es"
    assert find_language(None, SpokenLanguage(name="nn")).folder == Path("lm")
    shutil.rmtree("lm")
    shutil.copytree(PACKAGED_FOLDER / "es", "lm")
    assert find_language(None, spanish).folder == Path("lm")
    assert find_language("lm", SpokenLanguage(name="fr")).folder == Path("lm")


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


SETS = 120

HEARS = """
import sys
from pathlib import Path
import soundfile
from voz import LanguageError
from voz.settings import Recognition
from voz.language.language_files import LanguageFiles
from voz.api.recognizer import Recognizer

samples, _ = soundfile.read(sys.argv[1], dtype="int16")
for folder in sys.argv[2:]:
    for search in ("lm", "grammar"):
        try:
            recognizer = Recognizer(LanguageFiles(Path(folder)), Recognition(search=search))
        except LanguageError as error:
            print("refused:", error)
        else:
            print("heard:", *(u.text for u in recognizer.utterances([samples], "")))
"""
"""A process of its own: what makes pocketsphinx crash would take the tests along."""


def damaged_set(folder: Path, seed: int) -> Path:
    """A copy of the packaged files, one or two of them damaged; every other has a fingerprint."""
    chance = random.Random(seed)
    shutil.copytree(PACKAGED_FOLDER, folder)
    files = LanguageFiles(folder)
    if seed % 2:
        files.fingerprint.unlink()
    for path in chance.sample(files.generated[: 6 - 2 * (seed % 2)], chance.choice([1, 1, 2])):
        path.write_bytes(damaged(path.read_bytes(), chance))
    return folder


def test_whatever_is_damaged_is_one_line_and_never_a_crash(tmp_path: Path) -> None:
    folders = [damaged_set(tmp_path / str(seed), seed) for seed in range(SETS)]
    done = subprocess.run(
        [sys.executable, "-c", HEARS, GO_BACK, *folders], capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert len(lines) == 2 * SETS
    refused = [line for line in lines if line.startswith("refused:")]
    assert all("voz build-lm" in line for line in refused)
    assert len(refused) > SETS
    assert "heard: go back" in lines  # a changed number may be as good


def test_a_change_that_leaves_the_files_valid_is_noticed(built: LanguageFiles) -> None:
    check_files(built)
    built.dictionary.write_text(built.dictionary.read_text().replace("B AE K", "P AE K"))
    with pytest.raises(LanguageError, match=r"\.dic: was changed after"):
        check_files(built)


def test_files_of_two_languages_are_noticed(built: LanguageFiles, tmp_path: Path) -> None:
    other = language_of("go back\nhalt\n", tmp_path / "other")
    for one in built.generated:
        before = one.read_bytes()
        shutil.copy(other.folder / one.name, one)
        with pytest.raises(LanguageError, match="`voz build-lm`"):
            check_files(built)
        one.write_bytes(before)
    check_files(built)


@pytest.mark.parametrize("kind", ["dictionary", "grammar", "sentences"])
def test_without_a_fingerprint_they_have_to_fit(
    plain: LanguageFiles, tmp_path: Path, kind: str
) -> None:
    other = language_of("halt now\n", tmp_path / "other")
    check_files(plain)
    shutil.copy(getattr(other, kind), getattr(plain, kind))
    with pytest.raises(LanguageError, match="`voz build-lm`"):
        check_files(plain)


def test_a_missing_file_is_noticed(built: LanguageFiles) -> None:
    built.vocabulary.unlink()
    with pytest.raises(LanguageError, match=r"\.vocab: cannot be read .*`voz build-lm`"):
        check_files(built)


@pytest.mark.parametrize(
    "line",
    [
        "stop",
        "stop S T AA PP",
        "stop(2) S T AA P",
        "back B AE K\nback B AE K",
        "_stop S T AA P",
        f"{'o' * 41} OW",
        "stop S\x0bT AA P",
        "",
    ],
)
def test_a_dictionary_with_another_line_is_refused(plain: LanguageFiles, line: str) -> None:
    plain.dictionary.write_text(f"{line}\n")
    with pytest.raises(LanguageError, match=r"comandos_voz\.dic:.*`voz build-lm`"):
        check_files(plain)


CHANGES: dict[str, Callable[[str], str]] = {
    "cut": lambda text: text[: len(text) // 2],
    "no end": lambda text: text.replace("\\end\\\n", ""),
    "no beginning": lambda text: text.partition("\\1-grams:")[2],
    "empty": lambda _: "",
    "a count": lambda text: text.replace("ngram 2=", "ngram 2=1"),
    "a huge count": lambda text: text.replace("ngram 2=", "ngram 2=999999999"),
    "no number": lambda text: text.replace("-0.3010 back", "nan back"),
    "an endless number": lambda text: text.replace("-0.3010 back", "-1e99 back"),
    "a probability above 1": lambda text: text.replace("-0.3010 back", "0.3010 back"),
    "a word": lambda text: text.replace(" stop", " halt"),
    "no sentence": lambda text: text.replace("</s>", "</t>"),
    "an n-gram twice": lambda text: text.replace("<s> stop", "<s> go", 1),
    "an n-gram of nothing": lambda text: text.replace("<s> go back", "go <s> back"),
    "a control character": lambda text: text.replace(" stop", "\x0bstop", 1),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_model_that_cannot_be_is_refused(plain: LanguageFiles, change: str) -> None:
    plain.lm.write_text(CHANGES[change](plain.lm.read_text()))
    with pytest.raises(LanguageError, match=r"comandos_voz\.lm: .*`voz build-lm`"):
        check_files(plain)


def test_a_model_as_other_programs_write_it_is_taken(plain: LanguageFiles) -> None:
    text = plain.lm.read_text()
    text = f"Language model created by QuickLM\n(C) 1996\n{text}".replace("\n", "\r\n")
    plain.lm.write_bytes(text.encode())
    check_files(plain)
