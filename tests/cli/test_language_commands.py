"""`voz commands`, `voz parse` and `voz language`."""

from __future__ import annotations

import re
import shutil
import unicodedata
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from calls import Result
from recordings import ROOT
from spanish import RULES, spanish

from voz.language.build import build


def test_the_list_in_use_is_shown_and_becomes_a_page(voz: Any, here: Path) -> None:
    shown = voz("commands")
    assert "  go forward      drives forward at 0.1 m/s\n" in shown.out
    for name in ("commands.txt", "voz.toml"):
        (here / name).write_bytes((ROOT / "examples" / "drone" / name).read_bytes())
    build(here / "commands.txt", here / "lm")
    made = voz("commands", "--card")
    assert made.err.endswith("written: commands.html; open it in a browser and print it\n")
    page = (here / "commands.html").read_text()
    assert "<strong>stop</strong>" in page
    assert "turn <i>side</i> <i>angle</i> degrees" in page
    assert "<dd>15 to 180, by 15</dd>" in page
    refused = voz("commands", "--card", "--out", "commands.txt")
    assert refused.code == 2
    assert "commands.txt: " in refused.err
    (here / "lm" / "comandos_voz.templates").unlink()
    assert "does not tell from which list" in voz("commands", "--lm", "lm").err


Call = Callable[..., Result]


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A folder with the example's files, and a language that nobody added yet."""
    folder = tmp_path / "robot"
    folder.mkdir()
    shutil.copy(ROOT / "examples" / "spanish" / "comandos.txt", folder)
    shutil.copy(RULES, folder / "rules.txt")
    (folder / "voz.toml").write_text('[language]\nname = "es"\npronunciations = "rules.txt"\n')
    spanish(tmp_path / "cmusphinx-es")
    return tmp_path / "robot"


@pytest.fixture
def spanish_voz(robot: Path, voz: Any, inline: None, monkeypatch: pytest.MonkeyPatch) -> Call:
    """Call voz in that folder, in a home of its own."""
    monkeypatch.setenv("XDG_DATA_HOME", str(robot.parent / "data"))
    return lambda *arguments: voz(*arguments, cwd=robot)


@pytest.mark.slow
def test_a_language_is_added_and_a_list_in_it_is_built_and_typed(
    spanish_voz: Call, robot: Path
) -> None:
    added = spanish_voz("language", "add", "../cmusphinx-es", "--name", "es")
    assert added.code == 0, added.err
    assert '[language]\nname = "es"' in added.out
    assert "es: your copy, by pocketsphinx alone\n" in spanish_voz("language", "list").out
    assert spanish_voz("build-lm", "comandos.txt", "--out", "lm").code == 0
    assert spanish_voz("build-lm", "comandos.txt", "--out", "lm", "--check").code == 0
    for form in ("NFC", "NFD"):
        typed = unicodedata.normalize(form, "Más despacio.")
        (parsed,) = spanish_voz("parse", typed, "--json").json
        assert (parsed["text"], parsed["command"]) == ("más despacio", "más despacio")
    (robot / "said.txt").write_text("avanza\nempieza a escuchar\navanza\npara\nMÁS DESPACIO\n")
    run = spanish_voz("run", "--text", "said.txt", "--no-sound")
    assert run.code == 0, run.err
    said = [line.split(maxsplit=2)[2] for line in run.out.splitlines()]
    at = said.index('oído     "para" (1.00)')
    assert said[at + 1] == "el robot está parado"
    assert "el robot dice «bip bip. Te escucho»" in said
    assert 'ignorado "avanza" (1.00), no obedecido: di antes «empieza a escuchar»' in said
    unknown = spanish_voz("parse", "avanzo", "y la luna").out.splitlines()
    assert unknown == [
        "«avanzo»: no es una orden; ¿querías decir «avanza»?",
        "«y la luna»: no es una orden",
    ]
    assert 'oído     "más despacio" (1.00)' in said


def test_without_the_language_the_list_is_refused_with_what_to_do(spanish_voz: Call) -> None:
    complaint = spanish_voz("build-lm", "comandos.txt", "--out", "lm").complaint
    assert "voz language add DIR" in complaint


@pytest.mark.slow
def test_language_files_of_english_are_refused_where_the_settings_say_spanish(
    spanish_voz: Call,
) -> None:
    spanish_voz("language", "add", "../cmusphinx-es", "--name", "es")
    refused = spanish_voz("parse", "stop", "--lm", str(ROOT / "lm"))
    assert refused.code == 2
    assert "made for English, and [language] says es" in refused.err


def test_the_help_says_english(spanish_voz: Call) -> None:
    assert "The commands are English" in " ".join(spanish_voz("--help").out.split())


def test_a_folder_without_a_model_is_refused(spanish_voz: Call) -> None:
    assert "has no dictionary" in spanish_voz("language", "add", ".", "--name", "es").complaint


