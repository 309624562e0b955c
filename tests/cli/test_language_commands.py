"""`voz commands`, `voz parse` and `voz language`."""

from __future__ import annotations

import os
import shutil
import unicodedata
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from calls import Result, in_process
from recordings import ROOT
from spanish import spanish

from voz.language.build import build


def test_the_list_in_use_is_shown_and_becomes_a_page(
    voz: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shown = voz("commands")
    assert "  go forward      drives forward at 0.1 m/s\n" in shown.out
    for name in ("commands.txt", "voz.toml"):
        (tmp_path / name).write_bytes((ROOT / "examples" / "drone" / name).read_bytes())
    build(tmp_path / "commands.txt", tmp_path / "lm")
    made = voz("commands", "--card")
    assert made.err.endswith("written: commands.html; open it in a browser and print it\n")
    page = (tmp_path / "commands.html").read_text()
    assert "<strong>stop</strong>" in page
    assert "turn <i>side</i> <i>angle</i> degrees" in page
    assert "<dd>15 to 180, by 15</dd>" in page
    refused = voz("commands", "--card", "--out", "commands.txt")
    assert refused.code == 2
    assert "commands.txt: " in refused.err
    (tmp_path / "lm" / "comandos_voz.templates").unlink()
    assert "does not tell from which list" in voz("commands", "--lm", "lm").err


Call = Callable[..., Result]


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A folder with the example's files, and a language that nobody added yet."""
    shutil.copytree(ROOT / "examples" / "spanish", tmp_path / "robot")
    spanish(tmp_path / "cmusphinx-es")
    return tmp_path / "robot"


@pytest.fixture
def spanish_voz(robot: Path) -> Call:
    """Call voz in that folder, in a home of its own."""
    home = {**os.environ, "XDG_DATA_HOME": str(robot.parent / "data"), "PYTHONPATH": str(ROOT)}
    return lambda *arguments: in_process(*arguments, cwd=robot, env=home)


@pytest.mark.slow
def test_a_language_is_added_and_a_list_in_it_is_built_and_typed(
    spanish_voz: Call, robot: Path
) -> None:
    added = spanish_voz("language", "add", "../cmusphinx-es", "--name", "es")
    assert added.code == 0, added.err
    assert '[language]\nname = "es"' in added.out
    assert spanish_voz("language", "list").out == "English (comes with voz)\nes\n"
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
    assert "el robot dice «te escucho»" in said
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
