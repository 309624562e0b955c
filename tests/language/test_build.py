"""Language files of lists and templates: what is written, loaded by pocketsphinx, stale."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from full_disk import full_disk
from pocketsphinx import Config, Decoder, get_model_path

from voz import CommandsError, LanguageError
from voz.config import DEFAULT_COMMANDS_FILE, load_config
from voz.language.build import build, stale_files
from voz.language.command_source import read_list
from voz.language.grammar import jsgf
from voz.language.language_files import (
    PACKAGED_FOLDER,
    LanguageFiles,
    check_files,
    packaged_files,
    read_commands,
    read_sentences,
    stale_warning,
)
from voz.language.spoken_language import configured_language
from voz.settings import SpokenLanguage

ENDS = ("dic", "lm", "gram", "sent", "vocab", "log_pronounce", "source", "rivals", "sha256")
NAMES = [f"comandos_voz.{end}" for end in ENDS]


@pytest.fixture
def commands(tmp_path: Path) -> Path:
    path = tmp_path / "mine.txt"
    path.write_bytes(b"\xef\xbb\xbfGo Back\r\npoint cocacola\r\nthe stop\r\ndon't go\r\n")
    return path


def decoder(files: LanguageFiles, **search: str | None) -> Decoder:
    model = {"hmm": get_model_path("en-us/en-us"), "dict": str(files.dictionary)}
    return Decoder(Config(**model, **search, bestpath=False, loglevel="FATAL"))


def test_all_files_are_written_under_the_same_names_whatever_the_list_is_called(
    commands: Path, tmp_path: Path
):
    result = build(commands, tmp_path / "new" / "lm")
    assert [path.name for path in result.paths] == NAMES
    assert sorted(path.name for path in (tmp_path / "new" / "lm").iterdir()) == sorted(NAMES)
    assert (result.sentences, result.words, result.warnings) == (4, 7, ())


def test_the_files_have_the_form_of_lmtool(commands: Path, tmp_path: Path):
    build(commands, tmp_path)
    files = LanguageFiles(tmp_path)
    assert files.dictionary.read_text() == (
        "back\tB AE K\ncocacola\tK OW K AH K OW L AH\ndon't\tD OW N T\ndon't(2)\tD OW N\n"
        "go\tG OW\npoint\tP OY N T\nstop\tS T AA P\nthe\tDH AH\nthe(2)\tDH IY\n"
    )
    assert files.vocabulary.read_text() == "back\ncocacola\ndon't\ngo\npoint\nstop\nthe\n"
    assert files.sentences.read_text().splitlines()[0] == "<s> go back </s>"
    log = files.pronounce_log.read_text().splitlines()
    assert "cocacola\tcompound coca+cola\tK OW K AH K OW L AH" in log
    assert "the\tcmudict\tDH IY" in log


def test_check_names_what_is_missing_or_stale(commands: Path, tmp_path: Path):
    out = tmp_path / "lm"
    assert stale_files(commands, out) == NAMES
    assert not out.exists()
    build(commands, out)
    assert stale_files(commands, out) == []
    (out / "comandos_voz.dic").write_text("")
    (out / "comandos_voz.lm").unlink()
    assert stale_files(commands, out) == ["comandos_voz.dic", "comandos_voz.lm"]


def test_the_files_in_the_repository_are_up_to_date():
    assert stale_files(LanguageFiles(PACKAGED_FOLDER).commands, PACKAGED_FOLDER) == []


@pytest.mark.parametrize("name", ["es", "fr"])
def test_the_files_in_other_languages_are_up_to_date(name: str):
    files = packaged_files(name)
    language = configured_language(SpokenLanguage(name=name))
    assert stale_files(files.commands, files.folder, read_list(files.commands, language)) == []
    check_files(files)
    own = set(load_config(DEFAULT_COMMANDS_FILE.with_suffix(f".{name}.toml")).commands)
    assert own | {"stop"} >= {*read_commands(files).names} >= own


def test_pronunciations_beside_the_list_are_used(commands: Path, tmp_path: Path):
    (tmp_path / "pronunciations.txt").write_text("stop S T AO P\n")
    build(commands, tmp_path / "lm")
    assert "stop\tS T AO P\n" in (tmp_path / "lm" / "comandos_voz.dic").read_text()


def test_a_guessed_word_gives_a_warning_that_says_where_to_correct_it(tmp_path: Path):
    commands = tmp_path / "l.txt"
    commands.write_text("stop\ncall zorblax\n")
    assert build(commands, tmp_path).warnings == (
        f'{commands}:2: "zorblax" is in no dictionary; Z AO R B L AE K S is a guess: '
        "correct it in pronunciations.txt beside the list",
    )


def test_what_cannot_be_read_is_refused_in_one_line(tmp_path: Path):
    with pytest.raises(CommandsError, match=r"cannot be read \(.*\); give a readable"):
        build(tmp_path / "missing.txt", tmp_path / "lm")
    with pytest.raises(CommandsError, match="has no list; give a folder with"):
        build(tmp_path, tmp_path / "lm")


def test_pronunciations_that_cannot_be_read_are_refused(commands: Path, tmp_path: Path):
    (tmp_path / "pronunciations.txt").mkdir()
    with pytest.raises(CommandsError, match=r"pronunciations\.txt: cannot be read"):
        build(commands, tmp_path / "lm")


def test_a_file_instead_of_a_folder_is_refused(commands: Path):
    with pytest.raises(LanguageError, match=re.escape(f"{commands}: cannot be written")):
        build(commands, commands)


def test_a_refused_list_leaves_the_files_as_they_were(commands: Path, tmp_path: Path):
    out = tmp_path / "lm"
    before = {path: path.read_bytes() for path in build(commands, out).paths}
    commands.write_text("move @\n")
    with pytest.raises(CommandsError):
        build(commands, out)
    assert {path: path.read_bytes() for path in out.iterdir()} == before


def test_a_full_disk_leaves_the_files_as_they_were(commands: Path, tmp_path: Path):
    out = tmp_path / "lm"
    before = {path: path.read_bytes() for path in build(commands, out).paths}
    commands.write_text("go forward\n" * 5 + "turn left\nstop\n")
    with full_disk(300), pytest.raises(LanguageError, match="cannot be written"):
        build(commands, out)
    assert {path: path.read_bytes() for path in out.iterdir()} == before


def builder(out: Path, words: str) -> subprocess.Popen[str]:
    """A process that makes the same files again and again, and says so each time."""
    (out / f"{words}.txt").write_text(f"go {words}\nstop\n")
    return subprocess.Popen(
        [sys.executable, "-c", BUILDS, out / f"{words}.txt", out], stdout=subprocess.PIPE, text=True
    )


BUILDS = """
import sys
from pathlib import Path
from voz.language.build import build