def test_each_language_says_on_whose_speech_it_was_measured(
    voz: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    lines = voz("language", "list").out.splitlines()
    assert lines[0] == "en  English: measured on people"
    assert [line.partition(" ")[0] for line in lines[1:-1]] == ["es", "fr", "it", "de", "pt"]
    assert lines[-1].startswith("any other that espeak-ng speaks")


@pytest.mark.parametrize(
    ("language", "said", "told"),
    [
        (
            "es",
            ["empieza a escuchar", "avanza", "para", "gira a la izquierda", "mas despacio"],
            ["dice «bip bip. Te escucho»", "avanza a 0.10", "está parado", "gira a la izquierda"],
        ),
        (
            "fr",
            ["commence à écouter", "avance", "stop", "tourne à gauche", "arrête"],
            ["dit « bip bip. Je t'écoute »", "avance à 0.10", "est à l'arrêt", "tourne à gauche"],
        ),
    ],
)
def test_the_commands_of_voz_are_obeyed_in_other_languages(
    language: str, said: list[str], told: list[str], voz: Any, tmp_path: Path
) -> None:
    (tmp_path / "said.txt").write_text("\n".join(said), encoding="utf-8")
    run = voz("run", "--language", language, "--text", tmp_path / "said.txt", "--no-sound")
    assert run.code == 0, run.err
    robot = [line for line in run.out.splitlines() if " robot " in line]
    for line, what in zip(robot[: len(told)], told, strict=True):
        assert what in line


def test_what_is_said_is_obeyed_in_spanish(voz: Any, tmp_path: Path) -> None:
    wav = tmp_path / "said.wav"
    assert voz("say", "gira a la izquierda", "--voice", "espeak-ng:es", "--out", wav).code == 0
    (heard,) = voz("decode", "--language", "es", "--json", wav).json
    assert (heard["text"], heard["accepted"]) == ("gira a la izquierda", True)


def test_a_language_without_a_list_of_voz_says_what_to_run(voz: Any) -> None:
    refused = voz("parse", "halt", "--language", "de")
    assert refused.code == 2
    assert "made for English, and [language] says de; make the language files" in refused.err


FIRST_LINE = re.compile(r"printf '([^']+)' > commands.txt")
SECOND_LINE = re.compile(r"voz build-lm commands.txt --language ([a-z]+) --out lm")
DOCUMENTED = (ROOT / "docs" / "languages.md").read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "language"),
    [*zip(FIRST_LINE.findall(DOCUMENTED), SECOND_LINE.findall(DOCUMENTED), strict=True)],
)
def test_the_three_lines_of_the_guide_work_in_each_language(
    words: str, language: str, voz: Any, here: Path
) -> None:
    commands = words.replace("\\n", "\n")
    (here / "commands.txt").write_text(commands, encoding="utf-8")
    build_lm = voz("build-lm", "commands.txt", "--language", language, "--out", "lm")
    assert build_lm.code == 0, build_lm.err
    for command in commands.split():
        voice = f"espeak-ng:{language}"
        assert voz("say", command, "--voice", voice, "--out", "said.wav").code == 0
        (heard,) = voz("decode", "--lm", "lm", "--json", "said.wav").json
        assert heard["text"] == command


@pytest.mark.parametrize(
    ("language", "template", "said"),
    [
        ("es", "gira: gira {angle: 5..180} grados", "gira noventa y un grados"),
        ("fr", "tourne: tourne de {angle: 5..180} degrés", "tourne de quatre vingt onze degrés"),
        ("it", "gira: gira di {angle: 5..180} gradi", "gira di novantuno gradi"),
        ("de", "drehe: drehe um {angle: 5..180} grad", "drehe um einundneunzig grad"),
        ("pt", "gira: gira {angle: 5..180} graus", "gira noventa e um graus"),
    ],
)
def test_numbers_are_said_in_the_language(
    language: str, template: str, said: str, voz: Any, tmp_path: Path
) -> None:
    listed = tmp_path / "list.txt"
    listed.write_text(f"{template}\n", encoding="utf-8")
    made = voz("build-lm", listed, "--language", language, "--out", tmp_path / "lm")
    assert made.code == 0, made.err
    number = said.replace("noventa y un ", "91 ")
    for text in (said, number):
        (parsed,) = voz("parse", text, "--lm", tmp_path / "lm", "--json").json
        assert parsed["slots"] == {"angle": 91}


def test_a_language_without_numbers_is_told(voz: Any, tmp_path: Path) -> None:
    (tmp_path / "list.txt").write_text("kehr {angle: 5..180}\n")
    refused = voz("build-lm", tmp_path / "list.txt", "--language", "ka-none")
    assert refused.code == 2
    assert 'voz knows no numbers of "ka-none"' in refused.err
