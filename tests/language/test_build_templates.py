"""Templates as language files: what is written, what pocketsphinx loads, what is stale."""

from __future__ import annotations

from pathlib import Path

import pytest
from pocketsphinx import Config, Decoder, get_model_path

from voz import LanguageError
from voz.language.build import build, stale_files
from voz.language.generated.file_checks import check_files
from voz.language.generated.jsgf_grammar import jsgf
from voz.language.generated.language_files import (
    LanguageFiles,
    read_commands,
    read_sentences,
    stale_warning,
)

FEW = "stop\n[please] go (forward|back)\nturn: turn {way}\nimport ways.txt\n"
MANY = "stop\nturn {angle: 0..359} degree[s] [and {other: 0..359} degree[s]]\n"


def built(folder: Path, text: str) -> LanguageFiles:
    (folder / "ways.txt").write_text("way = left | right\n")
    (folder / "list.txt").write_text(text)
    build(folder / "list.txt", folder / "lm")
    return LanguageFiles(folder / "lm")


def accepting(files: LanguageFiles, texts: list[str]) -> list[bool]:
    config = Config(
        hmm=get_model_path("en-us/en-us"), dict=str(files.dictionary), lm=None, loglevel="FATAL"
    )
    decoder = Decoder(config)
    decoder.add_jsgf_file("all", str(files.grammar))
    grammar = decoder.get_fsg("all")
    return [grammar.accept(text) for text in texts]


def test_few_sentences_are_written_down_as_a_plain_list_is(tmp_path: Path) -> None:
    files = built(tmp_path, FEW)
    sentences = read_sentences(files)
    directions = ("go forward", "go back", "please go forward", "please go back")
    assert set(sentences) == {"stop", "turn left", "turn right", *directions}
    assert files.grammar.read_text() == jsgf(sentences)
    check_files(files)
    commands = read_commands(files)
    assert list(commands) == sentences
    parse = commands.parse("turn left")
    assert parse
    assert (parse.command, parse.slots) == ("turn", {"way": "left"})


@pytest.mark.slow
def test_of_many_sentences_some_are_written_with_all_words(tmp_path: Path) -> None:
    files = built(tmp_path, MANY)
    commands = read_commands(files)
    sentences = read_sentences(files)
    assert len(commands) > 1_000_000 > 10_000 > len(sentences)
    assert {w for s in sentences for w in s.split()} == set(commands.vocabulary)
    drawn = commands.sample(200, seed=1)
    assert all(accepting(files, drawn))
    assert not any(accepting(files, ["turn", "stop stop", "turn five degrees and"]))
    assert stale_files(tmp_path / "list.txt", files.folder) == []


def test_a_changed_file_of_those_imported_is_stale(tmp_path: Path) -> None:
    files = built(tmp_path, FEW)
    assert stale_warning(files) is None
    (tmp_path / "ways.txt").write_text("way = left | right | round\n")
    assert "ways.txt has changed" in (stale_warning(files) or "")
    assert LanguageFiles(files.folder).templates.name in stale_files(
        tmp_path / "list.txt", files.folder
    )
    built(tmp_path, FEW)
    assert stale_warning(files) is None


def test_a_plain_list_after_templates_leaves_nothing_of_them(tmp_path: Path) -> None:
    files = built(tmp_path, FEW)
    assert files.templates.exists()
    (tmp_path / "list.txt").write_text("go back\nstop\n")
    assert files.templates.name in stale_files(tmp_path / "list.txt", files.folder)
    build(tmp_path / "list.txt", files.folder)
    assert not files.templates.exists()
    check_files(files)
    assert list(read_commands(files)) == ["go back", "stop"]


def test_damaged_templates_are_refused(tmp_path: Path) -> None:
    files = built(tmp_path, FEW)
    files.templates.write_text(files.templates.read_text().replace("left", "felt"))
    with pytest.raises(LanguageError, match="was changed after `voz build-lm`"):
        check_files(files)
    files.fingerprint.unlink()
    with pytest.raises(LanguageError, match="is missing"):
        check_files(files)