commands, out = map(Path, sys.argv[1:])
while not (out / "enough").exists():
    build(commands, out)
    print(flush=True)
"""


def test_two_at_once_leave_one_set(tmp_path: Path):
    with builder(tmp_path, "left") as one, builder(tmp_path, "right") as other:
        for process in (one, other):
            process.stdout.readline()
        for _ in range(40):
            check_files(LanguageFiles(tmp_path))
        (tmp_path / "enough").touch()
    check_files(LanguageFiles(tmp_path))
    assert any(not stale_files(tmp_path / name, tmp_path) for name in ("left.txt", "right.txt"))


KILLED = """
import os, signal, sys
from pathlib import Path
from voz.language.build import build

left, replace = int(sys.argv[3]), Path.replace

def replace_a_few(self, target):
    global left
    if left == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    left -= 1
    return replace(self, target)

Path.replace = replace_a_few
build(Path(sys.argv[1]), Path(sys.argv[2]))
"""


@pytest.mark.parametrize("replaced", range(len(NAMES)))
def test_what_a_killed_one_leaves_is_noticed_and_mended_by_another(
    commands: Path, tmp_path: Path, replaced: int
):
    files = LanguageFiles(tmp_path / "lm")
    build(commands, files.folder)
    files.fingerprint.unlink()  # it was made by lmtool
    commands.write_text("go forward\nstop\n")
    killed = [sys.executable, "-c", KILLED, commands, files.folder, str(replaced)]
    assert subprocess.run(killed).returncode == -signal.SIGKILL
    if replaced:
        with pytest.raises(LanguageError, match="`voz build-lm`"):
            check_files(files)
    else:
        check_files(files)
    build(commands, files.folder)
    check_files(files)
    assert stale_files(commands, files.folder) == []


def test_pocketsphinx_loads_the_trigram_model_with_its_probabilities():
    lm = decoder(LanguageFiles(PACKAGED_FOLDER), lm=str(LanguageFiles(PACKAGED_FOLDER).lm))
    model = lm.get_lm(lm.current_search())
    text = LanguageFiles(PACKAGED_FOLDER).lm.read_text()
    expected = next(line for line in text.splitlines() if line.endswith(" go back </s>"))
    log10 = model.prob(["</s>", "back", "go"]) * 0.0001 / 2.302585
    assert log10 == pytest.approx(float(expected.split()[0]), abs=1e-3)


def test_pocketsphinx_accepts_each_command_in_the_grammar_and_no_other(
    commands: Path, tmp_path: Path
):
    build(commands, tmp_path)
    loaded = decoder(LanguageFiles(tmp_path), lm=None, jsgf=str(tmp_path / "comandos_voz.gram"))
    fsg = loaded.get_fsg(loaded.current_search())
    assert all(fsg.accept(text) for text in ("go back", "point cocacola", "don't go"))
    assert not any(fsg.accept(text) for text in ("go", "back", "point", "don't stop"))


@pytest.mark.parametrize("listed", ["stop\nseñal\n", "stop\n(señal|go)\n", "stop\nsen\u0303al\n"])
def test_a_letter_that_english_lacks_is_refused_with_its_line(listed: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.txt"
    path.write_text(listed, encoding="utf-8")
    with pytest.raises(CommandsError, match=r'mine.txt:2: "ñ" is not one of the letters a to z'):
        build(path, tmp_path / "lm")
    assert not (tmp_path / "lm").exists()


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
